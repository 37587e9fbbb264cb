// Post-controls: the appearance of amounts. They recompose at once and never simulate.
import { srgb_from_linear } from "../color/lab";
import type { Builder } from "../build/builder";
import type { Appearance, SceneState } from "../types";
import { section, slider, type Slider } from "../ui/controls";
import { h, replace, throttle } from "../ui/dom";
import { gesture } from "../ui/gesture";
import type { SceneContext } from "./context";

const kSend_ms = 60;
const kFields: [keyof Appearance, string, number, number, string][] = [
  ["strength", "Strength", 0, 3, "How much amount 1 covers"], ["variation", "Variation", 0, 1, "Of the strength, from texel to texel"],
  ["specular", "Gloss", -1, 1, "Change of the specular value by amount 1"], ["specular_variation", "Variation of gloss", 0, 1, ""],
  ["height", "Height", -2, 3, "Change of the height by amount 1"], ["height_variation", "Variation of height", 0, 1, ""],
];

export class AppearancePanel {
  readonly element: HTMLDetailsElement;
  private readonly body = h("div", { class: "stack" });
  private readonly sliders = new Map<string, Slider>();

  constructor(private readonly context: SceneContext, private readonly builder: Builder) {
    this.element = section("Appearance of materials", false, h("p", { class: "hint" }, "Changes the picture at once, without simulating again."), this.body);
  }

  build(scene: SceneState): void {
    this.sliders.clear();
    replace(this.body, scene.materials.map((material, i) => {
      const look = scene.appearance[material] ?? {};
      const send = throttle(kSend_ms, (field: string, value: number) => void this.context.send("appearance", { appearance: { [material]: { [field]: value } }, gesture: gesture() }));
      const color = look.color ? `background:rgb(${look.color.map((c) => Math.round(255 * srgb_from_linear(c))).join(" ")})` : "";
      const all = kFields.filter(([field]) => look[field] !== undefined).map(([field, label, low, high, hint]) => {
        const value = look[field] as number;
        const s = slider({ label, low: Math.min(low, value), high: Math.max(high, value), step: 0.01, value, hint, open: field !== "variation", ...(field === "height" ? { unit: "mm" } : {}), on_input: (v) => send(field, v) });
        this.sliders.set(`${material} ${field}`, s);
        return s.element;
      });
      const details = h("details", { class: "material" }, h("summary", {}, h("i", { class: "swatch", style: color, "aria-hidden": "true" }), material), h("div", { class: "stack" }, material === scene.look.film && h("p", { class: "hint" }, "In the picture it is a film of water. Strength, gloss and height count in exported files."), all, this.builder.actions("material", material)));
      details.open = i === 0;
      return details;
    }), this.builder.add_button("material"));
  }

  show(scene: SceneState): void {
    for (const material of scene.materials) {
      for (const [field] of kFields) {
        const value = scene.appearance[material]?.[field];
        if (typeof value === "number") this.sliders.get(`${material} ${field}`)?.set(value);
      }
    }
  }
}
