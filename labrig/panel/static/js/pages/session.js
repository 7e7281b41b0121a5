// One session of the library: what it is, what came out, what can be done with it.

import { mountAnalysis } from "../analysis.js";
import { table } from "../data_page.js";
import { h, put, setText } from "../dom.js";
import { bytes, clock, digits, number, timesOf, volts, whenInZone } from "../format.js";
import { get, post, query, Refused } from "../net.js";
import { Notes } from "../notes.js";
import { recoverButton, recoveredPlace } from "../recover.js";
import { outcome } from "./library.js";
import { SessionMarks } from "./session_marks.js";

const AGAIN_MS = 500; // while the library has files to read, the fit may be one of them

/** Rows of name and value that describe a session; used for comparing, too. */
export function factsOf(session) {
  const facts = [
    ["started", whenInZone(session.started)],
    ["outcome", [outcome(session), session.reason ? ` ${session.reason}` : ""]],
    ["output at the end", (session.output ?? "\u2013").toUpperCase()],
    ["sheet", (session.sheet ?? []).join(", ")],
    ["protocol", session.protocol ?? "\u2013"],
    ["boards", session.boards ?? "\u2013"],
    ["runs", `${session.runs_complete ?? "\u2013"} of ${session.runs ?? "\u2013"} complete`],
    ["readings", `${session.readings ?? "\u2013"}, ${session.invalid ?? 0} invalid`],
    [
      "length",
      clock(session.duration_s) +
        (session.clock === "virtual" ? ", by its own clock; it was recorded on a virtual one" : ""),
    ],
    ["size", bytes(session.bytes)],
    ["analysed", outdated(session.analysed ? "yes" : "no", session.analysis_outdated)],
    ["largest force", `${number(session.largest_force_mN, 3)} mN`],
    ["scatter of one reading", `${number(session.scatter_mN, 3)} mN`],
  ];
  if (session.fit_outdated) facts.push(["fit", outdated("yes", true)]);
  return [...facts, ...factsOfFit(session.fit ?? {})];
}

/** What a model file says: each number with its quantity and unit, errors by configuration. */
function factsOfFit(fits) {
  const facts = [];
  const rms = (force, curve) => `force ${digits(force, 3)} mN, curve ${digits(curve, 3)} mm`;
  for (const [name, fit] of Object.entries(fits)) {
    facts.push([
      `B, ${name}`,
      `${digits(1e6 * fit.B_Nm2, 4)} \u00B1 ${digits(1e6 * fit.B_sigma, 2)} \u00B5N\u00B7m\u00B2`,
    ]);
    for (const [voltage, value] of Object.entries(fit.EIBM_Nm ?? {})) {
      const sigma = fit.EIBM_sigma?.[voltage];
      const error = sigma === null || sigma === undefined ? "" : ` \u00B1 ${digits(1e6 * sigma, 2)}`;
      facts.push([
        `${fit.EIBM_quantity ?? "EIBM"}, ${name}, ${volts(Number(voltage))}`,
        `${digits(1e6 * value, 4)}${error} \u00B5N\u00B7m`,
      ]);
    }
    if (Number.isFinite(fit.rmse_force_mN) || Number.isFinite(fit.rmse_curve_mm))
      facts.push([`RMSE, ${name}`, rms(fit.rmse_force_mN, fit.rmse_curve_mm)]);
  }
  const first = Object.values(fits)[0];
  if (first?.model) facts.push(["model file", first.model]);
  if (Number.isFinite(first?.rmse_all_force_mN) || Number.isFinite(first?.rmse_all_curve_mm))
    facts.push(["RMSE, all sheets together", rms(first.rmse_all_force_mN, first.rmse_all_curve_mm)]);
  return facts;
}

function outdated(words, is) {
  return is ? `${words}, OUT OF DATE: runs or readings were marked since` : words;
}

