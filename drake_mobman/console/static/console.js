// The operator's side of the console: pad, lever, keys and gamepad make one command,
// which is sent 30 times a second as long as the operator looks at the page.

import { Charts } from "./charts.js";
import { Drag } from "./drag.js";
import { Gamepads } from "./gamepad.js";
import { Handle } from "./handle.js";
import { Keys } from "./keys.js";
import { Link } from "./link.js";
import { Scene } from "./scene.js";
import { show, showClosed } from "./show.js";

const BEAT = 1000 / 30; // Between two messages, changed or not [ms].
const SOONEST = 12; // Between two messages, if something changed [ms].

await loaded(".lever .knob");

let sequence = 0;
let said = -Infinity; // When the last message was sent [ms].
let due = performance.now(); // When the next beat is due [ms].
let operates = false;

const heard = new WeakSet(); // Documents whose keys the page receives.
const charts = new Charts(document.querySelectorAll(".plot"));
const link = new Link(
  (state) => {
    if (operates && state.role !== "you") neutral();
    operates = state.role === "you";
    show(state, gamepads.notice);
    charts.add(state);
  },
  (why) => {
    neutral();
    operates = false;
    showClosed(why);
  },
);
const ask = (what, more) => link.insist({ ask: what, ...more, ...link.times() });
const stop = () => ask("stop");
const pad = new Handle(document.querySelector(".pad"), "xy", changed, neutral);
const lever = new Handle(document.querySelector(".lever"), "y", changed, neutral);
const keys = new Keys(changed, stop);
const gamepads = new Gamepads(neutral, stop);
const drag = new Drag(changed);
const devices = [pad, lever, keys, gamepads, drag];
const [frame, still] = [".scene", ".still"].map((x) => document.querySelector(x));
const scene = new Scene(frame, still, (inside) => {
  drag.listen(inside);
  watch(inside);
});

// To the right, up and away from the ground, each within [-1, 1].
function pushed() {
  const sum = (...shares) => Math.max(-1, Math.min(1, shares.reduce((a, b) => a + b)));
  return {
    x: sum(pad.x, keys.x, gamepads.x),
    y: sum(pad.y, keys.y, gamepads.y),
    z: sum(lever.y, keys.z, gamepads.z),
  };
}

// False while a picture that did not load has the focus: the page gets no keys then.
function isHere() {
  const active = document.activeElement;
  const hears = active?.localName !== "iframe" || heard.has(active.contentDocument);
  return hears && document.visibilityState === "visible" && document.hasFocus();
}

function say(send = (message) => link.send(message)) {
  const { x, y, z } = pushed();
  const now = performance.now();
  const sent = send({
    sequence: ++sequence,
    v_c: y,
    omega_c: -x, // To the left is positive.
    v_z: z,
    dead_man: devices.some((device) => device.held),
    drag: drag.pull,
    ...link.times(),
  });
  if (sent) said = now;
}

function beat() {
  const now = performance.now();
  if (isHere()) scene.came_late(now - due);
  due = now + BEAT;
  gamepads.poll();
  link.check();
  if (!isHere()) lose();
  else if (operates && now - said > BEAT / 2) say();
}

// Sends at once what an event changed; what comes too soon waits for the next beat.
function changed() {
  const let_go = !devices.some((device) => device.held);
  if (operates && isHere() && (let_go || performance.now() - said >= SOONEST)) say();
}

// Releases everything, and sends that even if nobody is here any more.
function neutral() {
  for (const device of devices) device.neutral();
  if (operates) say((message) => link.insist(message));
}

// The same, where not every loss of attention comes as an event.
function lose() {
  if (devices.some((device) => device.held)) neutral();
}

// Keys and the loss of focus are events of the window that has the focus: the page's or
// the picture's. A change between these two releases nothing.
function watch(inside) {
  heard.add(inside.document);
  keys.listen(inside);
  // While a menu is open, the page does not see the release of a key.
  inside.addEventListener("contextmenu", (event) => event.defaultPrevented || neutral());
  inside.addEventListener("blur", () => isHere() || neutral());
}

watch(window);
window.addEventListener("pagehide", neutral);
document.addEventListener("visibilitychange", neutral);
document.addEventListener("freeze", neutral);
// At once, and for a second finger too, which makes no click.
document.addEventListener("pointerdown", ({ target }) => {
  const button = target.closest('[data-ask="stop"], [data-ask="choose"]');
  if (button) ask(button.dataset.ask, { choice: button.dataset.choice });
});
document.addEventListener("click", ({ target }) => {
  const button = target.closest("[data-ask]");
  if (button) ask(button.dataset.ask, { choice: button.dataset.choice });
});
setInterval(beat, BEAT);
document.documentElement.dataset.ready = "";

// Waits until NiceGUI has laid out the page.
async function loaded(selector) {
  while (!document.querySelector(selector)) {
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}
