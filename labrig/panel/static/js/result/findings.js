// What a result says in words: parameters, the verdict, what to measure next, what is not there yet.

import { h, put } from "../dom.js";
import { volts, withInterval } from "../format.js";
import { query } from "../net.js";

/** Parameters of the chosen model, as a table. */
export function parameters(choice) {
  const { part, chosen, result } = choice;
  const found = part?.parameters[chosen.model];
  const place = h("section", { class: "card" });
  if (!found) {
    const said = result?.complete === false ? "fitting\u2026" : "No model is fitted yet.";
    return put(place, h("h2", {}, "Parameters"), h("p", { class: "muted" }, said));
  }
  const model = result.models.find((one) => one.id === chosen.model);
  const meaning = chosen.model === "constant" ? "constant EIBM" : "EIBM along the sheet, mean over [0, l],";
  const rows = [
    row("bending stiffness B", found.B_uNm2, "\u00B5N\u00B7m\u00B2"),
    row("Young\u2019s modulus E", found.E_MPa, "MPa"),
    ...byVoltage(found.EIBM_uNm).map(([level, one]) =>
      row(`${meaning} at ${volts(Number(level))}`, one, "\u00B5N\u00B7m"),
    ),
  ];
  return put(
    place,
    h("h2", {}, `Parameters, ${part.name} sheet `, h("span", { class: "muted" }, model.name)),
    h(
      "div",
      { class: "scroll", tabindex: 0, role: "region", "aria-label": "parameters" },
      h("table", { class: "rows" }, h("tbody", {}, rows)),
    ),
    model.why && h("p", { class: "muted" }, model.why),
  );
}

/** From the highest voltage to the lowest, as the command line lists them. */
function byVoltage(values) {
  return Object.entries(values).sort(([a], [b]) => Number(b) - Number(a));
}

function row(name, parameter, unit) {
  const [value, low, high] = withInterval(parameter);
  return h(
    "tr",
    {},
    h("th", { scope: "row" }, name),
    h("td", { class: "num" }, `${value} ${unit}`),
    h("td", { class: "num" }, `90 %: ${low} to ${high}`),
  );
}

/** The verdict of the diagnosis, and what to measure next; `write()` has its protocol written. */
export function verdict({ diagnosis, models, complete }, write) {
  const place = h("section", { class: "card" });
  if (!diagnosis)
    return put(
      place,
      h("h2", {}, "Model discrepancy"),
      h("p", { class: "muted" }, complete || models.length ? "No diagnosis yet." : "reading\u2026"),
    );
  return put(
    place,
    h("h2", {}, "Model discrepancy"),
    h("p", { class: "verdict result-verdict" }, sentence(diagnosis.title)),
    diagnosis.sentences.map((text) => h("p", {}, text)),
    h("h2", {}, "Next measurement"),
    diagnosis.next.length
      ? [
          diagnosis.next.map((text) => h("p", {}, text)),
          h("button", { type: "button", onclick: write }, "Write its protocol"),
          h("p", { class: "muted" }, "A file beside the session; its row under Analysis then opens it as a new run."),
        ]
      : h("p", { class: "muted" }, "Nothing further is proposed."),
  );
}

function sentence(text) {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}.`;
}

/** What is out of date and what is not there yet, with the link to the report where there is one. */
export function standing(result, session) {
  const missing = result.missing.map((one) => one.text);
  const report = result.complete && !result.missing.some((one) => one.kind === "report");
  return [
    result.out_of_date.map((text) => h("p", { class: "fault" }, `Out of date: ${text}`)),
    result.warnings.length
      ? h(
          "details",
          {},
          h("summary", {}, `Remarks of the analysis (${result.warnings.length})`),
          h("ul", {}, result.warnings.map((text) => h("li", {}, text))),
        )
      : null,
    missing.map((text) => h("p", { class: "muted" }, text)),
    report &&
      h(
        "a",
        {
          class: "button main",
          href: `/api/analysis/output?${query({ session, name: "report" })}`,
          target: "_blank",
          rel: "noopener",
        },
        "Full report",
      ),
  ]
    .flat(Infinity)
    .filter(Boolean);
}
