// All that shows one job, put together: used for the run, for a replay, and twice to compare.

import { h } from "../dom.js";
import { Log } from "./log.js";
import { LostReadings } from "./lost.js";
import { ModelBeside } from "./model_beside.js";
import { Picture } from "./picture.js";
import { Preflight, PromptBar } from "./prompt.js";
import { Readings } from "./readings.js";
import { Strips } from "./strips.js";
import { Timeline } from "./timeline.js";

const STREAM = new Set(["picture", "signals", "predicted", "motion", "curve"]);
const SLOW_MS = 200; // the mark in the schedule moves by less than a pixel meanwhile

/** `acts`: { answer, mark, may }; null where nothing can be done (a replay). `beside`: elements. */
export class LiveView {
  constructor(job, acts = null, beside = []) {
    this.job = job;
    this.picture = new Picture(job);
    this.strips = new Strips(job);
    this.timeline = new Timeline(job);
    const readings = new Readings(job, acts ? { mark: acts.mark, may: acts.may } : {});
    const side = [new Preflight(job), new Log(job)];
    const lost = new LostReadings(job);
    const beside_run = new ModelBeside(job);
    const main = [lost, this.picture, this.strips, beside_run, this.timeline, readings];
    if (acts) main.unshift(new PromptBar(job, acts));
    this.parts = [...main, ...side];
    const elements = (parts) => parts.map((part) => part.element);
    this.element = h(
      "div",
      { class: "live" },
      elements(main),
      h("div", { class: "live-side" }, elements(side), beside),
    );
    this.stop = job.watch((dirty) => this.update(dirty));
    this.update(new Set(["story", "picture"]));
  }

  /** All parts, but with images and signals alone those around them follow at a slower pace. */
  update(dirty) {
    const streamed = [...dirty].every((type) => STREAM.has(type));
    const due = !streamed || performance.now() - this.moved >= SLOW_MS;
    for (const part of this.parts)
      if (due || part === this.picture || part === this.strips) part.update(dirty);
    clearTimeout(this.timer);
    if (due) this.moved = performance.now();
    else this.timer = setTimeout(() => this.update(new Set(STREAM)), SLOW_MS);
  }

  destroy() {
    this.stop();
    clearTimeout(this.timer);
    for (const part of this.parts) part.destroy?.();
  }
}
