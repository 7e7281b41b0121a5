// Load-cell calibration: dead weights one after the other, the line through them, its residuals.

import { h, newId, put, setText } from "../dom.js";
import { parseNumber } from "../form/limits.js";
import { digits, number } from "../format.js";
import { PromptBar } from "../live/prompt.js";
import { post } from "../net.js";
import { Chart } from "../plot.js";
import { steps } from "../steps.js";

const GRAVITY = 9.80665; // mN of one gram
const SUGGESTED_MN = [0, 9.81, 19.6, 49, 19.6, 9.81, 0];

/** Show the guide. */
export function mount(place, app) {
  const page = new LoadCell(app);
  place.append(page.element);
  return page;
}

class LoadCell {
  constructor(app) {
    this.app = app;
    this.loads = h("input", {
      id: newId("loads"),
      class: "wide",
      value: SUGGESTED_MN.join(", "),
      autocomplete: "off",
      oninput: () => this.show(),
    });
    this.grams = h(
      "select",
      { id: newId("unit"), onchange: () => this.convert() },
      h("option", { value: "1" }, "mN"),
      h("option", { value: GRAVITY }, "g"),
    );
    this.order = h("p", { class: "muted" });
    this.start = h(
      "button",
      {
        type: "button",
        class: "main",
        onclick: () => this.act(() => post("/api/weighing", { loads_mN: this.parse() })),
      },
      "Begin",
    );
    this.accept = h(
      "button",
      { type: "button", class: "main", onclick: () => this.act(() => this.write()) },
      "Accept and write load_cell.toml",
    );
    this.fault = h("p", { class: "fault", role: "alert" });
    this.done = h("p", { class: "good", role: "status" });
    this.points = h("div", {
      class: "scroll",
      tabindex: 0,
      role: "region",
      "aria-label": "weights so far",
    });
    this.residuals = new Chart({
      label: "residuals of the calibration line",
      x: { name: "load", unit: "mN", decimals: 2 },
      y: { name: "residual", unit: "mN", decimals: 3 },
      zero: true,
      leastX: 1,
      leastY: 0.02,
    });
    this.keys = h("p", { class: "muted" });
    this.picture = h("div", {}, this.residuals.element, this.keys);
    this.line = h("dl", { class: "facts facts-big" });
    this.prompt = new PromptBar(app.job, {
      answer: (prompt, done) => app.control.act(() => post("/api/answer", { prompt, done })),
      may: () => app.control.why(),
    });
    this.guide = steps([
      [
        "Weights",
        "Which weights hang on the load cell, one after the other. Up and down again shows its hysteresis; twice nothing shows its drift.",
        h(
          "p",
          { class: "inline" },
          h("label", { for: this.loads.id }, "loads"),
          this.loads,
          h("label", { class: "visually-hidden", for: this.grams.id }, "unit"),
          this.grams,
        ),
        this.order,
        this.start,
      ],
      [
        "Hang each",
        "The output stays at 0 V. Hang what is asked for, let it come to rest, press Go.",
        this.prompt.element,
        this.points,
      ],
      [
        "Look at the residuals",
        "A straight line should leave no pattern. One point far off: do it again. A bow: beyond the cell's range.",
        this.picture,
        this.line,
      ],
      ["Accept", "The old calibration is kept beside the new one.", this.accept, this.done],
    ]);
    this.element = h(
      "div",
      { class: "guide guide-wide" },
      h("h1", {}, "Load-cell calibration"),
      this.fault,
      this.guide.element,
    );
    const again = () => this.show();
    const stop = app.job.watch(again);
    app.control.watchers.add(again);
    this.destroy = () => {
      stop();
      app.control.watchers.delete(again);
      this.prompt.destroy();
      this.residuals.destroy();
    };
    this.show();
  }

  parse() {
    const unit = Number(this.grams.value);
    return this.loads.value
      .split(/[,;\s]+/)
      .filter(Boolean)
      .map((one) => Number((parseNumber(one) * unit).toPrecision(6)));
  }

