// What is clicked and typed about a photograph: clamp, direction, ruler, mask, lengths, strips.

import { h, newId, put, setText } from "../dom.js";
import { parseNumber } from "../form/limits.js";

const TOOLS = {
  clamp: "Clamp: click where the strip leaves it.",
  along: "Direction: click a place further along the clamped strip.",
  ruler: "Ruler: click both ends of a known length, and state it in mm.",
  through: "On the strip: where a curve leaves it, click places on its middle, from the clamp on. For this photograph alone.",
  tip: "Tip: click where the strip ends; no length need be stated then. For this photograph alone.",
  mask: "Mask: click the corners around what confuses; then close the polygon.",
};

const NAMES = { clamp: "Clamp", along: "Direction", ruler: "Ruler", through: "On the strip", tip: "Tip", mask: "Mask" };

export class KnownForm {
  /** `changed()`: something is to be drawn anew; `send(body, forAll)`: it is to be measured. */
  constructor(changed, send) {
    Object.assign(this, { changed, send, tool: "clamp", strip: "" });
    this.clear();
    this.tools = Object.keys(TOOLS).map((name) =>
      h("button", { type: "button", class: "small", "data-tool": name, onclick: () => this.choose(name) },
        NAMES[name]),
    );
    this.hint = h("p", { class: "muted", role: "status" });
    this.ruler = this.field("ruler, mm");
    this.free = this.field("free length, mm");
    this.thickness = this.field("thickness, mm (or empty)");
    this.close = h("button", { type: "button", class: "small", onclick: () => this.closeMask() }, "Close the polygon");
    this.unmask = h("button", { type: "button", class: "small", onclick: () => this.removeMask() }, "Remove the last mask");
    this.unplace = h("button", { type: "button", class: "small", onclick: () => this.removePlace() }, "Remove the last place");
    this.strips = h("select", { id: newId("strip"), onchange: () => this.chooseStrip(this.strips.value) });
    this.add = h("button", { type: "button", class: "small", onclick: () => this.addStrip() }, "Another strip");
    this.known = h("p", { class: "muted" });
    this.one = h("button", { type: "button", onclick: () => this.submit(false) }, "Measure this photograph");
    this.all = h("button", { type: "button", class: "main", onclick: () => this.submit(true) }, "Measure all");
    this.element = h("div", { class: "photograph-known" },
      h("div", { class: "inline" },
        h("div", { class: "inline", role: "toolbar", "aria-label": "what is clicked" }, this.tools),
        this.close, this.unmask, this.unplace, h("label", { for: this.strips.id }, "strip"), this.strips, this.add),
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
    Object.assign(this, { places: { "": {} }, rulerPx: [], masks: [], open: [], dirty: false });
  }

  /** Take what the server knows of a photograph; what was typed stays. */
  take({ known, known_fault: fault, sheet }) {
    this.clear();
    if (known) {
      this.places = Object.fromEntries(Object.entries(known.strips).map(([name, place]) => [name, { ...place }]));
      this.masks = known.mask_px.map((polygon) => polygon.map((corner) => [...corner]));
    }
    if (!(this.strip in this.places)) this.strip = Object.keys(this.places)[0];
    const scale = known ? `${known.px_per_mm.toPrecision(4)} pixels a mm (${known.method || "optics.json"})` : "no scale yet: click a ruler";
    setText(this.known, fault || `${scale}; ${sheet || "no length yet: state it"}.`);
    this.choose(known ? this.tool : "clamp");
    this.showStrips();
  }

  get drawn() {
    return { strips: this.places, ruler: this.rulerPx, masks: this.masks, open: this.open };
  }

  choose(tool) {
    this.tool = tool;
    for (const button of this.tools ?? []) button.setAttribute("aria-pressed", button.dataset.tool === tool);
    setText(this.hint, TOOLS[tool]);
    this.close.hidden = this.unmask.hidden = tool !== "mask";
    this.unplace.hidden = tool !== "through" && tool !== "tip";
  }

  clicked(px) {
    this.dirty = true; // what was clicked is kept until it is sent, or another photograph is opened
    const place = (this.places[this.strip] ??= {});
    if (this.tool === "clamp") {
      place.clamp_px = px;
      place.along_px = null; // it belonged to the other place
      this.choose("along");
    } else if (this.tool === "along") {
      place.along_px = px;
      if (!this.known.textContent.includes("a mm")) this.choose("ruler");
    } else if (this.tool === "through") place.through_px = [...(place.through_px ?? []), px];
    else if (this.tool === "tip") place.tip_px = px;
    else if (this.tool === "ruler") this.rulerPx = this.rulerPx.length === 1 ? [this.rulerPx[0], px] : [px];
    else this.open.push(px);
    this.changed();
  }

  closeMask() {
    if (this.open.length < 3) return setText(this.hint, "A mask needs at least three corners.");
    this.dirty = true;
    this.masks.push(this.open);
    this.open = [];
    this.changed();
  }

  removeMask() {
    this.dirty = true;
    if (this.open.length) this.open = [];
    else this.masks.pop();
    this.changed();
  }

  removePlace() {
    this.dirty = true;
    const place = this.places[this.strip] ?? {};
    if (this.tool === "tip") place.tip_px = null;
    else place.through_px = (place.through_px ?? []).slice(0, -1);
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

  /** What is sent to the server. */
  body() {
    const placed = Object.entries(this.places).filter(([, place]) => place.clamp_px);
    const single = placed.length === 1 && placed[0][0] === "";
    const body = { mask_px: this.masks };
    if (single) body.clamp = placed[0][1];
    else if (placed.length) body.strips = Object.fromEntries(placed);
    if (this.rulerPx.length === 2) body.ruler_px = this.rulerPx;
    for (const [key, { input }] of [["ruler_mm", this.ruler], ["free_length_mm", this.free], ["thickness_mm", this.thickness]])
      if (input.value.trim()) body[key] = parseNumber(input.value);
    if (body.thickness_mm !== undefined && body.free_length_mm === undefined) delete body.thickness_mm;
    if (!body.ruler_px) delete body.ruler_mm;
    return body;
  }

  submit(forAll) {
    this.send(this.body(), forAll);
  }
}
