// The charts of a result: the sheet in millimetres, F(p), and how B and EIBM settle.

import { shapeFor } from "../chart/draw.js";
import { h, put, setText } from "../dom.js";
import { number, volts, withInterval } from "../format.js";
import { Chart } from "../plot.js";
import { nameOf } from "./choice.js";

const POSITION = { name: "position p", symbol: "p", unit: "mm", decimals: 2 };
const COLOURS = { 1: "--plus", "-1": "--minus", 0: "--zero" };

export const colourFor = (voltage) => COLOURS[Math.sign(voltage)];

function card(title, note, ...children) {
  return h(
    "section",
    { class: "card" },
    h("h2", {}, title, " ", h("span", { class: "muted" }, note)),
    ...children,
  );
}

/** Points of a curve of the result. */
function pointsOf(curve) {
  return curve.x_mm.map((x, at) => [x, curve.y_mm[at]]);
}

/** All curves thin, the chosen one thick, the model dashed on top of it. */
export class SheetChart {
  constructor() {
    this.chart = new Chart({
      label: "the sheet, in millimetres",
      className: "chart-sheet",
      x: { name: "x", unit: "mm", decimals: 3 },
      y: { name: "y", unit: "mm", decimals: 3 },
      equal: true,
      scene: (context, to, more) => this.scene(context, to, more),
    });
    this.key = h("p", { class: "keys" });
    this.element = card("The sheet", "in millimetres; the model\u2019s band holds 90 % of new measurements", this.chart.element, this.key);
    this.element.classList.add("result-sheet");
  }

  destroy() {
    this.chart.destroy();
  }

  show(choice, reading) {
    const { part, chosen } = choice;
    if (!part) return this.chart.show([]);
    this.sheet = part.sheet;
    this.positions = part.positions_mm;
    const condition = choice.condition();
    const rest = part.conditions.filter((one) => one !== condition && one.curve);
    const level = (one) => (one.voltage_V === chosen.voltage_V ? 1 : 0);
    rest.sort((a, b) => level(a) - level(b));
    const thin = rest.map((one) => ({
      name: `${nameOf(one, part.conditions)}, ${volts(one.voltage_V)}`,
      points: pointsOf(one.curve),
      colour: colourFor(one.voltage_V),
      line: true,
      width: level(one) ? 1.1 : 0.7,
      faint: !level(one),
      silent: true,
    }));
    const shown = condition ? this.chosen(condition, reading, choice) : [];
    this.chart.options.include = this.around();
    this.chart.show([...thin, ...shown]);
    this.showKey(condition, shown, choice.result);
  }

  chosen(condition, reading, { part, chosen: { model } }) {
    const name = `${nameOf(condition, part.conditions)}, ${volts(condition.voltage_V)}`;
    const curve = reading?.curve ?? condition.curve;
    const predicted = condition.models[model]?.curve;
    return [
      curve && {
        name: `measured, ${name}`,
        points: pointsOf(curve),
        colour: colourFor(condition.voltage_V),
        line: true,
        width: 4,
        band: curve.half90_mm,
        normal: true,
      },
      predicted && {
        name: `model, ${name}`,
        points: pointsOf(predicted),
        colour: "--ink",
        line: true,
        dashed: true,
        width: 1.75,
        band: predicted.half90_mm,
        normal: true,
      },
    ].filter(Boolean);
  }

  showKey(condition, shown, { missing: lacks }) {
    const sign = `sign-${Math.sign(condition?.voltage_V ?? 0)}`;
    const looked = !lacks.some((one) => one.kind === "analyze");
    const none = looked ? "no curve was found here" : "Analyse looks for the curves";
    const missing = condition && !condition.curve ? none : "";
    const why = condition?.models ? Object.values(condition.models).find((one) => one.why)?.why : "";
    put(
      this.key,
      shown.map((one) =>
        h("span", { class: `line-key ${one.dashed ? "line-key-dashed" : sign}` }, one.name),
      ),
      missing && h("span", { class: "muted" }, missing),
      why && h("span", { class: "muted" }, `model: ${why}`),
    );
  }

