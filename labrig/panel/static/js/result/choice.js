// What of a result is looked at: configuration, set-up, voltage, reading, model; each a slider or list.

import { h, newId, put, setText } from "../dom.js";
import { number, plain, volts } from "../format.js";

/** Calls `changed()` whenever something else is chosen. */
export class Choice {
  constructor(changed) {
    this.changed = changed;
    this.result = null;
    this.chosen = { configuration: null, setup: 0, voltage_V: null, reading: null, model: null };
    this.configuration = this.list("sheet", "configuration");
    this.model = this.list("model", "model");
    this.setup = this.slider("position", (at) => this.choose({ setup: at, reading: null }));
    this.voltage = this.slider("voltage", (at) =>
      this.choose({ voltage_V: this.voltages()[at], reading: null }),
    );
    this.reading = this.slider("time", (at) =>
      this.choose({ reading: at ? this.readings()[at - 1].index : null }),
    );
    this.element = h(
      "div",
      { class: "result-choice" },
      [this.configuration, this.model, this.setup, this.voltage, this.reading].map(
        (one) => one.element,
      ),
    );
  }

  list(name, key) {
    const input = h("select", {
      id: newId(name),
      onchange: () => this.choose({ [key]: input.value, reading: null }),
    });
    const element = h("div", { class: "choose" }, h("label", { for: input.id }, name), input);
    return { input, element };
  }

  slider(name, act) {
    const id = newId(name);
    const output = h("output", { for: id });
    const input = h("input", {
      id,
      type: "range",
      min: 0,
      max: 0,
      step: 1,
      value: 0,
      oninput: () => act(Number(input.value)),
    });
    const element = h(
      "div",
      { class: "choose" },
      h("label", { for: id }, name, " ", output),
      input,
    );
    return { input, output, element };
  }

  choose(changes) {
    Object.assign(this.chosen, changes);
    this.show();
    this.changed();
  }

  /** Another result; what was chosen stays where it is still there. */
  set(result) {
    this.result = result;
    const { chosen } = this;
    const names = result.configurations.map((one) => one.name);
    if (!names.includes(chosen.configuration)) chosen.configuration = names[0] ?? null;
    const models = result.models.map((one) => one.id);
    if (chosen.model !== "none" && !models.includes(chosen.model))
      chosen.model = models.includes("effects") ? "effects" : (models[0] ?? null);
    this.fill(this.configuration, names.map((name) => [name, name]), chosen.configuration);
    const known = result.models.map((one) => [one.id, one.name]);
    this.fill(this.model, [...known, ["none", "none"]], chosen.model ?? "none");
    this.configuration.element.hidden = names.length < 2;
    this.model.element.hidden = !models.length;
    this.show();
  }

  fill({ input }, options, value) {
    put(
      input,
      options.map(([key, name]) => h("option", { value: key, selected: key === value }, name)),
    );
  }

  /** Another result of a run that goes on: the newest set-up, unless another one was chosen. */
  grow(result) {
    const before = this.result && newestOf(this.result);
    const followed = !before || (this.isAt(before) && this.chosen.reading == null);
    this.set(result);
    const newest = newestOf(result);
    if (!followed || !newest) return;
    this.chosen.configuration = newest.configuration;
    this.configuration.input.value = newest.configuration;
    const same = (one) => one.position_mm === newest.position_mm;
    this.chosen.setup = Math.max(0, this.setups().findLastIndex(same));
    this.show();
  }

  isAt({ configuration, position_mm }) {
    const { chosen } = this;
    return (
      chosen.configuration === configuration &&
      this.setups()[chosen.setup]?.position_mm === position_mm
    );
  }

  // --------------------------------------------------------------------------------------- what is

  get part() {
    return this.result?.configurations.find((one) => one.name === this.chosen.configuration);
  }

  /** Places that were set up, by position, those set up again after one another. */
  setups() {
    const found = new Map();
    for (const { position_mm, mounting, run, approach } of this.part?.conditions ?? []) {
      const key = [position_mm, mounting, run].join();
      if (!found.has(key)) found.set(key, { key, position_mm, mounting, run, approach });
    }
    const place = (one) => one.position_mm ?? -Infinity;
    const all = [...found.values()];
    return all
      .map((one) => ({ ...one, name: nameOf(one, all) }))
      .sort((a, b) => place(a) - place(b) || a.mounting - b.mounting || a.run - b.run);
  }

  voltages() {
    return [...(this.part?.voltages_V ?? [])].sort((a, b) => a - b);
  }

  /** The condition that is looked at. */
  condition() {
    const setup = this.setups()[this.chosen.setup];
    return this.part?.conditions.find(
      (one) =>
        setup &&
        [one.position_mm, one.mounting, one.run].join() === setup.key &&
        one.voltage_V === this.chosen.voltage_V,
    );
  }

  /** Its readings that have a curve of their own. */
  readings() {
    return (this.condition()?.readings ?? []).filter((one) => one.curve);
  }

  // ---------------------------------------------------------------------------------------- shown

  show() {
    const { chosen } = this;
    const [setups, voltages] = [this.setups(), this.voltages()];
    chosen.setup = Math.max(0, Math.min(setups.length - 1, chosen.setup));
    if (!voltages.includes(chosen.voltage_V)) chosen.voltage_V = voltages.at(-1) ?? null;
    const setup = setups[chosen.setup];
    this.put(this.setup, setups.length, chosen.setup, setup?.name ?? "\u2013");
    const level = voltages.indexOf(chosen.voltage_V);
    this.put(this.voltage, voltages.length, level, level < 0 ? "\u2013" : volts(chosen.voltage_V));
    const readings = this.readings();
    const at = 1 + readings.findIndex((one) => one.index === chosen.reading);
    if (!at) chosen.reading = null;
    this.reading.element.hidden = !readings.length;
    const words = at ? readingName(readings[at - 1]) : "mean image";
    this.put(this.reading, readings.length + 1, at, words);
  }

  put({ input, output }, count, at, words) {
    input.max = Math.max(0, count - 1);
    input.value = at;
    input.disabled = count < 2;
    input.setAttribute("aria-valuetext", words);
    setText(output, words);
  }
}

/** Where the run has measured last: { configuration, position_mm }; null before there is a fit. */
function newestOf({ convergence }) {
  const last = Object.entries(convergence ?? {}).flatMap(([configuration, steps]) =>
    steps.slice(-1).map((step) => ({ configuration, ...step })),
  );
  return last.sort((a, b) => a.conditions - b.conditions).at(-1) ?? null;
}

/** The position, and what tells set-ups of one position apart. */
export function nameOf({ position_mm, mounting, run, approach }, all) {
  const same = all.filter((one) => one.position_mm === position_mm);
  const differs = (key) => new Set(same.map((one) => one[key])).size > 1;
  return [
    position_mm == null ? "free" : `${plain(position_mm)} mm`,
    approach && differs("approach") && `from ${approach === "up" ? "below" : "above"}`,
    differs("mounting") && `set-up ${mounting + 1}`,
    differs("run") && `measurement ${run + 1}`,
  ]
    .filter(Boolean)
    .join(", ");
}

function readingName({ index, time_s }) {
  return `reading ${index + 1}${time_s == null ? "" : `, ${number(time_s, 2)} s`}`;
}
