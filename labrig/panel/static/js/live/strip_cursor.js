// Zoom, pan and cursor of the strip charts, which share one time axis.

import { HINT, KEYS, Navigation, zoomButtons } from "../chart/navigation.js";
import { h, setText } from "../dom.js";
import { number, signed } from "../format.js";
import { predictedAt } from "./predicted.js";

export { KEYS };

/** `strips`: the charts; `view.x` of it is what is shown, null: as usual. */
export class StripCursor {
  constructor(strips) {
    this.strips = strips;
    this.at_s = null; // the time that is read
    this.marks = [];
    this.navigations = [];
    this.read = h("output", { class: "chart-read hint" }, HINT);
    this.zoom = zoomButtons(() => this.navigations[0]);
    this.zoom.show(false);
    this.element = h("div", { class: "chart-foot" }, this.read, this.zoom.element);
  }

  /** Follow mouse and keys in one of the charts. */
  follow(line) {
    const { strips } = this;
    const mark = h("div", { class: "chart-line", hidden: true });
    line.plot.over.append(mark);
    this.marks.push({ line, mark });
    const chart = {
      uplot: line.plot,
      axes: ["x"],
      get view() {
        return strips.view;
      },
      set view(view) {
        strips.view = view;
      },
      usual: () => ({ x: strips.usual() }),
      whole: () => ({ x: this.whole() }),
      changed: () => this.changed(),
      point: (x) => this.point(x == null ? null : line.plot.posToVal(x, "x")),
      step: (points) => this.step(points),
    };
    this.navigations.push(new Navigation(chart, line.element, line.plot.over));
  }

  /** Forget the charts: others take their place. */
  leave() {
    this.marks = [];
    this.navigations = [];
  }

  /** All of the run that there is, and what is usually shown. */
  whole() {
    const [low, high] = this.strips.usual();
    const first = this.strips.job.signals.column("run_s")[0] ?? low;
    return [Math.min(low, first), high];
  }

  changed() {
    this.zoom.show(Boolean(this.strips.view.x));
    this.strips.show();
  }

  point(at_s) {
    this.at_s = at_s;
    this.show();
  }

  /** Move by moments of the recording. */
  step(moments) {
    const times = this.strips.job.signals.column("run_s");
    if (!times.length) return;
    const at = this.at_s == null ? times.length - 1 : nearest(times, this.at_s) + moments;
    this.point(times[Math.max(0, Math.min(times.length - 1, at))]);
  }

  show() {
    const { signals } = this.strips.job;
    const times = signals.column("run_s");
    const known = this.at_s != null && times.length;
    const at = known ? nearest(times, this.at_s) : 0;
    for (const { line, mark } of this.marks) {
      mark.hidden = !known;
      if (known) mark.style.left = `${line.plot.valToPos(times[at], "x")}px`;
    }
    this.read.classList.toggle("hint", !known);
    if (!known) return setText(this.read, HINT);
    const values = this.strips.lines.map(({ row }) => {
      const middle =
        0.5 * (signals.column(`${row.key}_least`)[at] + signals.column(`${row.key}_most`)[at]);
      const text = row.key === "drive_V" ? signed : number;
      const predicted = predictedAt(this.strips.job, row.key, times[at]);
      const beside = predicted == null ? "" : ` (model ${text(predicted, row.decimals)})`;
      return `${row.title.toLowerCase()} ${text(middle, row.decimals)} ${row.unit}${beside}`;
    });
    setText(this.read, `${number(times[at], 2)} s: ${values.join(", ")}`);
  }
}

/** Place of the value nearest to one, in ascending values. */
function nearest(values, wanted) {
  let [low, high] = [0, values.length - 1];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < wanted) low = middle + 1;
    else high = middle;
  }
  return low > 0 && wanted - values[low - 1] < values[low] - wanted ? low - 1 : low;
}
