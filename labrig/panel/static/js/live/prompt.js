// What the operator is asked to do, large, with Go and 'stop the session'.

import { h, put, setText } from "../dom.js";

/** `answer(done)` sends it; `may()` tells whether this page may answer, or why not. */
export class PromptBar {
  constructor(job, { answer, may }) {
    this.job = job;
    this.may = may;
    this.text = h("p", { class: "prompt-text" });
    this.why = h("p", { class: "prompt-why" });
    this.goWord = h("span", {}, "Go");
    this.go = h(
      "button",
      {
        class: "go",
        type: "button",
        onclick: () => this.send(true),
        "aria-keyshortcuts": "Control+Enter",
      },
      this.goWord,
      h("kbd", {}, "Ctrl Enter"),
    );
    this.stop = h(
      "button",
      { type: "button", onclick: () => this.send(false) },
      "Stop the session",
    );
    this.element = h(
      "section",
      { class: "prompt", hidden: true, role: "alert", "aria-label": "the run asks" },
      h("div", { class: "prompt-words" }, this.text, this.why),
      h("div", { class: "prompt-do" }, this.go, this.stop),
    );
    this.answer = answer;
    this.keys = (event) => {
      if (event.key === "Enter" && event.ctrlKey && !this.element.hidden && !this.go.disabled)
        this.send(true);
    };
    document.addEventListener("keydown", this.keys);
  }

  destroy() {
    document.removeEventListener("keydown", this.keys);
  }

  update() {
    const { prompt } = this.job;
    this.element.hidden = !prompt;
    if (!prompt) {
      this.sent = null;
      return;
    }
    setText(this.text, prompt.text);
    const repeat = prompt.kind === "repeat";
    setText(this.goWord, repeat ? "Go on" : "Go");
    setText(this.stop, repeat ? "Measure it again" : "Stop the session");
    const why = this.may();
    const busy = this.sent === prompt.prompt;
    this.go.disabled = this.stop.disabled = Boolean(why) || busy;
    setText(this.why, why || (busy ? "answer sent" : (this.fault ?? (repeat ? "" : "Check the rig, then press Go."))));
  }

  async send(done) {
    const { prompt } = this.job;
    if (!prompt || this.sent === prompt.prompt) return; // answered meanwhile, perhaps by another page
    this.sent = prompt.prompt;
    this.fault = null;
    this.update();
    try {
      await this.answer(prompt.prompt, done);
    } catch (error) {
      this.sent = null;
      this.fault = error.message;
      this.update();
    }
  }
}

/** The result of a preflight as a table. */
export function preflightTable(preflight) {
  const rows = preflight.checks.map((check) => {
    const word = check.ok ? (check.warning ? "WARNING" : "OK") : "FAILED";
    return h(
      "tr",
      { class: `check check-${word.toLowerCase()}` },
      h("td", {}, h("span", { class: "verdict" }, word)),
      h("th", { scope: "row" }, check.name),
      h("td", {}, check.found, typeof check.warning === "string" ? ` \u2014 ${check.warning}` : ""),
      h("td", {}, check.wanted),
    );
  });
  const head = h(
    "tr",
    {},
    ["result", "check", "found", "wanted"].map((name) => h("th", { scope: "col" }, name)),
  );
  return h("table", { class: "checks" }, h("thead", {}, head), h("tbody", {}, rows));
}

/** Preflight results, shown while there are any. */
export class Preflight {
  constructor(job, opened = false) {
    Object.assign(this, { job, opened });
    this.body = h("div", {
      class: "scroll",
      tabindex: 0,
      role: "region",
      "aria-label": "preflight checks",
    });
    this.verdict = h("strong");
    this.element = h(
      "details",
      { class: "card preflight", hidden: true },
      h("summary", {}, h("h2", {}, "Preflight ", this.verdict)),
      this.body,
    );
  }

  update(dirty) {
    if (!dirty.has("preflight") && !dirty.has("story") && this.built) return;
    this.built = true;
    const { preflight } = this.job;
    this.element.hidden = !preflight;
    if (!preflight) return;
    const warnings = preflight.checks.filter((check) => check.ok && check.warning).length;
    setText(
      this.verdict,
      preflight.ok ? `passed${warnings ? `, ${warnings} to look at` : ""}` : "FAILED",
    );
    this.element.open = this.opened || !preflight.ok;
    put(this.body, preflightTable(preflight));
  }
}
