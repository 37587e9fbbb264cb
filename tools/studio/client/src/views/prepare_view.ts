// Crop, mask, scale and color chart of a capture, set with a photograph in view and saved to its project.
import { get_json, post, post_file, url_of } from "../api";
import type { Mark } from "../capture/landmarks";
import { color_region, kMostSteps, Mask } from "../capture/mask";
import { mask_file, MaskLayer, pixels_of, read_mask } from "../capture/mask_layer";
import { kNudges, pane_head, PhotoPane, roi_shapes, shape_layer } from "../capture/photo_pane";
import { corners_of, kMembers, members_of, parse_roi, project_text, roi_between, texel_size, type Members, type ProjectInfo } from "../capture/project";
import { job_buttons } from "../jobs/job_buttons";
import type { PlaceBase } from "../types";
import { button, segmented, slider, toggle } from "../ui/controls";
import { h, replace, svg, type Child } from "../ui/dom";
import { failure, notice, show_error } from "../ui/notices";
import { number_text, parse_number, unique_id } from "../ui/numbers";
import type { View } from "./view";

type Tool = "crop" | "mask" | "scale" | "chart";
const kAbout = "/api/project", kMostPixels = 120e6;
const kCorners = ["the outer corner of the first patch (dark skin)", "the corner at the other end of its row (bluish green)", "the corner across from the first (black)", "the last corner (white)"];
const same = (a: unknown, b: unknown): boolean => JSON.stringify(a) === JSON.stringify(b);
const tenth = (v: number): number => Math.round(10 * v) / 10;

/// By place: what was set and not saved when its page was left.
const left_unsaved = new Map<string, { state: string; set: object; inside: Uint8Array | undefined }>();

export class PrepareView implements View {
  readonly element = h("main", { class: "landmarks prepare" }, h("p", { class: "empty", role: "status" }, "Opening ..."));
  private info!: ProjectInfo;
  private draft!: Members;
  private mask!: Mask;
  private masks!: MaskLayer;
  private mask_state = 0;        ///< Another number after each change of the mask.
  private saved_mask_state = 0;  ///< That of the mask on the disk.
  private num_mask_states = 0;
  private is_saving = false;
  private chart_way: "none" | "auto" | "corners" = "none";
  private pane: PhotoPane | undefined;
  private tool: Tool = "crop";
  private readonly undos: (() => void)[] = [];
  private scale: { x: number; y: number }[] = [];  ///< Two places.
  private clicked: [number, number][] = [];        ///< Corners of the chart.
  private from: [number, number] | undefined;      ///< Where a drag that draws began, or is.
  private way: "brush" | "color" = "brush";
  private value = 0;  ///< What is painted: 0 = outside.
  private tolerance = 8;
  private is_connected = true;
  private picked: { x: number; y: number } | undefined;  ///< The color that the last step has taken.
  private radius = 20;
  private length: number | undefined;
  private active: string | undefined;
  private shapes = shape_layer(1, 1);
  private readonly jobs: HTMLElement;
  private readonly options = h("div", { class: "tool-options" });
  private readonly said = h("code", { class: "command", "aria-label": "The project's members" });
  private readonly choice = h("select", { "aria-label": "Photograph", onchange: () => this.show_photo(this.choice.selectedIndex) });
  private readonly save_button = button("Save", () => void this.save(), { icon: "save", kind: "primary", hint: "Writes it to the project", key: "Ctrl+S" });
  private readonly undo_button = button("Undo", () => this.undo(), { icon: "undo", hint: "Takes the last change back", key: "Ctrl+Z" });
  private readonly warn = (event: BeforeUnloadEvent): void => { if (this.is_changed) event.preventDefault(); };

  constructor(private readonly place: PlaceBase) {
    this.jobs = job_buttons(place);
    window.addEventListener("beforeunload", this.warn);
    get_json<ProjectInfo>(url_of(kAbout, { place: place.place })).then((info) => this.take(info))
      .catch((error: unknown) => replace(this.element, failure("The project cannot be shown", error instanceof Error ? error.message : String(error))));
  }

  dispose(): void {
    window.removeEventListener("beforeunload", this.warn);
    this.pane?.dispose();
    if (this.is_changed) left_unsaved.set(this.place.place, { state: this.info.state, set: this.set_now(), inside: this.is_masked ? this.mask.inside : undefined });
  }

