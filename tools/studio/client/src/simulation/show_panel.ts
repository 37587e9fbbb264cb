// What is shown over the surface: amounts as colors, gammatons as points, plantlets, relief.
import { range_legend, unit_text } from "../history/overlay_panel";
import type { SurfaceLook } from "../scene/material";
import type { Overlay, SceneState } from "../types";
import { number_text, section, select, slider, toggle } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { overlay_of } from "./context";

export interface ShowOptions {
  overlay: string;
  plantlets: boolean;
  gammatons: number;
}

const kMostGammatons = 20000;
const kPlants = ["organic", "moss"];

export class ShowPanel {
  readonly element: HTMLDetailsElement;
  readonly legend_box = h("div", { class: "legends" });
  readonly shown: ShowOptions = { overlay: "", plantlets: false, gammatons: 0 };
  private readonly body = h("div", { class: "stack" });
  private amount = 1;
  private is_whole = false;
  private overlay: Overlay | undefined;

  constructor(private readonly look: SurfaceLook, private readonly redraw: () => void, private readonly changed: () => void) {
    this.element = section("What is shown", true, this.body);
  }

  build(scene: SceneState): void {
    const overlays = scene.overlays.map(overlay_of);
    const choice = select("Color by", [["", "nothing"], ...overlays.map((o) => [o.name, o.name] as [string, string])], this.shown.overlay, (name) => this.choose(name, scene));
    const plant = this.plant(scene);
    const range = select("Colors span", [["", "98 % of it"], ["whole", "all of it"]], this.is_whole ? "whole" : "", (value) => {
      this.is_whole = value !== "";
      this.apply();
    });
    replace(this.body, choice.element, range.element,
      slider({ label: "Strength", low: 0, high: 1, value: this.amount, text: (v) => `${Math.round(100 * v)} %`, on_input: (v) => { this.amount = v; this.apply(); } }).element,
      toggle("Gammatons as points", this.shown.gammatons > 0, (on) => { this.shown.gammatons = on ? kMostGammatons : 0; this.changed(); }, "Where material is under way").element,
      plant && toggle("Plantlets", this.shown.plantlets, (on) => { this.shown.plantlets = on; this.changed(); }, `Small plants where there is much ${plant}`).element,
      slider({ label: "Relief of normals", low: 0, high: 3, step: 0.05, value: 1, text: (v) => `× ${number_text(v)}`, on_input: (v) => { this.look.uniforms.normal_amount.value = v; this.redraw(); } }).element,
      slider({ label: "Displacement", low: 0, high: 10, step: 0.1, value: 0, text: (v) => `× ${number_text(v)}`, hint: "Heights move the mesh's vertices", on_input: (v) => { this.look.uniforms.displacement.value = v; this.redraw(); } }).element);
  }

  /// The material that plantlets grow of.
  plant(scene: SceneState): string | undefined {
    const names = scene.overlays.map((o) => overlay_of(o).name);
    return kPlants.find((p) => names.includes(p));
  }

  /// The one map that the server sends: what is asked for, else what plantlets need.
  wanted(scene: SceneState): string | null {
    return this.shown.overlay || (this.shown.plantlets ? (this.plant(scene) ?? null) : null);
  }

  /// What a byte of 255 stands for, of the map that the server sends.
  high(scene: SceneState): number {
    const wanted = this.wanted(scene);
    return scene.overlays.map(overlay_of).find((o) => o.name === wanted)?.high ?? 1;
  }

  private choose(name: string, scene: SceneState): void {
    this.shown.overlay = name;
    this.show(scene);
    this.apply();
    this.changed();
  }

  /// Ranges come from what is there, and change while it runs.
  show(scene: SceneState): void {
    this.overlay = scene.overlays.map(overlay_of).find((o) => o.name === this.shown.overlay);
    this.apply();
  }

  private apply(): void {
    const { overlay } = this;
    const most = overlay?.most ?? 0, [low, high] = this.is_whole ? [0, most] : overlay?.range ?? [0, most];
    const top = overlay?.high ?? 1;
    this.look.uniforms.overlay_kind.value = 2;
    this.look.uniforms.overlay_range.value.set(low / top, high > low ? high / top : 1);
    replace(this.legend_box, overlay?.range && range_legend(overlay.name, unit_text(overlay.unit), low, high, most));
    this.look.uniforms.overlay_amount.value = this.shown.overlay ? Math.max(this.amount, 0.001) : 0;
    this.redraw();
  }
}
