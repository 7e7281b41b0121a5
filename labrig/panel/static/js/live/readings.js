// Readings so far: mean and scatter at each voltage, for the present run and for all; and each
// reading of a run, where one can be marked invalid with a reason.

import { h, newId, put, setText } from "../dom.js";
import { number, shapeOf, volts } from "../format.js";
import { placeOf } from "../words.js";
import { stripRows, valueOf } from "./strip_rows.js";

const REASONS = [
  "bubble under the sheet",
  "the sheet slipped in the clamp",
  "something touched the rig",
  "sheet too dry",
];

/** `mark(run, reading|null, why)` sends it; null in a replay. `may()`: why this page may not. */
export class Readings {
  constructor(job, { mark = null, may = () => "" } = {}) {
    Object.assign(this, { job, mark, may, chosen: null, marking: null });
    this.cards = h("div", { class: "means" });
    this.table = h("div", {
      class: "scroll",
      tabindex: 0,
      role: "region",
      "aria-label": "mean force of every run",
    });
    this.single = h("div", {
      class: "scroll",
      tabindex: 0,
      role: "region",
      "aria-label": "single readings",
    });
    this.singleName = h("h3");
    this.whole = h("div");
    this.element = h(
      "section",
      { class: "card readings", "aria-label": "readings" },
      h(
        "h2",
        {},
        "Readings ",
        h("span", { class: "muted" }, "force in mN, mean \u00B1 scatter of one reading"),
      ),
      this.cards,
      h(
        "div",
        { class: "readings-two" },
        this.table,
        h(
          "div",
          { class: "readings-single" },
          h("div", { class: "readings-head" }, this.singleName, this.whole),
          this.single,
        ),
      ),
    );
  }

  update(dirty) {
    if (
      this.built &&
      !["story", "plan", "reading", "marked", "run_started", "run_stopped"].some((type) =>
        dirty.has(type),
      )
    )
      return;
    this.built = true;
    if (dirty.has("story")) this.chosen = this.marking = null;
    this.showCards();
    this.showTable();
    if (this.marking === null) this.showSingle();
  }

  get run() {
    return this.chosen ?? this.job.now_run;
  }

  voltages() {
    const found = new Set();
    for (const run of this.job.plan?.runs ?? [])
      for (const reading of run.readings) found.add(reading[2]);
    return [...found].sort((a, b) => b - a);
  }

  showCards() {
    const { job } = this;
    const planned = job.planned(job.now_run);
    const means = new Map(job.means(job.now_run).map((mean) => [mean.voltage, mean]));
    const wanted = (voltage) =>
      planned?.readings.filter(([, , v, kind]) => v === voltage && kind !== "discarded").length ??
      0;
    put(
      this.cards,
      this.voltages()
        .filter(wanted)
        .map((voltage) => {
          const mean = means.get(voltage);
          return h(
            "div",
            { class: "mean" },
            h(
              "span",
              { class: `mean-volts sign-${Math.sign(voltage)}` },
              `${shapeOf(voltage)} ${volts(voltage)}`,
            ),
            h("strong", {}, number(mean?.mean, 3)),
            h(
              "span",
              { class: "mean-rest" },
              `${mean?.scatter == null ? "" : `\u00B1 ${number(mean.scatter, 3)} mN \u00B7 `}${mean?.count ?? 0} of ${wanted(voltage)}`,
            ),
          );
        }),
    );
  }

  showTable() {
    const { job } = this;
    const columns = this.voltages();
    const begun = job.begun().filter((run) => job.runs.get(run.run)?.readings.size);
    if (!begun.length) {
      put(this.table, h("p", { class: "muted" }, "no readings yet"));
      return;
    }
    const head = h(
      "tr",
      {},
      h("th", { scope: "col" }, "run"),
      columns.map((voltage) =>
        h("th", { scope: "col", class: "num" }, `${shapeOf(voltage)} ${volts(voltage)}`),
      ),
    );
    put(
      this.table,
      h(
        "table",
        {},
        h("thead", {}, head),
        h(
          "tbody",
          {},
          begun.map((run) => this.row(run, columns)),
        ),
      ),
    );
  }

  row(run, columns) {
    const { job } = this;
    const means = new Map(job.means(run.run).map((mean) => [mean.voltage, mean]));
    const record = job.runs.get(run.run);
    const choose = () => {
      this.chosen = run.run === job.now_run ? null : run.run;
      this.marking = null;
      this.showTable();
      this.showSingle();
    };
    return h(
      "tr",
      { class: run.run === this.run ? "chosen" : "" },
      h(
        "th",
        { scope: "row" },
        h(
          "button",
          {
            class: "link",
            type: "button",
            onclick: choose,
            "aria-pressed": String(run.run === this.run),
          },
          `${run.run + 1} \u00B7 ${placeOf(run)}`,
        ),
        record.invalid && h("span", { class: "verdict bad" }, "INVALID"),
      ),
      columns.map((voltage) => {
        const mean = means.get(voltage);
        return h(
          "td",
          { class: "num" },
          mean
            ? [
                number(mean.mean, 3),
                h("span", { class: "muted" }, ` \u00B1 ${number(mean.scatter, 3)}`),
              ]
            : "\u2013",
          this.lostOf(record, voltage),
        );
      }),
    );
  }

