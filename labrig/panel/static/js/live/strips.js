// The session's channels over the run's time, with every sampling point marked.

import uPlot from "../../vendor/uplot/uPlot.esm.js";
import { colourOf, h, newId } from "../dom.js";
import { plain } from "../format.js";
import { forgetFrame, nextFrame } from "../frames.js";
import { drawEnvelope } from "./envelope.js";
import { drawMark } from "./marks.js";
import { drawPredicted, extremes } from "./predicted.js";
import { Numerals } from "./numerals.js";
import { KEYS, StripCursor } from "./strip_cursor.js";
import { stripRows, valueOf } from "./strip_rows.js";

const WHOLE_S = 40; // a run up to so long is shown as a whole, a longer one by its last
const ROLLING_S = 30;

// Where a browser does not keep up, images come first: the more of them it misses, the longer the
// charts wait between two updates.
const WAIT_MS = 120; // for each frame that is missed between two images
const MOST_WAIT_MS = 250;

const REDRAWN_BY = [
  "signals",
  "predicted",
  "reading",
  "marked",
  "plan",
  "story",
  "run_started",
  "run_stopped",
  "ended",
  "job",
  "alive",
];

/** A chart for each channel, under one another on one time axis. */
export class Strips {
  constructor(job) {
    this.job = job;
    this.shown_ms = -Infinity;
    this.points = 0; // moments that have reached the charts
    this.numerals = new Numerals(job);
    this.view = { x: null, y: null };
    this.keys = newId("strip-keys");
    this.lines = [];
    this.cursor = new StripCursor(this);
    this.element = h(
      "div",
      { class: "strips card", role: "group", "aria-label": "strip charts" },
      this.cursor.element,
      this.numerals.age,
      h("p", { class: "visually-hidden", id: this.keys }, KEYS),
    );
    this.seen = new ResizeObserver(() => this.resize());
    this.seen.observe(this.element);
    this.follow(job.plan);
    this.themed = () => this.lines.forEach((line) => this.repaint(line));
    addEventListener("labrig-theme", this.themed);
  }

  destroy() {
    this.seen.disconnect();
    clearTimeout(this.timer);
    forgetFrame(this.showLate);
    this.numerals.destroy();
    removeEventListener("labrig-theme", this.themed);
    this.forget();
  }

  /** Rows as the plan has them: other sessions have other channels. */
  follow(plan) {
    const rows = stripRows(plan);
    const named = JSON.stringify(rows);
    if (named === this.named) return;
    this.named = named;
    this.forget();
    const numerals = this.numerals.follow(rows);
    this.lines = rows.map((row, index) => this.line(row, numerals[index], index === rows.length - 1));
    this.cursor.element.before(...this.lines.map((line) => line.element));
    this.resize();
  }

  forget() {
    this.cursor.leave();
    for (const line of this.lines) {
      line.plot?.destroy();
      line.element.remove();
    }
    this.lines = [];
  }

  line(row, numeral, last) {
    const plot = h("div", {
      class: "strip-plot",
      tabindex: 0,
      role: "application",
      "aria-roledescription": "chart",
      "aria-label": `${row.title} in ${row.unit} over the time of the run in s`,
      "aria-describedby": this.keys,
    });
    const element = h(
      "div",
      { class: "strip", data: { row: row.key } },
      numeral,
      plot,
    );
    return { row, place: plot, element, last, plot: null };
  }

  resize() {
    for (const line of this.lines) {
      const [width, height] = [line.place.clientWidth, line.place.clientHeight];
      if (width < 20 || height < 20) continue;
      if (line.plot) line.plot.setSize({ width, height });
      else {
        line.plot = this.chart(line, width, height);
        this.cursor.follow(line);
      }
    }
    this.show();
  }

  repaint(line) {
    line.colours = null;
    line.plot?.redraw(true, true);
  }

  colours(line) {
    line.colours ??= {
      trace: colourOf(this.element, line.row.colour),
      predicted: colourOf(this.element, "--predicted"),
      ink: colourOf(this.element, "--muted"),
      grid: colourOf(this.element, "--grid"),
      plus: colourOf(this.element, "--plus"),
      minus: colourOf(this.element, "--minus"),
      zero: colourOf(this.element, "--zero"),
      back: colourOf(this.element, "--surface"),
    };
    return line.colours;
  }