  /** Places that are always shown: the clamp and the arc where the load cell stood. */
  around() {
    return [[0, 0], ...this.positions.map((position) => this.onArc(position))];
  }

  onArc(position_mm, more = 0) {
    const { arc_radius_mm: radius, arc_origin_deg: origin } = this.sheet;
    const angle = position_mm / radius + (Math.PI / 180) * origin;
    return [(radius + more) * Math.cos(angle), (radius + more) * Math.sin(angle)];
  }

  scene(context, to, { colour, ratio }) {
    if (!this.sheet) return;
    const tall = 0.05 * this.sheet.arc_radius_mm;
    context.globalAlpha = 0.35;
    context.fillStyle = colour("--ink");
    const [left, top] = [to.x(-2 * tall), to.y(tall)];
    context.fillRect(left, top, to.x(0) - left, to.y(-tall) - top);
    context.globalAlpha = 1;
    context.strokeStyle = colour("--edge");
    context.lineWidth = ratio;
    if (!this.positions.length) return;
    const [low, high] = [Math.min(...this.positions) - 3, Math.max(...this.positions) + 3];
    context.beginPath();
    for (let at = 0; at <= 60; at += 1) {
      const [x, y] = this.onArc(low + (at / 60) * (high - low));
      context.lineTo(to.x(x), to.y(y));
    }
    for (const position of this.positions) {
      const [inner, outer] = [this.onArc(position, -0.8), this.onArc(position, 0.8)];
      context.moveTo(to.x(inner[0]), to.y(inner[1]));
      context.lineTo(to.x(outer[0]), to.y(outer[1]));
    }
    context.stroke();
  }
}

/** Measured means with their standard errors, and the model's lines with their bands. */
export class ForceChart {
  constructor() {
    this.chart = new Chart({
      label: "force over position",
      x: POSITION,
      y: { name: "force F", symbol: "F", unit: "mN", decimals: 3 },
      zero: true,
      leastX: 2,
      leastY: 0.05,
    });
    this.key = h("p", { class: "keys" });
    this.element = card(
      "Force over position",
      "means with standard errors; the model\u2019s band holds 90 % of new measurements",
      this.chart.element,
      this.key,
    );
  }

  destroy() {
    this.chart.destroy();
  }

  show({ part, chosen, ...choice }, condition) {
    const levels = part?.voltages_V ?? [];
    const lines = (part?.lines ?? []).filter((one) => one.model === chosen.model);
    const series = lines.map((line) => ({
      name: `model, ${volts(line.voltage_V)}`,
      points: line.p_mm.map((p, at) => [p, line.F_mN[at]]),
      band: line.half90_mN,
      colour: colourFor(line.voltage_V),
      line: true,
      dashed: true,
      words: ([p, F], at) =>
        `p ${number(p, 2)} mm, F ${number(F, 3)} mN, 90 % of new measurements within \u00B1 ${number(line.half90_mN[at], 3)} mN`,
    }));
    for (const level of levels) series.push(measured(part, level));
    if (condition?.force) series.push(marked(condition));
    this.chart.show(series);
    put(
      this.key,
      levels.map((level) =>
        h("span", { class: `line-key sign-${Math.sign(level)}` }, volts(level)),
      ),
    );
  }
}

function measured(part, level) {
  const known = part.conditions.filter((one) => one.voltage_V === level && one.force);
  return {
    name: `measured, ${volts(level)}`,
    points: known.map((one) => [one.position_mm, one.force.mean_mN, one.force.sigma_mN]),
    colour: colourFor(level),
    shape: shapeFor(level),
    words: ([p, F, error], at) =>
      `p ${number(p, 2)} mm, F ${number(F, 3)} \u00B1 ${number(error, 3)} mN, ` +
      `${known[at].force.readings} readings`,
  };
}