  /** '2 of 3' where readings at a voltage do not count. */
  lostOf(record, voltage) {
    const taken = [...record.readings.values()].filter(
      (one) => one.voltage_V === voltage && one.kind !== "discarded",
    );
    const count = taken.filter((one) => one.valid).length;
    if (record.invalid || count === taken.length) return null;
    const name = `${count} of ${taken.length} readings count`;
    return h("span", { class: "lost", title: name }, `${count} of ${taken.length}`);
  }

  showSingle() {
    const { job } = this;
    const planned = job.planned(this.run);
    const record = job.runs.get(this.run);
    this.singleName.hidden = !planned;
    setText(this.singleName, planned ? `Run ${planned.run + 1}, each reading` : "");
    if (!planned || !record?.readings.size) {
      put(this.single);
      put(this.whole);
      return;
    }
    const names = [
      "reading",
      "drive",
      ...this.columns().map(({ title, unit }) => `${title.toLowerCase()}, ${unit}`),
      "state",
      ...(this.mark ? ["mark"] : []),
    ];
    const readings = [...record.readings.values()].sort((a, b) => b.index - a.index);
    put(
      this.whole,
      (this.mark || record.invalid) &&
        this.marker(null, record.invalid, "Mark the whole run invalid"),
    );
    put(
      this.single,
      h(
        "table",
        {},
        h(
          "thead",
          {},
          h(
            "tr",
            {},
            names.map((name) => h("th", { scope: "col" }, name)),
          ),
        ),
        h(
          "tbody",
          {},
          readings.map((reading) => this.reading(reading)),
        ),
      ),
    );
  }

  /** The channels but for the drive, whose voltage stands there as it was set. */
  columns() {
    return stripRows(this.job.plan).filter((row) => row.key !== "drive_V");
  }

  reading(reading) {
    const word = !reading.valid
      ? h("span", { class: "verdict bad" }, "INVALID")
      : reading.kind === "kept"
        ? ""
        : reading.kind.replace("_", " ");
    return h(
      "tr",
      { class: reading.valid ? "" : "invalid" },
      h("th", { scope: "row" }, String(reading.index + 1)),
      h("td", {}, `${shapeOf(reading.voltage_V)} ${volts(reading.voltage_V)}`),
      this.columns().map((row) =>
        h("td", { class: "num" }, number(valueOf(reading, row), row.decimals)),
      ),
      h("td", {}, word, reading.why && h("span", { class: "why" }, ` ${reading.why}`)),
      this.mark &&
        h(
          "td",
          {},
          reading.valid &&
            this.marker(reading.index, null, `Mark reading ${reading.index + 1} invalid`),
        ),
    );
  }

  /** A button that turns into a field for the reason. */
  marker(reading, invalid, name) {
    if (invalid) return h("p", { class: "verdict bad" }, `run INVALID: ${invalid}`);
    const place = h("div", { class: "marker" });
    const closed = () =>
      put(
        place,
        h(
          "button",
          { class: "small", type: "button", "aria-label": name, onclick: open },
          reading === null ? name : "Mark\u2026",
        ),
      );
    const open = () => {
      this.marking = reading ?? "run";
      put(place, this.reasonForm(reading, name, close));
      place.querySelector("input").focus();
    };
    const close = () => {
      this.marking = null;
      closed();
      this.showSingle();
    };
    closed();
    return place;
  }

  reasonForm(reading, name, close) {
    const list = newId("reasons");
    const field = h("input", {
      required: true,
      maxlength: 200,
      list,
      placeholder: "reason",
      "aria-label": `${name}: reason`,
      autocomplete: "off",
    });
    const fault = h("span", { class: "fault", role: "alert" });
    const { run } = this;
    const send = async (event) => {
      event.preventDefault();
      const why = this.may();
      if (why) return setText(fault, why);
      try {
        await this.mark(run, reading, field.value.trim());
        close();
      } catch (error) {
        setText(fault, error.message);
      }
    };
    return h(
      "form",
      { class: "marker-form", onsubmit: send },
      field,
      h(
        "datalist",
        { id: list },
        REASONS.map((reason) => h("option", { value: reason })),
      ),
      h("button", { class: "small", type: "submit" }, "Mark invalid"),
      h("button", { class: "small quiet", type: "button", onclick: close }, "Cancel"),
      fault,
    );
  }
}
