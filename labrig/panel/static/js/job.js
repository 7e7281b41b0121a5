// What is known of a job: the story's messages applied one after the other, and nothing else.
//
// Whoever shows an image tells `seen` when it is drawn. Whoever shows something calls `watch`;
// watchers are called once for all that came since the last time, with the set of message types, at
// most once per tick.

import { statistics } from "./format.js";
import { nextFrame } from "./frames.js";
import { Signals } from "./signals.js";

const SMOOTH = 0.1;

/** State of a job; `alive` says whether it is heard of now. */
export class Job {
  constructor() {
    this.watchers = new Set();
    this.onPicture = new Set(); // called with each image at once, not with the next frame
    this.onSeen = () => {}; // tells the server that an image is drawn: only then the next one comes
    this.clock = null; // the server's, where the job is on a socket
    this.dirty = new Set();
    this.counts = { pictures: 0, signals: 0, messages: 0 };
    this.alive = null;
    this.replay = null;
    this.model = null; // the panel's choice, not the job's
    this.queue = null; // the panel's, too
    this.forget();
  }

  /** Forget everything of the job, as a story demands. */
  forget() {
    if (this.picture) this.seen(this.picture);
    Object.assign(this, {
      job: null,
      plan: null,
      started: null,
      state: { state: "idle", run: null },
      output: null,
      prompt: null,
      step: null, // of the beginning
      pause: null, // whether one is asked for
      ended: null,
      curve: null,
      picture: null,
      missed: 0, // frames between two images, smoothed: 0 where the page keeps up with the camera
      preflight: null,
      weighing: null,
      result: null, // of what was measured so far: { session, configurations, convergence, ... }
      motion: null, // the dynamic model beside the run: { state, why, shape, force_rms_mN, ... }
      estimates: null, // its slow parameters over the session's time
      latest_s: null,
      now_run: null,
    });
    this.runs = new Map(); // run -> { readings: Map, started, stopped, invalid }
    this.log = [];
    this.signals = new Signals();
    this.predicted = new Signals(); // by the dynamic model
  }

  watch(update) {
    this.watchers.add(update);
    return () => this.watchers.delete(update);
  }

  /** One text message. */
  apply(message) {
    this.counts.messages += 1;
    if (message.type === "story") {
      this.forget();
      message.messages.forEach((one) => this.take(one));
      this.touch("story");
    } else {
      this.take(message);
    }
    this.touch(message.type);
  }

  /** One binary frame. */
  applyBinary(header, buffer, start) {
    if (header.type === "picture") {
      this.counts.pictures += 1;
      this.countMissed(header);
      this.picture = { ...header, bytes: new Uint8Array(buffer, start), came: performance.now() };
      this.setLatest(header.time_s);
      for (const show of this.onPicture) show(this.picture);
    } else if (header.type === "signals") {
      this.counts.signals += header.count;
      this.signals = joined(this.signals, header, buffer, start);
    } else if (header.type === "predicted") {
      this.predicted = joined(this.predicted, header, buffer, start);
    }
    this.touch(header.type);
  }

  /** Of a live camera; a replay leaves out frames where it is quick. */
  countMissed({ frame, exposed_s }) {
    if (!this.picture || exposed_s == null) return;
    const between = Math.max(0, frame - this.picture.frame - 1);
    this.missed += SMOOTH * (between - this.missed);
  }

  /** An image is drawn, or nobody will draw it any more. */
  seen(picture) {
    if (picture.seen) return;
    picture.seen = true;
    this.onSeen(picture);
  }

  /** How old an image is in s; null where its exposure has no time of day (a replay). */
  ageOf(picture) {
    const now_s = this.clock?.now_s();
    if (picture.exposed_s == null || now_s == null) return null;
    return Math.max(0, now_s - picture.exposed_s);
  }

  setAlive(alive) {
    this.alive = alive;
    this.touch("alive");
  }

  take(message) {
    this.setLatest(message.time_s);
    const handle = HANDLERS[message.type];
    if (handle) handle(this, message);
    if (message.log)
      this.log.push({ time_s: message.time_s, type: message.type, text: message.log });
  }

  setLatest(time_s) {
    if (time_s != null) this.latest_s = time_s;
  }

  /** The record of a run, made when first asked for. */
  runOf(index) {
    if (!this.runs.has(index))
      this.runs.set(index, { readings: new Map(), started: null, stopped: null, invalid: null });
    return this.runs.get(index);
  }

