// The keyboard: the space bar is the dead-man, arrows and letters steer, Shift slows.

const STEER = {
  ArrowUp: ["y", 1], KeyW: ["y", 1],
  ArrowDown: ["y", -1], KeyS: ["y", -1],
  ArrowRight: ["x", 1], KeyD: ["x", 1],
  ArrowLeft: ["x", -1], KeyA: ["x", -1],
  KeyR: ["z", 1], PageUp: ["z", 1],
  KeyF: ["z", -1], PageDown: ["z", -1],
};

const SLOW = ["ShiftLeft", "ShiftRight"];
const SHARE = 0.25; // Of the way that keys push then.

export class Keys {
  // `changed()` is called when keys change, `stop()` on Escape.
  constructor(changed, stop) {
    this.changed = changed;
    this.stop = stop;
    this.down = new Set();
  }

  // Receives keys that are pressed in a window.
  listen(window) {
    // Before anything else on the page: the space bar must not press a button.
    window.addEventListener("keydown", (event) => {
      if (event.code === "Escape") return this.stop();
      if (event.key === "Meta") return this.#let_go();
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      if (!this.#is_ours(event)) return;
      event.preventDefault();
      if (event.repeat) return;
      this.down.add(event.code);
      this.changed();
    }, true);
    window.addEventListener("keyup", (event) => {
      if (event.key === "Meta") return this.#let_go();
      if (this.#is_ours(event)) event.preventDefault();
      if (this.down.delete(event.code)) this.changed();
    }, true);
  }

  get held() {
    return this.down.has("Space");
  }

  get x() { return this.#sum("x"); }
  get y() { return this.#sum("y"); }
  get z() { return this.#sum("z"); }

  neutral() {
    this.down.clear();
  }

  // macOS does not report keys that are released while Meta is down.
  #let_go() {
    this.neutral();
    this.changed();
  }

  #is_ours(event) {
    return event.code in STEER || event.code === "Space" || SLOW.includes(event.code);
  }

  #sum(axis) {
    const pushed = new Set(); // Two keys of one direction count once.
    for (const code of this.down) {
      if (STEER[code]?.[0] === axis) pushed.add(STEER[code][1]);
    }
    const slow = SLOW.some((code) => this.down.has(code));
    return (slow ? SHARE : 1) * [...pushed].reduce((sum, way) => sum + way, 0);
  }
}
