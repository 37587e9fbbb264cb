// Emitters and objects: chosen here or on the stage, switched, moved with handles.
import type { Builder } from "../build/builder";
import type { Emitter, SceneState } from "../types";
import { number_text, section, segmented, slider, toggle, type Choice } from "../ui/controls";
import { h, replace, throttle } from "../ui/dom";
import { emitter_event, extent, size_of, type SceneContext } from "./context";
import type { Chosen, HandleMode, Handles } from "./handles";

const kSend_ms = 60;
const kMostCarried = 4;
const kShapes: Record<Emitter["shape"], string> = { point: "point", disk: "disk", rectangle: "rectangle", sphere: "sphere", sky: "whole sky", surface: "brush" };

export class EmittersPanel {
  readonly element: HTMLElement;
  readonly mode: Choice<HandleMode>;
  private readonly list = h("div", { class: "things", role: "list", "aria-label": "Emitters and objects" });
  private readonly adds = h("div", { class: "actions" });
  private readonly details = h("div", { class: "stack" });
  private readonly send: (emitter: Emitter) => void;
  private shown_details = "";

  constructor(private readonly context: SceneContext, private readonly handles: Handles, private readonly builder: Builder) {
    this.mode = segmented<HandleMode>("Handles", [["translate", "Move", "G"], ["rotate", "Rotate", "R"], ["scale", "Scale", "S"]], "translate", (mode) => handles.set_mode(mode));
    this.send = throttle(kSend_ms, (emitter: Emitter) => context.event(emitter_event(emitter)));
    const handles_shown = toggle("Show emitters", true, (on) => handles.set_visible(on));
    this.element = section("Emitters and objects", true, this.list, this.adds, this.mode.element, this.details, handles_shown.element);
    handles.on_choose = () => this.show(context.scene);
  }

  show(scene: SceneState): void {
    const { chosen } = this.handles;
    const row = (kind: Chosen["kind"], name: string, detail: string, on?: HTMLElement): HTMLElement => {
      const is_chosen = chosen?.kind === kind && chosen.name === name;
      return h("div", { class: `thing ${is_chosen ? "chosen" : ""}`, role: "listitem" },
        h("button", { type: "button", class: "quiet", "aria-pressed": String(is_chosen), onclick: () => this.choose(is_chosen ? undefined : { kind, name }) }, h("b", {}, name), h("small", {}, detail)), on);
    };
    const focused = (document.activeElement as HTMLElement | null)?.closest(".thing");
    const at = focused ? [...this.list.children].indexOf(focused) : -1;
    replace(this.list, scene.emitters.map((e) => row("emitter", e.name, `${kShapes[e.shape]}, ${number_text(e.gammatons ?? 0)} gammatons`, this.switch_of(e))), scene.objects.map((o) => row("object", o.name, "object")));
    if (at >= 0) this.list.children[at]?.querySelector("button")?.focus();
    if (this.adds.childElementCount === 0) replace(this.adds, this.builder.add_button("emitter"), this.builder.add_button("object"));
    this.show_details(scene);
  }

  /// After hello: what was chosen may be gone.
  build(scene: SceneState): void {
    this.shown_details = "";
    const { chosen } = this.handles;
    if (chosen && !(chosen.kind === "emitter" ? scene.emitters : scene.objects).some((part) => part.name === chosen.name)) this.handles.choose(undefined);
    this.show(scene);
  }

  choose(chosen: Chosen | undefined): void {
    this.handles.choose(chosen);
    this.show(this.context.scene);
  }

  private switch_of(emitter: Emitter): HTMLElement {
    const t = toggle("", emitter.on !== false, (on) => this.context.event(emitter_event({ ...emitter, on })));
    t.element.querySelector("input")?.setAttribute("aria-label", `${emitter.name} emits`);
    return t.element;
  }

  private show_details(scene: SceneState): void {
    const { chosen } = this.handles;
    const emitter = chosen?.kind === "emitter" ? scene.emitters.find((e) => e.name === chosen.name) : undefined;
    const key = `${chosen?.kind ?? ""} ${chosen?.name ?? ""} ${emitter?.shape ?? ""}`;
    if (key === this.shown_details) return;
    this.shown_details = key;
    if (!emitter) {
      replace(this.details, chosen && this.builder.actions("object", chosen.name), h("p", { class: "hint" }, chosen ? "Drag its handles in the picture." : "Choose one here, or click an emitter in the picture: it gets handles."));
      return;
    }
    const now = (): Emitter => this.context.scene.emitters.find((e) => e.name === emitter.name) ?? emitter;
    const [width, depth] = size_of(emitter);
    const span = extent(scene);
    const set = (fields: Partial<Emitter>): void => this.send(Object.assign(now(), fields));
    const has_size = ["disk", "rectangle", "sphere", "surface"].includes(emitter.shape);
    replace(this.details, this.builder.actions("emitter", emitter.name),
      emitter.shape === "sky" && h("p", { class: "hint" }, "A sky rains on every place alike: it can be turned, not moved."),
      has_size && slider({ label: emitter.shape === "rectangle" ? "Width" : "Diameter", low: 0, high: Math.max(span, width), value: width, unit: "mm", on_input: (v) => set({ size: emitter.shape === "rectangle" ? [v, size_of(now())[1]] : v }) }).element,
      emitter.shape === "rectangle" && slider({ label: "Depth", low: 0, high: Math.max(span, depth), value: depth, unit: "mm", on_input: (v) => set({ size: [size_of(now())[0], v] }) }).element,
      emitter.shape !== "sphere" && slider({ label: "Spread", low: 0, high: 90, step: 0.5, value: emitter.spread_deg ?? 0, unit: "°", hint: "Half angle of the cone", on_input: (v) => set({ spread_deg: v }) }).element,
      slider({ label: "Speed", low: 1, high: 20000, value: emitter.speed ?? 1000, logarithmic: true, unit: "mm/s", on_input: (v) => set({ speed: v }) }).element,
      scene.materials.filter((m) => (emitter.carries?.[m] ?? 0) > 0 || scene.materials.length <= 4).map((m) =>
        slider({ label: `Carries ${m}`, low: 0, high: kMostCarried, step: 0.05, value: emitter.carries?.[m] ?? 0, on_input: (v) => set({ carries: { ...now().carries, [m]: v } }) }).element));
  }
}
