// Meshcat in its frame. Where a machine has no graphics card, drawing takes most of its
// time; the stick comes first, and the picture gets coarser.

const COARSER = 0.7; // Pixels along an edge, from one step to the next.
const COARSEST = 0.4; // Pixels of the picture for a pixel of the screen.
const LATE = 6; // How late timers may be, on average, before it gets coarser [ms].
const PATIENCE = 20; // Timers between two steps.
const SOFTWARE = /swiftshader|llvmpipe|software|basic render/i; // No graphics card.

export class Scene {
  // `opened(window)` is called with Meshcat's own window, and again where it is loaded
  // anew; there is no `viewer` in it where the browser has no WebGL.
  constructor(frame, opened) {
    this.frame = frame;
    this.opened = opened;
    this.late = 0;
    this.count = 0;
    frame.addEventListener("load", () => this.#tidy());
    this.#tidy();
  }

  // Takes note that a timer came late by so much [ms].
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

  // Hides Meshcat's own panel: nothing in it is for the operator.
  #tidy() {
    const inside = this.frame.contentDocument; // None, where it could not be loaded.
    if (inside?.readyState !== "complete" || inside.URL === "about:blank") return;
    if (inside.querySelector("style.console")) return;
    if (SOFTWARE.test(this.#drawn_by())) this.#draw(COARSEST);
    const style = inside.createElement("style");
    style.className = "console";
    style.textContent = ".dg { display: none !important; }";
    inside.head.append(style);
    this.opened(this.frame.contentWindow);
  }
}
