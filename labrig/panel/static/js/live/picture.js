// The newest picture on a canvas, the extracted neutral curve and the model's over it.

import { h, setText } from "../dom.js";

const MEASURED = "#ffd400"; // on grey pictures both are bright, with a dark rim: the theme is no matter
const MODEL = "#7fe0ff";
const OLD_FRAMES = 25; // a curve further behind its picture than this is not drawn any more

/** Draws a job's pictures. `extra(context, toScreen)` may draw more over them. */
export class Picture {
  constructor(job, extra = null) {
    this.job = job;
    this.extra = extra;
    this.shown = 0; // pictures that have reached the screen
    this.canvas = h("canvas", {
      class: "picture-canvas",
      role: "img",
      "aria-label": "live picture of the sheet",
    });
    this.caption = h("span", { class: "picture-said" });
    this.element = h(
      "figure",
      { class: "picture card" },
      this.canvas,
      h(
        "figcaption",
        {},
        h("span", { class: "key key-measured" }, "neutral curve, measured"),
        h("span", { class: "key key-model" }, "model\u2019s prediction"),
        this.caption,
      ),
    );
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.seen = new ResizeObserver(() => this.draw());
    this.seen.observe(this.canvas);
  }

  destroy() {
    this.seen.disconnect();
  }

  update(dirty) {
    if (dirty.has("story") && !this.job.picture) this.clear();
    if (dirty.has("picture") && this.job.picture) this.decode(this.job.picture);
    else if (dirty.has("curve") || dirty.has("plan") || dirty.has("story")) this.draw();
  }

  clear() {
    this.bitmap?.close();
    this.bitmap = null;
    this.draw();
  }

  /** Decode the newest; what comes meanwhile waits in one place. */
  async decode(picture) {
    if (this.decoding) {
      this.waiting = picture;
      return;
    }
    this.decoding = true;
    try {
      const bitmap = await createImageBitmap(new Blob([picture.bytes], { type: picture.mime }));
      this.bitmap?.close();
      this.bitmap = bitmap;
      this.header = picture;
      this.draw();
      this.shown += 1;
      this.onshown?.(picture);
    } catch {
      setText(this.caption, `picture ${picture.frame} cannot be read`);
    }
    this.decoding = false;
    const next = this.waiting;
    this.waiting = null;
    if (next) this.decode(next);
  }

  /** Size the canvas to its place, and draw all. */
  draw() {
    const { canvas, context, bitmap } = this;
    const size = bitmap ?? this.job.plan?.picture ?? { width: 640, height: 480 };
    const ratio = window.devicePixelRatio || 1;
    canvas.style.aspectRatio = `${size.width} / ${size.height}`;
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round((width * size.height) / size.width));
    if (canvas.width !== width || canvas.height !== height)
      [canvas.width, canvas.height] = [width, height];
    context.setTransform(1, 0, 0, 1, 0, 0);
    if (!bitmap) {
      context.fillStyle = "#20252b";
      context.fillRect(0, 0, width, height);
      context.fillStyle = "#c8d0d8";
      context.font = `${18 * ratio}px sans-serif`;
      context.textAlign = "center";
      context.fillText("no picture", width / 2, height / 2);
      return;
    }
    context.drawImage(bitmap, 0, 0, width, height);
    this.scale = width / bitmap.width;
    this.drawCurves(ratio);
    this.extra?.(context, (px) => this.toScreen(px), ratio);
  }

  /** Pixel centres are whole numbers, canvas edges are: half a pixel between the two. */
  toScreen([u, v]) {
    return [(u + 0.5) * this.scale, (v + 0.5) * this.scale];
  }

  /** The picture's pixel under a pointer. */
  toPixel(event) {
    const box = this.canvas.getBoundingClientRect();
    const size = this.bitmap ?? { width: 1, height: 1 };
    const u = ((event.clientX - box.left) / box.width) * size.width - 0.5;
    const v = ((event.clientY - box.top) / box.height) * size.height - 0.5;
    return [u, v];
  }

  drawCurves(ratio) {
    const { job } = this;
    this.drawScale(ratio);
    const curve = job.curve;
    const behind = curve && this.header ? this.header.frame - curve.frame : null;
    if (!curve || behind > OLD_FRAMES || behind < -OLD_FRAMES) {
      setText(this.caption, this.header ? `frame ${this.header.frame}` : "");
      return;
    }
    const width = 2.5 * ratio;
    if (curve.model?.points_px?.length)
      this.line(curve.model.points_px, MODEL, width, [9 * ratio, 7 * ratio]);
    if (curve.points_px?.length) this.line(curve.points_px, MEASURED, width, []);
    const late = behind > 0 ? `, its curve ${behind} frames behind` : "";
    const why = curve.ok ? "" : ` \u2014 no curve: ${curve.why}`;
    setText(this.caption, `frame ${this.header.frame}${late}${why}`);
  }

  line(points, colour, width, dash) {
    const { context } = this;
    context.lineJoin = context.lineCap = "round";
    context.beginPath();
    for (const point of points) context.lineTo(...this.toScreen(point));
    for (const [stroke, extra] of [
      ["rgba(0,0,0,0.75)", 2 * (window.devicePixelRatio || 1)],
      [colour, 0],
    ]) {
      context.setLineDash(dash);
      context.strokeStyle = stroke;
      context.lineWidth = width + extra;
      context.stroke();
    }
    context.setLineDash([]);
  }

  /** A bar of 10 mm, and a cross at the clamp. */
  drawScale(ratio) {
    const setting = this.job.plan?.picture;
    if (!setting?.px_per_mm) return;
    const { context, canvas } = this;
    const long = 10 * setting.px_per_mm * this.scale;
    const [x, y] = [canvas.width - long - 14 * ratio, canvas.height - 16 * ratio];
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
      context.lineTo(x + long, y);
      context.stroke();
      if (width === 5) context.strokeText("10 mm", x + long / 2, y - 8 * ratio);
      else context.fillText("10 mm", x + long / 2, y - 8 * ratio);
    }
  }
}
