// The plots: a history of the session's states, drawn a few times a second.

import { echarts } from "nicegui-echart";

const DRAW = 200; // Between two drawings [ms].
const KEEP = 0.09; // Between two samples that are kept [s].

export class Charts {
  constructor(elements) {
    this.elements = [...elements];
    this.span = Number(this.elements[0].dataset.span); // [s].
    this.history = [];
    setInterval(() => this.#draw(), DRAW);
  }

  add(state) {
    const last = this.history.at(-1);
    if (last && state.time < last.time) this.history = []; // The session was reset.
    if (last && state.time >= last.time && state.time < last.time + KEEP) return;
    this.history.push(state);
    while (this.history[0].time < state.time - this.span) this.history.shift();
  }

  #draw() {
    if (document.visibilityState !== "visible" || !this.history.length) return;
    const now = this.history.at(-1).time;
    for (const element of this.elements) {
      if (!element.offsetParent) continue; // Not shown.
      const series = JSON.parse(element.dataset.keys).map((key) => ({
        data: this.history.map((state) => [state.time - now, state[key] ?? null]),
      }));
      echarts.getInstanceByDom(element)?.setOption({ series });
    }
  }
}
