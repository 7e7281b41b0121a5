// The dynamic model beside the run: its running error, and what the run says of its slow parameters.

import { h, put, setText } from "../dom.js";
import { number, signed } from "../format.js";
import { Chart } from "../plot.js";

const KNOWN = 0.1; // sigma of a ratio: what is less known is not drawn
const FAR = 3; // sigmas, and ...
const NOTICEABLE = 0.05; // ... of the model's value, from which on a change is said
const MOMENT_SCALE = 1e6; // micro
const NAMES = { B: "stiffness B", moment: "moment per volt" };
const UNITS = { B: "\u00B5N m\u00B2", moment: "\u00B5N m/V" };
const SOURCES = { B: "B_Nm2", moment: "moment_per_volt_Nm" };
const COLOURS = { B: "--trace-force", moment: "--trace-other" };

/** Hidden where no model is beside the run. */
export class ModelBeside {
  constructor(job) {
    this.job = job;
    this.why = h("p", { class: "model-why", role: "status" });
    this.change = h("p", { class: "model-why", role: "status" });
    this.cells = Object.fromEntries(
      ["force", "shape", "B", "moment"].map((name) => [name, h("td")]),
    );
    this.table = h(
      "table",
      { class: "model-errors" },
      h(
        "tbody",
        {},
        this.row("force error, RMS", "force"),
        this.row("shape error, RMS", "shape"),
        this.row("stiffness B, as the run shows it", "B"),
        this.row("moment per volt", "moment"),
      ),
    );
    this.chart = new Chart({
      label: "stiffness and moment per volt over those of the model, against the session's time",
      className: "chart-small",
      x: { name: "time", unit: "min", decimals: 2 },
      y: { name: "of the model\u2019s", unit: "%", decimals: 1 },
      leastX: 0.5,
      leastY: 10,
    });
    this.element = h(
      "section",
      { class: "card model-beside", "aria-label": "model beside the run", hidden: true },
      h("h2", {}, "Model beside the run"),
      this.why,
      this.change,
      this.table,
      this.chart.element,
    );
  }

  destroy() {
    this.chart.destroy();
  }

  row(name, cell) {
    const key = h("span", { class: `model-key model-key-${cell}` });
    return h("tr", {}, h("th", { scope: "row" }, key, name), this.cells[cell]);
  }

  update(dirty) {
    if (!["story", "motion", "estimates", "model"].some((type) => dirty.has(type))) return;
    const { motion, estimates } = this.job;
    this.element.hidden = !motion || (motion.state === "none" && !motion.why);
    if (this.element.hidden) return;
    const of_run = motion.state !== "none";
    setText(this.why, motion.why);
    this.why.hidden = !motion.why;
    this.table.hidden = !of_run;
    this.chart.element.hidden = !of_run && !estimates;
    if (of_run) this.showErrors(motion);
    if (dirty.has("estimates") || dirty.has("story")) this.showEstimates(estimates);
  }

  showErrors({ force_rms_mN, force_mean_mN, noise_mN, shape_rms_mm, over_s }) {
    const force = force_rms_mN == null ? "\u2013" : `${number(force_rms_mN, 3)} mN`;
    const noise = `mean ${signed(force_mean_mN, 3)} mN, noise ${number(noise_mN, 3)} mN`;
    const lately = `over the last ${number(over_s, 0)} s`;
    const about = force_rms_mN == null ? "no force is measured" : `${noise}; ${lately}`;
    put(this.cells.force, force, h("small", {}, about));
    const shape = shape_rms_mm == null ? "\u2013" : `${number(shape_rms_mm, 2)} mm`;
    put(this.cells.shape, shape, h("small", {}, shape_rms_mm == null ? "no curve yet" : lately));
  }

  showEstimates(estimates) {
    const rows = rowsOf(estimates);
    const last = rows.at(-1);
    const changes = [];
    for (const name of ["B", "moment"]) {
      const known = last && last[`${name}_sigma`] < KNOWN;
      const cell = this.cells[name];
      if (!known) {
        put(cell, "\u2013", h("small", {}, "not known yet"));
        continue;
      }
      put(cell, ...words(name, last, estimates.model[last.configuration]));
      changes.push(changeOf(name, last));
    }
    setText(this.change, changes.filter(Boolean).join(" "));
    this.change.hidden = !this.change.textContent;
    this.chart.show(["B", "moment"].map((name) => series(name, rows)));
  }
}

/** Rows as objects by column. */
function rowsOf(estimates) {
  const { columns = [], rows = [] } = estimates ?? {};
  return rows.map((row) => Object.fromEntries(columns.map((name, at) => [name, row[at]])));
}

/** A value with its standard deviation, and its share of the model's. */
function words(name, row, model) {
  const [ratio, sigma] = [row[name], row[`${name}_sigma`]];
  const scale = MOMENT_SCALE * model[SOURCES[name]];
  const decimals = Math.max(0, 2 - Math.floor(Math.log10(Math.abs(scale))));
  const value = `${number(scale * ratio, decimals)} \u00B1 ${number(scale * sigma, decimals)} ${UNITS[name]}`;
  const share = `${number(100 * ratio, 1)} \u00B1 ${number(100 * sigma, 1)} % of the model\u2019s`;
  return [value, h("small", {}, `${share}; \u00B1 is one standard deviation`)];
}

/** A sentence where a parameter is clearly not the model's any more. */
function changeOf(name, row) {
  const off = row[name] - 1;
  if (Math.abs(off) < NOTICEABLE || Math.abs(off) < FAR * row[`${name}_sigma`]) return "";
  const side = off > 0 ? "above" : "below";
  const upper = NAMES[name][0].toUpperCase() + NAMES[name].slice(1);
  return `${upper} is ${number(100 * Math.abs(off), 0)} % ${side} the model\u2019s.`;
}

function series(name, rows) {
  const known = rows.filter((row) => row[`${name}_sigma`] < KNOWN);
  return {
    name: NAMES[name],
    points: known.map((row) => [row.time_s / 60, 100 * row[name], 100 * row[`${name}_sigma`]]),
    band: known.map((row) => 100 * row[`${name}_sigma`]),
    colour: COLOURS[name],
    line: true,
    width: 2,
    dashed: name === "moment",
  };
}
