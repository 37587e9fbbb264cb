// Landmarks of a capture: the same places clicked in photographs that stand beside each other, saved to the project.
import { get_json, post, url_of } from "../api";
import { Landmarks, type LandmarksInfo, type Mark, type MarkedPhoto } from "../capture/landmarks";
import { kNudges, pane_head, PhotoPane, type PaneEvents } from "../capture/photo_pane";
import type { PlaceBase } from "../types";
import { button, icon_button } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { failure, notice, show_error } from "../ui/notices";
import type { View } from "./view";

const kFewest = 2, kForHomography = 4;  ///< Points that two photographs must share.
const kAbout = "/api/landmarks";

/// Marks that were not saved when a capture was left, and the state that they were made in.
const left_unsaved = new Map<string, { state: string; marks: Mark[] }>();

export class LandmarksView implements View {
  readonly element = h("main", { class: "landmarks" }, h("p", { class: "empty", role: "status" }, "Opening ..."));
  private info: LandmarksInfo | undefined;
  private marks = new Landmarks([]);
  private active: string | undefined;
  private panes: PhotoPane[] = [];
  private last: PhotoPane | undefined;  ///< That was clicked last.
  private readonly choices: HTMLSelectElement[] = [];
  private readonly say = h("p", { class: "say", role: "status" });
  private readonly lists = h("div", { class: "lists" });
  private readonly save_button = button("Save", () => void this.save(), { icon: "save", kind: "primary", hint: "Writes the points to the project", key: "Ctrl+S" });
  private readonly undo_button = button("Undo", () => this.undo(), { icon: "undo", hint: "Takes the last change back", key: "Ctrl+Z" });
  private readonly warn = (event: BeforeUnloadEvent): void => { if (this.marks.is_changed) event.preventDefault(); };

  constructor(private readonly place: PlaceBase) {
    window.addEventListener("beforeunload", this.warn);
    get_json<LandmarksInfo>(url_of(kAbout, { place: place.place })).then((info) => this.take(info))
      .catch((error: unknown) => replace(this.element, failure("The photographs cannot be shown", error instanceof Error ? error.message : String(error))));
  }

  dispose(): void {
    window.removeEventListener("beforeunload", this.warn);
    for (const pane of this.panes) pane.dispose();
    if (this.info && this.marks.is_changed) left_unsaved.set(this.place.place, { state: this.info.state, marks: [...this.marks.all] });
  }

  on_key(key: string): boolean {
    const pane = this.last;
    if (key === "ctrl+z") this.undo();
    else if (key === "ctrl+s") void this.save();
    else if (key === "f") for (const p of this.panes) p.fit();
    else if (key === "Escape") this.choose(undefined);
    else if ((key === "Delete" || key === "Backspace") && pane?.photo && this.active) this.change(() => this.marks.remove(pane.photo!.number, this.active!));
    else if (kNudges[key] && pane?.photo && this.active) this.nudge(pane.photo, kNudges[key]!);
    else return false;
    return true;
  }

  private take(info: LandmarksInfo): void {
    this.info = info;
    this.marks = new Landmarks(info.marks);
    const left = left_unsaved.get(this.place.place);
    left_unsaved.delete(this.place.place);
    if (left && left.state === info.state) {
      this.marks.begin();
      this.marks.replace(left.marks);
      notice("Points that were not saved are here again.", "info", kAbout);
    }
    if (info.photos.length < 2) {
      replace(this.element, failure("Nothing to mark", "Two or more photographs are needed that lie below the folder of the project."));
      return;
    }
    const events: PaneEvents = {
      on_mark: (pane, x, y) => this.mark(pane, x, y),
      on_choose: (pane, point) => { this.last = pane; this.choose(point); },
      on_grab: (pane, point) => { this.last = pane; this.marks.begin(); this.choose(point); },
      on_drag: (pane, point, x, y) => { this.marks.put(pane.photo!, point, x, y); this.show_marks(); },
      on_drop: () => this.show(),
    };
    this.panes = ["Left", "Right"].map((name, i) => {
      const choice = h("select", { "aria-label": `${name} photograph`, onchange: () => this.show_photo(i, info.photos[choice.selectedIndex]!) },
        info.photos.map((p) => h("option", {}, `${p.name}, ${p.time}`)));
      this.choices.push(choice);
      return new PhotoPane(this.place.place, `${name} photograph`, pane_head(choice, "Photograph", (index) => this.show_photo(i, info.photos[index]!)), events);
    });
    replace(this.element, h("aside", { class: "panel", "aria-label": "Points" }, h("header", { class: "panel-head" }, h("h1", {}, this.place.name), h("p", { class: "kind" }, "landmarks")),
      h("p", { class: "about" }, `Click a place in the left photograph, and the same place in the right one. The wheel zooms, a drag moves the picture or a marker. ${kFewest} points that two photographs share tell shift, turn and scale; ${kForHomography} tell the view.`),
      this.say, h("div", { class: "row" }, this.save_button, this.undo_button), this.lists), h("div", { class: "panes" }, this.panes.map((p) => p.element)));
    this.show_photo(0, info.photos[0]!);
    this.show_photo(1, info.photos[1]!);
    window.patinate = { view: "landmarks", is_ready: () => this.panes.every((p) => p.is_loaded), marks: () => this.marks.all,
      on_page: (side: number, x: number, y: number) => this.panes[side]!.on_page(x, y), is_changed: () => this.marks.is_changed };
  }