  chart(line, width, height) {
    const axis = {
      stroke: () => this.colours(line).ink,
      grid: { stroke: () => this.colours(line).grid, width: 1 },
      ticks: { show: false },
      font: `12px ${getComputedStyle(document.body).fontFamily}`,
    };
    const options = {
      width,
      height,
      padding: [8, 18, line.last ? 0 : 4, 0],
      legend: { show: false },
      cursor: { show: false },
      scales: {
        x: { time: false, range: () => this.window() },
        y: { range: (_, low, high) => this.range(line, low, high) },
      },
      series: [
        {},
        { paths: () => null, points: { show: false } },
        { paths: () => null, points: { show: false } },
      ],
      axes: [
        {
          ...axis,
          show: true,
          size: line.last ? 24 : 4,
          gap: 2,
          values: (_, ticks) => ticks.map((t) => (line.last ? `${t} s` : "")),
        },
        { ...axis, size: 46, gap: 4, space: 26, values: (_, ticks) => ticks.map(plain) },
      ],
      hooks: { draw: [(plot) => this.drawSignal(plot, line)] },
    };
    return new uPlot(options, [[], [], []], line.place);
  }

  /** What of the run's time is shown. */
  window() {
    return this.view.x ?? this.usual();
  }

  /** The same without zoom. */
  usual() {
    const { signals } = this.job;
    const duration = this.job.planned(signals.run ?? this.job.now_run)?.duration_s;
    const now = signals.newestTime() ?? 0;
    if (duration != null && duration <= WHOLE_S) return [-0.25, Math.max(duration, now)];
    return [Math.max(now, ROLLING_S) - ROLLING_S, Math.max(now, ROLLING_S)];
  }

  range(line, low, high) {
    if (line.row.key === "drive_V") {
      const steps = this.job.planned(this.job.signals.run)?.steps ?? [];
      const most = Math.max(
        1,
        ...steps.map(([, volts]) => Math.abs(volts)),
        Math.abs(low ?? 0),
        Math.abs(high ?? 0),
      );
      return [-1.2 * most, 1.2 * most];
    }
    if (low == null) return [-1.2, 1.2];
    [low, high] = extremes(this.job, line.row.key, [low, high]);
    const middle = 0.5 * (low + high);
    const half = Math.max(0.58 * (high - low), 0.5 * line.row.least);
    return [middle - half, middle + half];
  }

  update(dirty) {
    if (dirty.has("plan") || dirty.has("story")) this.follow(this.job.plan);
    if (!REDRAWN_BY.some((type) => dirty.has(type))) return;
    const wait = Math.min(MOST_WAIT_MS, WAIT_MS * this.job.missed);
    const left = this.shown_ms + wait - performance.now();
    clearTimeout(this.timer);
    if (left > 0) this.timer = setTimeout(() => nextFrame(this.showLate), left);
    else this.show();
  }

  showLate = () => this.show();

  show() {
    this.shown_ms = performance.now();
    const { signals } = this.job;
    for (const line of this.lines) {
      const { key } = line.row;
      line.plot?.setData([
        signals.column("run_s"),
        signals.column(`${key}_least`),
        signals.column(`${key}_most`),
      ]);
    }
    this.points = signals.count;
    this.cursor.show();
    this.numerals.update();
  }

  drawSignal(plot, line) {
    const ratio = window.devicePixelRatio || 1;
    drawEnvelope(plot, this.colours(line).trace, ratio);
    drawPredicted(plot, this.job, line.row.key, this.colours(line).predicted, ratio);
    this.drawMarks(plot, line);
  }

  /** Planned sampling points as ticks at the foot, taken ones as marks on the trace. */
  drawMarks(plot, line) {
    const { job } = this;
    const run = job.signals.run ?? job.now_run;
    const planned = job.planned(run);
    if (!planned) return;
    const { ctx, bbox } = plot;
    const ratio = window.devicePixelRatio || 1;
    const colours = this.colours(line);
    const taken = job.runs.get(run)?.readings ?? new Map();
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top - 6 * ratio, bbox.width, bbox.height + 12 * ratio);
    ctx.clip();
    const { min, max } = plot.scales.x;
    for (const [index, run_s, volts] of planned.readings) {
      const reading = taken.get(index);
      const at_s = reading?.run_s ?? run_s;
      if (at_s < min || at_s > max) continue;
      const x = plot.valToPos(at_s, "x", true);
      const colour = volts > 0 ? colours.plus : volts < 0 ? colours.minus : colours.zero;
      ctx.strokeStyle = colour;
      ctx.lineWidth = ratio;
      ctx.beginPath();
      ctx.moveTo(x, bbox.top + bbox.height);
      ctx.lineTo(x, bbox.top + bbox.height - 6 * ratio);
      ctx.stroke();
      if (!reading) continue;
      const value = valueOf(reading, line.row);
      if (value == null) continue;
      const y = plot.valToPos(value, "y", true);
      drawMark(ctx, x, y, 4.5 * ratio, { volts, reading, colour, back: colours.back, ratio });
    }
    ctx.restore();
  }
}
