// Camera calibration: live picture; scale by views of a board or by a bar; clamp and arc by pointing.

import { h, newId, put, setText } from "../dom.js";
import { parseNumber } from "../form/limits.js";
import { digits, number } from "../format.js";
import { post, remove } from "../net.js";
import { pixelWords, Pointing } from "../pointing.js";
import { steps } from "../steps.js";

const BOARD = [
  { key: "columns", name: "columns", value: 12, unit: "" },
  { key: "rows", name: "rows", value: 9, unit: "" },
  { key: "square_mm", name: "square", value: 5, unit: "mm" },
  { key: "marker_mm", name: "marker (0: checkerboard)", value: 3.6, unit: "mm" },
];
const TARGETS = {
  clamp: { words: "the point where the sheet leaves the clamp", what: "corner" },
  along: {
    words:
      "a point further along the clamp\u2019s edge line, in the direction of the clamped sheet",
    what: "corner",
  },
  ruler_a: { words: "one end of the scale bar", what: "corner" },
  ruler_b: { words: "the other end of the scale bar", what: "corner" },
  arc: { words: "the roll that stands at position 0", what: "round" },
};

/** Show the guide. */
export function mount(place, app) {
  const page = new Camera(app);
  place.append(page.element);
  return page;
}

class Camera {
  constructor(app) {
    Object.assign(this, {
      app,
      views: [],
      px: {},
      target: null,
      calibration: null,
      arc: null,
      accepted: "",
    });
    this.pointing = new Pointing(app.job, (px) => this.pointed(px));
    this.fault = h("p", { class: "fault", role: "alert" });
    this.live = h(
      "button",
      { type: "button", class: "main", onclick: () => this.act(() => this.toggle()) },
      "Start the camera",
    );
    this.method = newId("method");
    this.build();
    const again = () => this.show();
    const stop = app.job.watch(
      (dirty) => ["job", "story", "picture"].some((type) => dirty.has(type)) && again(),
    );
    app.control.watchers.add(again);
    this.destroy = () => {
      stop();
      app.control.watchers.delete(again);
      this.pointing.destroy();
    };
    this.show();
  }

  build() {
    this.board = BOARD.map((one) => ({
      ...one,
      input: h("input", {
        id: newId(one.key),
        value: one.value,
        inputmode: "decimal",
        class: "short",
      }),
    }));
    this.keep = this.button("Keep this view", () => this.keepView());
    this.kept = h("ul", { class: "views" });
    this.bar = h("input", { id: newId("bar"), value: 30, inputmode: "decimal", class: "short" });
    this.points = Object.fromEntries(
      Object.keys(TARGETS).map((name) => [name, this.pointButton(name)]),
    );
    this.calibrate = this.button("Calibrate", () => this.work());
    this.result = h("dl", { class: "facts facts-big" });
    this.warnings = h("ul");
    this.arcResult = h("p", { role: "status" });
    this.accept = this.button("Accept and write optics.json", () => this.write());
    this.accept.classList.add("main");
    this.done = h("p", { class: "good", role: "status" });
    const radio = (value, words, checked) =>
      h(
        "label",
        { class: "radio" },
        h("input", {
          type: "radio",
          name: this.method,
          value,
          checked,
          onchange: () => this.show(),
        }),
        ` ${words}`,
      );
    this.boardPart = h(
      "div",
      {},
      h(
        "div",
        { class: "inline" },
        this.board.map(({ input, name, unit }) => [
          h("label", { for: input.id }, name),
          input,
          unit,
        ]),
      ),
      this.keep,
      this.kept,
    );
    this.barPart = h(
      "div",
      {},
      this.points.ruler_a.element,
      this.points.ruler_b.element,
      h("p", { class: "inline" }, h("label", { for: this.bar.id }, "its length"), this.bar, "mm"),
    );
    this.guide = steps([
      ["Camera", "Focus, fix the lens, light the sheet as in the experiment.", this.live],
      [
        "Scale",
        "A board corrects the lens, too: keep six views or more, tilted each way; the first one in the sheet\u2019s plane.",
        h(
          "div",
          { class: "inline", role: "radiogroup", "aria-label": "how" },
          radio("board", "views of a board", true),
          radio("bar", "a scale bar", false),
        ),
        this.boardPart,
        this.barPart,
      ],
      [
        "Clamp",
        "Point near it; the corner itself is then found to a fraction of a pixel.",
        this.points.clamp.element,
        this.points.along.element,
      ],
      [
        "Calibrate",
        "The residual says how far the found corners are from where they should be.",
        this.calibrate,
        this.result,
        this.warnings,
      ],
      [
        "Arc\u2019s origin",
        "Stand the load cell at position 0 and point at its roll.",
        this.points.arc.element,
        this.arcResult,
      ],
      ["Accept", "The old calibration is kept beside the new one.", this.accept, this.done],
    ]);
    this.element = h(
      "div",
      { class: "guide" },
      h("h1", {}, "Camera calibration"),
      this.fault,
      h(
        "div",
        { class: "camera-two" },
        h("div", { class: "camera-left" }, this.pointing.element),
        this.guide.element,
      ),
    );
  }