  on_key(key: string): boolean {
    if (key === "ctrl+z") this.undo();
    else if (key === "ctrl+s") void this.save();
    else if (key === "f") this.pane?.fit();
    else if (kNudges[key] && this.active !== undefined) this.nudge(kNudges[key]!);
    else return false;
    return true;
  }

  private get is_masked(): boolean { return this.mask_state !== this.saved_mask_state; }
  private get is_changed(): boolean { return this.info !== undefined && this.draft !== undefined && (this.is_masked || !same(this.draft, members_of(this.info))); }

  private async take(info: ProjectInfo): Promise<void> {
    this.info = info;
    const photos = info.photos = info.photos.filter((photo) => info.reference === null || photo.number === info.reference);
    if (photos.length === 0 || info.width * info.height > kMostPixels) {
      replace(this.element, failure("Nothing to show", photos.length === 0 ? "The photograph that is meant does not lie below the folder of its project." : "These photographs are too large for a page; set the project's members with a text editor."));
      return;
    }
    this.draft = members_of(info);
    this.clicked = [...corners_of(info.chart)];
    this.chart_way = info.chart === null ? "none" : this.clicked.length > 0 ? "corners" : "auto";
    this.mask = new Mask(info.width, info.height);
    if (info.mask !== null && info.is_mask_shown) await read_mask(this.place.place, this.mask);
    this.take_unsaved();
    this.masks = new MaskLayer(this.mask);
    this.masks.show(this.mask.whole);
    this.radius = Math.max(2, Math.round(info.width / 40));
    replace(this.choice, photos.map((p) => h("option", {}, `${p.name}, ${p.time}`)));
    const pane = this.pane = new PhotoPane(this.place.place, "Photograph", pane_head(this.choice, "Photograph", (index) => this.show_photo(index)), {
      draws: () => this.tool === "crop" || (this.tool === "mask" && this.way === "brush"),
      on_draw: (phase, x, y) => this.draw(phase, x, y), on_hover: (x, y) => this.hover(x, y), on_mark: (_, x, y) => this.click(x, y),
      on_choose: (_, point) => { this.active = point; this.show(); }, on_grab: (_, point) => { this.remember(); this.active = point; },
      on_drag: (_, point, x, y) => { this.move(point, x, y); this.show(); }, on_drop: () => this.show(),
    });
    this.shapes = shape_layer(info.width, info.height);
    pane.layer.append(this.masks.canvas, this.shapes);
    const tools = segmented<Tool>("What is set", [["crop", "Crop"], ["mask", "Mask"], ["scale", "Scale"], ["chart", "Chart"]], this.tool, (tool) => { this.tool = tool; this.active = this.picked = undefined; this.show_tool(); });
    replace(this.element, h("aside", { class: "panel", "aria-label": "Crop, mask, scale, chart" }, h("header", { class: "panel-head" }, h("h1", {}, this.place.name), h("p", { class: "kind" }, "capture")),
      h("div", { class: "tool-options" }, tools.element), h("div", { class: "row" }, this.save_button, this.undo_button), this.options,
      h("div", { class: "tool-options" }, h("p", { class: "hint" }, `The same with a text editor, in ${info.file}:`), this.said, this.jobs)), h("div", { class: "panes one" }, pane.element));
    this.show_photo(0);
    this.show_tool();
    window.patinate = { view: "prepare", is_ready: () => pane.is_loaded, on_page: (x: number, y: number) => pane.on_page(x, y), draft: () => this.draft, is_changed: () => this.is_changed,
      num_outside: () => this.mask.inside.reduce((sum, v) => sum + (v ? 0 : 1), 0) };
  }

  private take_unsaved(): void {
    const left = left_unsaved.get(this.place.place);
    left_unsaved.delete(this.place.place);
    if (left?.state !== this.info.state) return;
    Object.assign(this, left.set);
    if (left.inside?.length === this.mask.inside.length) {
      this.mask.inside.set(left.inside);
      this.mask_state = ++this.num_mask_states;
    }
    notice("What was not saved is here again.", "info", kAbout);
  }

  private show_photo(index: number): void {
    this.choice.selectedIndex = index;
    this.picked = undefined;
    this.pane!.show(this.info.photos[index]!);
  }

