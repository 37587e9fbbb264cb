// Rules of aging: how fast each is, its products and reactants, its formula, and rules that come to the scene. Every change is an event of the run.
import type { Builder } from "../build/builder";
import type { Rule, SceneState } from "../types";
import { section, select, slider, type Slider } from "../ui/controls";
import { h, replace, throttle } from "../ui/dom";
import type { SceneContext } from "./context";

const kSend_ms = 80, kCheck_ms = 250;
/// A slider's end, times the value that it shows when it is made: room for both ways.
const kRoom = 4;
const kLeastRate = 0.5, kLeastShare = 1;

interface RuleControls {
  element: HTMLElement;
  /// Whether there is a slider for every product and reactant of the rule; one that it has no longer stays at 0.
  fits(rule: Rule): boolean;
  show(rule: Rule): void;
}

export class RulesPanel {
  readonly element: HTMLDetailsElement;
  private readonly body = h("div", { class: "stack" });
  private controls: RuleControls[] = [];
  private more = "";

  constructor(private readonly context: SceneContext, private readonly builder: Builder) {
    this.element = section("Rules of aging", false, this.body);
  }

  /// After hello: all controls again; `show` keeps those that fit.
  build(scene: SceneState): void {
    this.controls = [];
    this.more = "";
    this.show(scene);
  }

  show(scene: SceneState): void {
    const more = JSON.stringify(scene.more_rules);
    const is_same = this.more === more && this.controls.length === scene.rules.length && scene.rules.every((rule, i) => this.controls[i]!.fits(rule));
    if (!is_same) {
      this.more = more;
      this.controls = scene.rules.map((rule) => this.controls.find((c) => c.fits(rule)) ?? this.make(rule, scene));
      this.fill(scene);
    }
    scene.rules.forEach((rule, i) => this.controls[i]!.show(rule));
  }

  private fill(scene: SceneState): void {
    const begin = select("Begin", [["", "another rule"], ...scene.more_rules.map(({ name }) => [name, name] as [string, string])], "", (name) => {
      if (name) this.context.event({ op: "rule", target: name });
    });
    begin.element.title = "It ages the scene from now on";
    const about = h("dl", { class: "more-rules" }, scene.more_rules.map((r) => [h("dt", {}, r.name), h("dd", {}, r.about)]).flat());
    replace(this.body, scene.rules.length === 0 && h("p", { class: "hint" }, "This scene has no rules yet."), this.controls.map((c) => c.element), this.builder.add_button("rule"), scene.more_rules.length > 0 && [begin.element, about]);
  }

  private make(rule: Rule, scene: SceneState): RuleControls {
    const change = (members: Record<string, unknown>): void => this.context.event({ op: "rule", target: rule.name, ...members });
    const rate = slider({ label: "Rate", low: 0, high: Math.max(kLeastRate, kRoom * rule.rate), value: rule.rate, open: true, unit: `/ ${scene.time_unit}`,
      hint: "Amount made per unit of time where the formula is 1; 0: the rule rests", on_input: throttle(kSend_ms, (v: number) => change({ rate: v })) });
    const current = (): Rule => this.context.scene.rules.find((r) => r.name === rule.name) ?? rule;
    const shares = (side: "products" | "reactants", word: string): [string, Slider][] => Object.entries(rule[side]).map(([material, value]) => [`${side} ${material}`,
      slider({ label: `${word} ${material}`, low: 0, high: Math.max(kLeastShare, kRoom * value), open: true, value, hint: "Amount for each of the rule's extent",
        on_input: throttle(kSend_ms, (v: number) => change({ [side]: { ...current()[side], [material]: v } })) })]);
    const all = [...shares("products", "Product"), ...shares("reactants", "Reactant")];
    const formula = h("input", { type: "text", class: "formula", value: rule.driver, "aria-label": `Formula of ${rule.name}`, spellcheck: "false", title: "Over materials, slope, exposure, accessibility, height, age; Enter takes it" });
    const problem = h("p", { class: "problem", role: "alert" });
    let typed = 0;
    formula.oninput = () => {
      const number = ++typed;
      window.setTimeout(() => {
        if (number !== typed) return;
        void this.builder.formula_problem(rule.name, formula.value).catch((error: Error) => error.message).then((text) => { if (number === typed) problem.textContent = text; });
      }, kCheck_ms);
    };
    formula.onchange = () => change({ driver: formula.value });
    formula.onkeydown = (event) => {
      if (event.key === "Enter") formula.blur();
      if (event.key === "Escape") {
        formula.value = current().driver;
        problem.textContent = "";
        ++typed;
      }
    };
    return {
      element: h("div", { class: "rule" }, h("b", {}, rule.name), rate.element, h("details", {}, h("summary", {}, "Formula and amounts"), h("div", { class: "stack" }, formula, problem, all.map(([, s]) => s.element), this.builder.actions("rule", rule.name)))),
      fits: (now) => now.name === rule.name && (["products", "reactants"] as const).every((side) => Object.keys(now[side]).every((material) => all.some(([key]) => key === `${side} ${material}`))),
      show: (now) => {
        rate.set(now.rate);
        if (document.activeElement !== formula) formula.value = now.driver;
        for (const [key, s] of all) {
          const [side, material] = [key.slice(0, key.indexOf(" ")) as "products" | "reactants", key.slice(key.indexOf(" ") + 1)];
          s.set(now[side][material] ?? 0);
        }
      },
    };
  }
}
