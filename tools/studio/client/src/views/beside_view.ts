// Each frame of a history beside the photograph that it was made of, with one zoom.
import { pane_head, PhotoPane, roi_shapes, shape_layer, type PaneEvents } from "../capture/photo_pane";
import type { BesideInfo, StepsPlace } from "../types";
import { h } from "../ui/dom";
import type { View } from "./view";

export class BesideView implements View {
  readonly element: HTMLElement;
  private readonly pairs: { time: string; beside: BesideInfo }[];
  private readonly panes: [PhotoPane, PhotoPane];
  private readonly choice = h("select", { "aria-label": "Frame", onchange: () => this.show(this.choice.selectedIndex) });

  constructor(place: StepsPlace) {
    this.pairs = place.steps.flatMap(({ name, beside }) => (beside ? [{ time: name, beside }] : []));
    this.choice.append(...this.pairs.map(({ time, beside }) => h("option", {}, `${time}, ${beside.photo.name}`)));
    const events: PaneEvents = { on_view: (pane) => { for (const other of this.panes) if (other !== pane) other.view = pane.view; } };
    this.panes = [new PhotoPane(place.place, "Photograph", pane_head(this.choice, "Frame", (index) => this.show(index), ["←", "→"]), events),
      new PhotoPane(place.place, "Frame", h("header", {}, h("b", {}, "What became of it"), h("span", { class: "hint" }, "The wheel zooms both, a drag moves both.")), events)];
    this.element = h("main", { class: "beside" }, h("div", { class: "panes" }, this.panes.map((pane) => pane.element)));
    this.show(0);
    window.patinate = { view: "beside", is_ready: () => this.panes.every((pane) => pane.is_loaded), views: () => this.panes.map((pane) => pane.view), on_page: (side: number, x: number, y: number) => this.panes[side]!.on_page(x, y) };
  }

  dispose(): void {
    for (const pane of this.panes) pane.dispose();
  }

  on_key(key: string): boolean {
    const by = key === "ArrowRight" ? 1 : key === "ArrowLeft" ? -1 : 0;
    if (key === "f") for (const pane of this.panes) pane.fit();
    else if (by !== 0) this.show((this.choice.selectedIndex + by + this.pairs.length) % this.pairs.length);
    else return false;
    return true;
  }

  private show(index: number): void {
    const { photo, frame, roi } = this.pairs[index]!.beside, [raw, made] = this.panes;
    const before = raw.is_fit ? undefined : raw.view;  // What fits, fits in a window of another size, too.
    this.choice.selectedIndex = index;
    raw.show({ ...photo, number: index, time: "" }, roi ?? undefined);
    const shapes = shape_layer(photo.width, photo.height);
    if (roi && (roi[2] < photo.width || roi[3] < photo.height)) shapes.append(...roi_shapes(roi, photo.width, photo.height));
    raw.layer.replaceChildren(shapes);
    made.show({ ...frame, number: index, time: "" });
    if (before) raw.view = made.view = before;
  }
}
