// Draw series on the canvas of a chart: band, line, bars, points.

const SHAPES = {
  dot: (c, x, y, r) => c.arc(x, y, r, 0, 2 * Math.PI),
  square: (c, x, y, r) => c.rect(x - 0.9 * r, y - 0.9 * r, 1.8 * r, 1.8 * r),
  up: (c, x, y, r) => triangle(c, x, y, r, 1),
  down: (c, x, y, r) => triangle(c, x, y, r, -1),
};

function triangle(c, x, y, r, sign) {
  c.moveTo(x, y - 1.2 * sign * r);
  c.lineTo(x + 1.1 * r, y + 0.9 * sign * r);
  c.lineTo(x - 1.1 * r, y + 0.9 * sign * r);
  c.closePath();
}

/** The shape that tells the sign of a voltage without colour. */
export function shapeFor(volts) {
  return volts > 0 ? "up" : volts < 0 ? "down" : "dot";
}

/** Points to be joined, in pieces without unknown numbers. */
function pieces(points) {
  const found = [[]];
  for (const point of points)
    if (point[0] == null || point[1] == null) found.push([]);
    else found.at(-1).push(point);
  return found.filter((one) => one.length);
}

/** `to`: { x, y }, from values to pixels; `colour`: of this series; `ratio`: pixels per CSS pixel. */
export function drawSeries(c, series, { to, colour, back, ratio }) {
  c.save();
  c.globalAlpha = series.faint ? 0.55 : 1;
  c.strokeStyle = c.fillStyle = colour;
  c.lineJoin = "round";
  if (series.band) drawBand(c, series, to);
  if (series.line) drawLine(c, series, to, ratio);
  if (series.shape) drawPoints(c, series, { to, back, colour, ratio });
  c.restore();
}

function drawLine(c, { points, width = 1.5, dashed = false }, to, ratio) {
  c.lineWidth = width * ratio;
  c.setLineDash(dashed ? [7 * ratio, 4.5 * ratio] : []);
  c.beginPath();
  for (const piece of pieces(points))
    piece.forEach(([x, y], at) => (at ? c.lineTo(to.x(x), to.y(y)) : c.moveTo(to.x(x), to.y(y))));
  c.stroke();
  c.setLineDash([]);
}

/** `band`: half widths, along y, or along the line's normal where `normal` says so. */
function drawBand(c, { points, band, normal = false }, to) {
  const whole = points.map((point, at) => [...point.slice(0, 2), band[at] ?? 0, at]);
  c.save();
  c.globalAlpha *= 0.22;
  for (const piece of pieces(whole)) {
    const across = piece.map((_, at) => (normal ? normalAt(piece, at) : [0, 1]));
    c.beginPath();
    piece.forEach(([x, y, half], at) =>
      c.lineTo(to.x(x + half * across[at][0]), to.y(y + half * across[at][1])),
    );
    for (let at = piece.length - 1; at >= 0; at -= 1) {
      const [x, y, half] = piece[at];
      c.lineTo(to.x(x - half * across[at][0]), to.y(y - half * across[at][1]));
    }
    c.closePath();
    c.fill();
  }
  c.restore();
}

function normalAt(points, at) {
  const [before, after] = [points[Math.max(0, at - 1)], points[Math.min(points.length - 1, at + 1)]];
  const [dx, dy] = [after[0] - before[0], after[1] - before[1]];
  const size = Math.hypot(dx, dy) || 1;
  return [-dy / size, dx / size];
}

function drawPoints(c, { points, shape, hollow = false, size = 4 }, { to, back, colour, ratio }) {
  for (const [x, y, error] of points) {
    if (x == null || y == null) continue;
    const [px, py] = [to.x(x), to.y(y)];
    if (error) drawBar(c, px, to, [y - error, y + error], ratio);
    c.beginPath();
    SHAPES[shape](c, px, py, size * ratio);
    c.lineWidth = 1.5 * ratio;
    c.fillStyle = hollow ? back : colour;
    c.fill();
    c.stroke();
  }
}

function drawBar(c, px, to, [low, high], ratio) {
  const cap = 3 * ratio;
  c.lineWidth = 1.5 * ratio;
  c.beginPath();
  c.moveTo(px, to.y(low));
  c.lineTo(px, to.y(high));
  for (const end of [low, high]) {
    c.moveTo(px - cap, to.y(end));
    c.lineTo(px + cap, to.y(end));
  }
  c.stroke();
}
