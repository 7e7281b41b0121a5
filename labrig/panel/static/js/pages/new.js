// A new run: the protocol and the sheet as forms, the schedule they make, preflight, start.

import { h, newId, put, setText } from "../dom.js";
import { AboutForm } from "../form/about.js";
import { FileForm } from "../form/file.js";
import { about, number, plain } from "../format.js";
import { Job } from "../job.js";
import { Preflight } from "../live/prompt.js";
import { Timeline } from "../live/timeline.js";
import { get, post, query } from "../net.js";

/** Show the forms; `?next=SESSION` begins with the protocol that was proposed after a session. */
export function mount(place, app, asked) {
  const page = new NewRun(app, asked.get("next"));
  place.append(page.element);
  page.begin().catch((error) => setText(page.fault, error.message));
  return page;
}

class NewRun {
  constructor(app, after) {
    this.app = app;
    this.after = after; // the session
    this.preview = new Job(); // a job that only has a plan
    this.timeline = new Timeline(this.preview);
    this.preflight = new Preflight(app.job, true);
    this.fault = h("p", { class: "fault", role: "alert" });
    this.files = h("div", { class: "new-files" });
    this.about = new AboutForm();
    this.facts = h("dl", { class: "facts" });
    this.session = h("input", {
      id: newId("session"),
      value: suggested(),
      autocomplete: "off",
      class: "wide",
    });
    this.keep = h("input", { id: newId("keep"), autocomplete: "off", class: "wide" });
    this.keepRow = h(
      "div",
      { class: "field", hidden: true },
      h("label", { for: this.keep.id }, "save the changed protocol as"),
      this.keep,
    );
    this.clock = new ClockChoice();
    this.check = h(
      "button",
      { type: "button", onclick: () => this.act(() => this.tryRig()) },
      "Check the rig",
    );
    this.start = h(
      "button",
      { type: "button", class: "main", onclick: () => this.act(() => this.run()) },
      "Start the run",
    );
    this.later = h(
      "button",
      { type: "button", onclick: () => this.act(() => this.enqueue()) },
      "Add to the queue",
    );
    this.element = h(
      "div",
      { class: "new" },
      h("h1", {}, "New run"),
      h(
        "div",
        { class: "new-two" },
        this.files,
        h(
          "div",
          { class: "new-do" },
          h("section", { class: "card" }, h("h2", {}, "What it will be"), this.facts, this.fault),
          this.timeline.element,
          this.about.element,
          h(
            "section",
            { class: "card new-start" },
            h(
              "div",
              { class: "field" },
              h("label", { for: this.session.id }, "session file"),
              this.session,
            ),
            this.keepRow,
            app.status?.simulated &&
              this.clock.element,
            h("div", { class: "buttons" }, this.check, this.later, this.start),
          ),
          this.preflight.element,
        ),
      ),
    );
    const stops = [
      this.preview.watch((dirty) => this.timeline.update(dirty)),
      app.job.watch((dirty) => this.jobChanged(dirty)),
    ];
    const controlled = () => this.show();
    app.control.watchers.add(controlled);
    this.destroy = () => {
      stops.forEach((stop) => stop());
      app.control.watchers.delete(controlled);
      this.timeline.destroy();
    };
    this.jobChanged(new Set(["story"]));
  }

  async begin() {
    const [schemas, { files }] = await Promise.all([get("/api/schemas"), get("/api/files")]);
    const configurations = () =>
      Object.keys(this.sheet?.values ?? {}).filter((key) => key !== "arc");
    this.sheet = new FileForm("sheet", schemas.sheet, { changed: () => this.changed() });
    this.protocol = new FileForm("protocol", schemas.protocol, {
      choices: () => ({ configuration: configurations() }),
      changed: () => this.changed(),
    });
    put(this.files, this.protocol.element, this.sheet.element);
    await this.about.begin();
    await this.sheet.offer(files);
    await this.offerProtocols(files);
  }

  async offerProtocols(files) {
    if (!this.after) return this.protocol.offer(files);
    const proposed = await get(`/api/next-protocol?${query({ session: this.after })}`);
    await this.protocol.offer(files, proposed.name);
    if (this.protocol.text !== proposed.text)
      this.protocol.adopt(proposed, `proposed after ${this.after}`);
  }

  /** A form has changed: plan anew when both are sound. */
  async changed() {
    this.show();
    if (!this.protocol.ready || !this.sheet.name) return;
    const asked = (this.asked = {});
    const body = { protocol_text: this.protocol.text, sheet: this.sheet.name };
    const plan = await post("/api/plan", body).catch((error) => error);
    if (asked !== this.asked) return;
    this.planned = plan instanceof Error ? null : plan;
    setText(this.fault, plan instanceof Error ? plan.message : "");
    this.clock.offer(this.planned?.not_on_real_clock);
    if (this.planned) this.preview.apply({ type: "story", messages: [{ ...plan, type: "plan" }] });
    this.show();
  }

