// The sessions of the data folder: found, sorted, opened, compared, exported.

import { h, newId, put, setText } from "../dom.js";
import { bytes, clock, digits, number, volts, when } from "../format.js";
import { get, query } from "../net.js";
import { recoverButton, recoveredPlace } from "../recover.js";

const PAGE = 100;
const TYPED_MS = 250;
const COLUMNS = [
  { key: "started", name: "date", show: (s) => when(s.started) },
  {
    key: "name",
    name: "session",
    show: (s) => [
      h("a", { href: `#/session?${query({ name: s.name })}` }, s.name),
      !s.error && h("a", { class: "to-result", href: `#/result?${query({ session: s.name })}` }, "result"),
    ],
  },
  { key: "sheet", name: "sheet", show: (s) => (s.sheet ?? []).join(", ") },
  { key: "outcome", name: "outcome", show: (s) => outcome(s) },
  {
    key: "readings",
    name: "readings",
    num: true,
    show: (s) => `${s.readings ?? "\u2013"}${s.invalid ? ` (${s.invalid} invalid)` : ""}`,
  },
  { key: "duration_s", name: "length", num: true, show: (s) => clock(s.duration_s) },
  {
    key: "largest_force_mN",
    name: "largest force, mN",
    num: true,
    show: (s) => number(s.largest_force_mN, 2),
  },
  {
    key: "B_Nm2",
    name: "B, \u00B5N\u00B7m\u00B2",
    num: true,
    show: (s) => fitted(s, (fit) => digits(1e6 * fit.B_Nm2, 4)),
  },
  {
    key: "EIBM_Nm",
    name: "EIBM, \u00B5N\u00B7m",
    num: true,
    show: (s) => [fitted(s, moments), source(s)],
  },
  { key: "bytes", name: "size", num: true, show: (s) => bytes(s.bytes) },
];
const OUTCOMES = ["completed", "aborted", "failed", "crashed", "running"];

/** The outcome as a word with a mark of its own. */
export function outcome(session) {
  if (session.recoverable)
    return h("span", { class: "verdict bad", title: session.error }, "\u2715 cut short");
  if (session.error)
    return h("span", { class: "verdict bad", title: session.error }, "\u2715 DAMAGED");
  const mark =
    {
      completed: "\u2713",
      aborted: "\u25A0",
      failed: "\u2715",
      crashed: "\u2715",
      running: "\u25B6",
    }[session.outcome] ?? "?";
  const kind =
    session.outcome === "completed"
      ? "good"
      : session.outcome === "running" || session.outcome === "aborted"
        ? ""
        : "bad";
  return h(
    "span",
    { class: `verdict ${kind}`, title: session.reason ?? "" },
    `${mark} ${session.outcome}`,
  );
}

function fitted(session, show) {
  const fits = Object.entries(session.fit ?? {});
  return fits.length
    ? fits.map(([name, fit]) => h("span", { class: "per-sheet" }, h("i", {}, name), " ", show(fit)))
    : "\u2013";
}

/** The EIBM at each voltage. */
const moments = (fit) =>
  Object.entries(fit.EIBM_Nm ?? {})
    .map(([voltage, value]) => `${digits(1e6 * value, 4)} at ${volts(Number(voltage))}`)
    .join(", ");

/** The kind of EIBM, and the model file that B and EIBM are from. */
function source(session) {
  const fit = Object.values(session.fit ?? {})[0];
  return fit?.model ? h("span", { class: "fit-source" }, `${fit.EIBM_quantity}; ${fit.model}`) : "";
}

/** Show the library. */
export function mount(place, app) {
  const page = new Library(app);
  place.append(page.element);
  page.load();
  return page;
}

