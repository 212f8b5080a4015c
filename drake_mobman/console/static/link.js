// The socket to the session. What cannot be sent now is not sent at all: a command that
// arrives late is worse than none.

const AGAIN = 500; // Before a socket that closed is opened again [ms].

export class Link {
  // `heard(state)` is called with each state of the session, `closed(why)` when the
  // socket is.
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

  #open() {
    const secure = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${secure}://${location.host}/drive`);
    this.socket.onmessage = (event) => this.heard(JSON.parse(event.data));
    this.socket.onclose = (event) => {
      this.closed(event.reason);
      setTimeout(() => this.#open(), AGAIN);
    };
  }
}
