// The log, newest at the end; follows unless the reader has scrolled away.

import { h, setText } from "../dom.js";
import { timesOf } from "../format.js";
import { timeOf } from "../words.js";

const MOST_LINES = 1000;
const NAMES = {
  warning: "WARNING",
  output: "OUTPUT",
  prompt: "ASKED",
  not_asked: "NOT ASKED",
  marked: "MARKED",
  ended: "ENDED",
  action: "DONE BY",
  reading: "LOST",
};

/** A job's log lines. */
export class Log {
  constructor(job) {
    this.job = job;
    this.list = h("ol", { class: "log-lines scroll", tabindex: 0, "aria-label": "log" });
    this.count = h("span", { class: "muted" });
    this.times = h("p", { class: "muted log-times" });
    this.element = h(
      "section",
      { class: "card log", "aria-label": "log" },
      h("h2", {}, "Log ", this.count),
      this.times,
      this.list,
    );
    this.drawn = 0;
    this.source = null;
    this.follows = true; // the newest line is in sight; what was never laid out cannot tell
    this.list.addEventListener("scroll", () => {
      this.follows = this.list.scrollHeight - this.list.scrollTop - this.list.clientHeight < 40;
    });
  }

  update() {
    const { log, plan, started } = this.job;
    setText(this.times, timesOf(started?.wall, plan?.recorded_clock ?? plan?.clock));
    if (this.source !== log) {
      this.list.replaceChildren();
      this.source = log;
      this.drawn = Math.max(0, log.length - MOST_LINES);
    }
    if (this.drawn === log.length) return;
    for (const line of log.slice(this.drawn)) this.list.append(this.line(line));
    this.drawn = log.length;
    while (this.list.childElementCount > MOST_LINES) this.list.firstChild.remove();
    setText(this.count, `${log.length} lines`);
    if (this.follows) requestAnimationFrame(() => (this.list.scrollTop = this.list.scrollHeight));
  }

  line({ time_s, type, text }) {
    return h(
      "li",
      { class: `log-${type}` },
      h("time", {}, timeOf(time_s)),
      NAMES[type] && h("b", {}, NAMES[type]),
      h("span", {}, text),
    );
  }
}
