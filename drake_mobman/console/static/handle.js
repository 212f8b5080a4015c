// A stick on the page: the round pad, or a lever that moves up and down.
// It springs back when it is released, and holding it is the dead-man.

const DEAD = 0.06; // Dead zone around the middle, as a share of the way.

export class Handle {
  // `axes` is "xy" or "y"; `changed()` is called when it is pushed or released, `lost()`
  // when the browser takes the finger or mouse away before that.
  constructor(element, axes, changed, lost) {
    this.element = element;
    this.axes = axes;
    this.changed = changed;
    this.pointer = null;
    this.x = this.y = 0; // To the right and up, within [-1, 1].
    element.addEventListener("pointerdown", (event) => this.#take(event));
    element.addEventListener("pointermove", (event) => {
      if (event.pointerId === this.pointer) this.#move(event);
    });
    element.addEventListener("pointerup", (event) => {
      if (event.pointerId === this.pointer) this.#let_go();
    });
    for (const kind of ["pointercancel", "lostpointercapture"]) {
      element.addEventListener(kind, (event) => {
        if (event.pointerId === this.pointer) lost();
      });
    }
    element.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  get held() {
    return this.pointer !== null;
  }

  // Back to the middle, and released: it has to be pressed again.
  neutral() {
    this.pointer = null;
    this.#set(0, 0);
  }

  #take(event) {
    if (this.held || (event.pointerType === "mouse" && event.button !== 0)) return;
    event.preventDefault();
    document.activeElement?.blur(); // The 3D view may have the focus,
    window.focus(); // and keys with it.
    this.pointer = event.pointerId;
    // Until it is released: a layout that moves under a resting thumb is no command.
    this.box = this.element.getBoundingClientRect();
    this.element.setPointerCapture(event.pointerId);
    this.#move(event);
  }

  #move(event) {
    const box = this.box;
    const reach = (Math.min(box.width, box.height) / 2) * 0.8;
    const along = this.axes === "y" ? (box.height / 2) * 0.8 : reach;
    const x = this.axes === "y" ? 0 : (event.clientX - box.x - box.width / 2) / reach;
    const y = -(event.clientY - box.y - box.height / 2) / along;
    const far = Math.hypot(x, y);
    const share = far < DEAD ? 0 : Math.min(1, (far - DEAD) / (1 - DEAD)) / far;
    this.#set(x * share, y * share);
    this.changed();
  }

  #let_go() {
    this.neutral();
    this.changed();
  }

  #set(x, y) {
    this.x = x;
    this.y = y;
    this.element.style.setProperty("--x", x);
    this.element.style.setProperty("--y", y);
    this.element.classList.toggle("held", this.held);
  }
}
