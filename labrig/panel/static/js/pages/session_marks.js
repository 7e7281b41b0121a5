// The runs of a closed session, and marks that are made after its end: what is marked invalid, by
// whom and why. The recording itself stays as it is; a mark is taken back by another one.

import { h, put, setText } from "../dom.js";
import { when } from "../format.js";
import { post } from "../net.js";

/** A card with the runs and the marks of a session. `changed()` is called after each mark. */
export class SessionMarks {
  constructor(app, name, changed) {
    Object.assign(this, { app, name, changed });
    this.fault = h("p", { class: "fault", role: "alert" });
    this.form = h("div", { class: "marker" });
    this.runs = h("div", { class: "scroll" });
    this.marks = h("div", { class: "scroll" });
    this.element = h(
      "section",
      { class: "card session-marks", "aria-label": "runs and marks" },
      h("h2", {}, "Runs and marks"),
      this.runs,
      this.form,
      this.fault,
      this.marks,
    );
  }

  show(session) {
    const runs = session.runs_table ?? [];
    this.element.hidden = !runs.length;
    const closed = session.outcome !== "running" && !session.error;
    put(this.form);
    put(this.runs, runsTable(runs, closed && ((run) => this.ask(run))));
    const standing = lastOf(session.marks_table ?? []);
    put(
      this.marks,
      standing.length > 0 && marksTable(standing, (mark) => this.ask(mark.run, mark)),
    );
  }

  /** Ask for the reason; of a `mark` that is to be taken back, too. */
  ask(run, mark = null) {
    setText(this.fault, "");
    const number = h("input", { type: "number", min: 1, step: 1, value: mark?.reading ?? "" });
    const why = h("input", { required: true, maxlength: 200, autocomplete: "off" });
    const send = (event) => {
      event.preventDefault();
      const reading = mark ? mark.reading : number.value === "" ? null : Number(number.value);
      this.send(run, reading, why.value.trim(), mark !== null);
    };
    const did = mark ? `Take back the mark of ${named(mark)}` : `Mark run ${run} invalid`;
    put(
      this.form,
      h(
        "form",
        { class: "marker-form", onsubmit: send, "aria-label": did },
        h("strong", {}, did),
        !mark && h("label", {}, "reading (none: the whole run) ", number),
        h("label", {}, "reason ", why),
        h("button", { type: "submit" }, mark ? "Take back" : "Mark invalid"),
        h("button", { class: "quiet", type: "button", onclick: () => put(this.form) }, "Cancel"),
      ),
    );
    (mark ? why : number).focus();
  }

  async send(run, reading, why, undo) {
    const body = { name: this.name, run: run - 1, reading: reading && reading - 1, why, undo };
    try {
      await this.app.control.act(() => post("/api/library/mark", body));
      this.changed();
    } catch (error) {
      setText(this.fault, error.message);
    }
  }
}

function named(mark) {
  return mark.reading === null ? `run ${mark.run}` : `reading ${mark.reading} of run ${mark.run}`;
}

/** Of each run or reading the last mark. */
function lastOf(marks) {
  return [...new Map(marks.map((mark) => [named(mark), mark])).values()];
}

function runsTable(runs, ask) {
  return h(
    "table",
    {},
    h(
      "thead",
      {},
      h(
        "tr",
        {},
        ["run", "sheet", "at mm", "state", "readings", "invalid", ""].map((name) =>
          h("th", { scope: "col" }, name || h("span", { class: "visually-hidden" }, "mark")),
        ),
      ),
    ),
    h(
      "tbody",
      {},
      runs.map((run) =>
        h(
          "tr",
          {},
          [run.run, run.configuration, run.position_mm ?? "free", run.state, run.readings, run.invalid].map(
            (cell) => h("td", {}, `${cell}`),
          ),
          h("td", {}, ask && run.readings > 0 && markButton(run.run, ask)),
        ),
      ),
    ),
  );
}

function markButton(run, ask) {
  const name = `Mark run ${run} or a reading of it invalid`;
  return h(
    "button",
    { class: "small", type: "button", "aria-label": name, onclick: () => ask(run) },
    "Mark\u2026",
  );
}

function marksTable(marks, takeBack) {
  const columns = ["marked after the end", "reason", "by", "at", ""];
  return h(
    "table",
    {},
    h("thead", {}, h(
        "tr",
        {},
        columns.map((name) =>
          h("th", { scope: "col" }, name || h("span", { class: "visually-hidden" }, "take back")),
        ),
      )),
    h(
      "tbody",
      {},
      marks.map((mark) =>
        h(
          "tr",
          {},
          h("td", {}, `${named(mark)}: ${mark.invalid ? "INVALID" : "mark taken back"}`),
          [mark.why, mark.who, when(mark.when)].map((cell) => h("td", {}, cell)),
          h("td", {}, mark.invalid && backButton(mark, takeBack)),
        ),
      ),
    ),
  );
}

function backButton(mark, takeBack) {
  const name = `Take back the mark of ${named(mark)}`;
  return h(
    "button",
    { class: "small", type: "button", "aria-label": name, onclick: () => takeBack(mark) },
    "Take back\u2026",
  );
}
