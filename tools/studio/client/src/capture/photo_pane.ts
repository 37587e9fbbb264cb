// One photograph that is looked at closely: the wheel zooms, a drag moves it, a click marks; markers can be dragged.
import { preview_url } from "../api";
import { icon_button } from "../ui/controls";
import { h, replace, svg } from "../ui/dom";
import { notice } from "../ui/notices";
import type { Mark, MarkedPhoto } from "./landmarks";

const kMostPreview_px = 3000, kClick_px = 4, kLargestScale = 32, kWheel = 0.0016;

export interface PaneEvents {
  on_mark?(pane: PhotoPane, x: number, y: number): void;
  on_choose?(pane: PhotoPane, point: string): void;
  on_grab?(pane: PhotoPane, point: string): void;
  on_drag?(pane: PhotoPane, point: string, x: number, y: number): void;
  on_drop?(): void;
  /// Whether the next drag draws; the picture is then moved with another button of the mouse.
  draws?(): boolean;
  on_draw?(phase: "begin" | "move" | "end", x: number, y: number): void;
  /// Where the pointer is; nothing: it has left.
  on_hover?(x?: number, y?: number): void;
  /// A person has zoomed or moved it.
  on_view?(pane: PhotoPane): void;
}

/// What a pane shows, in sizes of its region: zoom 1 = all of it; x and y are in the middle.
export interface PaneView { zoom: number; x: number; y: number }
/// Left, top, width and height in pixels.
export type Region = [number, number, number, number];

export const kNudges: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/// The head of a pane: a list of what it can show, with buttons for the one before and the next. @param go  Shows one.
export function pane_head(choice: HTMLSelectElement, what: string, go: (index: number) => void, keys: string[] = []): HTMLElement {
  const step = (by: number) => () => go((choice.selectedIndex + by + choice.length) % choice.length);
  return h("header", {}, icon_button("back", `${what} before`, step(-1), keys[0]), choice, icon_button("step", `Next ${what.toLowerCase()}`, step(1), keys[1]));
}

/// For shapes over a photograph; pixel centers are whole numbers.
export function shape_layer(width: number, height: number): SVGElement {
  return svg("svg", { preserveAspectRatio: "none", viewBox: `-0.5 -0.5 ${width} ${height}` });
}

/// A rectangle, and all around it darkened.
export function roi_shapes([x, y, w, hgt]: Region, width: number, height: number): SVGElement[] {
  const [left, top] = [x - 0.5, y - 0.5];
  return [svg("path", { class: "cut", d: `M-.5 -.5h${width}v${height}h${-width}zM${left} ${top}v${hgt}h${w}v${-hgt}z` }), svg("rect", { class: "line", x: left, y: top, width: w, height: hgt })];
}

export class PhotoPane {
  readonly element: HTMLElement;
  photo: MarkedPhoto | undefined;
  readonly image = h("img", { alt: "", draggable: "false" });
  /// Lies over the photograph, as large as it.
  readonly layer = h("div", { class: "layer" });
  private readonly markers = h("div", { class: "markers" });
  private readonly stage: HTMLElement;
  private readonly size = new ResizeObserver(() => this.resized());
  private marks: Mark[] = [];
  private active: string | undefined;
  private scale = 1;  ///< Pixels of the page for one of the photograph.
  private left = 0;   ///< Of the photograph's edge, in the stage.
  private top = 0;
  private laid_out = [0, 0];  ///< Size of the stage when it was last looked at.
  is_fit = true;
  private region: Region = [0, 0, 1, 1];  ///< What fit() shows.

  constructor(private readonly place: string, name: string, head: HTMLElement, private readonly events: PaneEvents) {
    this.stage = h("div", { class: "photo-stage", role: "application", tabindex: "0", "aria-label": `${name}: the wheel zooms, a drag moves${events.on_mark ? ", a click marks a point" : ""}` }, this.image, this.layer, this.markers);
    this.element = h("section", { class: "photo-pane", "aria-label": name }, head, this.stage);
    this.image.addEventListener("load", () => { this.image.hidden = false; this.resized(); this.place_all(); });
    this.image.addEventListener("error", () => notice(`${this.image.alt} cannot be shown.`, "error"));
    this.stage.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
    this.stage.addEventListener("pointerdown", (e) => this.press(e));
    this.stage.addEventListener("contextmenu", (e) => { if (events.draws?.()) e.preventDefault(); });
    this.stage.addEventListener("pointermove", (e) => { const { x, y } = this.in_photo(e); events.on_hover?.(x, y); });
    this.stage.addEventListener("pointerleave", () => events.on_hover?.());
    this.size.observe(this.stage);
  }

  dispose(): void {
    this.size.disconnect();
  }

  show(photo: MarkedPhoto, region: Region = [0, 0, photo.width, photo.height]): void {
    if (photo === this.photo) return;
    this.photo = photo;
    this.region = region;
    this.image.hidden = true;
    this.image.alt = photo.name;
    this.image.src = preview_url(photo.place ?? this.place, photo.path, Math.min(photo.width, kMostPreview_px), photo.image);
    this.fit();
  }

  set_marks(marks: Mark[], active: string | undefined): void {
    this.marks = marks;
    this.active = active;
    this.place_all();
  }

  fit(): void {
    if (!this.photo) return;
    this.view = { zoom: 1, x: 0.5, y: 0.5 };
    this.is_fit = true;
  }

  private get fit_scale(): number {
    return Math.min(this.stage.clientWidth / this.region[2], this.stage.clientHeight / this.region[3]) || 1;
  }

