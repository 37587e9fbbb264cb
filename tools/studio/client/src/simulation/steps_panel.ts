// All that was done, step by step: the last one is undone first, and a click goes to any of them.
import type { SceneState, Step } from "../types";
import { section } from "../ui/controls";
import { h, replace } from "../ui/dom";

export class StepsPanel {
  readonly element: HTMLDetailsElement;
  private readonly list = h("ol", { class: "steps-done", "aria-label": "Steps, the first one at the top" });
  private shown = "";

  /// @param go  Undoes (or redoes) so many.
  constructor(private readonly go: (op: "undo" | "redo", steps: number) => void) {
    this.element = section("Steps", true, this.list);
  }

  show(scene: SceneState): void {
    const { done, undone } = scene.steps ?? { done: [], undone: [] };
    const key = JSON.stringify([done, undone]);
    if (key === this.shown) return;
    this.shown = key;
    if (done.length + undone.length === 0) {
      replace(this.list, h("li", { class: "hint" }, "Nothing yet. Settings, moves, looks, strokes and edits are listed here, and can be undone."));
      return;
    }
    const row = ({ label, iteration }: Step, kind: string, is_now: boolean, on_click: (() => void) | undefined): HTMLElement =>
      h("li", { class: kind }, h("button", { type: "button", class: "quiet", "aria-current": is_now ? "step" : undefined, onclick: on_click, disabled: !on_click }, h("span", {}, label), h("small", {}, `at ${iteration}`)));
    const last = done.length - 1;
    replace(this.list,
      h("li", {}, h("button", { type: "button", class: "quiet", "aria-current": done.length === 0 ? "step" : undefined, disabled: done.length === 0, onclick: () => this.go("undo", done.length) }, h("span", {}, "Before all these"))),
      done.map((step, i) => row(step, "done", i === last, i === last ? undefined : () => this.go("undo", last - i))),
      undone.map((step, i) => row(step, "undone", false, () => this.go("redo", i + 1))));
    const now = this.list.querySelector<HTMLElement>("[aria-current]");
    if (now) this.list.scrollTop = now.offsetTop - this.list.clientHeight / 2;
  }
}

/// What the next undo and redo would do, for their buttons.
export function next_steps(scene: SceneState | undefined): { undo: string; redo: string } {
  const { done, undone } = scene?.steps ?? { done: [], undone: [] };
  return { undo: done[done.length - 1]?.label ?? "", redo: undone[0]?.label ?? "" };
}
