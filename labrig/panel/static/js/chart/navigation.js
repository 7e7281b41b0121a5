// Zoom, pan and cursor of a chart, by mouse, wheel, touch and keyboard.
//
// The chart owns what is shown: `view` is { x: [low, high] | null, y: the same }, null shows all.

import { h } from "../dom.js";

const STEP = 1.25; // of one press of a key, or one notch of the wheel
const MOVE = 0.15; // of what is shown
const CLICK_PX = 5; // a shorter drag is a click
const MOST = 4000; // how far one can zoom in

export const HINT =
  "Click, then wheel or drag to zoom, Shift and drag to move, double-click to show all.";
export const KEYS =
  "Arrow keys move the cursor, plus and minus zoom, Shift and arrow keys move the view, 0 shows all.";

/**
 * `chart`: { uplot, axes: ["x", "y"], whole(), view, changed(), point(x, y), step(points, series) }.
 * `whole()` gives { x, y } of all there is, `usual()` those shown without zoom where that is less.
 * x and y of `point` are pixels in the plot.
 */
export class Navigation {
  constructor(chart, element, over) {
    Object.assign(this, { chart, element, over });
    this.box = h("div", { class: "chart-box", hidden: true });
    over.append(this.box);
    const on = (name, act, more) => over.addEventListener(name, (event) => act(event), more);
    on("wheel", (event) => this.wheel(event), { passive: false });
    on("pointerdown", (event) => this.press(event));
    on("pointermove", (event) => this.move(event));
    on("pointerup", (event) => this.release(event));
    on("pointercancel", () => this.drop());
    on("pointerleave", () => this.drag || chart.point(null));
    on("dblclick", () => this.reset());
    element.addEventListener("keydown", (event) => this.key(event));
  }

  get zoomed() {
    return Boolean(this.chart.view.x || this.chart.view.y);
  }

  /** What is shown of an axis. */
  shown(axis) {
    const { chart } = this;
    return chart.view[axis] ?? (chart.usual ? chart.usual() : chart.whole())[axis];
  }

  reset() {
    this.chart.view = { x: null, y: null };
    this.chart.changed();
  }

  /** Show less (factor below 1) or more about a place, by default the middle. */
  zoom(factor, at = {}) {
    const whole = this.chart.whole();
    const view = { x: null, y: null };
    for (const axis of this.chart.axes) {
      const [low, high] = this.shown(axis);
      const about = at[axis] ?? 0.5 * (low + high);
      const span = (high - low) * factor;
      const all = whole[axis][1] - whole[axis][0];
      if (span < all / MOST) return;
      const share = (about - low) / (high - low);
      view[axis] = span >= all ? null : within([about - share * span, span], whole[axis]);
    }
    this.chart.view = view;
    this.chart.changed();
  }

  /** Move by shares of what is shown. */
  pan(shares) {
    if (!this.zoomed) return;
    const whole = this.chart.whole();
    for (const axis of this.chart.axes) {
      const [low, high] = this.shown(axis);
      const by = (shares[axis] ?? 0) * (high - low);
      this.chart.view[axis] = within([low + by, high - low], whole[axis]);
    }
    this.chart.changed();
  }

  wheel(event) {
    // a wheel that only passes over the chart scrolls the page
    if (!event.ctrlKey && !this.element.contains(document.activeElement)) return;
    event.preventDefault();
    this.zoom(event.deltaY > 0 ? STEP : 1 / STEP, this.placeOf(event));
  }

  press(event) {
    this.element.querySelector("[tabindex]")?.focus({ preventScroll: true });
    if (event.button > 1) return;
    const moves = event.shiftKey || event.button === 1 || event.pointerType === "touch";
    this.drag = { moves, from: [event.offsetX, event.offsetY], at: [event.offsetX, event.offsetY] };
    this.over.setPointerCapture(event.pointerId);
    event.preventDefault();
  }