  get view(): PaneView {
    const [x, y, width, height] = this.region;
    return { zoom: this.scale / this.fit_scale, x: ((this.stage.clientWidth / 2 - this.left) / this.scale - x) / width, y: ((this.stage.clientHeight / 2 - this.top) / this.scale - y) / height };
  }

  set view({ zoom, x, y }: PaneView) {
    this.scale = zoom * this.fit_scale;
    this.left = this.stage.clientWidth / 2 - this.scale * (this.region[0] + x * this.region[2]);
    this.top = this.stage.clientHeight / 2 - this.scale * (this.region[1] + y * this.region[3]);
    this.is_fit = false;
    this.place_all();
  }

  get is_loaded(): boolean {
    const is_laid_out = this.laid_out[0] === this.stage.clientWidth && this.laid_out[1] === this.stage.clientHeight;
    return is_laid_out && this.photo !== undefined && this.image.complete && this.image.naturalWidth > 0 && !this.image.hidden;
  }

  /// Where a place of the photograph is on the page.
  on_page(x: number, y: number): { x: number; y: number } {
    const box = this.stage.getBoundingClientRect();
    return { x: box.left + this.left + this.scale * (x + 0.5), y: box.top + this.top + this.scale * (y + 0.5) };
  }

  private in_photo(event: MouseEvent): { x: number; y: number } {
    const box = this.stage.getBoundingClientRect();
    return { x: (event.clientX - box.left - this.left) / this.scale - 0.5, y: (event.clientY - box.top - this.top) / this.scale - 0.5 };
  }

  private resized(): void {
    this.laid_out = [this.stage.clientWidth, this.stage.clientHeight];
    if (this.is_fit) this.fit();
  }

  private place_all(): void {
    if (!this.photo) return;
    this.image.style.width = `${this.scale * this.photo.width}px`;
    this.image.style.transform = `translate(${this.left}px, ${this.top}px)`;
    this.image.classList.toggle("close", this.scale > 2);
    this.layer.style.cssText = `width: ${this.scale * this.photo.width}px; height: ${this.scale * this.photo.height}px; transform: translate(${this.left}px, ${this.top}px)`;
    replace(this.markers, this.marks.map((m) => h("div", {
      class: m.point === this.active ? "marker active" : "marker", "data-point": m.point, title: `Point ${m.point}: drag to correct`,
      style: `transform: translate(${this.left + this.scale * (m.x + 0.5)}px, ${this.top + this.scale * (m.y + 0.5)}px)` }, h("span", {}, m.point))));
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    if (!this.photo) return;
    const box = this.stage.getBoundingClientRect();
    const scale = Math.min(kLargestScale, Math.max(this.fit_scale / 2, this.scale * Math.exp(-kWheel * event.deltaY)));
    const x = event.clientX - box.left, y = event.clientY - box.top;
    this.left = x - (x - this.left) * (scale / this.scale);
    this.top = y - (y - this.top) * (scale / this.scale);
    this.scale = scale;
    this.is_fit = false;
    this.place_all();
    this.events.on_view?.(this);
  }

  private press(event: PointerEvent): void {
    if (!this.photo || (event.button !== 0 && !this.events.draws?.())) return;
    const point = (event.target as HTMLElement).closest<HTMLElement>(".marker")?.dataset["point"];
    const from = { x: event.clientX, y: event.clientY, left: this.left, top: this.top };
    const mark = point === undefined ? undefined : this.marks.find((m) => m.point === point);
    const held = this.in_photo(event);
    let is_moved = false;
    const draws = event.button === 0 && point === undefined && this.events.draws?.() === true;
    if (draws) this.events.on_draw?.("begin", held.x, held.y);
    this.stage.setPointerCapture(event.pointerId);
    const move = (e: PointerEvent): void => {
      if (draws) {
        const now = this.in_photo(e);
        return this.events.on_draw?.("move", now.x, now.y);
      }
      if (!is_moved && Math.hypot(e.clientX - from.x, e.clientY - from.y) < kClick_px) return;
      if (!is_moved && point !== undefined) this.events.on_grab?.(this, point);
      is_moved = true;
      if (point !== undefined && mark) {
        const now = this.in_photo(e);
        this.events.on_drag?.(this, point, mark.x + now.x - held.x, mark.y + now.y - held.y);
        return;
      }
      this.left = from.left + e.clientX - from.x;
      this.top = from.top + e.clientY - from.y;
      this.is_fit = false;
      this.place_all();
      this.events.on_view?.(this);
    };
    const end = (e: PointerEvent): void => {
      for (const [type, f] of [["pointermove", move], ["pointerup", end], ["pointercancel", end]] as const) this.stage.removeEventListener(type, f);
      const now = this.in_photo(e);
      if (draws) this.events.on_draw?.("end", now.x, now.y);
      else if (is_moved) this.events.on_drop?.();
      else if (e.type === "pointerup" && point !== undefined) this.events.on_choose?.(this, point);
      else if (e.type === "pointerup" && event.button === 0) this.click(e);
    };
    for (const [type, f] of [["pointermove", move], ["pointerup", end], ["pointercancel", end]] as const) this.stage.addEventListener(type, f);
  }

  private click(event: PointerEvent): void {
    const { x, y } = this.in_photo(event);
    if (!this.photo || x < -0.5 || y < -0.5 || x > this.photo.width - 0.5 || y > this.photo.height - 0.5) return;
    this.events.on_mark?.(this, x, y);
  }
}
