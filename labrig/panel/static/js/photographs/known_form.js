// What is clicked and typed about a photograph: clamp, direction, ruler, lengths, strips, and facts:
// the server names these, each with what it is of ("strip" or "picture") and the shape of its value.

import { h, newId, put, setText } from "../dom.js";
import { parseNumber } from "../form/limits.js";

const TOOLS = {
  clamp: "Clamp: click where the strip leaves it.",
  along: "Direction: click a place further along the clamped strip.",
  ruler: "Ruler: click both ends of a known length, and state it in mm.",
};

const NAMES = { clamp: "Clamp", along: "Direction", ruler: "Ruler" };

/** What was typed into a field; an error where it is no length. */
function millimetres({ input, name }) {
  const value = parseNumber(input.value);
  if (value > 0) return value;
  const [what] = name.split(",");
  throw new Error(`${what}: ${input.value.trim()} is no length; give a number above 0, with a point for its decimals.`);
}

const toolOf = (fact) => fact.key.replace(/_px$/, "");

export class KnownForm {
  /** `changed()`: something is to be drawn anew; `send(body, forAll)`: `body()` is to be measured. */
  constructor(changed, send) {
    Object.assign(this, { changed, send, tool: "clamp", strip: "", facts: [], rulerSent: "" });
    this.clear();
    this.toolbar = h("div", { class: "inline", role: "toolbar", "aria-label": "what is clicked" });
    this.showTools();
    this.hint = h("p", { class: "muted", role: "status" });
    this.ruler = this.field("ruler, mm");
    this.free = this.field("free length, mm");
    this.thickness = this.field("thickness, mm (or empty)");
    this.close = h("button", { type: "button", class: "small", onclick: () => this.closeMask() }, "Close the polygon");
    this.unmask = h("button", { type: "button", class: "small", onclick: () => this.removeMask() }, "Remove the last mask");
    this.unplace = h("button", { type: "button", class: "small", onclick: () => this.removePlace() }, "Remove the last place");
    this.strips = h("select", { id: newId("strip"), onchange: () => this.chooseStrip(this.strips.value) });
    this.another = h("button", { type: "button", class: "small", onclick: () => this.addStrip() }, "Another strip");
    this.known = h("p", { class: "muted" });
    this.one = h("button", { type: "button", onclick: () => this.submit(false) }, "Measure this photograph");
    this.all = h("button", { type: "button", class: "main", onclick: () => this.submit(true) }, "Measure all");
    this.element = h("div", { class: "photograph-known" },
      h("div", { class: "inline" },
        this.toolbar,
        this.close, this.unmask, this.unplace, h("label", { for: this.strips.id }, "strip"), this.strips, this.another),
      this.hint,
      h("div", { class: "photograph-fields" },
        [this.ruler, this.free, this.thickness].map(({ input, name }) =>
          h("p", {}, h("label", { for: input.id }, name), input))),
      this.known,
      h("div", { class: "inline" }, this.all, this.one),
    );
    this.choose("clamp");
    this.showStrips();
  }

  field(name) {
    return { name, input: h("input", { id: newId("mm"), inputmode: "decimal", class: "short", autocomplete: "off" }) };
  }

  clear() {
    Object.assign(this, { places: { "": {} }, pictures: {}, rulerPx: [], open: [], dirty: false });
  }

  /** A button for each tool: ours, and one for each fact that can be clicked. */
  showTools() {
    const names = [...Object.entries(NAMES), ...this.facts.map((fact) => [toolOf(fact), fact.label])];
    this.tools = names.map(([tool, label]) =>
      h("button", { type: "button", class: "small", "data-tool": tool, onclick: () => this.choose(tool) }, label),
    );
    put(this.toolbar, this.tools);
  }

  /** The fact that is clicked with the tool in use, if it is one. */
  get fact() {
    return this.facts.find((fact) => toolOf(fact) === this.tool);
  }

  /** Where the values of a fact are: with the strip, or with the pictures. */
  holder(fact) {
    return fact.of === "strip" ? (this.places[this.strip] ??= {}) : this.pictures;
  }

  /** Take what the server knows of a photograph; what was typed stays. */
  take({ known, known_fault: fault, sheet, tools }) {
    this.clear();
    this.facts = tools;
    this.showTools();
    if (known) {
      this.places = Object.fromEntries(Object.entries(known.strips).map(([name, place]) => [name, { ...place }]));
      for (const { key, of } of tools) if (of === "picture") this.pictures[key] = known[key];
    }
    if (!(this.strip in this.places)) this.strip = Object.keys(this.places)[0];
    const origin = known ? [known.file, known.method].filter(Boolean).join(": ") : "";
    const scale = known ? `${known.px_per_mm.toPrecision(4)} pixels a mm (${origin})` : "no scale yet: click a ruler";
    setText(this.known, fault || `${scale}; ${sheet || "no length yet: state it"}.`);
    this.choose(known ? this.tool : "clamp");
    this.showStrips();
  }

