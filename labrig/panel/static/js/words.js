// What states are called, in words an operator reads at two metres, and the shapes beside them.

import { clock } from "./format.js";

/** Shapes in a box of 40 x 40, told apart without colour: tick, triangle, bolt, question, ring. */
export const SHAPES = {
  safe: "M4 4H36V36H4ZM10.500 20.500L17.500 27.500L30 12.500L26.500 9.500L17.200 20.800L13.800 17.200Z",
  armed: "M20 3L38 36H2ZM17.800 14V26H22.200V14ZM17.800 28.500V32.500H22.200V28.500Z",
  energised: "M23 1L6 23H17L14 39L34 16H22Z",
  unknown:
    "M20 1L39 20L20 39L1 20ZM14.500 16H18C18 12.500 22.500 12.700 22.500 15.800C22.500 18.500 18.200 18.300 18.200 24H21.700C21.700 20.500 26 20.300 26 15.600C26 8.200 14.500 8.400 14.500 16ZM18 26.500V30.500H22V26.500Z",
  none: "M20 4A16 16 0 1 0 20 36A16 16 0 1 0 20 4ZM20 10A10 10 0 1 1 20 30A10 10 0 1 1 20 10Z",
};

const OUTPUT = {
  safe: "SAFE",
  armed: "ARMED",
  energised: "ENERGISED",
  unknown: "UNKNOWN",
  none: "NOT IN USE",
};

/** The output as the page may state it: what is not heard of any more is UNKNOWN. */
export function outputOf(job) {
  if (!job.alive && (job.alive === false || job.job))
    return lamp("unknown", "no connection to the panel");
  if (job.job?.state === "lost" && job.output?.by !== "guard")
    return lamp("unknown", "the run does not answer");
  if (job.output) return lamp(job.output.state, job.output.why);
  if (job.ended) return lamp(job.ended.output, job.ended.reason);
  return lamp("none", job.alive ? "no run has used it" : "connecting");
}

function lamp(state, why) {
  const known = OUTPUT[state] ? state : "unknown";
  return { state: known, word: OUTPUT[known], why: why ?? "" };
}

const PHASES = {
  idle: "IDLE",
  preparing: "PREPARING",
  leading_in: "LEADING IN",
  running: "RUNNING",
  tailing: "FINISHING",
  paused: "PAUSED",
  stopping: "STOPPING",
  finished: "FINISHED",
  unknown: "UNKNOWN",
};
const KINDS = { run: "run", preflight: "preflight", weighing: "weighing", camera: "camera" };

/** The job in a word, and what it is at. */
export function goingOf(job) {
  if (job.alive === false) return { word: "NOT HEARD", why: "trying to reach the panel again" };
  if (!job.job) return { word: "NO RUN", why: "nothing is going on" };
  if (job.job.state === "lost")
    return {
      word: "LOST",
      why: job.output?.by === "guard" ? "ended by the guard" : "the run's process does not answer",
    };
  if (job.prompt) return { word: "WAITING", why: runName(job) || "for the operator" };
  if (
    job.job.state === "starting" ||
    (job.going && job.job.kind === "run" && job.state.state === "idle")
  )
    return { word: "STARTING", why: job.step?.text ?? KINDS[job.job.kind] };
  if (job.ended) return { word: job.ended.outcome.toUpperCase(), why: job.ended.reason };
  if (job.job.state === "ended") return { word: "ENDED", why: job.job.text ?? "" };
  if (job.job.kind !== "run")
    return { word: KINDS[job.job.kind]?.toUpperCase() ?? "BUSY", why: "under way" };
  return { word: PHASES[job.state.state] ?? "UNKNOWN", why: runName(job) };
}

/** 'run 3 of 14 · long, 10 mm'. */
export function runName(job) {
  const run = job.planned(job.now_run);
  if (!run) return "";
  const which = run.repeats == null ? `${run.run + 1}` : `${run.repeats + 1} again,`;
  return `${which} of ${job.plan.runs.length} \u00B7 ${placeOf(run)}`;
}

const PURPOSES = { no_touch_zero: "zero", free_shape: "free shape", dead_weight: "dead weight" };

/** Where a run is taken: 'long, 10 mm', with what it is for when that is no measurement. */
export function placeOf(run) {
  const where = run.position_mm == null ? "free" : `${run.position_mm} mm`.replace("-", "\u2212");
  const again = run.mounting ? `, set anew ${run.mounting}` : "";
  const named = run.extra ? run.extra.replaceAll("_", " ") : PURPOSES[run.purpose];
  const purpose = named ? `, ${named}` : "";
  const repeat = run.repeats == null ? "" : `, run ${run.repeats + 1} again`;
  return `${run.configuration}, ${where}${again}${purpose}${repeat}`;
}

/** Session time for the log's left column. */
export function timeOf(time_s) {
  return time_s == null ? "" : clock(time_s);
}

const NUMBER = /(?<![\w.])[-+]?\d+(?:\.\d+)?/g;

/** Reasons, each once; those that differ in their numbers alone are one, with their range. */
export function inShort(reasons) {
  const alike = new Map();
  for (const reason of reasons.flatMap((one) => one.split("; "))) {
    const words = reason.replace(NUMBER, "\0");
    alike.set(words, [...(alike.get(words) ?? []), reason.match(NUMBER) ?? []]);
  }
  return [...alike]
    .map(([words, numbers]) => {
      let at = 0;
      return words.replaceAll("\0", () => {
        const values = numbers.map((one) => one[at]).sort((a, b) => a - b);
        at += 1;
        const [low, high] = [values[0], values.at(-1)];
        return low === high ? low : `${low} to ${high}`;
      });
    })
    .join("; ");
}