  move(event) {
    const { drag, over } = this;
    if (!drag) return this.chart.point(event.offsetX, event.offsetY);
    const [x, y] = [event.offsetX, event.offsetY];
    if (drag.moves)
      this.pan({
        x: (drag.at[0] - x) / over.clientWidth,
        y: (y - drag.at[1]) / over.clientHeight,
      });
    else this.showBox(drag.from, [x, y]);
    drag.at = [x, y];
  }

  release(event) {
    const { drag } = this;
    this.drop();
    if (!drag || drag.moves) return;
    const to = [event.offsetX, event.offsetY];
    if (Math.abs(to[0] - drag.from[0]) < CLICK_PX) return;
    const [one, other] = [this.placeAt(...drag.from), this.placeAt(...to)];
    const both = this.chart.axes.length > 1 && Math.abs(to[1] - drag.from[1]) >= CLICK_PX;
    const view = { x: null, y: null };
    for (const axis of both ? this.chart.axes : ["x"])
      view[axis] = [Math.min(one[axis], other[axis]), Math.max(one[axis], other[axis])];
    this.chart.view = { ...this.chart.view, ...view };
    this.chart.changed();
  }

  drop() {
    this.drag = null;
    this.box.hidden = true;
  }

  showBox(from, to) {
    const tall = this.chart.axes.length > 1;
    const [top, bottom] = tall
      ? [Math.min(from[1], to[1]), Math.max(from[1], to[1])]
      : [0, this.over.clientHeight];
    Object.assign(this.box.style, {
      left: `${Math.min(from[0], to[0])}px`,
      width: `${Math.abs(to[0] - from[0])}px`,
      top: `${top}px`,
      height: `${bottom - top}px`,
    });
    this.box.hidden = false;
  }

  placeOf(event) {
    return this.placeAt(event.offsetX, event.offsetY);
  }

  placeAt(x, y) {
    const { uplot, axes } = this.chart;
    return Object.fromEntries(
      axes.map((axis) => [axis, uplot.posToVal(axis === "x" ? x : y, axis)]),
    );
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const act = event.shiftKey && MOVES[event.key] ? MOVES[event.key] : ACTS[event.key];
    if (!act || event.target.closest("button, a, input, select")) return;
    event.preventDefault();
    act(this);
  }
}

const ACTS = {
  "+": (to) => to.zoom(1 / STEP),
  "=": (to) => to.zoom(1 / STEP),
  "-": (to) => to.zoom(STEP),
  0: (to) => to.reset(),
  ArrowRight: (to) => to.chart.step(1, 0),
  ArrowLeft: (to) => to.chart.step(-1, 0),
  ArrowUp: (to) => to.chart.step(0, -1),
  ArrowDown: (to) => to.chart.step(0, 1),
};
const MOVES = {
  ArrowRight: (to) => to.pan({ x: MOVE }),
  ArrowLeft: (to) => to.pan({ x: -MOVE }),
  ArrowUp: (to) => to.pan({ y: MOVE }),
  ArrowDown: (to) => to.pan({ y: -MOVE }),
};

/** A range of a length, moved so that it does not lie outside the whole. */
function within([low, span], [least, most]) {
  const from = Math.max(least, Math.min(low, most - span));
  return [from, from + span];
}

/** Buttons for those who have neither wheel nor keys: zoom in, zoom out, show all. */
export function zoomButtons(navigation) {
  const button = (words, name, act) =>
    h("button", { type: "button", class: "small quiet", "aria-label": name, title: name, onclick: act }, words);
  const all = button("show all", "show all", () => navigation().reset());
  const element = h(
    "div",
    { class: "chart-zoom" },
    button("\u2212", "zoom out", () => navigation().zoom(STEP)),
    button("+", "zoom in", () => navigation().zoom(1 / STEP)),
    all,
  );
  return { element, show: (zoomed) => (all.disabled = !zoomed) };
}