  button(words, work) {
    return h("button", { type: "button", onclick: () => this.act(work) }, words);
  }

  pointButton(name) {
    const said = h("span", { class: "point-said" }, "not set");
    const button = h(
      "button",
      { type: "button", "aria-pressed": "false", onclick: () => this.aim(name) },
      "Set",
    );
    return {
      said,
      button,
      element: h("div", { class: "point" }, button, h("span", {}, TARGETS[name].words), said),
    };
  }

  get by() {
    return this.element.querySelector(`input[name="${this.method}"]:checked`).value;
  }

  boardValues() {
    return Object.fromEntries(this.board.map(({ key, input }) => [key, parseNumber(input.value)]));
  }

  async act(work) {
    setText(this.fault, "");
    try {
      await this.app.control.act(work);
    } catch (error) {
      setText(this.fault, error.message);
    }
    this.show();
  }

  async toggle() {
    await post("/api/camera", { do: this.running ? "end" : "start" });
  }

  get running() {
    const { job } = this.app;
    return job.going && job.job.kind === "camera";
  }

  async keepView() {
    const view = await post("/api/camera/view", { board: this.boardValues() });
    this.views.push(view);
    this.pointing.setMarks([
      ...this.marks(),
      ...view.corners_px.map((px) => ({ px, shape: "dot" })),
    ]);
    this.pointing.setText(`View ${view.view} is kept: ${view.corners_px.length} corners.`);
  }

  async drop(view) {
    await remove(`/api/camera/view/${view.view}`);
    this.views = this.views.filter((one) => one !== view);
  }

  aim(name) {
    this.target = name;
    this.pointing.setText(`Point at ${TARGETS[name].words}.`);
    this.pointing.picture.canvas.focus();
    this.show();
  }

  /** The operator points roughly, the server finds the point itself. */
  pointed(px) {
    const name = this.target;
    if (!name) return this.pointing.setText("First say what it is: press one of the Set buttons.");
    return this.act(async () => {
      const found = await post("/api/camera/refine", { what: TARGETS[name].what, px });
      this.px[name] = found.px;
      this.target = null;
      setText(
        this.points[name].said,
        `${pixelWords(found.px)} \u00B1 ${digits(found.sigma_px, 2)} px, moved by ${digits(found.moved_px, 2)} px`,
      );
      this.pointing.to(found.px);
      this.pointing.setText(`Found at ${pixelWords(found.px)}.`);
      if (name === "arc") await this.findArc(found.px);
    });
  }

  async findArc(px) {
    this.arc = await post("/api/camera/arc", { px });
    setText(
      this.arcResult,
      `radius ${number(this.arc.radius_mm, 2)} mm, origin ${number(this.arc.origin_deg, 2)}\u00B0, \u00B1 ${number(this.arc.sigma_mm, 2)} mm: put these into [arc] of sheet.toml.`,
    );
  }

