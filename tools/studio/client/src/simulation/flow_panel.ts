// How material travels: behavior and exchange.
import type { SceneState } from "../types";
import type { Chart } from "../ui/chart";
import { section, select, slider, type Slider } from "../ui/controls";
import { h, replace, throttle } from "../ui/dom";
import type { SceneContext } from "./context";
import { figure10 } from "./figure10";

interface Preset {
  text: string;
  slider: number;
  absorb: number;
  ratio: number;
}

const kPresets: Record<string, Preset> = {
  rain: { text: "Rain that runs down", slider: 0.72, absorb: 0.02, ratio: 0.4 },
  film: { text: "Slow, creeping film", slider: 0.92, absorb: 0.03, ratio: 0.5 },
  splash: { text: "Splashes", slider: 0.25, absorb: 0.1, ratio: 0.6 },
  dust: { text: "Dust that settles", slider: 0.33, absorb: 0.3, ratio: 0.9 },
  wash: { text: "Washing off", slider: 0.7, absorb: 0.01, ratio: 0.1 },
};
const kSend_ms = 80;

export class FlowPanel {
  readonly elements: HTMLElement[];
  private readonly behavior = h("div", { class: "stack" });
  private readonly rates = h("div", { class: "stack" });
  private readonly sliders = new Map<string, Slider>();
  private chart: Chart | undefined;
  private chart_absorb = -1;
  private readonly chart_box = h("div", {});
  private readonly own = h("p", { class: "hint" }, "The scene has probabilities of its own; moving the slider replaces them.");
  private readonly send_behavior = throttle(kSend_ms, (slider: number, absorb: number) => this.context.event({ op: "behavior", behavior: { slider, absorb } }));

  constructor(private readonly context: SceneContext) {
    const preset = select("Like", [["", "as it is"], ...Object.entries(kPresets).map(([k, p]) => [k, p.text] as [string, string])], "", (name) => this.apply(name));
    this.elements = [
      section("How it flows", true, preset.element, this.behavior),
      section("Exchange with the surface", false, this.rates),
    ];
  }

  /// After hello: all controls; `show` later only moves them.
  build(scene: SceneState): void {
    this.sliders.clear();
    const make = (key: string, label: string, value: number, hint: string, send: (v: number) => void): HTMLElement => {
      const s = slider({ label, low: 0, high: 1, step: 0.005, value, hint, on_input: send });
      this.sliders.set(key, s);
      return s.element;
    };
    replace(this.behavior,
      make("slider", "From bouncing to creeping", scene.slider ?? 0.5, "Figure 10: left all bounce, right all float ever more slowly", () => this.flow()), this.own, this.chart_box,
      make("absorb", "Absorbed at a hit", scene.behavior.absorb, "Share of gammatons that end in the surface", () => this.flow()),
      make("ratio", "Ratio r: washes or deposits", scene.exchange.ratio, "0 only picks up, 1 only drops", throttle(kSend_ms, (v: number) => this.context.event({ op: "ratio", ratio: v }))));
    replace(this.rates, h("p", { class: "hint" }, "Share of a material that changes sides at a contact."), scene.materials.map((m) =>
      make(`rate ${m}`, m, scene.exchange.rates[m] ?? 0, `Exchange rate of ${m}`, throttle(kSend_ms, (v: number) => this.context.event({ op: "rate", target: m, rate: v })))));
    this.own.hidden = typeof scene.slider === "number";
    this.chart_absorb = -1;
    this.draw();
  }

  show(scene: SceneState): void {
    if (typeof scene.slider === "number") this.sliders.get("slider")?.set(scene.slider);
    this.own.hidden = typeof scene.slider === "number";
    this.sliders.get("absorb")?.set(scene.behavior.absorb);
    this.sliders.get("ratio")?.set(scene.exchange.ratio);
    for (const m of scene.materials) this.sliders.get(`rate ${m}`)?.set(scene.exchange.rates[m] ?? 0);
    this.draw();
  }

  // What is sent later is what was seen now: the server's answer to the one before may move a slider meanwhile.
  private flow(): void {
    this.draw();
    this.send_behavior(this.value("slider"), this.value("absorb"));
  }

  private value(key: string): number {
    return this.sliders.get(key)?.get() ?? 0;
  }

  private draw(): void {
    const absorb = this.value("absorb");
    if (absorb !== this.chart_absorb) {
      this.chart_absorb = absorb;
      this.chart = figure10(absorb, (s) => {
        this.sliders.get("slider")?.set(s);
        this.flow();
      });
      replace(this.chart_box, this.chart.element);
    }
    this.chart?.mark(this.value("slider"));
  }

  private apply(name: string): void {
    const preset = kPresets[name];
    if (!preset) return;
    this.context.event({ op: "behavior", behavior: { slider: preset.slider, absorb: preset.absorb } }, preset.text);
    this.context.event({ op: "ratio", ratio: preset.ratio }, preset.text);
    this.sliders.get("slider")?.set(preset.slider);
    this.sliders.get("absorb")?.set(preset.absorb);
    this.sliders.get("ratio")?.set(preset.ratio);
    this.draw();
  }
}
