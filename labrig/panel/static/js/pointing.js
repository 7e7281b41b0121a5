// Pointing at a pixel of a picture: by the pointer or the arrow keys, with a magnifier.

import { h, setText } from "./dom.js";
import { plain } from "./format.js";
import { Picture } from "./live/picture.js";

const LENS_PX = 18; // picture pixels to either side
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** A picture with a cross; `chosen(px)` is called with what was pointed at, raw pixels. */
export class Pointing {
  constructor(job, chosen) {
    this.chosen = chosen;
    this.cross = null;
    this.marks = []; // { px, name, shape: "cross"|"dot"|"ring", line: [px, ...] }
    this.picture = new Picture(job, (context, toScreen, ratio) =>
      this.draw(context, toScreen, ratio),
    );
    this.lens = h("canvas", {
      class: "lens",
      width: 180,
      height: 180,
      hidden: true,
      "aria-hidden": "true",
    });
    this.said = h(
      "p",
      { class: "pointing-said", role: "status" },
      "Click in the image, or move the cross with the arrow keys (Shift: 10) and press Enter.",
    );
    const { canvas } = this.picture;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", "picture: arrow keys move the cross, Enter chooses");
    canvas.classList.add("pointing");
    canvas.addEventListener("pointermove", (event) => this.to(this.picture.toPixel(event)));
    canvas.addEventListener("click", (event) => this.choose(this.picture.toPixel(event)));
    canvas.addEventListener("keydown", (event) => this.key(event));
    this.element = h("div", { class: "pointing-box" }, this.picture.element, this.lens, this.said);
    this.stop = job.watch((dirty) => {
      this.picture.update(dirty);
      this.magnify();
    });
    this.picture.update(new Set(["story", "picture"]));
  }

  destroy() {
    this.stop();
    this.picture.destroy();
  }

  key(event) {
    const way = ARROWS[event.key];
    const size = this.picture.bitmap;
    if (!size || (!way && event.key !== "Enter")) return;
    event.preventDefault();
    if (!way) {
      if (this.cross) this.choose(this.cross);
      return;
    }
    const step = event.shiftKey ? 10 : 1;
    const [u, v] = this.cross ?? [size.width / 2, size.height / 2];
    this.to([Math.round(u) + step * way[0], Math.round(v) + step * way[1]]);
  }

  to([u, v]) {
    const size = this.picture.bitmap;
    if (!size) return;
    this.cross = [
      Math.min(Math.max(u, 0), size.width - 1),
      Math.min(Math.max(v, 0), size.height - 1),
    ];
    this.picture.draw();
    this.magnify();
  }

  choose(px) {
    if (!this.picture.bitmap) return;
    this.to(px);
    this.chosen(this.cross.map((value) => Math.round(100 * value) / 100));
  }

  setText(text) {
    setText(this.said, text);
  }

  setMarks(marks) {
    this.marks = marks;
    this.picture.draw();
  }

  draw(context, toScreen, ratio) {
    for (const mark of this.marks) drawMark(context, toScreen, ratio, mark);
    if (!this.cross) return;
    const [x, y] = toScreen(this.cross);
    const { width, height } = context.canvas;
    for (const [colour, wide] of [
      ["rgba(0,0,0,0.6)", 3],
      ["#ffffff", 1],
    ]) {
      context.strokeStyle = colour;
      context.lineWidth = wide * ratio;
      context.beginPath();
      for (const [ax, ay, bx, by] of [
        [0, y, x - 9 * ratio, y],
        [x + 9 * ratio, y, width, y],
        [x, 0, x, y - 9 * ratio],
        [x, y + 9 * ratio, x, height],
      ]) {
        context.moveTo(ax, ay);
        context.lineTo(bx, by);
      }
      context.stroke();
    }
  }

  magnify() {
    const { bitmap } = this.picture;
    if (!bitmap || !this.cross) return;
    this.lens.hidden = false;
    const context = this.lens.getContext("2d");
    const [u, v] = this.cross;
    const side = 2 * LENS_PX + 1;
    context.imageSmoothingEnabled = false;
    context.fillStyle = "#000000";
    context.fillRect(0, 0, 180, 180);
    context.drawImage(bitmap, u + 0.5 - side / 2, v + 0.5 - side / 2, side, side, 0, 0, 180, 180);
    context.strokeStyle = "#ffd400";
    context.beginPath();
    context.moveTo(90, 0);
    context.lineTo(90, 180);
    context.moveTo(0, 90);
    context.lineTo(180, 90);
    context.stroke();
  }
}

function drawMark(context, toScreen, ratio, { px, name, shape = "cross", line }) {
  const [x, y] = toScreen(px);
  context.font = `600 ${13 * ratio}px sans-serif`;
  context.textAlign = "left";
  for (const [colour, wide] of [
    ["rgba(0,0,0,0.8)", 4],
    ["#7dff9b", 2],
  ]) {
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = wide * ratio;
    context.beginPath();
    if (line) {
      context.moveTo(x, y);
      line.forEach((end) => context.lineTo(...toScreen(end)));
    } else if (shape === "cross") {
      for (const sign of [1, -1]) {
        context.moveTo(x - 8 * ratio, y - 8 * sign * ratio);
        context.lineTo(x + 8 * ratio, y + 8 * sign * ratio);
      }
    } else {
      context.arc(x, y, (shape === "dot" ? 2.5 : 9) * ratio, 0, 2 * Math.PI);
    }
    context.stroke();
    if (!name) continue;
    if (wide === 4) context.strokeText(name, x + 12 * ratio, y - 8 * ratio);
    else context.fillText(name, x + 12 * ratio, y - 8 * ratio);
  }
}

/** 'u 123.4, v 56.7'. */
export function pixelWords([u, v]) {
  return `u ${plain(Math.round(100 * u) / 100)}, v ${plain(Math.round(100 * v) / 100)}`;
}
