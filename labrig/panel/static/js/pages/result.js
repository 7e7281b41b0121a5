// The result of a session: curves, forces, models, B and EIBM; growing while the session is measured.

import { mountAnalysis } from "../analysis.js";
import { h, put, setText } from "../dom.js";
import { get, query } from "../net.js";
import { ForceChart, Settling, SheetChart } from "../result/charts.js";
import { Choice } from "../result/choice.js";
import { parameters, standing, verdict } from "../result/findings.js";

const STAGES = [
  ["measured", "fitting\u2026"],
  ["fitted", "fitting position by position\u2026"],
];

const GROWS = "The result grows with each position that is measured.";

/** Show the session named in the address; without one, that of the run. */
export function mount(place, app, asked) {
  const page = new ResultPage(app, asked.get("session") ?? app.job.plan?.session ?? "");
  place.append(page.element);
  page.load();
  return page;
}

class ResultPage {
  constructor(app, session) {
    this.app = app;
    this.session = session;
    this.choice = new Choice(() => this.show());
    this.charts = [new SheetChart(), new ForceChart(), new Settling()];
    const [sheet, force, settling] = this.charts;
    this.said = h("p", { class: "result-said muted", role: "status" });
    this.words = h("div", { class: "result-words" });
    this.standing = h("div", { class: "result-standing" });
    this.analysis = h("div", { class: "result-analysis" });
    this.body = h(
      "div",
      { class: "result" },
      h("div", { class: "result-left" }, h("section", { class: "card" }, this.choice.element), sheet.element),
      h("div", { class: "result-right" }, force.element, settling.element),
    );
    this.element = h(
      "div",
      {},
      h(
        "div",
        { class: "runbar" },
        h("h1", {}, "Result ", h("a", { href: `#/session?${query({ name: session })}` }, session)),
        this.said,
      ),
      this.body,
      h("section", { class: "card result-do" }, this.analysis, this.standing),
      this.words,
    );
    this.readings = new Map(); // "condition/index" -> curve
    this.stop = app.job.watch((dirty) => this.heard(dirty));
    this.analysed = mountAnalysis(this.analysis, app, session, () => this.load());
  }

  destroy() {
    this.gone = true;
    this.stop();
    this.analysed.destroy();
    this.charts.forEach((one) => one.destroy());
  }

  get live() {
    const { job } = this.app;
    return job.going && (job.plan?.session ?? job.job?.session) === this.session;
  }

  heard(dirty) {
    const { job } = this.app;
    if (dirty.has("result") && job.result?.session === this.session) {
      if (this.live) this.grow(job.result);
      else this.load(); // the live fit follows a run on a virtual clock, also after its end
    }
    if (dirty.has("ended") && job.plan?.session === this.session) this.load();
  }

  /** A further position was measured. */
  grow(result) {
    this.set(result, (choice) => choice.grow(result));
  }

  /** First what was measured, at once; then the models; then how B and EIBM settled. */
  async load() {
    const mine = (this.latest = {});
    const is = () => mine === this.latest && !this.gone;
    if (this.live) {
      setText(this.said, `${GROWS} None is fitted yet.`);
      if (this.app.job.result?.session === this.session) this.grow(this.app.job.result);
      return;
    }
    setText(this.said, "reading\u2026");
    try {
      for (const [upto, then] of STAGES) {
        const found = await get(`/api/result?${query({ session: this.session, upto })}`);
        if (!is()) return;
        this.set(found, (choice) => (found.live ? choice.grow(found) : choice.set(found)));
        if (found.complete) return;
        setText(this.said, then);
      }
      await this.settle(is);
    } catch (error) {
      if (is()) setText(this.said, error.message);
    }
  }

  /** Show B and EIBM of a further position as soon as they are known. */
  async settle(is) {
    for (let complete = false; !complete; ) {
      const found = await get(`/api/result/settling?${query({ session: this.session })}`);
      if (!is()) return;
      Object.assign(this.result, found);
      this.charts[2].show(this.choice);
      ({ complete } = found);
    }
    this.set(this.result, (choice) => choice.set(this.result));
  }

  /** Show another result; `choose(choice)` hands it on to what is chosen. */
  set(result, choose) {
    this.result = result;
    this.readings.clear();
    setText(this.said, this.live ? GROWS : "");
    choose(this.choice);
    this.show();
    put(this.standing, standing(result, this.session));
  }

  show() {
    const { choice, charts } = this;
    const condition = choice.condition();
    const [sheet, force, settling] = charts;
    sheet.show(choice, this.reading(condition));
    force.show(choice, condition);
    settling.show(choice);
    put(this.words, parameters(choice), verdict(this.result, () => this.writeNext()));
  }

  /** Have the protocol of the next measurement written; the list of jobs shows how that goes. */
  writeNext() {
    this.analysis.scrollIntoView({ block: "nearest" });
    return this.analysed.begin("next");
  }

  /** The curve of the chosen reading; asked for when it is not known yet. */
  reading(condition) {
    const { reading } = this.choice.chosen;
    if (!condition || reading == null) return null;
    const key = `${condition.id}/${reading}`;
    if (!this.readings.has(key)) {
      this.readings.set(key, null);
      const of = { session: this.session, condition: condition.id, index: reading };
      get(`/api/result/reading?${query(of)}`).then(
        (found) => {
          this.readings.set(key, found);
          if (!this.gone) this.show();
        },
        (error) => setText(this.said, error.message),
      );
    }
    return this.readings.get(key);
  }
}