  async work() {
    const { clamp, along, ruler_a, ruler_b } = this.px;
    const body =
      this.by === "board"
        ? {
            board: this.boardValues(),
            views: this.views.map((one) => one.view),
            clamp_px: clamp,
            along_px: along,
          }
        : { ruler_px: [ruler_a, ruler_b], ruler_mm: parseNumber(this.bar.value), clamp_px: clamp };
    this.calibration = await post("/api/camera/calibrate", body);
  }

  async write() {
    const { written, kept, carried } = await post("/api/camera/accept", {});
    this.accepted = `\u2713 ${written} is written${kept ? `; the old one is kept as ${kept}` : ""}${carried ? `; ${carried}` : ""}.`;
  }

  marks() {
    const named = Object.entries(this.px).map(([name, px]) => ({
      px,
      name: name.replace("_", " "),
      shape: name === "arc" ? "ring" : "cross",
    }));
    const axes = this.calibration?.axes_px;
    if (!axes) return named;
    return [
      ...named,
      { px: axes[1], name: "x", line: [axes[0]] },
      { px: axes[2], name: "y", line: [axes[0]] },
    ];
  }

  show() {
    const { control, job } = this.app;
    const why = control.why() || (job.going && !this.running ? "Something else is going on." : "");
    const board = this.by === "board";
    setText(this.live, this.running ? "End the camera" : "Start the camera");
    this.live.disabled = Boolean(why);
    this.boardPart.hidden = !board;
    this.barPart.hidden = board;
    this.keep.disabled = !this.running;
    this.points.along.element.hidden = !board;
    const scaled = board ? this.views.length > 0 : this.px.ruler_a && this.px.ruler_b;
    this.calibrate.disabled = !scaled || !this.px.clamp;
    this.accept.disabled = !this.calibration;
    for (const [name, { button }] of Object.entries(this.points)) {
      button.setAttribute("aria-pressed", String(this.target === name));
      button.disabled = !this.running;
    }
    this.showViews();
    this.showResult();
    setText(this.done, this.accepted);
    if (this.shown !== this.calibration || this.count !== Object.values(this.px).join()) {
      [this.shown, this.count] = [this.calibration, Object.values(this.px).join()];
      this.pointing.setMarks(this.marks());
    }
    this.guide.at(
      this.accepted
        ? 6
        : this.arc
          ? 5
          : this.calibration
            ? 4
            : scaled && this.px.clamp
              ? 3
              : scaled
                ? 2
                : this.running
                  ? 1
                  : 0,
    );
  }

  showViews() {
    if (this.viewsShown === this.views.length) return;
    this.viewsShown = this.views.length;
    put(
      this.kept,
      this.views.map((view, index) =>
        h(
          "li",
          {},
          h("img", {
            src: `/api/camera/view/${view.view}`,
            alt: `view ${view.view} of the board`,
            width: 120,
          }),
          h(
            "span",
            {},
            `${index ? "" : "in the sheet\u2019s plane; "}${view.corners_px.length} corners`,
          ),
          h(
            "button",
            {
              type: "button",
              class: "small",
              "aria-label": `drop view ${view.view}`,
              onclick: () => this.act(() => this.drop(view)),
            },
            "Drop",
          ),
        ),
      ),
    );
  }

  showResult() {
    const found = this.calibration;
    put(
      this.result,
      found &&
        [
          [
            "scale",
            `${digits(found.px_per_mm, 5)} \u00B1 ${digits(found.px_per_mm_sigma, 2)} px/mm`,
          ],
          [
            "residual",
            `${digits(found.residual_px, 3)} px, ${digits(found.residual_um, 3)} \u00B5m`,
          ],
          ["largest", `${digits(found.largest_um, 3)} \u00B5m`],
          ["method", found.method],
        ].map(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]),
    );
    put(
      this.warnings,
      (found?.warnings ?? []).map((text) => h("li", { class: "fault" }, text)),
    );
  }
}
