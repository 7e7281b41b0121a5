// A folder of photographs: every curve as a small picture; click, correct, accept, refuse.

import { h, newId, put, setText } from "../dom.js";
import { get, post, query } from "../net.js";
import { PhotographCanvas } from "../photographs/canvas.js";
import { KnownForm } from "../photographs/known_form.js";

const POLL_MS = 1000;
const SHOW = {
  all: () => true,
  "to look at": (one) => !one.decision && one.state !== "waiting",
  "no curve": (one) => one.state !== "found" && one.state !== "waiting",
  found: (one) => one.state === "found",
  accepted: (one) => one.decision === "accepted",
  refused: (one) => one.decision === "refused",
};
const MARKS = { accepted: "\u2713 accepted", refused: "\u2715 refused by hand" };
const WORDS = {
  waiting: "waiting\u2026", found: "found", refused: "no curve", unreadable: "cannot be read", new: "not clicked yet",
};

/** Show the page. */
export function mount(place, app) {
  if (!document.querySelector("link[href$='css/photographs.css']"))
    document.head.append(h("link", { rel: "stylesheet", href: "/static/css/photographs.css" }));
  const page = new Photographs(app);
  place.append(page.element);
  page.poll();
  return page;
}

class Photographs {
  constructor(app) {
    Object.assign(this, { app, since: 0, list: new Map(), tiles: new Map(), current: null, gone: false, turn: 0 });
    this.said = h("p", { class: "muted", role: "status" }, "reading the folder\u2026");
    this.fault = h("p", { class: "fault", role: "alert" });
    this.done = h("p", { class: "good", role: "status" });
    this.filter = h("select", { id: newId("show"), onchange: () => this.arrange() },
      Object.keys(SHOW).map((name) => h("option", { value: name }, name)));
    this.gallery = h("div", { class: "photographs-gallery", role: "list", "aria-label": "photographs" });
    this.tables = h("button", { type: "button", onclick: () => this.act(() => this.writeTables()) }, "Write the tables");
    this.title = h("h2");
    this.canvasElement = h("canvas", { class: "photograph-canvas" });
    this.canvas = new PhotographCanvas(this.canvasElement, (px) => this.form.clicked(px));
    this.form = new KnownForm(() => this.draw(), (body, forAll) => this.act(() => this.sendKnown(body, forAll)));
    this.why = h("p", { class: "photograph-why", role: "status" });
    this.note = h("input", { id: newId("note"), placeholder: "why (optional)", maxlength: 400 });
    const button = (words, work, kind = "") => h("button", { type: "button", class: kind, onclick: work }, words);
    this.accept = button("Accept (A)", () => this.act(() => this.decide("accepted")), "main");
    this.refuse = button("Refuse (R)", () => this.act(() => this.decide("refused")));
    this.undo = button("Undecided", () => this.act(() => this.decide("none")), "small");
    this.acceptAll = button("Accept all that are shown", () => this.act(() => this.acceptShown()), "small");
    this.editor = h("div", { class: "photograph-editor", hidden: true },
      h("div", { class: "inline" }, button("\u2190", () => this.step(-1), "small"), this.title, button("\u2192", () => this.step(1), "small")),
      this.canvasElement, this.why,
      h("div", { class: "inline" }, this.accept, this.refuse, this.undo, h("label", { for: this.note.id, class: "visually-hidden" }, "why"), this.note),
      this.form.element);
    this.element = h("div", { class: "photographs" },
      h("h1", {}, "Curves of photographs"),
      h("div", { class: "inline photographs-bar" }, h("label", { for: this.filter.id }, "show"), this.filter, this.acceptAll, this.tables, this.said),
      this.fault, this.done,
      h("div", { class: "photographs-two" }, this.gallery, this.editor));
    this.keys = (event) => this.key(event);
    addEventListener("keydown", this.keys);
  }

  destroy() {
    this.gone = true;
    clearTimeout(this.timer);
    removeEventListener("keydown", this.keys);
    this.canvas.destroy();
  }

  // ------------------------------------------------------------------------------------ the list

  async poll() {
    clearTimeout(this.timer);
    try {
      this.update(await get(`/api/photographs?${query({ since: this.since })}`));
    } catch (error) {
      setText(this.said, error.message);
    }
    if (!this.gone) this.timer = setTimeout(() => this.poll(), POLL_MS);
  }

  update(found) {
    this.since = found.revision + 1;
    for (const one of found.photographs) this.take(one);
    const count = (test) => [...this.list.values()].filter(test).length;
    const parts = [`${found.total} photographs`, `${count(SHOW.found)} with a curve`, `${count((one) => one.decision === "accepted")} accepted`,
      `${count((one) => one.decision === "refused")} refused by hand`];
    if (found.waiting) parts.push(`${found.waiting} still to be measured`);
    if (found.videos) parts.push(`${found.videos} videos, which labrig curves --batch measures`);
    setText(this.said, found.total ? `${parts.join(", ")}. ${found.unused}` : "There is no photograph in this folder.");
    this.arrange();
    if (!this.current && this.list.size) this.open([...this.list.keys()][0]);
  }

  take(one) {
    const before = this.list.get(one.name);
    this.list.set(one.name, one);
    if (before?.revision === one.revision) return;
    this.showTile(one);
    if (one.name === this.current) this.load(one.name);
  }

