// Small plots of points and lines, as SVG: for residuals and comparisons.

import { svg } from "./dom.js";
import { plain } from "./format.js";

const [LEFT, RIGHT, TOP, BOTTOM] = [58, 12, 12, 40];

/** Round steps that divide a range into about `count`. */
export function ticksOf(low, high, count = 5) {
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((n) => n * power).find((one) => one >= raw);
  const found = [];
  for (let at = Math.ceil(low / step) * step; at <= high + 1e-9 * step; at += step)
    found.push(Number(at.toPrecision(12)));
  return found;
}

function spread(values, least) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const middle = 0.5 * (low + high);
  const half = Math.max(0.58 * (high - low), 0.5 * least);
  return [middle - half, middle + half];
}

/**
 * `series`: [{ name, points: [[x, y, sigma?]], shape: "dot"|"ring"|"up"|"down", className, line }].
 * `zero`: a line at y = 0.
 */
export function plot({
  series,
  x,
  y,
  width = 520,
  height = 240,
  zero = false,
  leastX = 1e-9,
  leastY = 1e-9,
  label,
}) {
  const points = series.flatMap((one) => one.points).filter(([, value]) => value != null);
  const element = svg("svg", {
    class: "plot",
    viewBox: `0 0 ${width} ${height}`,
    role: "img",
    "aria-label": label,
  });
  if (!points.length) return element;
  const [x0, x1] = spread(
    points.map(([value]) => value),
    leastX,
  );
  const [y0, y1] = spread(
    [
      ...points.flatMap(([, value, sigma = 0]) => [value - (sigma ?? 0), value + (sigma ?? 0)]),
      ...(zero ? [0] : []),
    ],
    leastY,
  );
  const toX = (value) => LEFT + ((value - x0) / (x1 - x0)) * (width - LEFT - RIGHT);
  const toY = (value) => height - BOTTOM - ((value - y0) / (y1 - y0)) * (height - TOP - BOTTOM);
  for (const tick of ticksOf(x0, x1)) {
    element.append(
      svg("path", { class: "plot-grid", d: `M${toX(tick)} ${TOP}V${height - BOTTOM}` }),
      svg("text", { x: toX(tick), y: height - BOTTOM + 16, "text-anchor": "middle" }, plain(tick)),
    );
  }
  for (const tick of ticksOf(y0, y1)) {
    element.append(
      svg("path", { class: "plot-grid", d: `M${LEFT} ${toY(tick)}H${width - RIGHT}` }),
      svg("text", { x: LEFT - 6, y: toY(tick) + 4, "text-anchor": "end" }, plain(tick)),
    );
  }
  if (zero)
    element.append(svg("path", { class: "plot-zero", d: `M${LEFT} ${toY(0)}H${width - RIGHT}` }));
  element.append(
    svg(
      "text",
      { class: "plot-name", x: (LEFT + width - RIGHT) / 2, y: height - 6, "text-anchor": "middle" },
      x,
    ),
    svg(
      "text",
      {
        class: "plot-name",
        x: 0,
        y: 0,
        "text-anchor": "middle",
        transform: `translate(13 ${(TOP + height - BOTTOM) / 2}) rotate(-90)`,
      },
      y,
    ),
  );
  for (const one of series) element.append(drawn(one, toX, toY));
  return element;
}

function drawn({ points, shape = "dot", className = "", line = false, name = "" }, toX, toY) {
  const group = svg("g", { class: `plot-series ${className}` }, svg("title", {}, name));
  const known = points.filter(([, value]) => value != null);
  if (line)
    group.append(
      svg("path", {
        class: "plot-line",
        d: `M${known.map(([a, b]) => `${toX(a)} ${toY(b)}`).join("L")}`,
      }),
    );
  for (const [a, b, sigma] of known) {
    const [px, py] = [toX(a), toY(b)];
    if (sigma)
      group.append(
        svg("path", { class: "plot-bar", d: `M${px} ${toY(b - sigma)}V${toY(b + sigma)}` }),
      );
    group.append(svg("path", { class: `plot-point plot-${shape}`, d: SHAPES[shape](px, py) }));
  }
  return group;
}

const SHAPES = {
  dot: (x, y) => `M${x - 4} ${y}A4 4 0 1 0 ${x + 4} ${y}A4 4 0 1 0 ${x - 4} ${y}Z`,
  ring: (x, y) => `M${x - 4} ${y}A4 4 0 1 0 ${x + 4} ${y}A4 4 0 1 0 ${x - 4} ${y}Z`,
  up: (x, y) => `M${x} ${y - 5}L${x + 5} ${y + 4}H${x - 5}Z`,
  down: (x, y) => `M${x} ${y + 5}L${x + 5} ${y - 4}H${x - 5}Z`,
  square: (x, y) => `M${x - 4} ${y - 4}h8v8h-8Z`,
};
