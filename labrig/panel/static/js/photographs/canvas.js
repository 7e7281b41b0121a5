// The photograph that is clicked on: zoom with the wheel, move by dragging, point with mouse or keys.

const DRAG_PX = 4;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const COLOURS = { seen: "#ff3b30", bridged: "#ffd400", mark: "#39ff88", mask: "rgba(80,160,255,0.35)" };

export class PhotographCanvas {
  /** `chosen(px)`: a raw pixel [u, v] was clicked. */
  constructor(canvas, chosen) {
    Object.assign(this, { canvas, chosen, bitmap: null, size: null, view: null, cross: null, drag: null });
    this.shown = { curves: [], strips: {}, pictures: {}, facts: [], ruler: [], open: [] };
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", "photograph: arrow keys move the cross, Enter chooses, plus and minus zoom");
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.release(event));
    canvas.addEventListener("keydown", (event) => this.key(event));
    this.resized = new ResizeObserver(() => this.fit());
    this.resized.observe(canvas);
  }

  destroy() {
    this.resized.disconnect();
    this.bitmap?.close();
  }

  /** Show a bitmap of a photograph of `size` raw pixels; the same size keeps the view. */
  setPicture(bitmap, size) {
    const same = this.size && size && this.size[0] === size[0] && this.size[1] === size[1];
    this.bitmap?.close();
    Object.assign(this, { bitmap, size });
    if (!same) this.view = null;
    this.fit();
  }

  show(shown) {
    this.shown = shown;
    this.draw();
  }

  fit() {
    const box = this.canvas.getBoundingClientRect();
    const ratio = devicePixelRatio || 1;
    this.canvas.width = Math.max(1, Math.round(box.width * ratio));
    this.canvas.height = Math.max(1, Math.round(box.height * ratio));
    this.draw();
  }

  /** Scale and offset from raw pixels to the canvas's own. */
  get map() {
    const { width, height } = this.canvas;
    const [columns, rows] = this.size ?? [1, 1];
    const whole = Math.min(width / columns, height / rows);
    const view = this.view ?? { zoom: 1, u: columns / 2, v: rows / 2 };
    const scale = whole * view.zoom;
    return { scale, x: width / 2 - view.u * scale, y: height / 2 - view.v * scale };
  }

  toScreen([u, v]) {
    const { scale, x, y } = this.map;
    return [x + (u + 0.5) * scale, y + (v + 0.5) * scale];
  }

  toPixel(event) {
    const box = this.canvas.getBoundingClientRect();
    const ratio = this.canvas.width / box.width;
    const { scale, x, y } = this.map;
    return [
      ((event.clientX - box.left) * ratio - x) / scale - 0.5,
      ((event.clientY - box.top) * ratio - y) / scale - 0.5,
    ];
  }

  wheel(event) {
    if (!this.size) return;
    event.preventDefault();
    this.zoomAt(this.toPixel(event), event.deltaY < 0 ? 1.25 : 0.8);
  }

  /** Zoom so that a pixel stays where it is. */
  zoomAt([u, v], by) {
    const view = this.view ?? { zoom: 1, u: this.size[0] / 2, v: this.size[1] / 2 };
    const zoom = Math.min(40, Math.max(1, view.zoom * by));
    const share = view.zoom / zoom;
    this.view = zoom === 1 ? null : { zoom, u: u + (view.u - u) * share, v: v + (view.v - v) * share };
    this.draw();
  }

  press(event) {
    if (!this.size || event.button !== 0) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.drag = { x: event.clientX, y: event.clientY, moved: false };
  }

  move(event) {
    if (!this.size) return;
    if (!this.drag) {
      this.cross = this.inside(this.toPixel(event));
      return this.draw();
    }
    const [dx, dy] = [event.clientX - this.drag.x, event.clientY - this.drag.y];
    if (!this.drag.moved && Math.hypot(dx, dy) < DRAG_PX) return;
    const ratio = this.canvas.width / this.canvas.getBoundingClientRect().width;
    const view = this.view ?? { zoom: 1, u: this.size[0] / 2, v: this.size[1] / 2 };
    const { scale } = this.map;
    this.view = { ...view, u: view.u - (dx * ratio) / scale, v: view.v - (dy * ratio) / scale };
    this.drag = { x: event.clientX, y: event.clientY, moved: true };
    this.draw();
  }

  release(event) {
    const drag = this.drag;
    this.drag = null;
    if (drag && !drag.moved && this.size) this.choose(this.toPixel(event));
  }

  key(event) {
    if (!this.size) return;
    const middle = this.cross ?? [this.size[0] / 2, this.size[1] / 2];
    if (event.key === "+" || event.key === "-") this.zoomAt(middle, event.key === "+" ? 1.25 : 0.8);
    else if (ARROWS[event.key]) {
      const step = event.shiftKey ? 10 : 1;
      const [du, dv] = ARROWS[event.key];
      this.cross = this.inside([Math.round(middle[0]) + step * du, Math.round(middle[1]) + step * dv]);
      this.draw();
    } else if (event.key === "Enter") this.choose(middle);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  choose(px) {
    const [u, v] = this.inside(px);
    this.chosen([Math.round(10 * u) / 10, Math.round(10 * v) / 10]);
  }

  inside([u, v]) {
    return [
      Math.min(Math.max(u, 0), this.size[0] - 1),
      Math.min(Math.max(v, 0), this.size[1] - 1),
    ];
  }

  draw() {
    const context = this.canvas.getContext("2d");
    const { width, height } = this.canvas;
    context.fillStyle = "#101418";
    context.fillRect(0, 0, width, height);
    if (!this.bitmap || !this.size) return;
    const { scale, x, y } = this.map;
    context.imageSmoothingEnabled = scale < 2;
    context.drawImage(this.bitmap, x, y, this.size[0] * scale, this.size[1] * scale);
    const ratio = devicePixelRatio || 1;
    const { curves, strips, pictures, facts, ruler, open } = this.shown;
    const areas = facts.filter(({ shape }) => shape === "polygons");
    for (const { key, of } of areas)
      for (const holder of of === "strip" ? Object.values(strips) : [pictures])
        for (const polygon of holder[key] ?? []) this.polygon(context, polygon, true);
    if (open.length) this.polygon(context, open, false);
    for (const curve of curves) {
      if (curve.ok) this.curve(context, curve, ratio);
      else if (curve.refused_at_px) this.ring(context, curve.refused_at_px, ratio);
    }
    if (ruler.length) this.line(context, ruler, ratio, COLOURS.mark);
    for (const [name, place] of Object.entries(strips)) {
      if (place.clamp_px) this.clamp(context, name, place.clamp_px, place.along_px, ratio);
      this.places(context, facts.filter(({ of }) => of === "strip"), place, ratio);
    }
    this.places(context, facts.filter(({ of }) => of === "picture"), pictures, ratio);
    if (this.cross) this.crosshair(context, ratio);
  }

  polygon(context, corners, closed) {
    context.beginPath();
    corners.forEach((corner, at) => context[at ? "lineTo" : "moveTo"](...this.toScreen(corner)));
    if (closed) context.closePath();
    context.fillStyle = COLOURS.mask;
    if (closed) context.fill();
    context.strokeStyle = "#50a0ff";
    context.lineWidth = 2 * (devicePixelRatio || 1);
    context.stroke();
  }

  curve(context, { points_px: points, seen }, ratio) {
    for (let at = 1; at < points.length; at += 1) {
      context.strokeStyle = seen[at - 1] ? COLOURS.seen : COLOURS.bridged;
      context.lineWidth = 2 * ratio;
      context.beginPath();
      context.moveTo(...this.toScreen(points[at - 1]));
      context.lineTo(...this.toScreen(points[at]));
      context.stroke();
    }
  }

  ring(context, place, ratio) {
    const [x, y] = this.toScreen(place);
    context.strokeStyle = COLOURS.bridged;
    context.lineWidth = 2 * ratio;
    context.beginPath();
    context.arc(x, y, 18 * ratio, 0, 2 * Math.PI);
    context.stroke();
  }

  line(context, ends, ratio, colour) {
    for (const [stroke, wide] of [["rgba(0,0,0,0.7)", 4], [colour, 2]]) {
      context.strokeStyle = context.fillStyle = stroke;
      context.lineWidth = wide * ratio;
      context.beginPath();
      ends.forEach((end, at) => context[at ? "lineTo" : "moveTo"](...this.toScreen(end)));
      context.stroke();
      for (const end of ends) {
        const [x, y] = this.toScreen(end);
        context.beginPath();
        context.arc(x, y, wide * ratio, 0, 2 * Math.PI);
        context.fill();
      }
    }
  }

  clamp(context, name, clamp, along, ratio) {
    if (along) {
      // an arrow of one length on the screen, whatever the second place is
      const [a, b] = [this.toScreen(clamp), this.toScreen(along)];
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
      const share = (48 * ratio) / length;
      const { scale, x, y } = this.map;
      const end = [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share];
      this.line(context, [clamp, [(end[0] - x) / scale - 0.5, (end[1] - y) / scale - 0.5]], ratio, COLOURS.mark);
    }
    const [x, y] = this.toScreen(clamp);
    for (const [stroke, wide] of [["rgba(0,0,0,0.7)", 5], [COLOURS.mark, 2]]) {
      context.strokeStyle = stroke;
      context.lineWidth = wide * ratio;
      context.beginPath();
      context.arc(x, y, 9 * ratio, 0, 2 * Math.PI);
      context.stroke();
    }
    if (!name) return;
    context.font = `600 ${14 * ratio}px sans-serif`;
    context.lineWidth = 4 * ratio;
    context.strokeStyle = "rgba(0,0,0,0.8)";
    context.strokeText(name, x + 12 * ratio, y - 10 * ratio);
    context.fillStyle = COLOURS.mark;
    context.fillText(name, x + 12 * ratio, y - 10 * ratio);
  }

  /** A dot for each of several places of a fact, a square for one by itself. */
  places(context, facts, holder, ratio) {
    for (const [fill, wide] of [["rgba(0,0,0,0.7)", 5], [COLOURS.mark, 3]]) {
      context.fillStyle = fill;
      for (const { key, shape } of facts) {
        if (shape === "points")
          for (const place of holder[key] ?? []) {
            context.beginPath();
            context.arc(...this.toScreen(place), wide * ratio, 0, 2 * Math.PI);
            context.fill();
          }
        else if (shape === "point" && holder[key]) {
          const [x, y] = this.toScreen(holder[key]);
          context.fillRect(x - wide * ratio, y - wide * ratio, 2 * wide * ratio, 2 * wide * ratio);
        }
      }
    }
  }

  crosshair(context, ratio) {
    const [x, y] = this.toScreen(this.cross);
    for (const [stroke, wide] of [["rgba(0,0,0,0.5)", 3], ["#ffffff", 1]]) {
      context.strokeStyle = stroke;
      context.lineWidth = wide * ratio;
      context.beginPath();
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        context.moveTo(x + 5 * dx * ratio, y + 5 * dy * ratio);
        context.lineTo(x + 18 * dx * ratio, y + 18 * dy * ratio);
      }
      context.stroke();
    }
  }
}
