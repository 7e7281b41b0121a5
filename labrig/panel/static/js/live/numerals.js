// The newest value of each signal in large numerals, while signals are acquired; once they are not,
// a dash, with the last value small beside it and how old it is.

import { h, setText } from "../dom.js";
import { ago, number, signed, when } from "../format.js";

const NUMERAL_MS = 180; // numerals that change faster cannot be read
const AGE_MS = 5000;

/** `age` stands below the numerals. */
export class Numerals {
  constructor(job) {
    this.job = job;
    this.lines = [];
    this.age = h("p", { class: "strips-age", role: "status", hidden: true });
    this.ageing = setInterval(() => this.showAge(), AGE_MS);
  }

  destroy() {
    clearTimeout(this.timer);
    clearInterval(this.ageing);
  }

  /** Elements for these rows: { key, title, unit, decimals, sign }, in the place of earlier ones. */
  follow(rows) {
    this.lines = rows.map((row) => this.line(row));
    return this.lines.map((line) => line.element);
  }

  line(row) {
    const value = h("strong", { class: "numeral-value" }, "\u2013");
    const last = h("span", { class: "numeral-last" });
    const element = h(
      "div",
      { class: "numeral" },
      h("span", { class: "numeral-name" }, row.title),
      value,
      h("span", { class: "numeral-unit" }, row.unit),
      last,
    );
    return { row, value, last, element };
  }

  /** The first change shows at once, those after it together, the last one always. */
  update() {
    if (this.timer && this.job.acquiring) return;
    clearTimeout(this.timer);
    this.show();
    this.timer = setTimeout(() => {
      this.timer = null;
      this.show();
    }, NUMERAL_MS);
  }

  show() {
    const { signals, acquiring } = this.job;
    for (const { row, value, last } of this.lines) {
      const newest = signals.newest(row.key);
      const text = (row.sign ? signed : number)(newest, row.decimals);
      setText(value, acquiring ? text : "\u2013");
      setText(last, acquiring || newest == null ? "" : `last ${text} ${row.unit}`);
    }
    this.showAge();
  }

  showAge() {
    const { job } = this;
    const { signals } = job;
    this.age.hidden = job.acquiring || !signals.count;
    if (this.age.hidden) return;
    const at = `run ${signals.run + 1}, at ${number(signals.newestTime(), 1)} s`;
    const wall = job.ended?.wall;
    const now_s = job.clock?.now_s(); // of the computer that has dated the end
    const since = ago(wall, now_s == null ? Date.now() : 1e3 * now_s);
    const over = wall ? `; the session ended ${when(wall)}${job.replay ? "" : `, ${since}`}` : "";
    setText(this.age, `Nothing is measured now. Last sample: ${at}${over}.`);
  }
}