class Library {
  constructor(app) {
    this.app = app;
    this.recovered = recoveredPlace();
    this.asked = {
      sort: "started",
      down: 1,
      text: "",
      outcome: "",
      sheet: "",
      limit: PAGE,
      offset: 0,
    };
    this.chosen = new Set();
    this.said = h("p", { class: "muted", role: "status" }, "looking\u2026");
    this.body = h("div", {
      class: "scroll library-table",
      tabindex: 0,
      role: "region",
      "aria-label": "sessions",
    });
    this.compare = h("a", { class: "button", "aria-disabled": "true" }, "Compare two");
    this.pages = h("div", { class: "buttons" });
    const typed = (key) => (event) => {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.ask({ [key]: event.target.value, offset: 0 }), TYPED_MS);
    };
    const field = (name, control) => {
      control.id = newId("filter");
      return h("label", { for: control.id }, name, " ", control);
    };
    this.element = h(
      "div",
      {},
      h("h1", {}, "Sessions"),
      h(
        "section",
        { class: "card filters" },
        field(
          "find",
          h("input", {
            type: "search",
            oninput: typed("text"),
            placeholder: "name, sheet, protocol",
          }),
        ),
        field(
          "outcome",
          h(
            "select",
            { onchange: typed("outcome") },
            h("option", { value: "" }, "any"),
            OUTCOMES.map((one) => h("option", {}, one)),
          ),
        ),
        field("sheet", h("input", { oninput: typed("sheet"), placeholder: "any" })),
        this.compare,
        this.said,
      ),
      this.recovered,
      h("section", { class: "card" }, this.body, this.pages),
    );
    this.showChosen();
  }

  ask(changes) {
    Object.assign(this.asked, changes);
    this.load();
  }

  async load() {
    const mine = (this.latest = {});
    const { down, ...rest } = this.asked;
    try {
      const found = await get(`/api/library?${query({ ...rest, down: down ? 1 : 0 })}`);
      if (mine === this.latest) this.show(found);
    } catch (error) {
      setText(this.said, error.message);
    }
  }

  show({ sessions, total, damaged, pending, cut }) {
    const { offset, sort, down } = this.asked;
    const last = Math.min(offset + sessions.length, total);
    setText(
      this.said,
      `${total ? `${offset + 1} to ${last} of ${total}` : "no sessions"}${damaged ? `, ${damaged} damaged` : ""}` +
        `${pending ? `; ${pending} ${pending === 1 ? "file" : "files"} not looked into yet` : ""}${cut ? `; ${cut}` : ""}`,
    );
    const head = h(
      "tr",
      {},
      h("th", { scope: "col" }, h("span", { class: "visually-hidden" }, "choose")),
      COLUMNS.map((column) => this.heading(column, sort, down)),
    );
    put(
      this.body,
      h(
        "table",
        {},
        h("thead", {}, head),
        h(
          "tbody",
          {},
          sessions.map((session) => this.row(session)),
        ),
      ),
    );
    const page = (name, to, able) =>
      h(
        "button",
        { type: "button", disabled: !able, onclick: () => this.ask({ offset: to }) },
        name,
      );
    put(
      this.pages,
      total > PAGE && [
        page("Earlier page", Math.max(0, offset - PAGE), offset > 0),
        page("Later page", offset + PAGE, last < total),
      ],
    );
  }

  heading({ key, name, num }, sort, down) {
    const sorted = key === sort;
    const press = () => this.ask({ sort: key, down: sorted ? Number(!down) : 1, offset: 0 });
    return h(
      "th",
      {
        scope: "col",
        class: num ? "num" : "",
        "aria-sort": sorted ? (down ? "descending" : "ascending") : "none",
      },
      h(
        "button",
        { type: "button", class: "link", onclick: press },
        name,
        sorted ? (down ? " \u25BC" : " \u25B2") : "",
      ),
    );
  }

  row(session) {
    const choose = (event) => {
      if (event.target.checked) this.chosen.add(session.name);
      else this.chosen.delete(session.name);
      this.showChosen();
    };
    return h(
      "tr",
      {},
      h(
        "td",
        {},
        h("input", {
          type: "checkbox",
          checked: this.chosen.has(session.name),
          onchange: choose,
          "aria-label": `choose ${session.name}`,
        }),
      ),
      COLUMNS.map((column) =>
        h(
          "td",
          { class: column.num ? "num" : "" },
          column.show(session),
          column.key === "outcome" && session.recoverable && this.recover(session.name),
        ),
      ),
    );
  }

  recover(name) {
    return [" ", recoverButton(this.app, name, this.recovered, () => this.load())];
  }

  showChosen() {
    const [a, b] = this.chosen;
    const two = this.chosen.size === 2;
    if (two) this.compare.setAttribute("href", `#/compare?${query({ a, b })}`);
    else this.compare.removeAttribute("href");
    this.compare.setAttribute("aria-disabled", String(!two));
    setText(this.compare, two ? "Compare the two" : `Compare (choose two, ${this.chosen.size} chosen)`);
  }
}