  private set_now(): object {
    const { draft, scale, clicked, chart_way, length } = this;
    return { draft, scale, clicked, chart_way, length };
  }

  // What is set now comes back with undo.
  private remember(): void {
    const now = this.set_now();
    this.picked = undefined;
    this.add_undo(() => Object.assign(this, now));
  }

  private remember_mask(): void {
    const was = this.mask_state;
    this.mask.begin();
    this.mask_state = ++this.num_mask_states;
    this.add_undo(() => { this.mask.undo(); this.mask_state = was; this.masks.show(this.mask.whole); });
  }

  private add_undo(step: () => void): void {
    this.undos.push(step);
    if (this.undos.length > kMostSteps) this.undos.shift();
  }

  private undo(): void {
    if (this.from) return;  // The rest of a stroke would be part of the step before it.
    this.undos.pop()?.();
    this.picked = undefined;
    this.show_tool();
  }

  private set(members: Partial<Members>): void {
    this.remember();
    this.draft = { ...this.draft, ...members };
    this.show_tool();
  }

  private draw(phase: "begin" | "move" | "end", x: number, y: number): void {
    if (phase === "begin") {
      this.from = [x, y];
      if (this.tool === "mask") this.remember_mask();
    }
    const [ax, ay] = this.from ?? [x, y];
    if (phase === "end") this.from = undefined;
    else if (this.tool === "mask") this.from = [x, y];
    if (this.tool === "mask") {
      this.masks.show(this.mask.stroke([ax, ay], [x, y], this.radius, this.value));
      this.hover(x, y);
      if (phase === "end") this.show();
      return;
    }
    const roi = roi_between(ax, ay, x, y, this.info.width, this.info.height);
    if (phase === "end" && roi) this.set({ roi });
    else this.show_shapes(roi ?? this.draft.roi);
  }

  private hover(x?: number, y?: number): void {
    this.shapes.querySelector(".brush")?.remove();
    if (x !== undefined && y !== undefined && this.tool === "mask" && this.way === "brush") this.shapes.append(svg("ellipse", { class: "brush", cx: x, cy: y, rx: this.radius, ry: this.radius }));
  }

  private click(x: number, y: number): void {
    if (this.tool === "mask") return this.pick(x, y);
    this.remember();
    if (this.tool === "scale") {
      this.scale = [...(this.scale.length === 2 ? [] : this.scale), { x: tenth(x), y: tenth(y) }];
      this.active = String(this.scale.length);
      this.measure();
    } else {
      this.clicked = [...(this.clicked.length === 4 ? [] : this.clicked), [tenth(x), tenth(y)]];
      this.active = String(this.clicked.length);
      this.chart_way = "corners";
      this.take_corners();
    }
    this.show_tool();
  }

  private move(point: string, x: number, y: number): void {
    const at = Number(point) - 1, inside = (v: number, size: number): number => tenth(Math.min(size - 0.5, Math.max(-0.5, v)));
    const [px, py] = [inside(x, this.info.width), inside(y, this.info.height)];
    if (this.tool === "scale") this.scale = this.scale.map((p, i) => (i === at ? { x: px, y: py } : p));
    else this.clicked = this.clicked.map((p, i) => (i === at ? [px, py] : p));
    if (this.tool === "scale") this.measure();
    else this.take_corners();
  }

  private nudge([dx, dy]: [number, number]): void {
    const mark = this.marks().find(({ point }) => point === this.active);
    if (!mark) return;
    this.remember();
    this.move(mark.point, mark.x + dx, mark.y + dy);
    this.show();
  }

  private measure(): void {
    const size = texel_size(this.scale, this.length);
    if (size !== null) this.draft = { ...this.draft, texel_size_mm: size };
  }

  private take_corners(): void {
    if (this.clicked.length === 4) this.draft = { ...this.draft, chart: { ...(typeof this.draft.chart === "object" ? this.draft.chart : {}), corners: this.clicked } };
  }

  // Another tolerance takes the place of the last one.
  private pick(x: number, y: number): void {
    const image = this.pane!.image, { width, height } = this.info;
    if (!this.pane!.is_loaded) return;
    this.remember_mask();
    this.picked = { x, y };
    const pixels = pixels_of(image), at = (v: number, size: number, shown: number): number => Math.min(shown - 1, Math.max(0, Math.floor(((v + 0.5) * shown) / size)));
    const region = color_region(pixels, at(x, width, pixels.width), at(y, height, pixels.height), this.tolerance, this.is_connected);
    this.masks.show(this.mask.fill(region, pixels.width, pixels.height, this.value));
    this.show();
  }

