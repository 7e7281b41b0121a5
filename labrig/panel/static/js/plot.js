// The chart of all pages: points, lines and bands that can be zoomed, panned and read off.

import uPlot from "../vendor/uplot/uPlot.esm.js";
import { drawSeries } from "./chart/draw.js";
import { HINT, KEYS, Navigation, zoomButtons } from "./chart/navigation.js";
import { colourOf, h, newId, put, setText } from "./dom.js";
import { number, plain } from "./format.js";

const NEAR_PX = 48; // the cursor reads the nearest point up to so far away
const MARGIN = 0.05; // around the data

/**
 * `x`, `y`: { name, unit, decimals }. `equal`: a unit is as long along x as along y.
 * `zero`: y = 0 is shown, with a line. `leastX`, `leastY`: the smallest ranges that are shown.
 * `scene(context, to, more)` draws below the series. `include`: points that are always shown. `label`: what the chart is, for those who hear it.
 *
 * A series: { name, points: [[x, y, error?]], colour: "--plus", line, width, dashed, faint,
 * shape: "dot"|"square"|"up"|"down", size, hollow, band: [half width], normal: along the normal,
 * silent: not read by the cursor, words: (point, at) => text in place of x and y }.
 */
export class Chart {
  constructor(options) {
    this.options = { equal: false, zero: false, leastX: 1e-9, leastY: 1e-9, ...options };
    this.axes = ["x", "y"];
    this.series = [];
    this.view = { x: null, y: null };
    this.at = null; // [series, point] that is read
    const keys = newId("chart-keys");
    this.zoom = zoomButtons(() => this.navigation);
    this.place = h("div", {
      class: "chart-plot",
      tabindex: 0,
      role: "application",
      "aria-roledescription": "chart",
      "aria-label": options.label,
      "aria-describedby": keys,
      onblur: () => this.point(null),
    });
    this.read = h("output", { class: "chart-read" });
    this.about = h("p", { class: "visually-hidden", id: keys }, KEYS);
    this.element = h(
      "div",
      { class: `chart ${options.className ?? ""}` },
      this.place,
      h("div", { class: "chart-foot" }, this.read, this.zoom.element),
      this.about,
    );
    this.seen = new ResizeObserver(() => this.resize());
    this.seen.observe(this.place);
    this.themed = () => {
      this.colours.clear();
      this.uplot?.redraw(true, true);
    };
    this.colours = new Map();
    addEventListener("labrig-theme", this.themed);
    this.point(null);
  }

  destroy() {
    this.seen.disconnect();
    removeEventListener("labrig-theme", this.themed);
    this.uplot?.destroy();
  }

  /** Show series; zoom and pan stay. */
  show(series) {
    const reading = this.at && this.series[this.at[0]]?.name;
    this.series = series;
    this.all = null;
    const again = reading ? series.findIndex((one) => one.name === reading) : -1;
    if (this.at && !series[again]?.points[this.at[1]]) this.point(null);
    else if (this.at) this.at = [again, this.at[1]];
    this.describe();
    this.changed();
  }

  describe() {
    const { x, y } = this.options;
    const known = this.series.filter((one) => !one.silent && one.points.length);
    const names = known.map((one) => one.name).join("; ");
    const { x: wide, y: tall } = this.whole();
    const range = (axis, [low, high]) => `${axis.name} ${plain(low)} to ${plain(high)} ${axis.unit}`;
    setText(
      this.about,
      known.length ? `Shows ${names}. ${range(x, wide)}; ${range(y, tall)}. ${KEYS}` : "No data yet.",
    );
  }

  changed() {
    this.zoom.show(this.navigation?.zoomed);
    if (!this.uplot) return;
    const { x, y } = this.shown();
    this.uplot.setData([x, y]);
    this.showCursor();
  }

  resize() {
    const [width, height] = [this.place.clientWidth, this.place.clientHeight];
    if (width < 40 || height < 40) return;
    if (this.uplot) this.uplot.setSize({ width, height });
    else this.make(width, height);
    this.changed();
  }

  colour(name) {
    if (!this.colours.has(name)) this.colours.set(name, colourOf(this.element, name));
    return this.colours.get(name);
  }

  make(width, height) {
    const { x, y } = this.options;
    const axis = (of, more) => ({
      stroke: () => this.colour("--muted"),
      grid: { stroke: () => this.colour("--grid"), width: 1 },
      ticks: { show: false },
      font: `12px ${getComputedStyle(document.body).fontFamily}`,
      labelFont: `12px ${getComputedStyle(document.body).fontFamily}`,
      label: [of.name, of.unit].filter(Boolean).join(", "),
      labelSize: 18,
      values: (_, ticks) => ticks.map((one) => (of.whole && one % 1 ? "" : plain(one))),
      ...more,
    });
    const nothing = { show: true, paths: () => null, points: { show: false } };
    this.uplot = new uPlot(
      {
        width,
        height,
        padding: [8, 12, 0, 0],
        legend: { show: false },
        cursor: { show: false },
        scales: {
          x: { time: false, range: () => this.shown().x },
          y: { range: () => this.shown().y },
        },
        series: [{}, nothing],
        axes: [axis(x, { size: 24, gap: 4, space: x.whole ? 22 : 46 }), axis(y, { size: 44, gap: 4, space: 30 })],
        hooks: { draw: [(plot) => this.draw(plot)] },
      },
      [[0, 1], [0, 1]],
      this.place,
    );
    this.mark = h("div", { class: "chart-mark", hidden: true });
    this.uplot.over.append(this.mark);
    this.navigation = new Navigation(this, this.element, this.uplot.over);
  }

