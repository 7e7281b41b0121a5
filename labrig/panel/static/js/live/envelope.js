// A signal as least and most of each 10 ms, drawn in upright bars of whole pixels.
//
// Bars cost a tenth of what two stroked lines and the area between them do without a graphics card,
// and no spike is lost: a column of the screen shows all that fell into it.

const THIN_PX = 1.5; // of a signal that stands still

/** Index of the first value that is not below `wanted`; `times` rises. */
function firstFrom(times, wanted) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < wanted) low = middle + 1;
    else high = middle;
  }
  return low;
}

/**
 * Columns of pixels from left to right: calls `add(left, right, top, bottom)` for each. `toX` and
 * `toY` give pixels; neighbours touch, so that a step is a line.
 */
export function columns([times, least, most], [from, to], toX, toY, add) {
  const begin = Math.max(0, firstFrom(times, from) - 1);
  const end = Math.min(times.length, firstFrom(times, to) + 1);
  let [left, top, bottom] = [null, 0, 0];
  for (let i = begin; i < end; i += 1) {
    const x = Math.round(toX(times[i]));
    let [high, low] = [toY(most[i]), toY(least[i])];
    if (left === null) [left, top, bottom] = [x, high, low];
    if (x === left) {
      [top, bottom] = [Math.min(top, high), Math.max(bottom, low)];
      continue;
    }
    add(left, x, top, bottom);
    if (low < top) low = top;
    if (high > bottom) high = bottom;
    [left, top, bottom] = [x, high, low];
  }
  if (left !== null) add(left, left + 1, top, bottom);
}

/** Draw the series 1 (least) and 2 (most) of a uPlot over its time axis. */
export function drawEnvelope(plot, colour, ratio) {
  const { ctx, bbox, scales, data } = plot;
  const [x, y] = [scales.x, scales.y];
  if (x.min == null || y.min == null || !data[0].length) return;
  const [wide, high] = [bbox.width / (x.max - x.min), bbox.height / (y.max - y.min)];
  const toX = (time) => bbox.left + (time - x.min) * wide;
  const toY = (value) => bbox.top + (y.max - value) * high;
  const [right, foot] = [bbox.left + bbox.width, bbox.top + bbox.height];
  const thin = Math.max(1, Math.round(THIN_PX * ratio));
  let bar = null; // the one that is still growing: equal neighbours are one
  const draw = () => bar && ctx.fillRect(bar[0], bar[2], bar[1] - bar[0], bar[3] - bar[2]);
  ctx.fillStyle = colour;
  columns(data, [x.min, x.max], toX, toY, (from, to, top, bottom) => {
    const [l, r] = [Math.max(from, bbox.left), Math.min(to, right)];
    if (!(r > l) || !(bottom >= top)) return;
    const spare = Math.max(0, thin - (bottom - top)) / 2;
    const t = Math.max(bbox.top, Math.round(top - spare));
    const b = Math.min(foot, Math.max(t + thin, Math.round(bottom + spare)));
    if (bar && bar[1] === l && bar[2] === t && bar[3] === b) {
      bar[1] = r;
      return;
    }
    draw();
    bar = [l, r, t, b];
  });
  draw();
}
