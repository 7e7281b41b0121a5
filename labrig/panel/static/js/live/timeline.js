// The schedule: all runs on the session's estimated time, the present run's voltage, and 'now'.

import { h, put, setText, svg } from "../dom.js";
import { about, clock, number, volts } from "../format.js";
import { placeOf } from "../words.js";
import { svgMark } from "./marks.js";

const RUNS_HIGH = 60;
const WAVE_HIGH = 76;
const LEFT = 40;
const RIGHT = 12;

/** `plan` may be shown without a job: then nothing of it has happened yet. */
export class Timeline {
  constructor(job) {
    this.job = job;
    this.runs = svg("svg", { class: "timeline-runs", role: "img", height: RUNS_HIGH });
    this.wave = svg("svg", { class: "timeline-wave", role: "img", height: WAVE_HIGH });
    this.said = h("p", { class: "timeline-said" }, "no schedule yet");
    this.element = h(
      "section",
      { class: "timeline card", "aria-label": "schedule" },
      h("h2", {}, "Schedule"),
      this.said,
      this.runs,
      this.wave,
    );
    this.seen = new ResizeObserver(() => this.build());
    this.seen.observe(this.element);
  }

  destroy() {
    this.seen.disconnect();
  }

  update(dirty) {
    const anew = [
      "story",
      "plan",
      "run_started",
      "run_stopped",
      "reading",
      "marked",
      "ended",
      "job",
      "state",
    ];
    if (anew.some((type) => dirty.has(type))) this.build();
    else if (this.job.plan) this.move();
  }

  build() {
    const { plan } = this.job;
    const width = this.element.clientWidth - 2 * 16;
    for (const drawn of [this.runs, this.wave]) drawn.toggleAttribute("hidden", !plan);
    if (!plan || width < 50) {
      put(this.runs);
      put(this.wave);
      setText(this.said, "no schedule yet");
      return;
    }
    this.width = width;
    this.buildRuns(plan, width);
    this.buildWave(width);
    this.move();
  }

  /** One cell a run: hatched while people move things, solid while the run goes on. */
  buildRuns(plan, width) {
    const whole = Math.max(plan.estimate_s, 1e-9);
    this.x = (seconds) => LEFT + ((width - LEFT - RIGHT) * seconds) / whole;
    const cells = plan.runs.map((run, index) => {
      const before = index ? plan.runs[index - 1].starts_s + plan.runs[index - 1].duration_s : 0;
      const [from, start, end] = [
        this.x(before),
        this.x(run.starts_s),
        this.x(run.starts_s + run.duration_s),
      ];
      const state = this.stateOf(run);
      const room = end - from;
      const name = run.position_mm == null ? "free" : `${run.position_mm}`.replace("-", "\u2212");
      return svg(
        "g",
        { class: `cell cell-${state}` },
        svg("title", {}, `run ${run.run + 1}: ${placeOf(run)}, ${state}`),
        svg("rect", {
          class: "cell-wait",
          x: from + 0.5,
          y: 32,
          width: Math.max(start - from - 1, 0),
          height: 22,
        }),
        svg("rect", {
          class: "cell-run",
          x: start + 0.5,
          y: 32,
          width: Math.max(end - start - 1, 1.5),
          height: 22,
        }),
        room > 7 * name.length + 4 &&
          svg("text", { x: (from + end) / 2, y: 26, "text-anchor": "middle" }, name),
        state === "done" &&
          room > 14 &&
          svg("path", { class: "cell-tick", d: `M${end - 13} 43l4 4l6 -9` }),
      );
    });
    this.now = svg("path", { class: "now" });
    put(
      this.runs,
      svg("text", { x: 0, y: 26, class: "unit" }, "mm"),
      this.groups(plan),
      cells,
      this.now,
    );
    this.runs.setAttribute("width", width);
    const done = plan.runs.filter((run) => this.stateOf(run) === "done").length;
    this.runs.setAttribute("aria-label", `${done} of ${plan.runs.length} runs are complete`);
  }

  /** The configurations' names, each where its runs begin. */
  groups(plan) {
    return plan.runs.map((run, index) => {
      const before = plan.runs[index - 1];
      if (before?.configuration === run.configuration) return null;
      const x = this.x(before ? before.starts_s + before.duration_s : 0);
      return svg(
        "g",
        {},
        svg("path", { class: "group-line", d: `M${x} 0V56` }),
        svg("text", { x: x + 4, y: 11, class: "group-name" }, run.configuration),
      );
    });
  }

  stateOf(run) {
    const record = this.job.runs.get(run.run);
    if (this.job.plan.done?.includes(run.run)) return "done";
    if (record?.stopped) return record.stopped.completed ? "done" : "broken";
    if (record?.started) return this.job.over ? "broken" : "now";
    return this.job.over ? "not done" : "to come";
  }

