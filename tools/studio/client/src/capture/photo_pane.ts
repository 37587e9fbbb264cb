// One photograph that is looked at closely: the wheel zooms, a drag moves it, a click marks; markers can be dragged.
import { preview_url } from "../api";
import { h, replace } from "../ui/dom";
import type { Mark, MarkedPhoto } from "./landmarks";

const kMostPreview_px = 3000, kClick_px = 4, kLargestScale = 32, kWheel = 0.0016;

export interface PaneEvents {
  on_mark(pane: PhotoPane, x: number, y: number): void;
  on_choose(pane: PhotoPane, point: string): void;
  on_grab(pane: PhotoPane, point: string): void;
  on_drag(pane: PhotoPane, point: string, x: number, y: number): void;
  on_drop(): void;
}

export class PhotoPane {
  readonly element: HTMLElement;
  photo: MarkedPhoto | undefined;
  private readonly image = h("img", { alt: "", draggable: "false" });
  private readonly markers = h("div", { class: "markers" });
  private readonly stage: HTMLElement;
  private readonly size = new ResizeObserver(() => this.resized());
  private marks: Mark[] = [];
  private active: string | undefined;
  private scale = 1;  ///< Pixels of the page for one of the photograph.
  private left = 0;   ///< Of the photograph's edge, in the stage.
  private top = 0;
  private is_fit = true;

  constructor(private readonly place: string, name: string, head: HTMLElement, private readonly events: PaneEvents) {
    this.stage = h("div", { class: "photo-stage", role: "application", tabindex: "0", "aria-label": `${name} photograph: click to mark a point, the wheel zooms, a drag moves` }, this.image, this.markers);
    this.element = h("section", { class: "photo-pane", "aria-label": `${name} photograph` }, head, this.stage);
    this.image.addEventListener("load", () => { this.image.hidden = false; this.place_all(); });
    this.stage.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
    this.stage.addEventListener("pointerdown", (e) => this.press(e));
    this.size.observe(this.stage);
  }

  dispose(): void {
    this.size.disconnect();
  }

  show(photo: MarkedPhoto): void {
    if (photo === this.photo) return;
    this.photo = photo;
    this.image.hidden = true;
    this.image.alt = photo.name;
    this.image.src = preview_url(this.place, photo.path, Math.min(photo.width, kMostPreview_px), photo.image);
    this.fit();
  }

  set_marks(marks: Mark[], active: string | undefined): void {
    this.marks = marks;
    this.active = active;
    this.place_all();
  }

  fit(): void {
    if (!this.photo) return;
    const { clientWidth: w, clientHeight: hgt } = this.stage;
    this.scale = Math.min(w / this.photo.width, hgt / this.photo.height) || 1;
    this.left = (w - this.scale * this.photo.width) / 2;
    this.top = (hgt - this.scale * this.photo.height) / 2;
    this.is_fit = true;
    this.place_all();
  }

  get is_loaded(): boolean {
    return this.photo !== undefined && this.image.complete && this.image.naturalWidth > 0 && !this.image.hidden;
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
    if (this.is_fit) this.fit();
  }

  private place_all(): void {
    if (!this.photo) return;
    this.image.style.width = `${this.scale * this.photo.width}px`;
    this.image.style.transform = `translate(${this.left}px, ${this.top}px)`;
    this.image.classList.toggle("close", this.scale > 2);
    replace(this.markers, this.marks.map((m) => h("div", {
      class: m.point === this.active ? "marker active" : "marker", "data-point": m.point, title: `Point ${m.point}: drag to correct`,
      style: `transform: translate(${this.left + this.scale * (m.x + 0.5)}px, ${this.top + this.scale * (m.y + 0.5)}px)` }, h("span", {}, m.point))));
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    if (!this.photo) return;
    const box = this.stage.getBoundingClientRect();
    const fit = Math.min(box.width / this.photo.width, box.height / this.photo.height);
    const scale = Math.min(kLargestScale, Math.max(fit / 2, this.scale * Math.exp(-kWheel * event.deltaY)));
    const x = event.clientX - box.left, y = event.clientY - box.top;
    this.left = x - (x - this.left) * (scale / this.scale);
    this.top = y - (y - this.top) * (scale / this.scale);
    this.scale = scale;
    this.is_fit = false;
    this.place_all();
  }

  private press(event: PointerEvent): void {
    if (event.button !== 0 || !this.photo) return;
    const point = (event.target as HTMLElement).closest<HTMLElement>(".marker")?.dataset["point"];
    const from = { x: event.clientX, y: event.clientY, left: this.left, top: this.top };
    const mark = point === undefined ? undefined : this.marks.find((m) => m.point === point);
    const held = this.in_photo(event);
    let is_moved = false;
    this.stage.setPointerCapture(event.pointerId);
    const move = (e: PointerEvent): void => {
      if (!is_moved && Math.hypot(e.clientX - from.x, e.clientY - from.y) < kClick_px) return;
      if (!is_moved && point !== undefined) this.events.on_grab(this, point);
      is_moved = true;
      if (point !== undefined && mark) {
        const now = this.in_photo(e);
        this.events.on_drag(this, point, mark.x + now.x - held.x, mark.y + now.y - held.y);
        return;
      }
      this.left = from.left + e.clientX - from.x;
      this.top = from.top + e.clientY - from.y;
      this.is_fit = false;
      this.place_all();
    };
    const end = (e: PointerEvent): void => {
      for (const [type, f] of [["pointermove", move], ["pointerup", end], ["pointercancel", end]] as const) this.stage.removeEventListener(type, f);
      if (is_moved) this.events.on_drop();
      else if (e.type === "pointerup" && point !== undefined) this.events.on_choose(this, point);
      else if (e.type === "pointerup") this.click(e);
    };
    for (const [type, f] of [["pointermove", move], ["pointerup", end], ["pointercancel", end]] as const) this.stage.addEventListener(type, f);
  }

  private click(event: PointerEvent): void {
    const { x, y } = this.in_photo(event);
    if (!this.photo || x < -0.5 || y < -0.5 || x > this.photo.width - 0.5 || y > this.photo.height - 0.5) return;
    this.events.on_mark(this, x, y);
  }
}
