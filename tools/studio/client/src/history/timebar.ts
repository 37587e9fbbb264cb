// The time slider with the real time stamps, and playing.
import { icon_button, slider } from "../ui/controls";
import { h } from "../ui/dom";
import { icon } from "../ui/icons";

const kSlowest_s = 60, kFastest_s = 1, kUsual_s = 12;

export interface TimebarOptions {
  times: number[];
  unit: string;
  /// Only these can be shown (a static session).
  only?: number[] | undefined;
  on_time: (which: "a" | "b", time: number) => void;
}

export class Timebar {
  readonly element: HTMLElement;
  private readonly a: TimeSlider;
  private readonly b: TimeSlider;
  private readonly play_button: HTMLButtonElement;
  private is_playing = false;
  private speed: number;
  private last_frame = 0;

  constructor(private readonly options: TimebarOptions) {
    const { times, unit } = options;
    const span = this.last - this.first || 1;
    this.speed = span / kUsual_s;
    this.a = new TimeSlider("Time", options, (t) => { this.pause(); options.on_time("a", t); });
    this.b = new TimeSlider("Second time", options, (t) => options.on_time("b", t));
    this.b.element.hidden = true;
    this.play_button = h("button", { type: "button", class: "primary round", "aria-label": "Play", title: "Play (Space)", onclick: () => this.toggle() }, icon("play"));
    const speed = slider({ label: "Speed", low: span / kSlowest_s, high: span / kFastest_s, value: this.speed, logarithmic: true, unit: `${unit}/s`, on_input: (v) => { this.speed = v; } });
    const transport = h("div", { class: "transport" }, icon_button("back", "Frame before", () => this.jump(-1), "←"), this.play_button, icon_button("step", "Next frame", () => this.jump(1), "→"));
    speed.element.classList.add("speed");
    if (times.length < 2) transport.hidden = speed.element.hidden = true;
    this.element = h("div", { class: "timebar" }, transport, h("div", { class: "sliders" }, this.a.element, this.b.element), speed.element);
  }

  get first(): number { return this.options.times[0] ?? 0; }
  get last(): number { return this.options.times[this.options.times.length - 1] ?? 0; }
  get time(): number { return this.a.value; }
  get second_time(): number { return this.b.value; }

  set_time(time: number): void {
    this.a.set(time);
    this.options.on_time("a", this.a.value);
  }

  set_second_time(time: number): void {
    this.b.set(time);
    this.options.on_time("b", this.b.value);
  }

  show_second(is_shown: boolean): void {
    this.b.element.hidden = !is_shown;
    this.a.name(is_shown ? "Left time" : "Time");
    this.b.name("Right time");
  }

  /// To the frame before or after.
  jump(by: number): void {
    this.pause();
    const { times } = this.options;
    const now = this.time, slack = 1e-9 * (this.last - this.first);
    const next = by > 0 ? times.find((t) => t > now + slack) : [...times].reverse().find((t) => t < now - slack);
    if (next !== undefined) this.set_time(next);
  }

  toggle(): void {
    if (this.is_playing) this.pause();
    else this.play();
  }

  pause(): void {
    this.is_playing = false;
    this.show_playing();
  }

  private play(): void {
    this.is_playing = true;
    this.show_playing();
    if (this.time >= this.last) this.set_time(this.first);
    this.last_frame = performance.now();
    const frame = (now: number): void => {
      if (!this.is_playing || !this.element.isConnected) return;
      let time = this.time + (this.speed * (now - this.last_frame)) / 1000;
      this.last_frame = now;
      if (time >= this.last) time = this.last;
      this.set_time(time);
      if (time >= this.last) this.pause();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  private show_playing(): void {
    const text = this.is_playing ? "Pause" : "Play";
    this.play_button.setAttribute("aria-label", text);
    this.play_button.title = `${text} (Space)`;
    this.play_button.replaceChildren(icon(this.is_playing ? "pause" : "play"));
  }
}

class TimeSlider {
  readonly element: HTMLElement;
  private readonly label = h("label", {});
  private readonly input = h("input", { type: "range", step: "any" });
  private readonly output = h("output", { class: "value" });

  constructor(name: string, private readonly options: TimebarOptions, on_input: (time: number) => void) {
    const { times } = options;
    const [first, last] = [times[0] ?? 0, times[times.length - 1] ?? 1];
    this.input.min = String(first);
    this.input.max = String(last > first ? last : first + 1);
    this.input.disabled = last === first;
    this.input.id = `time-${Math.random().toString(36).slice(2)}`;
    this.label.htmlFor = this.input.id;
    this.input.addEventListener("input", () => {
      this.set(Number(this.input.value));
      on_input(this.value);
    });
    const ticks = h("div", { class: "ticks", "aria-hidden": "true" }, times.length > 400 ? [] : times.map((t) => h("i", { style: `left:${last > first ? (100 * (t - first)) / (last - first) : 0}%` })));
    this.element = h("div", { class: "time" }, this.label, h("div", { class: "track" }, ticks, this.input), this.output);
    this.name(name);
    this.set(first);
  }

  get value(): number { return Number(this.input.value); }

  name(text: string): void { this.label.textContent = text; }

  set(time: number): void {
    const { only, unit, times } = this.options;
    const shown = only && only.length > 0 ? only.reduce((best, t) => (Math.abs(t - time) < Math.abs(best - time) ? t : best)) : time;
    this.input.value = String(shown);
    const span = (times[times.length - 1] ?? 0) - (times[0] ?? 0);
    const digits = Math.max(0, Math.min(6, 3 - Math.floor(Math.log10(span || 1))));
    const text = `${shown.toFixed(digits).replace(/\.?0+$/, (zeros) => (zeros.startsWith(".") ? "" : zeros))} ${unit}`;
    this.output.textContent = text;
    this.input.setAttribute("aria-valuetext", text);
    this.input.style.setProperty("--share", `${(100 * (shown - Number(this.input.min))) / (Number(this.input.max) - Number(this.input.min))}%`);
  }
}
