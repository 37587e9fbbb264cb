// What was done on the way from photographs and scans to data: step by step, each with its pictures.
import * as THREE from "three";
import { get_mesh, preview_url } from "../api";
import { dress, read_glb } from "../scene/mesh_loader";
import { Viewer } from "../scene/viewer";
import type { StepPicture, StepsPlace } from "../types";
import { icon_button } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { show_error } from "../ui/notices";
import type { View } from "./view";
import { facts_table } from "./workspace";

interface NumberedStep {
  step: StepsPlace["steps"][number];
  number: number;
}

/// The first of a sheet has its heading to jump to, the others their picture.
function anchor_of(number: number, group: NumberedStep[]): string | undefined {
  return number === group[0]!.number ? undefined : `step-${number}`;
}

const kTileWidth = 420, kLargeWidth = 1800;

export class CaptureView implements View {
  readonly element: HTMLElement;
  private readonly large = h("dialog", { class: "light-box", "aria-label": "Picture" });
  private viewer: Viewer | undefined;
  private pictures: StepPicture[] = [];
  private at = 0;

  constructor(private readonly place: StepsPlace) {
    const steps = place.steps ?? [];
    this.pictures = steps.flatMap((s) => s.pictures);
    const list = h("ol", {}, steps.map((s, i) => h("li", {}, h("a", { href: `#step-${i}`, onclick: (e: Event) => { e.preventDefault(); this.element.querySelector(`#step-${i}`)?.scrollIntoView({ behavior: "smooth" }); } }, s.name,
      h("small", {}, s.pictures.length === 1 ? "1 picture" : `${s.pictures.length} pictures`)))));
    const stage = h("div", { class: "mesh-stage", hidden: true });
    const body = h("div", { class: "steps" }, stage,
      steps.length === 0 && h("p", { class: "empty" }, "Nothing was kept of its steps."),
      this.groups().map((group) => h("section", {}, group.map(({ step, number }, i) => [
        i === 0 && h("h2", { id: `step-${number}` }, h("span", { class: "number" }, number + 1), group.length > 1 ? `${step.name} to ${group[group.length - 1]!.step.name}` : step.name),
        i === 0 && h("p", {}, step.text)]).flat(),
        h("div", { class: "pictures" }, group.map(({ step, number }) => step.pictures.map((p) => this.tile(p, group.length > 1 ? step.name : p.caption, anchor_of(number, group)))).flat()))));
    this.element = h("main", { class: "capture" }, h("aside", { class: "panel", "aria-label": "Steps" },
      h("header", { class: "panel-head" }, h("h1", {}, place.name), h("p", { class: "kind" }, place.kind)), h("nav", { "aria-label": "Steps" }, list), facts_table(place.facts ?? [])), body, this.large);
    this.large.addEventListener("click", (e) => { if (e.target === this.large) this.large.close(); });
    this.large.addEventListener("keydown", (e) => {
      if (e.key === "ArrowRight") this.show(this.at + 1);
      else if (e.key === "ArrowLeft") this.show(this.at - 1);
    });
    if (place.mesh) this.show_mesh(stage);
    window.patinate = { view: "capture" };
  }

  dispose(): void {
    this.viewer?.dispose();
  }

  // Steps of one photograph and no words, one after the other, are one sheet.
  private groups(): NumberedStep[][] {
    const groups: NumberedStep[][] = [];
    const is_plain = ({ step }: NumberedStep): boolean => step.text === "" && step.pictures.length <= 1;
    (this.place.steps ?? []).forEach((step, number) => {
      const last = groups[groups.length - 1];
      const numbered = { step, number };
      if (last && is_plain(last[0]!) && is_plain(numbered)) last.push(numbered);
      else groups.push([numbered]);
    });
    return groups;
  }

  private tile(picture: StepPicture, caption: string, id: string | undefined): HTMLElement {
    const number = this.pictures.indexOf(picture);
    return h("figure", { id }, h("button", { type: "button", onclick: () => this.show(number), "aria-label": `Enlarge: ${picture.caption}` },
      h("img", { src: preview_url(this.place.place, picture.path, kTileWidth), alt: picture.caption, loading: "lazy", decoding: "async" })), h("figcaption", {}, caption));
  }

  private show(number: number): void {
    const picture = this.pictures[number];
    if (!picture) return;
    this.at = number;
    replace(this.large, h("header", {}, h("span", {}, `${picture.caption}  (${number + 1} of ${this.pictures.length})`), icon_button("back", "Picture before", () => this.show(number - 1), "←"),
      icon_button("step", "Next picture", () => this.show(number + 1), "→"), icon_button("close", "Close", () => this.large.close(), "Esc")),
      h("img", { src: preview_url(this.place.place, picture.path, kLargeWidth), alt: picture.caption }));
    if (!this.large.open) this.large.showModal();
  }

  private show_mesh(stage: HTMLElement): void {
    stage.hidden = false;
    this.viewer = new Viewer(stage, false);
    this.viewer.canvas.setAttribute("aria-label", "The registered scans; drag to turn");
    const viewer = this.viewer;
    get_mesh(this.place.place).then(read_glb).then((group) => {
      dress(group, new THREE.MeshStandardMaterial({ color: 0xb9b4aa, roughness: 0.8, side: THREE.DoubleSide }));
      viewer.content.add(group);
      viewer.fit();
    }).catch(show_error);
  }
}