  jobChanged(dirty) {
    this.preflight.update(dirty);
    this.show();
  }

  show() {
    const { job, control } = this.app;
    const ready = this.protocol?.ready && this.sheet?.ready && this.planned;
    const why = job.going ? "Something is going on already." : control.why();
    this.check.disabled = this.start.disabled = !ready || Boolean(why);
    this.start.title = why;
    this.later.disabled = !ready || Boolean(control.why());
    this.keepRow.hidden = !this.protocol?.touched;
    if (this.protocol?.touched && !this.keep.value) this.keep.value = this.protocol.name;
    put(this.facts, this.factsOf(this.planned), why && fact("not now", why));
  }

  factsOf(plan) {
    if (!plan) return fact("schedule", "none yet");
    const { limits, runs } = plan;
    const most = Math.max(
      0,
      ...runs.flatMap((run) => run.steps.map(([, volts]) => Math.abs(volts))),
    );
    const total = runs.reduce((sum, run) => sum + run.under_voltage_s, 0);
    const under = Math.max(0, ...runs.map((run) => run.under_voltage_s));
    const readings = runs.reduce((sum, run) => sum + run.readings.length, 0);
    return [
      fact("takes", `${about(plan.estimate_s)}, of it ${about(plan.running_s)} running`),
      fact("runs", `${runs.length}, ${readings} readings`),
      fact("voltage", `up to ${plain(most)} V of ${plain(limits.sheet_voltage_V)} V allowed`),
      fact(
        "under voltage",
        `${number(total, 1)} s in all, up to ${number(under, 1)} s of ${plain(limits.time_under_voltage_s)} s allowed in one run`,
      ),
      plan.free_shapes ? fact("free shapes", plan.free_shapes) : null,
      ...(plan.warnings ?? []).map((text) => fact("dynamic fit", `${text}.`)),
    ];
  }

  async act(work) {
    setText(this.fault, "");
    try {
      await this.app.control.act(work);
    } catch (error) {
      setText(this.fault, error.message);
    }
  }

  /** Files that were changed are saved first: what runs is what stands in a file. */
  async saved() {
    if (this.sheet.touched) await this.sheet.save(this.sheet.name);
    if (this.protocol.touched)
      await this.protocol.save(this.keep.value.trim() || this.protocol.name);
    return { protocol: this.protocol.name, sheet: this.sheet.name };
  }

  async tryRig() {
    await post("/api/preflight", await this.saved());
  }

  async run() {
    await post("/api/run", await this.wanted());
    location.hash = "#/run";
  }

  async enqueue() {
    await post("/api/queue/add", await this.wanted());
    location.hash = "#/queue";
  }

  async wanted() {
    const body = { ...(await this.saved()), session: this.session.value.trim() };
    if (this.about.values) body.about = this.about.values;
    if (this.app.status?.simulated) body.clock = this.clock.value;
    return body;
  }
}

/** Real time, unless the protocol wants what only the simulated operator can do, at once. */
class ClockChoice {
  constructor() {
    this.real = h("option", { value: "real" }, "real time");
    this.select = h(
      "select",
      { id: newId("clock"), onchange: () => (this.chosen = this.select.value) },
      this.real,
      h("option", { value: "virtual" }, "virtual: as fast as it can"),
    );
    this.why = h("p", { class: "field-hint", id: newId("why") });
    this.select.setAttribute("aria-describedby", this.why.id);
    this.element = h(
      "div",
      { class: "field" },
      h("label", { for: this.select.id }, "simulated rig\u2019s clock"),
      this.select,
      this.why,
    );
    this.offer(null);
  }

  /** `whyNot`: why this protocol cannot run in real time, or nothing. */
  offer(whyNot) {
    this.real.disabled = Boolean(whyNot);
    this.select.value = whyNot ? "virtual" : (this.chosen ?? "real");
    setText(this.why, whyNot ?? "");
    this.why.hidden = !whyNot;
  }

  get value() {
    return this.select.value;
  }
}

function fact(name, value) {
  return [h("dt", {}, name), h("dd", {}, value)];
}

/** A file name with the day and the time. */
function suggested() {
  const now = new Date();
  const two = (value) => String(value).padStart(2, "0");
  const day = `${now.getFullYear()}-${two(now.getMonth() + 1)}-${two(now.getDate())}`;
  return `session-${day}-${two(now.getHours())}${two(now.getMinutes())}${two(now.getSeconds())}.h5`;
}