/** The chosen condition, ringed. */
function marked({ position_mm, voltage_V, force }) {
  return {
    name: "chosen",
    points: [[position_mm, force.mean_mN]],
    colour: colourFor(voltage_V),
    shape: shapeFor(voltage_V),
    size: 7,
    silent: true,
  };
}

/** B and EIBM with 90 % intervals against the number of positions measured so far. */
export class Settling {
  constructor() {
    this.charts = new Map(); // what -> chart
    this.place = h("div", { class: "result-settling" });
    this.said = h("p", { class: "muted" });
    this.element = card(
      "B and constant EIBM as positions are added",
      "90 % intervals",
      this.place,
      this.said,
    );
  }

  destroy() {
    for (const chart of this.charts.values()) chart.destroy();
  }

  show({ result, part }) {
    const steps = (part && result.convergence[part.name]) ?? [];
    const known = steps.filter((one) => one.B_uNm2);
    const levels = [...new Set(known.flatMap((one) => Object.keys(one.EIBM_uNm)))].map(Number);
    const asked = new Map(
      known.length ? [["B", series("B", known, (one) => one.B_uNm2, "--ink", "square")]] : [],
    );
    for (const level of levels.sort((a, b) => b - a)) {
      const of = (one) => one.EIBM_uNm[keyOf(level, one.EIBM_uNm)];
      const name = `EIBM at ${volts(level)}`;
      const there = known.filter(of);
      asked.set(name, series(name, there, of, colourFor(level), shapeFor(level)));
    }
    for (const [name, chart] of this.charts) if (!asked.has(name)) this.drop(name, chart);
    for (const [name, one] of asked) this.chart(name).show([one]);
    const last = steps.at(-1);
    const why = last && !last.B_uNm2 ? last.why : "";
    const count = known.length ? `${capital(after(known.at(-1).positions))}: ` : "";
    const newest = known.length ? `${count}${inWords(known.at(-1))}` : "";
    setText(this.said, why || `${newest}${later(known, result)}` || "B and EIBM are not computed yet.");
  }

  drop(name, chart) {
    chart.element.remove();
    chart.destroy();
    this.charts.delete(name);
  }

  chart(name) {
    if (!this.charts.has(name)) {
      const unit = name === "B" ? "\u00B5N\u00B7m\u00B2" : "\u00B5N\u00B7m";
      const chart = new Chart({
        label: `${name} against the number of positions measured`,
        x: { name: "positions measured", unit: "", decimals: 0, whole: true },
        y: { name, unit, decimals: 3 },
        leastX: 2,
        leastY: 0.01,
        className: "chart-small",
        hint: "",
      });
      this.charts.set(name, chart);
      this.place.append(chart.element);
    }
    return this.charts.get(name);
  }
}

const after = (count) => `after ${count} position${count === 1 ? "" : "s"}`;
/** Why the parameters differ from the last step: the sheets are fitted together. */
function later(known, { configurations }) {
  const all = configurations.reduce((sum, one) => sum + one.conditions.length, 0);
  if (!known.length || known.at(-1).conditions >= all) return "";
  return " The parameters below take in what was measured after that, too.";
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** B of a step with its interval, for whoever does not read it off the chart. */
function inWords({ B_uNm2 }) {
  const [value, low, high] = withInterval(B_uNm2);
  return `B ${value} \u00B5N\u00B7m\u00B2, 90 %: ${low} to ${high}.`;
}

function keyOf(level, values) {
  return Object.keys(values).find((key) => Number(key) === level);
}

function series(name, steps, of, colour, shape) {
  return {
    name,
    points: steps.map((one) => [
      one.positions,
      of(one).value,
      0.5 * (of(one).interval90[1] - of(one).interval90[0]),
    ]),
    colour,
    shape,
    line: true,
    words: (_, at) => {
      const [value, low, high] = withInterval(of(steps[at]));
      const place = steps[at].position_mm;
      const newest = place == null ? "" : ` (last ${number(place, 1)} mm)`;
      return `${value}, 90 %: ${low} to ${high}, ${after(steps[at].positions)}${newest}`;
    },
  };
}
