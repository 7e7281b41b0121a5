// Readings that do not count, run by run, with why: a line while a run goes on, a warning at its end.

import { h, put } from "../dom.js";
import { inShort, placeOf } from "../words.js";

/** Hidden while every reading counts. */
export class LostReadings {
  constructor(job) {
    this.job = job;
    this.head = h("strong");
    this.list = h("ul");
    this.element = h(
      "section",
      { class: "notice card lost-readings", role: "status", hidden: true },
      this.head,
      this.list,
    );
  }

  update(dirty) {
    if (this.built && !["story", "plan", "reading", "marked"].some((type) => dirty.has(type)))
      return;
    this.built = true;
    const found = this.job
      .begun()
      .map((run) => ({ run, ...this.job.losses(run.run) }))
      .filter(({ lost }) => lost.length);
    this.element.hidden = !found.length;
    const count = found.reduce((sum, { lost }) => sum + lost.length, 0);
    put(this.head, `${count} ${count === 1 ? "reading does" : "readings do"} not count`);
    put(
      this.list,
      found.map(({ run, lost, of }) => {
        const reasons = inShort(lost.map((one) => one.why));
        const where = `run ${run.run + 1} (${placeOf(run)})`;
        return h("li", {}, `${where}: ${lost.length} of ${of}: ${reasons}`);
      }),
    );
  }
}
