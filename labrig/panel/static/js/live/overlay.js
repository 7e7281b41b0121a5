// Lines over the image: the measured curve, the model's prediction, the scale bar.
//
// An image is grey, so colours and rims do not depend on the theme. The measured curve is thin and
// whole; the prediction lies over it in wide dashes, so that either can be seen where they coincide.

const MEASURED = "#ffd400";
const PREDICTED = "#ff5cf0";
const RIM = "rgba(0, 0, 0, 0.85)";
const REFERENCE_PX = 720; // width of a canvas on which a line is as wide as it is stated here
const [MEASURED_PX, PREDICTED_PX, RIM_PX] = [1.8, 4.2, 1.6];
const DASH_PX = [11, 9];

/** Widths grow with the canvas, within what an eye can take. */
function widthOf(canvasWidth, ratio) {
  return ratio * Math.min(2, Math.max(0.75, canvasWidth / ratio / REFERENCE_PX));
}

function line(context, points, colour, width, rim, dash) {
  context.lineJoin = "round";
  context.lineCap = dash.length ? "butt" : "round";
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.setLineDash(dash);
  for (const [stroke, extra] of [
    [RIM, 2 * rim],
    [colour, 0],
  ]) {
    context.strokeStyle = stroke;
    context.lineWidth = width + extra;
    context.stroke();
  }
  context.setLineDash([]);
}

/** The neutral curve as found in the image. */
export function drawCurve(context, points, canvasWidth, ratio) {
  const unit = widthOf(canvasWidth, ratio);
  line(context, points, MEASURED, MEASURED_PX * unit, RIM_PX * unit, []);
}

/** The curve that the model predicts: over everything else. */
export function drawPrediction(context, points, canvasWidth, ratio) {
  const unit = widthOf(canvasWidth, ratio);
  const dash = DASH_PX.map((px) => px * unit);
  line(context, points, PREDICTED, PREDICTED_PX * unit, RIM_PX * unit, dash);
}

/** A bar of 10 mm in the lower right corner. */
export function drawScaleBar(context, canvas, length, ratio) {
  const [x, y] = [canvas.width - length - 14 * ratio, canvas.height - 16 * ratio];
  context.font = `600 ${13 * ratio}px sans-serif`;
  context.textAlign = "center";
  for (const [colour, width] of [
    ["rgba(0,0,0,0.8)", 5],
    ["#ffffff", 2.5],
  ]) {
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = width * ratio;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + length, y);
    context.stroke();
    if (width === 5) context.strokeText("10 mm", x + length / 2, y - 8 * ratio);
    else context.fillText("10 mm", x + length / 2, y - 8 * ratio);
  }
}
