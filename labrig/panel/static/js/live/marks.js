// Marks of readings: the shape tells the sign, filled counts, hollow is discarded, crossed invalid.

import { svg } from "../dom.js";

/** On a canvas, around (x, y). */
export function drawMark(context, x, y, size, { volts, reading, colour, back, ratio }) {
  const path = new Path2D(pathOf(volts, x, y, size));
  const counts = reading.valid && reading.kind !== "discarded";
  context.fillStyle = counts ? colour : back;
  context.strokeStyle = counts ? back : colour;
  context.lineWidth = 1.25 * ratio;
  context.fill(path);
  context.stroke(path);
  if (!reading.valid) {
    context.beginPath();
    for (const sign of [1, -1]) {
      context.moveTo(x - 1.5 * size, y - 1.5 * sign * size);
      context.lineTo(x + 1.5 * size, y + 1.5 * sign * size);
    }
    context.strokeStyle = colour;
    context.lineWidth = 2 * ratio;
    context.stroke();
  }
}

/** As SVG; `state` is planned, taken, discarded or invalid. */
export function svgMark(volts, x, y, size, state) {
  const sign = volts > 0 ? "plus" : volts < 0 ? "minus" : "zero";
  const mark = svg("path", {
    d: pathOf(volts, x, y, size),
    class: `mark mark-${sign} mark-${state}`,
  });
  if (state !== "invalid") return mark;
  const cross = `M${x - 6} ${y - 6}L${x + 6} ${y + 6}M${x - 6} ${y + 6}L${x + 6} ${y - 6}`;
  return svg("g", {}, mark, svg("path", { d: cross, class: `mark-cross mark-${sign}` }));
}

/** Triangle up for a positive voltage, down for a negative, circle for none. */
function pathOf(volts, x, y, size) {
  if (!volts)
    return `M${x - size} ${y}A${size} ${size} 0 1 0 ${x + size} ${y}A${size} ${size} 0 1 0 ${x - size} ${y}Z`;
  const [wide, tall] = [1.1 * size, volts > 0 ? -1.15 * size : 1.15 * size];
  return `M${x} ${y + tall}L${x + wide} ${y - 0.75 * tall}L${x - wide} ${y - 0.75 * tall}Z`;
}
