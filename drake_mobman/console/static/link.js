// The WebSocket to the session. What cannot be sent now is not sent at all: a command
// that arrives late is worse than none.

const AGAIN = 500; // Before a socket that closed is opened again [ms].
const SILENT = 1000; // Without data from the session, the page says so [ms].
const LOST = 5000; // After that, another socket is tried [ms].

export class Link {
  // `heard(state)` is called with each state of the session, `closed(why)` when the
  // socket closes, or when no data arrives any more.
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

  // The time now, and by how much the session's clock is ahead of ours, at least, as it
  // sent its time before we received it. From these it bounds the latency of a message.
  times() {
    return { sent: performance.now() / 1000, ahead: this.ahead };
  }

  // Checks whether data still arrives; to be called often.
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
    this.last = Infinity; // When data last arrived [ms].
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
