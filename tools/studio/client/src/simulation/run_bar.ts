// Run, step, reset, and how far it is.
import type { Status } from "../types";
import { icon_button, number_text } from "../ui/controls";
import { h } from "../ui/dom";
import { icon } from "../ui/icons";

const kRate_ms = 1000;

export class RunBar {
  readonly element: HTMLElement;
  private readonly run: HTMLButtonElement;
  private readonly numbers = { iteration: h("b", {}, "0"), time: h("b", {}, "0"), rate: h("b", {}, "-"), updates: h("b", {}, "-") };
  private readonly state = h("span", { class: "state", role: "status" }, "opening");
  private last = { at: 0, updates: 0 };

  constructor(actions: { run: () => void; step: () => void; reset: () => void }) {
    this.run = h("button", { type: "button", class: "primary run", title: "Run or pause (Space)", onclick: actions.run }, icon("play"), h("span", {}, "Run"));
    const number = (value: HTMLElement, text: string) => h("div", { class: "number" }, value, h("small", {}, text));
    this.element = h("div", { class: "run-bar" }, this.run, icon_button("step", "One step", actions.step, "→"), icon_button("reset", "Back to the start", actions.reset), this.state,
      h("div", { class: "spacer" }), number(this.numbers.iteration, "iterations"), number(this.numbers.time, "passed"), number(this.numbers.rate, "iterations/s"), number(this.numbers.updates, "pictures/s"));
  }

  show(status: Status, unit: string, num_updates: number): void {
    this.run.replaceChildren(icon(status.running ? "pause" : "play"), h("span", {}, status.running ? "Pause" : "Run"));
    this.state.textContent = status.running ? "running" : "paused";
    this.numbers.iteration.textContent = String(status.iteration);
    this.numbers.time.textContent = `${number_text(status.time)} ${unit}`;
    this.numbers.rate.textContent = status.running ? number_text(status.iterations_per_s) : "-";
    const now = performance.now();
    if (now - this.last.at < kRate_ms) return;
    if (this.last.at > 0) this.numbers.updates.textContent = status.running ? number_text((1000 * (num_updates - this.last.updates)) / (now - this.last.at), 2) : "-";
    this.last = { at: now, updates: num_updates };
  }

  show_lost(): void {
    this.state.textContent = "no connection";
  }
}
