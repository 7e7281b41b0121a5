// The run as it goes on.

import { h, put, setText } from "../dom.js";
import { LiveView } from "../live/view.js";
import { get, post } from "../net.js";
import { Notes } from "../notes.js";
import { recoverButton, recoveredPlace } from "../recover.js";

/** Show the present job. */
export function mount(place, app) {
  const { job, control } = app;
  const notes = new Notes(app);
  const acts = {
    answer: (prompt, done) => control.act(() => post("/api/answer", { prompt, done })),
    mark: (run, reading, why) => control.act(() => post("/api/mark", { run, reading, why })),
    may: () => control.why(),
  };
  const view = new LiveView(job, acts, [notes.element]);
  const bar = runBar(app);
  place.append(h("h1", { class: "visually-hidden" }, "Run"), bar.element, bar.notice, view.element);
  const again = () => view.update(new Set(["prompt"]));
  control.watchers.add(again);
  const stop = job.watch(() => bar.update());
  bar.update();
  return {
    view,
    destroy() {
      stop();
      control.watchers.delete(again);
      notes.destroy();
      view.destroy();
    },
  };
}

/** Choose a name, also one that is not among the files. */
function chosenModel(select, name) {
  if (![...select.options].some((option) => option.value === name))
    select.append(h("option", { value: name }, name));
  select.value = name;
}

/** How the job ended, in full; empty while it goes on. */
function endOf({ job, ended, output }) {
  if (job?.state === "lost" && output?.by === "guard") return job.text;
  if (job?.state === "lost")
    return "The run\u2019s process does not answer. Press STOP, then look at the amplifier.";
  if (job?.state !== "ended") return "";
  const told = ended?.reason && !job.text?.includes(ended.reason) ? `${ended.reason} ` : "";
  const code = job.code ? ` (code ${job.code})` : "";
  return `Ended: ${told}${job.text ?? ""}${code}`;
}

/** Whether nothing follows the present run, before which a pause could be. */
function lastRun(job) {
  const done = new Set(job.plan?.done ?? []);
  const left = (job.plan?.runs ?? []).filter(({ run }) => !done.has(run));
  return left.length === 0 || left[left.length - 1].run === job.now_run;
}

/** What is running, the gentle stop, whose model is drawn; or the way to a new run. */
function runBar(app) {
  const { job, control } = app;
  const name = h("strong", { class: "runbar-name" });
  const fault = h("span", { class: "fault", role: "alert" });
  const gentle = h(
    "button",
    { type: "button", onclick: () => act(() => post("/api/stop_after_pulse")) },
    "Stop after this pulse",
  );
  const pause = h("button", {
    type: "button",
    onclick: () => act(() => post("/api/pause", { on: !job.pause?.on })),
  });
  const model = h(
    "select",
    { onchange: () => act(() => post("/api/model", { name: model.value || null })) },
    h("option", { value: "" }, "none"),
  );
  const begin = h("a", { class: "button", href: "#/new" }, "New run");
  const replay = h("a", { class: "button" }, "Replay it");
  const result = h("a", { class: "button" });
  const recover = h("span");
  const recovered = recoveredPlace();
  const act = async (work) => {
    setText(fault, control.why());
    if (fault.textContent) return;
    await control.act(work).catch((error) => setText(fault, error.message));
  };
  get("/api/files")
    .then(({ files }) => {
      for (const file of files)
        if (file.kind === "model") model.append(h("option", { value: file.name }, file.name));
      update();
    })
    .catch(() => {});
  const element = h(
    "div",
    { class: "runbar" },
    name,
    h("span", { class: "runbar-gap" }),
    fault,
    h("label", {}, "Model drawn ", model),
    pause,
    gentle,
    begin,
    replay,
    result,
    recover,
    recovered,
  );
  const notice = h("p", { class: "notice card", role: "status", hidden: true });
  const update = () => {
    const how = endOf(job);
    notice.hidden = !how;
    setText(notice, how);
    const run = job.job?.kind === "run" || job.plan;
    const session = job.plan?.session ?? job.job?.session;
    setText(
      name,
      !run
        ? "No run yet"
        : [session, job.plan?.protocol, job.plan?.simulated ? "SIMULATED RIG" : null]
            .filter(Boolean)
            .join(" \u00B7 "),
    );
    gentle.hidden = !(job.going && job.job.kind === "run");
    pause.hidden = gentle.hidden || !job.started || (lastRun(job) && !job.pause?.on);
    setText(
      pause,
      job.state.state === "paused"
        ? "Continue"
        : job.pause?.on
          ? "Do not pause"
          : "Pause after this position",
    );
    begin.hidden = job.going;
    const lost = job.job?.state === "lost" && Boolean(session); // its file was not closed
    if (lost && recover.dataset.session !== session) {
      recover.dataset.session = session;
      put(recover, recoverButton(app, session, recovered));
    }
    recover.hidden = recovered.hidden = !lost;
    replay.hidden = job.going || lost || !session || !job.started;
    result.hidden = lost || !session || !job.started || job.job?.kind !== "run";
    setText(result, job.going ? "The result so far" : "Show the result");
    result.classList.toggle("main", !job.going);
    if (session) result.setAttribute("href", `#/result?session=${encodeURIComponent(session)}`);
    if (session) replay.setAttribute("href", `#/replay?session=${encodeURIComponent(session)}`);
    if (document.activeElement !== model) chosenModel(model, job.model ?? "");
  };
  return { element, notice, update };
}
