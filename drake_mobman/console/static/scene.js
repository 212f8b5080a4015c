// The picture in its frame, drawn by Meshcat's page. Without a graphics card, drawing
// takes most of the machine's time; the stick comes first, so the picture gets coarser.

import { Motion } from "./motion.js";

const COARSER = 0.7; // Pixels along an edge, from one step to the next.
const COARSEST = 0.4; // Pixels of the picture for a pixel of the screen.
const LATE = 6; // How late timers may be, on average, before it gets coarser [ms].
const PATIENCE = 20; // Timers between two steps.
const SOFTWARE = /swiftshader|llvmpipe|software|basic render/i; // No graphics card.
const AGAIN = 3000; // Before a page that did not load is loaded again [ms].

export class Scene {
  // `opened(window)` is called with Meshcat's own window, each time it is loaded; there
  // is no `viewer` in it where the browser has no WebGL. `notice` shows why there is no
  // picture, or why it is frozen.
  constructor(frame, notice, opened) {
    this.frame = frame;
    this.notice = notice;
    this.opened = opened;
    this.motion = new Motion((why) => this.#say(why));
    this.late = 0;
    this.count = 0;
    frame.addEventListener("load", () => this.#loaded());
    this.#loaded();
  }

  // Notes how late a timer came [ms].
  came_late(late) {
    this.late += (Math.min(late, 100) - this.late) / PATIENCE;
    this.count += 1;
    if (this.count < PATIENCE || this.late < LATE) return;
    this.late = this.count = 0;
    const finer = this.#renderer?.getPixelRatio();
    if (finer > COARSEST) this.#draw(Math.max(COARSEST, finer * COARSER));
  }

  get #renderer() {
    return this.frame.contentDocument?.defaultView.viewer?.renderer;
  }

  #drawn_by() {
    const gl = this.#renderer?.getContext();
    const info = gl?.getExtension("WEBGL_debug_renderer_info");
    return info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  }

  #draw(ratio) {
    this.#renderer.setPixelRatio(ratio);
  }

  // Takes over the loaded page, unless it is still loading.
  #loaded() {
    const inside = this.frame.contentDocument; // None, where it could not be loaded.
    if (inside && inside.readyState !== "complete") return;
    if (inside?.URL === "about:blank" || inside?.querySelector("style.console")) return;
    if (!inside?.querySelector("#meshcat-pane")) {
      this.motion.end();
      this.#say("No picture: it did not load.");
      setTimeout(() => (this.frame.src = this.frame.src), AGAIN);
      return;
    }
    this.#tidy(inside);
    const { viewer, MeshCat } = this.frame.contentWindow;
    if (viewer) this.motion.show(viewer, MeshCat);
    else this.#say("No picture: this browser draws nothing in 3D.");
    this.opened(this.frame.contentWindow);
  }

  // Hides Meshcat's own panel: the operator does not need it.
  #tidy(inside) {
    if (SOFTWARE.test(this.#drawn_by())) this.#draw(COARSEST);
    const style = inside.createElement("style");
    style.className = "console";
    style.textContent = ".dg { display: none !important; }";
    inside.head.append(style);
  }

  #say(why) {
    if (this.notice.textContent !== why) this.notice.textContent = why;
  }
}