  // ---------------------------------------------------------------------------------- what is shown

  /** Ranges of all data, with a margin. */
  whole() {
    this.all ??= this.extent();
    return this.options.equal ? this.equally(this.all) : this.all;
  }

  shown() {
    const whole = this.whole();
    const range = { x: this.view.x ?? whole.x, y: this.view.y ?? whole.y };
    return this.options.equal ? this.equally(range) : range;
  }

  extent() {
    const { zero, leastX, leastY, include = [] } = this.options;
    const [xs, ys] = [[], []];
    for (const { points, band, normal } of this.series)
      points.forEach(([x, y, error = 0], at) => {
        if (x == null || y == null) return;
        const half = Math.max(error ?? 0, normal ? 0 : (band?.[at] ?? 0));
        xs.push(x);
        ys.push(y - half, y + half);
      });
    for (const [x, y] of include) {
      xs.push(x);
      ys.push(y);
    }
    if (zero) ys.push(0);
    return { x: spread(xs, leastX), y: spread(ys, leastY) };
  }

  /** The same, widened in one direction so that lengths are true. */
  equally({ x, y }) {
    const box = this.uplot?.over;
    const [width, height] = [box?.clientWidth || 1, box?.clientHeight || 1];
    const scale = Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height);
    const about = ([low, high], span) => [0.5 * (low + high - span), 0.5 * (low + high + span)];
    return { x: about(x, scale * width), y: about(y, scale * height) };
  }

  draw(plot) {
    const { ctx, bbox } = plot;
    const ratio = uPlot.pxRatio;
    const to = {
      x: (value) => plot.valToPos(value, "x", true),
      y: (value) => plot.valToPos(value, "y", true),
    };
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    if (this.options.zero) this.drawZero(ctx, bbox, to, ratio);
    this.options.scene?.(ctx, to, { colour: (name) => this.colour(name), ratio });
    const back = this.colour("--surface");
    for (const one of this.series)
      drawSeries(ctx, one, { to, colour: this.colour(one.colour ?? "--ink"), back, ratio });
    ctx.restore();
  }

  drawZero(ctx, bbox, to, ratio) {
    ctx.strokeStyle = this.colour("--edge");
    ctx.lineWidth = ratio;
    ctx.setLineDash([5 * ratio, 4 * ratio]);
    ctx.beginPath();
    ctx.moveTo(bbox.left, to.y(0));
    ctx.lineTo(bbox.left + bbox.width, to.y(0));
    ctx.stroke();
    ctx.setLineDash([]);
  }

  // ------------------------------------------------------------------------------------ the cursor

  /** Read the point nearest to a place in the plot; without one, none. */
  point(x, y) {
    this.at = x == null ? null : this.nearest(x, y);
    this.showCursor();
  }

  nearest(x, y) {
    let [found, least] = [null, NEAR_PX ** 2];
    this.series.forEach(({ points, silent }, one) => {
      if (silent) return;
      points.forEach(([a, b], at) => {
        if (a == null || b == null) return;
        const off =
          (this.uplot.valToPos(a, "x") - x) ** 2 + (this.uplot.valToPos(b, "y") - y) ** 2;
        if (off < least) [found, least] = [[one, at], off];
      });
    });
    return found;
  }

  /** Move the cursor by points of its series, or to another series. */
  step(points, series) {
    const read = this.series.flatMap((one, at) => (one.silent || !one.points.length ? [] : [at]));
    if (!read.length) return;
    const now = this.at ?? [read[0], -points];
    const turn = Math.max(0, read.indexOf(now[0]));
    const one = read[(turn + series + read.length) % read.length];
    const last = this.series[one].points.length - 1;
    this.at = [one, Math.max(0, Math.min(last, now[1] + points))];
    this.showCursor();
  }

  showCursor() {
    const one = this.at && this.series[this.at[0]];
    const point = one?.points[this.at[1]];
    if (this.mark) this.mark.hidden = !point;
    const known = point && point[0] != null && point[1] != null;
    this.read.classList.toggle("hint", !known);
    if (!known) return setText(this.read, this.options.hint ?? HINT);
    Object.assign(this.mark.style, {
      left: `${this.uplot.valToPos(point[0], "x")}px`,
      top: `${this.uplot.valToPos(point[1], "y")}px`,
    });
    put(this.read, h("b", {}, one.name), ` ${one.words?.(point, this.at[1]) ?? this.words(point)}`);
  }

  words([a, b, error]) {
    const { x, y } = this.options;
    const off = error ? ` \u00B1 ${number(error, y.decimals ?? 3)}` : "";
    const [first, second] = [number(a, x.decimals ?? 2), number(b, y.decimals ?? 3) + off];
    return `${x.symbol ?? x.name} ${first} ${x.unit}, ${y.symbol ?? y.name} ${second} ${y.unit}`;
  }
}

function spread(values, least) {
  if (!values.length) return [0, 1];
  const [low, high] = values.reduce(
    ([a, b], one) => [Math.min(a, one), Math.max(b, one)],
    [Infinity, -Infinity],
  );
  const half = Math.max((0.5 + MARGIN) * (high - low), 0.5 * least);
  return [0.5 * (low + high) - half, 0.5 * (low + high) + half];
}
