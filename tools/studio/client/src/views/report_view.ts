// A page that patinate wrote, as it is. It runs as a stranger: it cannot use the studio.
import { url_of } from "../api";
import type { PlaceBase } from "../types";
import { h } from "../ui/dom";
import type { View } from "./view";

export class ReportView implements View {
  readonly element: HTMLElement;

  constructor(place: PlaceBase & { page?: string }) {
    this.element = h("main", { class: "report" }, h("iframe", { class: "report-frame", title: place.name, src: url_of("/api/file", { place: place.place, path: place.page ?? "report.html" }), sandbox: "allow-scripts" }));
    window.patinate = { view: "report" };
  }

  dispose(): void {}
}