  private show_photo(side: number, photo: MarkedPhoto): void {
    this.choices[side]!.selectedIndex = this.info!.photos.indexOf(photo);
    this.panes[side]!.show(photo);
    this.active = undefined;
    this.show();
  }

  // The chosen point, or the first that this photograph lacks and the other has, or a new one.
  private mark(pane: PhotoPane, x: number, y: number): void {
    const photo = pane.photo!, other = this.panes.find((p) => p !== pane)!.photo!;
    const chosen = this.active !== undefined && !this.marks.at(photo.number, this.active) ? this.active : undefined;
    const point = chosen ?? this.marks.first_missing(other.number, photo.number) ?? this.marks.new_point();
    this.last = pane;
    this.active = point;
    this.change(() => this.marks.put(photo, point, x, y));
  }

  private nudge(photo: MarkedPhoto, [dx, dy]: [number, number]): void {
    const mark = this.marks.at(photo.number, this.active!);
    if (mark) this.change(() => this.marks.put(photo, mark.point, mark.x + dx, mark.y + dy));
  }

  private change(f: () => void): void {
    this.marks.begin();
    f();
    this.show();
  }

  private choose(point: string | undefined): void {
    this.active = point;
    this.show();
  }

  private undo(): void {
    this.marks.undo();
    this.show();
  }

  private async save(): Promise<void> {
    if (!this.info || !this.marks.is_changed) return;
    this.save_button.disabled = true;
    try {
      const answer = await post(url_of(kAbout, { place: this.place.place }), { state: this.info.state, marks: this.marks.all });
      const was_used = this.info.uses_marks;
      this.info = JSON.parse(await answer.text()) as LandmarksInfo;
      this.marks.was_saved();
      notice(`${this.marks.all.length} marks are saved in ${this.info.table}${was_used ? "" : "; the project now says \"align\": \"auto\", so that they are used"}. Give the ingest command again.`, "info", kAbout);
    } catch (error) {
      show_error(error, kAbout);
    }
    this.show();
  }

  private show_marks(): void {
    for (const pane of this.panes) if (pane.photo) pane.set_marks(this.marks.of_photo(pane.photo.number), this.active);
  }

  private show(): void {
    const [left, right] = this.panes.map((p) => p.photo);
    if (!left || !right || !this.info) return;
    this.show_marks();
    this.undo_button.disabled = !this.marks.can_undo;
    this.save_button.disabled = !this.marks.is_changed || this.marks.all.length === 0;
    const in_right = this.marks.first_missing(left.number, right.number), in_left = this.marks.first_missing(right.number, left.number);
    this.say.textContent = in_right !== undefined ? `Click point ${in_right} in the right photograph.` : in_left !== undefined ? `Click point ${in_left} in the left photograph.`
      : `Click a new place in the left photograph: point ${this.marks.new_point()}.`;
    replace(this.lists, h("h2", {}, "Photographs"), h("ul", { class: "photo-list" }, this.info.photos.map((p) => this.photo_row(p, left))),
      h("h2", {}, "Points"), h("ul", { class: "point-list" }, this.marks.points().map((p) => this.point_row(p))));
  }

  private photo_row(photo: MarkedPhoto, left: MarkedPhoto): HTMLElement {
    const count = this.marks.of_photo(photo.number).length;
    return h("li", {}, h("button", { type: "button", class: photo === this.panes[1]!.photo ? "quiet on" : "quiet", title: "Show it on the right", disabled: photo === left, onclick: () => this.show_photo(1, photo) },
      h("span", {}, photo.name), h("small", { class: count < kFewest ? "few" : "" }, count === 1 ? "1 point" : `${count} points`)));
  }

  private point_row(point: string): HTMLElement {
    const count = this.marks.all.filter((m) => m.point === point).length;
    return h("li", {}, h("button", { type: "button", class: point === this.active ? "quiet on" : "quiet", onclick: () => this.choose(point) }, h("span", {}, `Point ${point}`),
      h("small", { class: count < 2 ? "few" : "" }, count === 1 ? "in 1 photograph" : `in ${count} photographs`)), icon_button("close", `Remove point ${point}`, () => this.change(() => { this.marks.remove_point(point); if (this.active === point) this.active = undefined; })));
  }
}