  convert() {
    const to = Number(this.grams.value);
    const factor = to === 1 ? GRAVITY : 1 / GRAVITY;
    this.loads.value = this.loads.value
      .split(/[,;\s]+/)
      .filter(Boolean)
      .map((one) => Number((parseNumber(one) * factor).toPrecision(5)))
      .join(", ");
    this.show();
  }

  async act(work) {
    setText(this.fault, "");
    try {
      await this.app.control.act(work);
    } catch (error) {
      setText(this.fault, error.message);
    }
  }

  async write() {
    const { written, kept } = await post("/api/weighing/accept", {});
    setText(
      this.done,
      `\u2713 ${written} is written${kept ? `; the old one is kept as ${kept}` : ""}.`,
    );
    this.show();
  }

  show() {
    const { job, control } = this.app;
    const { weighing } = job;
    const busy = job.going && job.job.kind === "weighing";
    const loads = this.parse();
    const wrong = loads.some((load) => !Number.isFinite(load) || load < 0)
      ? "Loads are numbers, not below 0."
      : new Set(loads).size < 2
        ? "At least two different loads are needed."
        : "";
    const why = wrong || (job.going ? "Something is going on already." : control.why());
    setText(
      this.order,
      why || `${loads.length} weights: ${loads.map((load) => number(load, 2)).join(", ")} mN`,
    );
    this.start.disabled = Boolean(why);
    this.prompt.update();
    this.showPoints(weighing);
    this.showFit(weighing);
    const finished = weighing?.finished && weighing.fit;
    this.accept.disabled = !finished || busy || Boolean(control.why());
    this.guide.at(this.done.textContent ? 3 : finished ? 2 : busy ? 1 : 0);
  }

  showPoints(weighing) {
    if (!weighing) {
      put(this.points);
      return;
    }
    const head = h(
      "tr",
      {},
      ["weight", "load, mN", "signal, mV", "residual, mN"].map((name, index) =>
        h("th", { scope: "col", class: index ? "num" : "" }, name),
      ),
    );
    const rows = weighing.wanted.map((load, index) => {
      const point = weighing.points[index];
      const next = index === weighing.points.length && !weighing.finished;
      return h(
        "tr",
        { class: next ? "chosen" : "" },
        h("th", { scope: "row" }, `${index + 1} ${point ? "\u2713" : next ? "\u25B6" : ""}`),
        h("td", { class: "num" }, number(load, 2)),
        h("td", { class: "num" }, number(point?.mV, 3)),
        h("td", { class: "num" }, number(point?.off_mN, 3)),
      );
    });
    put(this.points, h("table", {}, h("thead", {}, head), h("tbody", {}, rows)));
  }

  showFit(weighing) {
    const points = (weighing?.points ?? []).filter((point) => point.off_mN != null);
    const up = (index) => index === 0 || points[index].load_mN >= points[index - 1].load_mN;
    const series = [
      {
        name: "loading",
        shape: "up",
        points: points
          .filter((_, index) => up(index))
          .map((point) => [point.load_mN, point.off_mN]),
      },
      {
        name: "unloading",
        shape: "down",
        points: points
          .filter((_, index) => !up(index))
          .map((point) => [point.load_mN, point.off_mN]),
      },
    ];
    this.residuals.element.hidden = !points.length;
    this.residuals.show(series);
    setText(
      this.keys,
      points.length ? "\u25B2 while loading, \u25BC while unloading" : "after three weights",
    );
    const fit = weighing?.fit;
    put(
      this.line,
      fit && [
        h("dt", {}, "sensitivity"),
        h(
          "dd",
          {},
          `${digits(fit.sensitivity_V_per_N, 5)} \u00B1 ${digits(fit.sensitivity_sigma_V_per_N, 2)} V/N`,
        ),
        h("dt", {}, "offset"),
        h(
          "dd",
          {},
          `${digits(1e3 * fit.offset_V, 4)} \u00B1 ${digits(1e3 * fit.offset_sigma_V, 2)} mV`,
        ),
      ],
    );
  }
}
