// The socket to the session. What cannot be sent now is not sent at all: a command that
// arrives late is worse than none.

const AGAIN = 500; // Before a socket that closed is opened again [ms].
const SILENT = 1000; // Without data from the session, the page says so [ms].
const LOST = 5000; // After that, another socket is tried [ms].

export class Link {
  // `heard(state)` is called with each state of the session, `closed(why)` when the
  // socket is, or when nothing is heard any more.
  constructor(heard, closed) {
    this.heard = heard;
    this.closed = closed;
    this.#open();
  }

  // Sends a message unless others are still under way; returns whether it was sent.
  send(message) {
    const open = this.socket.readyState === WebSocket.OPEN;
    if (!open || this.socket.bufferedAmount > 0) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  // Sends a message even behind others; returns whether it was sent.
  insist(message) {
    const open = this.socket.readyState === WebSocket.OPEN;
    if (open) this.socket.send(JSON.stringify(message));
    return open;
  }

  // When it is now, and by how much the session's clock is ahead of ours, at least: what
  // it said, it said before we heard it. By these it sees how late a message comes.
  times() {
    return { sent: performance.now() / 1000, ahead: this.ahead };
  }

  // Looks whether the session is still heard; to be called now and then.
  check() {
    const silent = performance.now() - this.last;
    if (this.socket.readyState !== WebSocket.OPEN || silent < SILENT) return;
    this.closed("no data from it");
    if (silent > LOST) this.socket.close();
  }

  #open() {
    const secure = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${secure}://${location.host}/drive`);
    this.socket = socket;
    this.ahead = null;
    this.last = Infinity; // When it was last heard [ms].
    socket.onopen = () => (this.last = performance.now());
    socket.onmessage = (event) => {
      if (socket.readyState !== WebSocket.OPEN) return; // Given up.
      const state = JSON.parse(event.data);
      this.last = performance.now();
      this.ahead = state.clock - this.last / 1000;
      this.heard(state);
    };
    socket.onclose = (event) => {
      this.closed(event.reason);
      setTimeout(() => this.#open(), AGAIN);
    };
  }
}
