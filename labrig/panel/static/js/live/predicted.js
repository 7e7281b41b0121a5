// What the dynamic model predicts of a signal, as a line over the measured trace.

const WIDTH = 2;
const MOST_POINTS = 2000; // of a line: more than a screen has columns

/** Columns of the prediction of a channel: [times, values]; null where there is none of this run. */
function columnsOf({ predicted, signals }, key) {
  if (!predicted.count || predicted.run !== signals.run) return null;
  const values = predicted.column(`${key}_least`);
  return values.length ? [predicted.column("run_s"), values] : null;
}

/** Index of the first time that is not below `wanted`. */
function firstFrom(times, wanted) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < wanted) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** A range that holds the prediction as well. */
export function extremes(job, key, [low, high]) {
  const known = columnsOf(job, key);
  if (!known) return [low, high];
  for (const value of known[1]) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}

/** The prediction at a time; null where there is none. */
export function predictedAt(job, key, at_s) {
  const known = columnsOf(job, key);
  if (!known) return null;
  const [times, values] = known;
  const at = firstFrom(times, at_s - 0.001);
  return at < times.length && Math.abs(times[at] - at_s) < 0.02 ? values[at] : null;
}

/** Draw the line within the times that a uPlot shows. */
export function drawPredicted(plot, job, key, colour, ratio) {
  const known = columnsOf(job, key);
  const { ctx, bbox, scales } = plot;
  const [x, y] = [scales.x, scales.y];
  if (!known || x.min == null || y.min == null) return;
  const [times, values] = known;
  const [from, to] = [Math.max(0, firstFrom(times, x.min) - 1), firstFrom(times, x.max) + 1];
  const step = Math.max(1, Math.ceil((to - from) / MOST_POINTS));
  const [wide, high] = [bbox.width / (x.max - x.min), bbox.height / (y.max - y.min)];
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.beginPath();
  for (let i = from; i < Math.min(to, times.length); i += step)
    ctx.lineTo(bbox.left + (times[i] - x.min) * wide, bbox.top + (y.max - values[i]) * high);
  ctx.strokeStyle = colour;
  ctx.lineWidth = WIDTH * ratio;
  ctx.lineJoin = "round";
  ctx.stroke();
  ctx.restore();
}
