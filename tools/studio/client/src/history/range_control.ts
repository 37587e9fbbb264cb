// What the colors of a map span: automatic, all of it, without outliers, or as typed; in equal steps or equal factors.
import { kAutomatic, type MapRange, type RangeChoice, type RangeMode } from "../color/range";
import { number_field, select } from "../ui/controls";
import { h } from "../ui/dom";

const kModes: [RangeMode, string][] = [["auto", "automatic"], ["all", "all of it"], ["percentile", "without outliers"], ["typed", "as typed"]];

export class RangeControl {
  readonly element: HTMLElement;
  choice: RangeChoice = { ...kAutomatic };
  private readonly mode = select("Colors span", kModes, "auto", (mode) => this.set({ mode }));
  private readonly scale = select<"linear" | "log">("Scale", [["linear", "equal steps"], ["log", "logarithmic"]], "linear", (scale) => this.set({ is_log: scale === "log" }));
  private readonly percent = number_field("Left out at either end", kAutomatic.percent, "%", (v) => this.set({ percent: Math.min(Math.max(v, 0), 49) }));
  private readonly low = number_field("From", 0, "", (v) => this.set({ low: v }));
  private readonly high = number_field("To", 1, "", (v) => this.set({ high: v }));
  private shown: MapRange | undefined;

  constructor(private readonly on_change: () => void) {
    this.element = h("div", { class: "stack" }, this.mode.element, this.percent.element, this.low.element, this.high.element, this.scale.element);
    this.show_fields();
  }

  /// The range that is shown now: what typing begins with.
  show(range: MapRange, unit: string): void {
    this.shown = range;
    for (const field of [this.low, this.high]) field.set_unit(unit);
    // Factors have no place on both sides of 0.
    const can_be_log = range.most > 0 && range.least >= 0;
    this.scale.element.hidden = !can_be_log && !this.choice.is_log;
  }

  /// Another map: its own range, in equal steps.
  begin(): void {
    this.choice = { ...kAutomatic };
    this.mode.set("auto");
    this.scale.set("linear");
    this.show_fields();
  }

  private set(change: Partial<RangeChoice>): void {
    if (change.mode === "typed" && this.choice.mode !== "typed" && this.shown) {
      change = { ...change, low: this.shown.low, high: this.shown.high };
      this.low.set(this.shown.low);
      this.high.set(this.shown.high);
    }
    Object.assign(this.choice, change);
    this.show_fields();
    this.on_change();
  }

  private show_fields(): void {
    this.percent.element.hidden = this.choice.mode !== "percentile";
    this.low.element.hidden = this.high.element.hidden = this.choice.mode !== "typed";
  }
}