  private pick_again(): void {
    if (!this.picked) return;
    const { x, y } = this.picked;
    this.undos.pop()?.();
    this.pick(x, y);
  }

  private async save(): Promise<void> {
    if (!this.is_changed || this.from || this.is_saving) return;
    this.save_button.disabled = this.is_saving = true;
    const place = this.place.place;
    try {
      const is_all = this.mask.is_everything, is_masked = this.is_masked, mask_state = this.mask_state;
      if (is_masked && !is_all) {
        this.saved(await post_file<ProjectInfo>(url_of("/api/mask", { place, state: this.info.state }), await mask_file(this.mask)));
        this.saved_mask_state = mask_state;
      }
      const was = members_of(this.info), draft = this.draft, corners = corners_of(draft.chart);
      const now = { ...draft, chart: draft.chart === null ? null : corners.length > 0 ? { corners } : "auto" };
      const members = { ...Object.fromEntries(kMembers.filter((name) => !same(was[name], draft[name])).map((name) => [name, now[name]])), ...(is_masked && is_all ? { mask: null } : {}) };
      if (Object.keys(members).length > 0) this.saved(JSON.parse(await (await post(url_of(kAbout, { place }), { state: this.info.state, members })).text()) as ProjectInfo);
      this.saved_mask_state = mask_state;
      if (this.draft === draft) this.draft = members_of(this.info);  // Else more was set while it was saved.
      notice(`It is saved in ${this.info.file}.`, "info", kAbout);
    } catch (error) {
      show_error(error, kAbout);
    }
    this.is_saving = false;
    this.show();
  }

  private saved(info: ProjectInfo): void {
    const { photos } = this.info;
    this.info = { ...info, photos };
  }

  private marks(): Mark[] {
    const places = this.tool === "scale" ? this.scale : this.tool === "chart" ? this.clicked.map(([x, y]) => ({ x, y })) : [];
    return places.map(({ x, y }, i) => ({ photo: 0, point: String(i + 1), x, y }));
  }

  private show_shapes(roi = this.draft.roi): void {
    const { width, height } = this.info, line = (points: number[][]): SVGElement => svg("polygon", { class: "line", points: points.map((p) => p.join(",")).join(" ") });
    const shapes: SVGElement[] = [];
    if (roi) shapes.push(...roi_shapes(roi, width, height));
    if (this.tool === "scale") shapes.push(line(this.scale.map(({ x, y }) => [x, y])));
    if (this.tool === "chart") shapes.push(line(this.clicked));
    this.shapes.replaceChildren(...shapes);
  }

  private show(): void {
    this.show_shapes();
    this.pane!.set_marks(this.marks(), this.active);
    this.pane!.element.classList.toggle("brushing", this.tool === "mask" && this.way === "brush");
    this.undo_button.disabled = this.undos.length === 0;
    this.save_button.disabled = !this.is_changed || this.is_saving;
    this.jobs.inert = this.is_changed;  // They read what is saved.
    const mask = this.mask.is_everything && this.is_masked ? null : this.is_masked ? "masks/..." : this.info.mask;
    this.said.textContent = project_text(this.draft, mask) || "(nothing of this)";
    for (const each of this.options.querySelectorAll<HTMLElement>("[data-said]")) each.textContent = this.say(each.dataset["said"]!);
  }

  private say(what: string): string {
    const { texel_size_mm: size, roi } = this.draft, { width, height } = this.info;
    if (what === "crop") return roi ? `${roi[2]} x ${roi[3]} of ${width} x ${height} pixels stay.` : `All ${width} x ${height} pixels stay.`;
    if (what === "scale") return `${["Click one end of a known length.", "Click the other end.", this.length ? "" : "Type the length."][this.scale.length]} ${size === null ? "" : `A pixel is ${number_text(size, 4)} mm; a photograph is ${number_text(size * width)} x ${number_text(size * height)} mm.`}`.trim();
    if (this.chart_way === "auto") return "The chart is looked for in every photograph.";
    return this.clicked.length < 4 ? `Click ${kCorners[this.clicked.length]}.` : "These corners hold for every photograph. Keep the chart outside of the crop or the mask.";
  }

