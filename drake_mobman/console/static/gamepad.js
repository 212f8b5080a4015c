// A gamepad: the left stick is the pad, the right one the lever, a trigger the dead-man.

const DEAD = 0.12; // Worn sticks do not quite return.
const TRIGGERS = [6, 7]; // Of the standard mapping.
const STOP = 1; // The button to the right, B or a circle.

export class Gamepads {
  // `lost()` is called when one is unplugged, `stop()` when its button is pressed.
  constructor(lost, stop) {
    this.stop = stop;
    this.pressed = false;
    this.notice = ""; // A text about those that cannot be used.
    this.neutral();
    window.addEventListener("gamepaddisconnected", lost);
  }

  neutral() {
    this.x = this.y = this.z = 0;
    this.held = false;
    this.waits = true; // Until the triggers are released: an earlier press has no effect.
  }

  // Reads the gamepad, which sends no events; the first one counts. Without the standard
  // mapping, it is not known which axis is which, or where it rests.
  poll() {
    const pads = [...(navigator.getGamepads?.() ?? [])].filter((one) => one?.connected);
    const pad = pads.find((one) => one.mapping === "standard");
    const odd = pads.find((one) => one.mapping !== "standard");
    this.notice = odd
      ? `${odd.id || "a gamepad"} is not used: this browser does not know its axes`
      : "";
    if (!pad) return this.neutral();
    const pulled = TRIGGERS.some((i) => pad.buttons[i]?.value > 0.5);
    if (!pulled) this.waits = false;
    this.held = pulled && !this.waits;
    this.x = axis(pad, 0);
    this.y = -axis(pad, 1);
    this.z = -axis(pad, 3);
    const stops = Boolean(pad.buttons[STOP]?.pressed);
    if (stops && !this.pressed) this.stop();
    this.pressed = stops;
  }
}

function axis(pad, i) {
  const value = pad.axes[i] ?? 0;
  const beyond = Math.max(0, Math.abs(value) - DEAD) / (1 - DEAD);
  return Math.sign(value) * Math.min(1, beyond);
}
