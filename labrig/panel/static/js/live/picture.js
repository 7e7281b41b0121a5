// The newest image on a canvas, the extracted neutral curve and the model's over it.

import { h, setText } from "../dom.js";
import { forgetFrame, nextFrame } from "../frames.js";
import { ImageRate } from "./image_rate.js";
import { drawCurve, drawPrediction, drawScaleBar } from "./overlay.js";
import { errorText } from "./prediction_error.js";

const OLD_FRAMES = 25; // a curve further behind its image than this is not drawn any more
const SAID_MS = 250; // numbers that change faster cannot be read

/** Draws a job's images. `extra(context, toScreen)` may draw more over them. */
export class Picture {
  constructor(job, extra = null) {
    this.job = job;
    this.extra = extra;
    this.shown = 0; // images that have reached the screen
    this.rate = new ImageRate();
    this.canvas = h("canvas", {
      class: "picture-canvas",
      role: "img",
      "aria-label": "live image of the sheet",
    });
    this.age = h("span", { class: "picture-age" });
    this.caption = h("span", { class: "picture-said" });
    this.error = h("span", { class: "picture-error" });
    this.element = h(
      "figure",
      { class: "picture card" },
      this.canvas,
      h(
        "figcaption",
        {},
        h("span", { class: "key key-measured" }, "neutral curve, measured"),
        h("span", { class: "key key-model" }, "model\u2019s prediction"),
        this.error,
        h("span", { class: "picture-state" }, this.caption, this.age),
      ),
    );
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.seen = new ResizeObserver(() => this.resize());
    this.seen.observe(this.canvas);
    this.came = (picture) => this.decode(picture);
    job.onPicture.add(this.came);
    this.timer = setInterval(() => this.showAge(), SAID_MS);
  }

  destroy() {
    this.seen.disconnect();
    this.job.onPicture.delete(this.came);
    clearInterval(this.timer);
    forgetFrame(this.show);
  }

  update(dirty) {
    if (dirty.has("story")) {
      this.rate.forget();
      if (!this.job.picture) this.clear();
      else if (this.job.picture !== this.header) this.decode(this.job.picture);
    }
    if (dirty.has("curve") || dirty.has("motion") || dirty.has("plan") || dirty.has("story")) this.drawSoon();
  }

  clear() {
    this.bitmap?.close();
    this.bitmap = this.header = null;
    this.drawSoon();
  }

  /** Decode an image; what comes meanwhile waits in one place. */
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
      nextFrame(this.show, { isUrgent: true });
    } catch {
      setText(this.caption, `image ${picture.frame} cannot be read`);
      this.job.seen(picture);
    }
    this.decoding = false;
    const next = this.waiting;
    this.waiting = null;
    if (next) this.decode(next);
  }

  /** With the next tick; a hidden page has none, and so gets no further image. */
  drawSoon() {
    nextFrame(this.show);
  }

  /** Draw; acknowledge an image that has not been drawn before. */
  show = () => {
    this.draw();
    if (!this.header || this.header === this.drawn) return;
    this.drawn = this.header;
    this.shown += 1;
    this.rate.add(performance.now());
    this.onshown?.(this.header);
    this.job.seen(this.header);
  };

  /** Keep the size of the canvas: to ask for it at each image costs a layout of the page. */
  resize() {
    this.width = this.canvas.clientWidth;
    this.drawSoon();
  }

  /** Size the canvas to its place, and draw all. */
  draw() {
    const { canvas, context, bitmap } = this;
    const size = bitmap ?? this.job.plan?.picture ?? { width: 640, height: 480 };
    const ratio = window.devicePixelRatio || 1;
    const shape = `${size.width} / ${size.height}`;
    if (this.shape !== shape) canvas.style.aspectRatio = this.shape = shape;
    const width = Math.max(1, Math.round((this.width ?? canvas.clientWidth) * ratio));
    const height = Math.max(1, Math.round((width * size.height) / size.width));
    if (canvas.width !== width || canvas.height !== height)
      [canvas.width, canvas.height] = [width, height];
    context.setTransform(1, 0, 0, 1, 0, 0);
    if (!bitmap) {
      this.drawNothing(ratio);
      return;
    }
    context.drawImage(bitmap, 0, 0, width, height);
    this.scale = width / bitmap.width;
    this.drawCurves(ratio);
    this.extra?.(context, (px) => this.toScreen(px), ratio);
  }

  drawNothing(ratio) {
    const { context, canvas } = this;
    context.fillStyle = "#20252b";
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.fillStyle = "#c8d0d8";
    context.font = `${18 * ratio}px sans-serif`;
    context.textAlign = "center";
    context.fillText("no image", canvas.width / 2, canvas.height / 2);
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
    const { job, context, canvas } = this;
    const setting = job.plan?.picture;
    if (setting?.px_per_mm) drawScaleBar(context, canvas, 10 * setting.px_per_mm * this.scale, ratio);
    const curve = this.curve();
    if (!curve) {
      setText(this.error, "");
      setText(this.caption, this.header ? `frame ${this.header.frame}` : "");
      return;
    }
    const toScreen = (points) => points.map((point) => this.toScreen(point));
    if (curve.points_px?.length) drawCurve(context, toScreen(curve.points_px), canvas.width, ratio);
    const model = this.predicted() ?? curve.model;
    if (model?.points_px?.length)
      drawPrediction(context, toScreen(model.points_px), canvas.width, ratio);
    const behind = this.header.frame - curve.frame;
    const late = behind > 0 ? `, its curve ${behind} frames behind` : "";
    const why = curve.ok ? "" : ` \u2014 no curve: ${curve.why}`;
    setText(this.caption, `frame ${this.header.frame}${late}${why}`);
    setText(this.error, errorText(model));
  }

  /** The newest curve, unless it belongs to quite another image. */
  curve() {
    const { curve } = this.job;
    const behind = curve && this.header ? this.header.frame - curve.frame : null;
    return behind === null || Math.abs(behind) > OLD_FRAMES ? null : curve;
  }

  /** The shape of the dynamic model, where there is one of about this image. */
  predicted() {
    const shape = this.job.motion?.shape;
    const behind = shape && this.header ? this.header.frame - shape.frame : null;
    return behind === null || Math.abs(behind) > OLD_FRAMES ? null : shape;
  }

  /** How old the image is, and at what rate images come. */
  showAge() {
    if (!this.header) return setText(this.age, "");
    const { text, stale } = this.rate.said(performance.now(), this.job.ageOf(this.header));
    setText(this.age, text);
    this.age.dataset.stale = stale;
  }
}
