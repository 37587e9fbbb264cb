// Run, step, reset, and how far it is.
import type { Status } from "../types";
import { icon_button, number_text, select } from "../ui/controls";
import { h } from "../ui/dom";
import { icon } from "../ui/icons";

const kRate_ms = 1000;
const kSpeeds: [string, string][] = [["0", "as fast as it can"], ["20", "20 iterations a picture"], ["5", "5 iterations a picture"], ["1", "1 iteration a picture"]];

export class RunBar {
  readonly element: HTMLElement;
  private readonly run: HTMLButtonElement;
  private readonly numbers = { iteration: h("b", {}, "0"), time: h("b", {}, "0"), rate: h("b", {}, "-"), updates: h("b", {}, "-") };
  private readonly state = h("span", { class: "state", role: "status" }, "opening");
  private is_running = false;
  private last = { at: 0, updates: 0 };

  constructor(actions: { run: () => void; step: () => void; reset: () => void; pace: (iterations: number) => void }) {
    this.run = h("button", { type: "button", class: "primary run", title: "Run or pause (Space)", onclick: actions.run }, icon("play"), h("span", {}, "Run"));
    const speed = select("Speed", kSpeeds, "0", (value) => actions.pace(Number(value)));
    speed.element.classList.add("pace");
    const number = (value: HTMLElement, text: string) => h("div", { class: "number" }, value, h("small", {}, text));
    this.element = h("div", { class: "run-bar" }, this.run, icon_button("step", "One step", actions.step, "→"), icon_button("reset", "Back to the start", actions.reset), speed.element, this.state,
      h("div", { class: "spacer" }), number(this.numbers.iteration, "iterations"), number(this.numbers.time, "passed"), number(this.numbers.rate, "iterations/s"), number(this.numbers.updates, "pictures/s"));
  }

  /// @param is_running  Unless it paints: then it is to continue afterwards.
  show(status: Status, is_running: boolean, unit: string, num_updates: number): void {
    if (is_running !== this.is_running) this.run.replaceChildren(icon(is_running ? "pause" : "play"), h("span", {}, is_running ? "Pause" : "Run"));
    this.is_running = is_running;
    this.show_state(status.painting ? "painting" : typeof status.catching_up === "number" ? `again to ${status.catching_up}` : is_running ? "running" : "paused");
    this.numbers.iteration.textContent = String(status.iteration);
    this.numbers.time.textContent = `${number_text(status.time)} ${unit}`;
    this.numbers.rate.textContent = is_running && status.iterations_per_s > 0 ? number_text(status.iterations_per_s) : "-";
    const now = performance.now();
    if (now - this.last.at < kRate_ms) return;
    if (this.last.at > 0) this.numbers.updates.textContent = is_running ? number_text((1000 * (num_updates - this.last.updates)) / (now - this.last.at), 2) : "-";
    this.last = { at: now, updates: num_updates };
  }

  show_state(text: string): void {
    if (this.state.textContent !== text) this.state.textContent = text;  // A page that does not change is not drawn again.
  }
}
