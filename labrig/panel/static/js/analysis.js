// Analysis jobs of a session: start, follow and cancel them, and open what they have written.

import { h, newId, put, setText } from "./dom.js";
import { when } from "./format.js";
import { get, post, query } from "./net.js";

const KINDS = [
  ["analyze", "Analyse", "forces from the signals and curves from the images"],
  ["fit", "Fit", "B and EIBM of each configuration"],
  ["diagnose", "Diagnose", "what the model is missing"],
  ["report", "Report", "tables and figures as one page"],
  ["next", "What to measure next", "the measurement that tells two effects apart"],
];
const SAVE = true;
const OUTPUTS = {
  fit: [["model", "Model file"]],
  diagnose: [
    ["completed_model", "Completed model"],
    ["diagnosis", "Diagnosis (JSON)"],
  ],
  report: [
    ["report", "Open the report"],
    ["report", "Save the report", SAVE],
    ["figures", "Save its figures (PDF and SVG)"],
  ],
  next: [["next", "Its protocol"]],
};
const STATES = {
  queued: "waits for the job before it",
  running: "running",
  failed: "Failed: ",
  cancelled: "",
  done: "",
};

/** All analysis jobs of the panel, as the live socket reports them. */
export class AnalysisJobs {
  constructor() {
    this.jobs = [];
    this.watchers = new Set();
  }

  set(jobs) {
    this.jobs = jobs;
    for (const update of this.watchers) update();
  }

  watch(update) {
    this.watchers.add(update);
    return () => this.watchers.delete(update);
  }

  /** The newest job of this kind and session. */
  last(kind, session) {
    return this.jobs.findLast((job) => job.kind === kind && job.session === session) ?? null;
  }
}

/**
 * The buttons of one session. `changed(job)` is called when a job has ended well, for whoever shows
 * its outcome. Returns an object with `destroy()`, and `begin(kind)`, which presses a button.
 */
export function mountAnalysis(place, app, session, changed = () => {}) {
  const fault = h("p", { class: "fault", role: "alert" });
  const spoken = h("p", { class: "visually-hidden", role: "status", "aria-live": "polite" });
  const title = newId("analysis");
  const rows = KINDS.map((kind) => new Row(kind, app, session, fault));
  put(
    place,
    h(
      "section",
      { class: "analysis", "aria-labelledby": title },
      h("h2", { id: title }, "Analysis"),
      h(
        "ul",
        { class: "analysis-jobs" },
        rows.map((row) => row.element),
      ),
      fault,
      spoken,
    ),
  );
  const outputs = () =>
    get(`/api/analysis/outputs?${query({ session })}`).then(
      (found) => rows.forEach((row) => row.showOutputs(found)),
      () => {}, // a session that cannot be read is reported by its page
    );
  const update = () => {
    for (const row of rows) {
      const ended = row.update();
      if (!ended) continue;
      setText(spoken, `${row.title}: ${row.words.textContent}`);
      outputs();
      if (ended.state === "done") changed(ended);
    }
  };
  const forget = app.analyses.watch(update);
  update();
  outputs();
  return { destroy: forget, begin: (kind) => rows.find((row) => row.kind === kind).begin() };
}

/** One kind of job: its button, and how the last one goes or went. */
class Row {
  constructor([kind, title, help], app, session, fault) {
    Object.assign(this, { kind, title, help, app, session, fault });
    const says = newId("says");
    this.start = h(
      "button",
      { type: "button", "aria-describedby": says, onclick: () => this.begin() },
      title,
    );
    this.words = h("span", { id: says, class: "analysis-words" }, help);
    this.bar = h("progress", { max: 1, "aria-label": title, hidden: true });
    this.cancel = h(
      "button",
      {
        type: "button",
        class: "small",
        hidden: true,
        "aria-label": `Cancel: ${title}`,
        onclick: () => this.act("/api/analysis/cancel", { id: this.job.id }),
      },
      "Cancel",
    );
    this.links = h("span", { class: "analysis-links" });
    this.notes = h("details", { hidden: true }, h("summary", {}, "Remarks"), h("ul"));
    this.element = h(
      "li",
      { data: { kind } },
      this.start,
      h("div", { class: "analysis-how" }, this.words, this.bar, this.links, this.notes),
      this.cancel,
    );
  }

  begin() {
    return this.act("/api/analysis/start", { kind: this.kind, session: this.session });
  }

  async act(path, body) {
    try {
      await this.app.control.act(() => post(path, body));
      setText(this.fault, "");
    } catch (error) {
      setText(this.fault, error.message);
    }
  }

  /** Show the job as it is now; the job, when it has ended since the last time. */
  update() {
    const before = this.job;
    const job = this.app.analyses.last(this.kind, this.session);
    if (!job) return null;
    this.job = job;
    const under_way = job.state === "queued" || job.state === "running";
    const focused = document.activeElement === this.cancel;
    this.start.disabled = under_way;
    this.cancel.hidden = !under_way;
    if (focused && !under_way) this.start.focus(); // a hidden button would drop the focus
    this.bar.hidden = job.state !== "running";
    if (job.fraction > 0) this.bar.value = job.fraction;
    else this.bar.removeAttribute("value"); // nothing is known yet
    this.element.dataset.state = job.state;
    setText(this.words, wordsOf(job));
    const notes = job.result?.notes ?? [];
    this.notes.hidden = notes.length === 0;
    setText(this.notes.querySelector("summary"), `Remarks (${notes.length})`);
    put(
      this.notes.querySelector("ul"),
      notes.map((note) => h("li", {}, note)),
    );
    const same = before?.id === job.id && before.state === job.state;
    return before && !same && !under_way ? job : null;
  }

  showOutputs({ outputs, analysed }) {
    if (this.kind === "analyze" && analysed && !this.job) setText(this.words, "is analysed");
    const found = (OUTPUTS[this.kind] ?? []).filter(([name]) => outputs[name]);
    if (found.length && !this.job)
      setText(this.words, `written ${when(outputs[found[0][0]].wall)}`);
    put(
      this.links,
      found.map(([name, text, save = name !== "report"]) =>
        linkTo(this.session, name, text, outputs[name], save),
      ),
      this.kind === "next" && outputs.next && this.app.status?.mode === "rig" && this.newRun(),
    );
  }

  /** The protocol that was proposed, as a new run. */
  newRun() {
    const href = `#/new?${query({ next: this.session })}`;
    return h("a", { class: "button small", href }, "Open it as a new run");
  }
}

function wordsOf(job) {
  if (job.state === "running") {
    const share = job.fraction > 0 ? `, ${Math.round(100 * job.fraction)} %` : "";
    return `${job.step || "running"}${share}`;
  }
  return `${STATES[job.state]}${job.message}`;
}

/** A link that stores the file, or, a page, opens it. */
function linkTo(session, name, text, output, save) {
  const href = `/api/analysis/output?${query({ session, name, save: save ? "true" : "" })}`;
  const how = save ? { download: output.file } : { target: "_blank", rel: "noopener" };
  return h("a", { class: "button small", href, title: output.file, ...how }, text);
}