  get drawn() {
    return { strips: this.places, pictures: this.pictures, facts: this.facts, ruler: this.rulerPx, open: this.open };
  }

  choose(tool) {
    this.tool = tool;
    for (const button of this.tools) button.setAttribute("aria-pressed", button.dataset.tool === tool);
    setText(this.hint, TOOLS[tool] ?? this.fact.hint);
    this.close.hidden = this.unmask.hidden = this.fact?.shape !== "polygons";
    this.unplace.hidden = !this.fact || this.fact.shape === "polygons";
    if (this.close.hidden) this.open = [];
  }

  clicked(px) {
    this.dirty = true; // what was clicked is kept until it is sent, or another photograph is opened
    const place = (this.places[this.strip] ??= {});
    const fact = this.fact;
    if (this.tool === "clamp") {
      place.clamp_px = px;
      place.along_px = null; // it belonged to the other place
      this.choose("along");
    } else if (this.tool === "along") {
      place.along_px = px;
      if (!this.known.textContent.includes("a mm")) this.choose("ruler");
    } else if (this.tool === "ruler") this.rulerPx = this.rulerPx.length === 1 ? [this.rulerPx[0], px] : [px];
    else if (fact.shape === "polygons") this.open.push(px);
    else if (fact.shape === "points") this.add(fact, px);
    else this.holder(fact)[fact.key] = px;
    this.changed();
  }

  add(fact, value) {
    const holder = this.holder(fact);
    holder[fact.key] = [...(holder[fact.key] ?? []), value];
  }

  closeMask() {
    if (this.open.length < 3) return setText(this.hint, "A polygon needs at least three corners.");
    this.dirty = true;
    this.add(this.fact, this.open);
    this.open = [];
    this.changed();
  }

  removeMask() {
    if (this.open.length) this.open = [];
    else this.removePlace();
    this.changed();
  }

  removePlace() {
    this.dirty = true;
    const { fact } = this;
    const holder = this.holder(fact);
    holder[fact.key] = fact.shape === "point" ? null : (holder[fact.key] ?? []).slice(0, -1);
    this.changed();
  }

  chooseStrip(name) {
    this.strip = name;
    this.choose("clamp");
    this.changed();
  }

  addStrip() {
    const letters = "abcdefghijklmnopqrstuvwxyz";
    this.dirty = true;
    if ("" in this.places) {
      this.places = { a: this.places[""] };
    }
    const name = [...letters].find((letter) => !(letter in this.places));
    if (!name) return;
    this.places[name] = {};
    this.showStrips();
    this.strips.value = name;
    this.chooseStrip(name);
  }

  showStrips() {
    const names = Object.keys(this.places);
    put(this.strips, names.map((name) => h("option", { value: name, selected: name === this.strip }, name || "the only one")));
  }

  /** What is sent to the server; an error where what is stated cannot be, or not without more. */
  body() {
    const placed = Object.entries(this.places).filter(([, place]) => place.clamp_px);
    const single = placed.length === 1 && placed[0][0] === "";
    const body = { ...this.pictures };
    if (single) body.clamp = placed[0][1];
    else if (placed.length) body.strips = Object.fromEntries(placed);
    if (this.rulerPx.length === 2) body.ruler_px = this.rulerPx;
    for (const [key, field] of [["ruler_mm", this.ruler], ["free_length_mm", this.free], ["thickness_mm", this.thickness]])
      if (field.input.value.trim()) body[key] = millimetres(field);
    if (body.thickness_mm !== undefined && body.free_length_mm === undefined)
      throw new Error("A thickness is stated: state the free length as well, or empty the field.");
    if (!body.ruler_px) {
      const stated = this.ruler.input.value.trim();
      if (stated && stated !== this.rulerSent)
        throw new Error("A ruler's length is stated: click both its ends again (Ruler), or empty the field.");
      delete body.ruler_mm;
    }
    return body;
  }

  submit(forAll) {
    this.send(() => this.body(), forAll);
  }

  /** What was sent is kept by the server. */
  sent() {
    Object.assign(this, { rulerPx: [], rulerSent: this.ruler.input.value.trim(), dirty: false });
  }
}