  showTile(one) {
    let tile = this.tiles.get(one.name);
    if (!tile) {
      const image = h("img", { alt: "", loading: "lazy" });
      const words = h("figcaption");
      const element = h("figure", { class: "photograph-tile", role: "listitem" },
        h("button", { type: "button", class: "photograph-open", "aria-label": one.name, onclick: () => this.open(one.name) }, image), words);
      tile = { element, image, words };
      this.tiles.set(one.name, tile);
    }
    tile.element.dataset.state = one.state;
    tile.element.dataset.decision = one.decision ?? "";
    if (one.size && one.state !== "waiting")
      tile.image.src = `/api/photographs/thumbnail?${query({ name: one.name, v: one.revision })}`;
    const state = MARKS[one.decision] ?? WORDS[one.state];
    const warned = one.state === "found" && one.warnings.length ? ` \u26A0 ${one.warnings.length}` : "";
    put(tile.words, h("b", {}, one.name), h("span", { class: "photograph-state" }, `${state}${warned}${one.own ? " \u00B7 own" : ""}`));
    tile.element.title = one.why || one.warnings.join("; ");
  }

  get shown() {
    return [...this.list.values()].filter(SHOW[this.filter.value]);
  }

  arrange() {
    const wanted = this.shown.map((one) => this.tiles.get(one.name).element);
    const there = [...this.gallery.children];
    if (wanted.length !== there.length || wanted.some((element, at) => element !== there[at]))
      put(this.gallery, wanted);
  }

  // ---------------------------------------------------------------------------- one photograph

  open(name) {
    if (name === this.current) return; // to load it again would undo what was clicked meanwhile
    if (this.current) this.tiles.get(this.current)?.element.removeAttribute("aria-current");
    this.current = name;
    this.tiles.get(name)?.element.setAttribute("aria-current", "true");
    this.editor.hidden = false;
    this.loadedPicture = null;
    this.load(name);
  }

  async load(name) {
    const turn = (this.turn += 1);
    try {
      const details = await get(`/api/photographs/details?${query({ name })}`);
      if (turn !== this.turn || this.gone) return;
      this.details = details;
      if (this.loadedPicture !== name) {
        const answer = await fetch(`/api/photographs/picture?${query({ name })}`);
        if (!answer.ok) throw new Error((await answer.json()).error);
        const bitmap = await createImageBitmap(await answer.blob());
        if (turn !== this.turn || this.gone) return bitmap.close();
        this.loadedPicture = name;
        this.canvas.setPicture(bitmap, details.size);
        this.form.take(details);
      } else if (details.state !== "waiting" && !this.form.dirty) this.form.take(details);
      this.showDetails();
    } catch (error) {
      setText(this.why, error.message);
    }
  }

  showDetails() {
    const one = this.details;
    const decision = MARKS[one.decision] ? ` \u2014 ${MARKS[one.decision]}` : "";
    setText(this.title, `${one.file}${decision}`);
    const said = one.state === "found" ? one.warnings.join("; ") || "found, without a warning" : one.why || WORDS[one.state];
    setText(this.why, one.note ? `${said} (${one.note})` : said);
    this.why.dataset.state = one.state;
    this.accept.disabled = one.state !== "found";
    this.draw();
  }

  draw() {
    this.canvas.show({ curves: this.details?.curves ?? [], ...this.form.drawn });
  }

  step(by) {
    const names = this.shown.map((one) => one.name);
    const at = names.indexOf(this.current);
    const next = names[Math.min(Math.max(at + by, 0), names.length - 1)];
    if (!next || next === this.current) return;
    this.open(next);
    this.tiles.get(next).element.scrollIntoView({ block: "nearest" });
  }

  key(event) {
    if (event.target.closest?.("input, select, textarea, canvas") || event.ctrlKey || event.metaKey || event.altKey) return;
    const work = {
      a: () => this.details?.state === "found" && this.act(() => this.decide("accepted")),
      r: () => this.act(() => this.decide("refused")),
      ArrowLeft: () => this.step(-1),
      ArrowRight: () => this.step(1),
    }[event.key];
    if (!work || !this.current) return;
    event.preventDefault();
    work();
  }

  // ----------------------------------------------------------------------------------- to act

  async act(work) {
    setText(this.fault, "");
    setText(this.done, "");
    try {
      await this.app.control.act(work);
    } catch (error) {
      setText(this.fault, error.message);
    }
  }

  async sendKnown(body, forAll) {
    const done = await post("/api/photographs/known", { ...body(), name: this.current, for_all: forAll });
    this.form.sent();
    setText(this.done, `Wrote ${done.written.join(" and ")}; ${done.measured_again} to be measured again.`);
    await this.poll();
  }

  async decide(decision) {
    const name = this.current;
    await post("/api/photographs/decide", { names: [name], decision, note: this.note.value.trim() });
    this.note.value = "";
    if (decision !== "none") this.step(1);
    await this.poll();
  }

  async acceptShown() {
    const names = this.shown.filter((one) => one.state === "found" && !one.decision).map((one) => one.name);
    if (!names.length) throw new Error("None of those that are shown has a curve that is undecided.");
    await post("/api/photographs/decide", { names, decision: "accepted" });
    setText(this.done, `Accepted ${names.length}.`);
    await this.poll();
  }

  async writeTables() {
    const { written } = await post("/api/photographs/tables");
    setText(this.done, `Wrote ${written.join(" and ")}.`);
  }
}