  shownRun() {
    const { job } = this;
    return job.planned(job.now_run) ?? job.plan?.runs[0] ?? null;
  }

  buildWave(width) {
    const run = this.shownRun();
    if (!run) return;
    const most = Math.max(1e-9, ...run.steps.map(([, value]) => Math.abs(value)));
    const middle = WAVE_HIGH / 2;
    this.waveX = (seconds) =>
      LEFT + ((width - LEFT - RIGHT) * seconds) / Math.max(run.duration_s, 1e-9);
    const y = (value) => middle - (value / most) * (middle - 14);
    let path = `M${this.waveX(0)} ${y(run.steps[0]?.[1] ?? 0)}`;
    for (const [run_s, value] of run.steps) path += `H${this.waveX(run_s)}V${y(value)}`;
    path += `H${this.waveX(run.duration_s)}`;
    const taken = this.job.runs.get(run.run)?.readings ?? new Map();
    const marks = run.readings.map(([index, run_s, value, kind]) => {
      const reading = taken.get(index);
      const state = !reading
        ? "planned"
        : !reading.valid
          ? "invalid"
          : kind === "discarded"
            ? "discarded"
            : "taken";
      return svgMark(value, this.waveX(run_s), y(value), 4, state);
    });
    const levels = [...new Set([most, 0, -most])];
    this.waveNow = svg("path", { class: "now" });
    put(
      this.wave,
      levels.map((level) => svg("text", { class: "unit", x: 0, y: y(level) + 4 }, volts(level))),
      svg("path", { class: "zero-line", d: `M${LEFT} ${y(0)}H${width - RIGHT}` }),
      svg("path", { class: "wave", d: path }),
      marks,
      this.waveNow,
    );
    this.wave.setAttribute("width", width);
    this.wave.setAttribute(
      "aria-label",
      `run ${run.run + 1}: ${taken.size} of ${run.readings.length} readings are taken`,
    );
  }

  /** Only 'now' moves. */
  move() {
    const { job } = this;
    const run = this.shownRun();
    if (!run || !this.x) return;
    const record = job.runs.get(run.run);
    const going = record?.started && !record.stopped && !job.over;
    const run_s = going ? this.runTime(run) : record?.stopped ? run.duration_s : 0;
    const begun = (job.started || job.job) && !job.over;
    const planned = run.repeats == null ? run : job.planned(run.repeats);
    const at = this.x(record?.started ? planned.starts_s + run_s : this.waiting(planned));
    this.now.setAttribute("d", begun ? `M${at} 28V58M${at - 5} 28H${at + 5}L${at} 34Z` : "");
    const wave = this.waveX(run_s);
    this.waveNow.setAttribute("d", going ? `M${wave} 0V${WAVE_HIGH}` : "");
    setText(this.said, this.words(run, going ? run_s : null));
  }

  /** Before a run: as far into its wait as time has gone, at most to its beginning. */
  waiting(run) {
    const { plan, runs, latest_s } = this.job;
    const before = plan.runs[plan.runs.indexOf(run) - 1];
    const stopped = before ? runs.get(before.run)?.stopped?.time_s : 0;
    const gone = Math.max(0, (latest_s ?? 0) - (stopped ?? 0));
    return Math.min(run.starts_s, (before ? before.starts_s + before.duration_s : 0) + gone);
  }

  runTime(run) {
    const { signals } = this.job;
    const newest = signals.run === run.run ? signals.newestTime() : null;
    return Math.min(Math.max(newest ?? 0, 0), run.duration_s);
  }

  words(run, run_s) {
    const { plan, latest_s } = this.job;
    const runs = plan.runs.length === 1 ? "run" : "runs";
    const count = `${plan.runs.length} ${runs}, ${about(plan.estimate_s)}`;
    if (!this.job.started) return `${count}; not begun`;
    if (this.job.over) return `${this.end()} \u00B7 ${this.complete()}`;
    const where = `run ${run.run + 1}: ${placeOf(run)}`;
    const within = run_s == null ? "" : `, ${number(run_s, 1)} s of ${number(run.duration_s, 1)} s`;
    return `now ${clock(latest_s)} of ${count} \u00B7 ${where}${within}`;
  }

  /** 'ended after 5:14', by the session's own clock; 'lost' when nobody has reported the end. */
  end() {
    const { ended, job, latest_s } = this.job;
    const word = !ended && job?.state === "lost" ? "lost" : "ended";
    return `${word} after ${clock(ended?.time_s ?? latest_s)}`;
  }

  complete() {
    const { runs } = this.job.plan;
    const done = runs.filter((run) => this.stateOf(run) === "done").length;
    return `${done} of ${runs.length} ${runs.length === 1 ? "run" : "runs"} complete`;
  }
}
