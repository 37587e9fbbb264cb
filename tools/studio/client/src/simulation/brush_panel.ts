// The brush: which emitter it is, what it carries and how much, or what it takes away; its size, distance and spread.
import type { Emitter, SceneState } from "../types";
import { section, segmented, select, slider } from "../ui/controls";
import { h, replace } from "../ui/dom";
import type { Brush } from "./brush";
import { extent, size_of } from "./context";

const kLeastFlow = 0.02, kMostFlow = 16;  // Amount that a drop holds at birth; 16 is the most that scene files allow.
const kEverything = "*", kMixed = "+";

export class BrushPanel {
  readonly element: HTMLElement;
  private readonly body = h("div", { class: "stack" });
  private shown = "";

  constructor(private readonly brush: Brush, private readonly scene: () => SceneState) {
    this.element = section("Paint on the surface", true, this.body);
    brush.on_change = () => this.show(scene(), true);
  }

  show(scene: SceneState, is_forced = false): void {
    const emitter = this.brush.current();
    const key = JSON.stringify([emitter?.name, emitter?.shape, emitter?.carries, scene.emitters.length, this.brush.erased]);
    if ((!is_forced && key === this.shown) || this.body.contains(document.activeElement)) return;
    this.shown = key;
    if (!emitter) {
      replace(this.body, h("p", { class: "hint" }, "This scene has no emitter to paint with."));
      return;
    }
    const with_what = select("Paint with", scene.emitters.map((e) => [e.name, e.name] as [string, string]), emitter.name, (name) => {
      this.brush.emitter = name;
      this.again();
    });
    const is_eraser = this.brush.erased.length > 0;
    const mode = segmented("What the brush does", [["paint", "Paint", "Lays material down"], ["erase", "Erase", "Takes material away"]], is_eraser ? "erase" : "paint", (chosen) => {
      this.brush.erased = chosen === "erase" ? [...scene.materials] : [];
      this.again();
    });
    replace(this.body, with_what.element, mode.element, is_eraser ? this.eraser(scene) : this.materials(emitter, scene),
      emitter.shape === "surface" ? this.shape(emitter, scene) : h("p", { class: "hint" }, `With the first stroke, ${emitter.name} becomes a brush that follows the surface.`));
  }

  private again(): void {
    (document.activeElement as HTMLElement | null)?.blur();
    this.show(this.scene(), true);
  }

  private materials(emitter: Emitter, scene: SceneState): HTMLElement[] {
    const carried = scene.materials.filter((m) => (emitter.carries?.[m] ?? 0) > 0);
    const flow = Math.max(...carried.map((m) => emitter.carries?.[m] ?? 0), 0);
    const one = carried.length === 1 ? carried[0]! : carried.length > 1 ? kMixed : "";
    const options: [string, string][] = [...(carried.length === 0 ? [["", "choose one"] as [string, string]] : []), ...scene.materials.map((m) => [m, m] as [string, string]),
      ...(carried.length > 1 ? [[kMixed, carried.join(" + ")] as [string, string]] : [])];
    const all = (value: (material: string) => number): Record<string, number> => Object.fromEntries(scene.materials.map((m) => [m, value(m)]));
    const material = select("Material", options, one, (chosen) => {
      if (chosen === kMixed || chosen === "") return;
      this.brush.change({ carries: all((m) => (m === chosen ? flow || 1 : 0)) });
      this.again();
    });
    const strength = slider({ label: "Flow", low: kLeastFlow, high: kMostFlow, value: flow || 1, logarithmic: true, hint: "Amount that each drop brings", on_input: (v) => {
      const now = this.brush.current();
      const most = Math.max(...scene.materials.map((m) => now?.carries?.[m] ?? 0), 0);
      if (now && most > 0) this.set({ carries: all((m) => ((now.carries?.[m] ?? 0) * v) / most) });
    } });
    return [material.element, strength.element];
  }

  private eraser(scene: SceneState): HTMLElement[] {
    const { erased } = this.brush;
    const what = select("Takes away", [[kEverything, "everything"], ...scene.materials.map((m) => [m, m] as [string, string])], erased.length === scene.materials.length ? kEverything : erased[0]!, (chosen) => {
      this.brush.erased = chosen === kEverything ? [...scene.materials] : [chosen];
      this.again();
    });
    return [what.element];
  }

  private shape(emitter: Emitter, scene: SceneState): HTMLElement[] {
    const span = extent(scene);
    return [
      slider({ label: "Size", low: span / 500, high: span / 2, value: size_of(emitter)[0], logarithmic: true, unit: "mm", hint: "Shift and wheel", on_input: (v) => this.set({ size: v }) }).element,
      slider({ label: "Distance", low: span / 1000, high: span / 2, value: emitter.distance ?? 10, logarithmic: true, unit: "mm", hint: "Wheel", on_input: (v) => this.set({ distance: v }) }).element,
      slider({ label: "Spread", low: 0, high: 90, step: 0.5, value: emitter.spread_deg ?? 0, unit: "°", on_input: (v) => this.set({ spread_deg: v }) }).element];
  }

  // The sliders are what changes it: they need not be made again.
  private set(fields: Partial<Emitter>): void {
    const told = this.brush.on_change;
    this.brush.on_change = undefined;
    this.brush.change(fields);
    this.brush.on_change = told;
  }
}