  /** The plan's entry of a run. */
  planned(index) {
    const all = [...(this.plan?.runs ?? []), ...(this.plan?.repeats ?? [])];
    return all.find((run) => run.run === index) ?? null;
  }

  /** All planned runs, and those that were measured again so far. */
  begun() {
    const again = (this.plan?.repeats ?? []).filter((run) => this.runs.has(run.run));
    return [...(this.plan?.runs ?? []), ...again];
  }

  /** Readings of a run that do not count, and how many should: { lost: [reading], of }. */
  losses(index) {
    const planned = this.planned(index);
    const run = this.runs.get(index);
    if (!planned || !run) return { lost: [], of: 0 };
    const counts = (kind) => kind !== "discarded";
    const lost = [...run.readings.values()].filter((one) => !one.valid && counts(one.kind));
    return { lost, of: planned.readings.filter(([, , , kind]) => counts(kind)).length };
  }

  /** Readings of a run that count, by voltage: [{ voltage, mean, scatter, count, values }]. */
  means(index) {
    const groups = new Map();
    const run = this.runs.get(index);
    if (!run || run.invalid) return [];
    for (const reading of run.readings.values()) {
      if (!reading.valid || reading.kind === "discarded") continue;
      if (!groups.has(reading.voltage_V)) groups.set(reading.voltage_V, []);
      groups.get(reading.voltage_V).push(reading.force_mN);
    }
    return [...groups].map(([voltage, values]) => ({ voltage, values, ...statistics(values) }));
  }

  /** Whether a job is under way now. */
  get going() {
    return this.job != null && (this.job.state === "starting" || this.job.state === "going");
  }

  /** Whether the session is over, as far as anybody can know: then nothing of it is 'now'. */
  get over() {
    return this.ended != null || this.job?.state === "ended" || this.job?.state === "lost";
  }

  /** Whether signals are being acquired; else the newest that came are the last reading. */
  get acquiring() {
    const record = this.runs.get(this.signals.run ?? this.now_run);
    return this.alive !== false && !this.over && Boolean(record?.started) && !record.stopped;
  }

  touch(type) {
    this.dirty.add(type);
    nextFrame(this.flush, { whenHidden: true }); // the title of a hidden page must stay true
  }

  /** Call the watchers. */
  flush = () => {
    const dirty = this.dirty;
    this.dirty = new Set();
    for (const update of this.watchers) update(dirty);
  };
}

/** Signals with a piece more, or those of another run. */
function joined(signals, header, buffer, start) {
  const found = header.fresh || header.run !== signals.run ? new Signals(header.run) : signals;
  found.append(header.rows, header.count, buffer, start);
  return found;
}

const HANDLERS = {
  job: (job, m) => {
    job.job = m;
    if (m.state === "ended" || m.state === "lost") job.prompt = null;
  },
  plan: (job, m) => (job.plan = m),
  model: (job, m) => (job.model = m.name),
  step: (job, m) => (job.step = m),
  pause: (job, m) => (job.pause = m),
  started: (job, m) => (job.started = m),
  state: (job, m) => {
    job.state = m;
    if (m.run != null) job.now_run = m.run;
  },
  output: (job, m) => (job.output = m),
  prompt: (job, m) => (job.prompt = m),
  answered: (job, m) => {
    if (job.prompt?.prompt === m.prompt) job.prompt = null;
  },
  run_started: (job, m) => {
    job.now_run = m.run;
    job.runOf(m.run).started = m;
  },
  voltage: (job, m) => (job.runOf(m.run).voltage = m),
  reading: (job, m) => job.runOf(m.run).readings.set(m.index, { ...m }),
  marked: (job, m) => {
    const run = job.runOf(m.run);
    const why = `${m.why} (${m.who})`;
    if (m.reading == null) run.invalid = why;
    else if (run.readings.has(m.reading))
      Object.assign(run.readings.get(m.reading), { valid: false, why });
  },
  run_stopped: (job, m) => (job.runOf(m.run).stopped = m),
  ended: (job, m) => {
    job.ended = m;
    job.prompt = null;
  },
  curve: (job, m) => (job.curve = m),
  preflight: (job, m) => (job.preflight = m),
  queue: (job, m) => (job.queue = m),
  weighing: (job, m) => (job.weighing = m),
  result: (job, m) => (job.result = m),
  motion: (job, m) => (job.motion = m),
  estimates: (job, m) => (job.estimates = m),
  replay: (job, m) =>
    (job.replay = { ...job.replay, ...m, marks: m.marks ?? job.replay?.marks ?? [] }),
};
