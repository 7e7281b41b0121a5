// One session of the library: what it is, what came out, what can be done with it.

import { mountAnalysis } from "../analysis.js";
import { table } from "../data_page.js";
import { h, put, setText } from "../dom.js";
import { bytes, clock, digits, number, when } from "../format.js";
import { get, post, query, Refused } from "../net.js";
import { Notes } from "../notes.js";
import { outcome } from "./library.js";

const AGAIN_MS = 500; // while the library has files to read, the fit may be one of them

/** Rows of name and value that describe a session; used for comparing, too. */
export function factsOf(session) {
  const facts = [
    ["started", when(session.started)],
    ["outcome", [outcome(session), session.reason ? ` ${session.reason}` : ""]],
    ["output at the end", (session.output ?? "\u2013").toUpperCase()],
    ["sheet", (session.sheet ?? []).join(", ")],
    ["protocol", session.protocol ?? "\u2013"],
    ["boards", session.boards ?? "\u2013"],
    ["runs", `${session.runs_complete ?? "\u2013"} of ${session.runs ?? "\u2013"} complete`],
    ["readings", `${session.readings ?? "\u2013"}, ${session.invalid ?? 0} invalid`],
    ["length", clock(session.duration_s)],
    ["size", bytes(session.bytes)],
    ["analysed", session.analysed ? "yes" : "no"],
    ["largest force", `${number(session.largest_force_mN, 3)} mN`],
    ["scatter of one reading", `${number(session.scatter_mN, 3)} mN`],
  ];
  for (const [name, fit] of Object.entries(session.fit ?? {})) {
    facts.push([
      `B, ${name}`,
      `${digits(1e6 * fit.B_Nm2, 4)} \u00B1 ${digits(1e6 * fit.B_sigma, 2)} \u00B5N\u00B7m\u00B2`,
    ]);
    for (const [volts, value] of Object.entries(fit.EIBM_Nm ?? {})) {
      facts.push([
        `EIBM, ${name}, ${volts} V`,
        `${digits(1e6 * value, 4)} \u00B1 ${digits(1e6 * fit.EIBM_sigma?.[volts], 2)} \u00B5N\u00B7m`,
      ]);
    }
    facts.push([
      `RMSE, ${name}`,
      `${digits(fit.rmse_force_mN, 3)} mN, ${digits(fit.rmse_curve_mm, 3)} mm`,
    ]);
  }
  return facts;
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
  let again = null;
  const read = () =>
    get(`/api/library/session?${query({ name })}`).then(
      (session) => {
        resume.hidden =
          app.status?.mode !== "rig" ||
          session.runs == null ||
          session.runs_complete >= session.runs ||
          session.outcome === "running";
        put(body, facts(session), log(session), (session.about ?? []).map(table), notes.element);
        if (session.pending) again = setTimeout(read, AGAIN_MS);
      },
      (error) => put(body, h("p", { class: "fault" }, error.message)),
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
    h("ol", { class: "log-lines scroll", tabindex: 0, "aria-label": "log of the session" }, lines),
  );
}
