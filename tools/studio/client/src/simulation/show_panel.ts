// What is shown over the surface: amounts as colors, gammatons as points, plantlets, relief.
import { chosen_range, type MapRange } from "../color/range";
import { range_legend, unit_text } from "../history/legends";
import { RangeControl } from "../history/range_control";
import { kOverlay, type SurfaceLook } from "../scene/material";
import type { TilePlane } from "../scene/texture_tiles";
import type { Overlay, SceneState } from "../types";
import { section, select, slider, toggle } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { overlay_of } from "./context";

export interface ShowOptions {
  overlay: string;
  plantlets: boolean;
  gammatons: number;
}

const kMostGammatons = 20000;

export class ShowPanel {
  readonly element: HTMLDetailsElement;
  readonly legend_box = h("div", { class: "legends" });
  readonly shown: ShowOptions = { overlay: "", plantlets: true, gammatons: 0 };
  private readonly body = h("div", { class: "stack" });
  private amount = 1;
  private readonly range = new RangeControl(() => this.apply());
  /// The bytes of the map that is shown.
  plane: (() => TilePlane | undefined) | undefined;
  private overlay: Overlay | undefined;

  constructor(private readonly look: SurfaceLook, private readonly redraw: () => void, private readonly changed: () => void) {
    this.element = section("What is shown", true, this.body);
  }

  build(scene: SceneState): void {
    const overlays = scene.overlays.map(overlay_of);
    const choice = select("Color by", [["", "nothing"], ...overlays.map((o) => [o.name, o.name] as [string, string])], this.shown.overlay, (name) => this.choose(name, scene));
    const plant = scene.look.plants;
    replace(this.body, choice.element, this.range.element,
      slider({ label: "Strength", low: 0, high: 1, value: this.amount, unit: "%", factor: 100, on_input: (v) => { this.amount = v; this.apply(); } }).element,
      toggle("Gammatons as points", this.shown.gammatons > 0, (on) => { this.shown.gammatons = on ? kMostGammatons : 0; this.changed(); }, "Where material is under way").element,
      plant && toggle("Plantlets", this.shown.plantlets, (on) => { this.shown.plantlets = on; this.changed(); }, `Small plants where there is much ${plant}`).element,
      slider({ label: "Relief of normals", low: 0, high: 3, step: 0.05, value: 1, unit: "×", on_input: (v) => { this.look.uniforms.normal_amount.value = v; this.redraw(); } }).element,
      slider({ label: "Displacement", low: 0, high: 10, step: 0.1, value: 0, unit: "×", hint: "Heights move the mesh's vertices", on_input: (v) => {
        const is_other = v > 0 !== this.look.uniforms.displacement.value > 0;
        this.look.uniforms.displacement.value = v;
        if (is_other) this.changed();
        this.redraw();
      } }).element);
  }

  /// The one map that the server sends.
  wanted(): string | null {
    return this.shown.overlay || null;
  }

  private choose(name: string, scene: SceneState): void {
    this.shown.overlay = name;
    this.range.begin();
    this.show(scene);
    this.changed();
  }

  /// Ranges come from what is there, and change while it runs.
  show(scene: SceneState): void {
    this.overlay = scene.overlays.map(overlay_of).find((o) => o.name === this.shown.overlay);
    this.apply();
  }

  /// The map that is shown, if any.
  shown_overlay(): Overlay | undefined {
    return this.shown.overlay ? this.overlay : undefined;
  }

  /// What the colors span now.
  span(): MapRange {
    const { overlay } = this;
    const most = overlay?.most ?? 0, [low, high] = overlay?.range ?? [0, most];
    const whole = { low: 0, high: most, least: 0, most };
    if (this.range.choice.mode === "all" && !this.range.choice.is_log) return whole;
    return { ...chosen_range(this.range.choice.mode === "percentile" ? this.values() : new Float32Array([0, most]), this.range.choice, { low, high, least: 0, most }), least: 0, most };
  }

  // A texel without any of it does not count.
  private values(): Float32Array {
    const bytes = this.plane?.()?.data ?? new Uint8Array(), top = this.overlay?.high ?? 1;
    const there: number[] = [];
    const step = Math.max(1, Math.floor(bytes.length / 400000));
    for (let i = 0; i < bytes.length; i += step) if (bytes[i]! > 0) there.push(top * (bytes[i]! / 255) ** 2);
    return new Float32Array(there);
  }

  private apply(): void {
    const { overlay } = this, { uniforms } = this.look;
    const range = this.span(), top = overlay?.high ?? 1, { is_log } = this.range.choice;
    uniforms.overlay_kind.value = kOverlay.roots;
    uniforms.overlay_is_log.value = is_log ? 1 : 0;
    uniforms.overlay_range.value.set(range.low / top, range.high > range.low ? range.high / top : 1);
    this.range.element.hidden = !overlay;
    if (overlay?.range) this.range.show(range, unit_text(overlay.unit));
    replace(this.legend_box, overlay?.range && range_legend({ name: overlay.name, unit: unit_text(overlay.unit), range, is_log }));
    uniforms.overlay_amount.value = this.shown.overlay ? Math.max(this.amount, 0.001) : 0;
    this.redraw();
  }
}
