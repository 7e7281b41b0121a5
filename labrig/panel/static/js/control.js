// Who holds control: one acts, the others watch. STOP belongs to everybody and is not here.

import { h, newId, put } from "./dom.js";
import { post } from "./net.js";

const KEY = "labrig-operator";
const HELD = "labrig-held";

/** What the server says of control, and this page's way to take it. */
export class Control {
  constructor() {
    this.client = null;
    this.state = { holder: null, name: null, clients: 1 };
    this.name = localStorage.getItem(KEY) ?? "";
    this.watchers = new Set();
  }

  /** The server's name for this page. One that is loaded again wants back what it held. */
  arrived(client) {
    this.client = client;
    this.wanted = sessionStorage.getItem(HELD) === "yes";
  }

  set(state) {
    this.state = { ...this.state, ...state };
    if (this.mine) this.wanted = false;
    sessionStorage.setItem(HELD, this.mine || this.wanted ? "yes" : "no");
    if (this.wanted && this.free) {
      this.wanted = false;
      this.take().catch(() => {}); // somebody was faster
    }
    for (const update of this.watchers) update();
  }

  get mine() {
    return this.client !== null && this.state.holder === this.client;
  }

  /** Whether control is to be had: nobody holds it, or whoever does has gone. */
  get free() {
    return !this.state.holder || this.state.here === false;
  }

  /** Why this page may not act; empty when it may (control that is free is taken by acting). */
  why() {
    if (this.mine || this.free) return "";
    return `${this.state.name || "Somebody else"} holds control; this page watches. Take control to act.`;
  }

  /** Act as the holder: takes control first where nobody has it. */
  async act(work) {
    if (!this.mine && this.free) await this.take();
    return work();
  }

  async take(force = false) {
    const body = { do: "take", name: this.name || "operator" };
    this.set(await post("/api/control", force ? { ...body, force } : body));
  }

  async release() {
    this.set(await post("/api/control", { do: "release" }));
  }

  rename(name) {
    this.name = name.trim();
    localStorage.setItem(KEY, this.name);
  }
}

/** The words and the button in the bar. */
export function controlView(control, place, fault) {
  const id = newId("name");
  const field = h("input", {
    id,
    value: control.name,
    maxlength: 40,
    placeholder: "your name",
    autocomplete: "name",
    onchange: () => control.rename(field.value),
    // not from somebody else: that takes the button, which says so
    onkeydown: ({ key }) => key === "Enter" && control.free && press(),
  });
  const held = h("span", { class: "control-held" });
  const button = h("button", { type: "button", class: "small", onclick: () => press() });
  const press = async () => {
    try {
      control.rename(field.value);
      if (control.mine) await control.release();
      else await control.take(!control.free);
    } catch (error) {
      fault(error.message);
    }
  };
  const show = () => {
    const { name, clients } = control.state;
    const pages = clients > 1 ? ` \u00B7 ${clients} pages` : "";
    held.textContent = `Control: ${control.mine ? `you (${name || "operator"})` : control.free ? "nobody" : name || "somebody else"}${pages}`;
    held.dataset.mine = control.mine;
    button.textContent = control.mine ? "Release" : !control.free ? "Take over" : "Take control";
    const focused = document.activeElement === field;
    field.hidden = control.mine;
    if (focused && control.mine) button.focus(); // where the field was, for the keyboard
  };
  put(place, held, h("label", { for: id, class: "visually-hidden" }, "your name"), field, button);
  control.watchers.add(show);
  show();
}