/** Show the session named in the address. */
export function mount(place, app, asked) {
  const name = asked.get("name");
  const body = h("div", { class: "session-two" }, h("p", { class: "muted" }, "reading\u2026"));
  const fault = h("p", { class: "fault", role: "alert" });
  const analysis = h("div", { class: "card session-analysis" });
  const link = (words, href, more = {}) => h("a", { class: "button", href, ...more }, words);
  const file = (as) => `/api/library/export?${query({ name, as })}`;
  const resume = h("button", { type: "button", hidden: true, onclick: () => act() }, "Resume it");
  const act = async () => {
    try {
      await app.control.act(() => post("/api/run", { resume: name }));
      location.hash = "#/run";
    } catch (error) {
      setText(fault, error.message);
    }
  };
  const tables = () =>
    fetched(file("csv"), `${name.replace(/\.[^.]*$/, "")}.zip`).then(
      () => setText(fault, ""),
      (error) => setText(fault, error.message),
    );
  place.append(
    h("h1", {}, name),
    h(
      "div",
      { class: "buttons session-do" },
      link("Result", `#/result?${query({ session: name })}`, { class: "button main" }),
      link("Replay", `#/replay?${query({ session: name })}`),
      h("button", { type: "button", onclick: () => tables() }, "Export tables (CSV)"),
      link("Download the file", file("h5"), { download: "" }),
      resume,
      link("All sessions", "#/library"),
    ),
    fault,
    analysis,
    body,
  );
  const notes = new Notes(app, name);
  const marks = new SessionMarks(app, name, () => read());
  let again = null;
  const read = () =>
    get(`/api/library/session?${query({ name })}`).then(
      (session) => {
        marks.show(session);
        resume.hidden =
          app.status?.mode !== "rig" ||
          session.runs == null ||
          session.runs_complete >= session.runs ||
          session.outcome === "running";
        put(body, facts(session), log(session), marks.element, (session.about ?? []).map(table), notes.element);
        if (session.pending) again = setTimeout(read, AGAIN_MS);
      },
      (error) => put(body, unopened(app, name, error.message)),
    );
  read();
  const analysed = mountAnalysis(analysis, app, name, read);
  return {
    destroy() {
      clearTimeout(again);
      analysed.destroy();
      notes.destroy?.();
    },
  };
}

/** Why it cannot be opened; where a crash has left it, with what can be done about that. */
function unopened(app, name, why) {
  const said = recoveredPlace();
  const cut_short = why.includes("labrig recover");
  return h(
    "section",
    { class: "card" },
    h("p", { class: "fault" }, why),
    cut_short && recoverButton(app, name, said),
    said,
  );
}

/** Save what an address gives; raises Refused with the server's sentence where it gives nothing. */
async function fetched(address, name) {
  const answer = await fetch(address, { credentials: "same-origin" });
  if (!answer.ok)
    throw new Refused(
      (await answer.json().catch(() => ({}))).error ?? "It cannot be had.",
      answer.status,
    );
  const url = URL.createObjectURL(await answer.blob());
  h("a", { href: url, download: name }).click();
  // a busy computer reads it late; taken away before, the download would fail without a word
  setTimeout(() => URL.revokeObjectURL(url), 120_000);
}

function facts(session) {
  return h(
    "section",
    { class: "card" },
    session.error && h("p", { class: "fault" }, session.error),
    h(
      "dl",
      { class: "facts" },
      factsOf(session).map(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]),
    ),
  );
}

function log(session) {
  const lines = (session.log ?? []).map((line) =>
    h(
      "li",
      {},
      typeof line === "string"
        ? line
        : [
            h("time", {}, line.time_s != null ? clock(line.time_s) : ""),
            h("span", {}, line.text ?? line.log ?? ""),
          ],
    ),
  );
  return h(
    "section",
    { class: "card log" },
    h("h2", {}, "Log"),
    h("p", { class: "muted" }, timesOf(session.started, session.clock)),
    h("ol", { class: "log-lines scroll", tabindex: 0, "aria-label": "log of the session" }, lines),
  );
}