  private show_tool(): void {
    const say = h("p", { class: "say", role: "status", "data-said": this.tool });
    const { width, height } = this.info;
    replace(this.options, this.tool === "crop" ? this.crop_options(say, width, height) : this.tool === "mask" ? this.mask_options() : this.tool === "scale" ? this.scale_options(say) : this.chart_options(say));
    this.show();
  }

  private field(label: string, value: string, hint: string, on: (text: string) => void): HTMLElement {
    const id = unique_id(), input = h("input", { id, type: "text", autocomplete: "off", spellcheck: "false", value });
    input.onchange = () => on(input.value);
    return h("div", { class: "field" }, h("label", { for: id }, label), input, h("span", { class: "hint" }, hint));
  }

  private crop_options(say: HTMLElement, width: number, height: number): Child[] {
    return [h("p", { class: "about" }, "Drag a rectangle over the part that is to become the history."), say,
      this.field("x, y, width, height", this.draft.roi?.join(", ") ?? "", "In pixels of the photograph; empty: all of it.", (text) => {
        const roi = parse_roi(text, width, height);
        if (roi || text.trim() === "") this.set({ roi });
        else notice(`Four whole numbers are needed, inside of ${width} x ${height} pixels.`, "error", kAbout);
      })];
  }

  private mask_options(): Child[] {
    const paint = segmented("What is painted", [["0", "Outside", "What belongs to no history"], ["255", "Inside", "Takes it back"]], String(this.value), (value) => { this.value = Number(value); this.picked = undefined; });
    const way = segmented<"brush" | "color">("How", [["brush", "Brush"], ["color", "Color"]], this.way, (chosen) => { this.way = chosen; this.picked = undefined; this.show_tool(); });
    return [h("p", { class: "about" }, this.way === "brush" ? "Paint over what is no part of the surface. The right button of the mouse moves the picture." : "Click a color. All places of nearly this color are taken."), way.element, paint.element,
      this.way === "brush" ? slider({ label: "Radius", low: 1, high: Math.max(50, this.info.width / 4), value: this.radius, logarithmic: true, unit: "px", on_input: (v) => { this.radius = v; } }).element
        : [slider({ label: "Tolerance", low: 1, high: 60, step: 0.5, value: this.tolerance, hint: "CIEDE2000: 1 is just noticeable", on_input: (v) => { this.tolerance = v; this.pick_again(); } }).element,
          toggle("Only what is connected", this.is_connected, (v) => { this.is_connected = v; this.pick_again(); }).element],
      this.info.mask !== null && !this.info.is_mask_shown && h("p", { class: "hint" }, `${this.info.mask} is not as large as the photographs and cannot be shown; a new mask takes its place.`),
      button("All inside", () => { this.remember_mask(); this.masks.show(this.mask.fill(new Uint8Array([1]), 1, 1, 255)); this.show(); }, { hint: "Begins without a mask" })].flat();
  }

  private scale_options(say: HTMLElement): Child[] {
    return [h("p", { class: "about" }, "Click both ends of a length that you know, such as 50 mm of a ruler, and type it."), say,
      this.field("Length in mm", this.length === undefined ? "" : String(this.length), "Between the two places.", (text) => { this.remember(); this.length = parse_number(text); this.measure(); this.show_tool(); }),
      this.draft.texel_size_mm !== null && button("No scale", () => this.set({ texel_size_mm: null }))];
  }

  private chart_options(say: HTMLElement): Child[] {
    const kind = segmented<"none" | "auto" | "corners">("Color chart", [["none", "None"], ["auto", "Find it"], ["corners", "Corners"]], this.chart_way, (chosen) => {
      const { corners, ...rest } = typeof this.draft.chart === "object" && this.draft.chart !== null ? this.draft.chart : {};
      this.remember();
      this.chart_way = chosen;
      this.clicked = [];
      if (chosen !== "corners") this.draft = { ...this.draft, chart: chosen === "none" ? null : Object.keys(rest).length > 0 ? rest : "auto" };
      this.show_tool();
    });
    return [h("p", { class: "about" }, "A chart of 24 patches gives true colors. If it is not found in every photograph, click its four corners, clockwise from the first patch."), kind.element, this.chart_way !== "none" && say];
  }
}
