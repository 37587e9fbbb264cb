// One place of a running scene: all amounts, height and color there now, and since it was chosen, as curves and as a table.
import type * as THREE from "three";
import { hex_of, lab_of_codes } from "../color/texel";
import type { Probe, SceneState } from "../types";
import { chart } from "../ui/chart";
import { button, number_text, section, select } from "../ui/controls";
import { column_name, download_csv, type Column } from "../ui/csv";
import { h, replace, throttle } from "../ui/dom";

const kMostSamples = 2000;
const kDraw_ms = 400;
const kNumStyles = 4;

export class PlacePanel {
  readonly element: HTMLDetailsElement;
  /// Where the mark stands.
  point: THREE.Vector3 | undefined;
  private texel: { x: number; y: number } | undefined;
  private samples: Probe[] = [];
  private what: "amounts" | "color" | "height" = "amounts";
  private waits = false;
  private readonly body = h("div", { class: "stack" });
  private readonly curve = h("div", {});
  private readonly numbers = h("dl", { class: "facts" });
  private readonly draw_soon = throttle(kDraw_ms, () => this.draw());

  /// @param ask  Sends `probe`.
  constructor(private readonly ask: (x: number, y: number) => void, private readonly scene: () => SceneState) {
    this.element = section("Values of a place", false, this.body);
    this.clear();
  }

  clear(): void {
    this.point = this.texel = undefined;
    this.samples = [];
    replace(this.body, h("p", { class: "hint" }, "Click the surface: all amounts, height and color there, and how they change while the scene runs."));
  }

  choose(point: THREE.Vector3, uv: { x: number; y: number }): void {
    const { width, height } = this.scene();
    const at = (share: number, size: number): number => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
    this.point = point;
    this.texel = { x: at(uv.x, width), y: at(uv.y, height) };
    this.samples = [];
    this.element.open = true;
    const what = select("Curve of", [["amounts", "amounts"], ["color", "color"], ["height", "height"]], this.what, (chosen) => {
      this.what = chosen;
      this.draw();
    });
    replace(this.body, h("p", { class: "texel" }, `Texel ${this.texel.x}, ${this.texel.y}`), this.numbers, what.element, this.curve,
      button("Save as CSV", () => this.save(), { icon: "download", hint: "All values since the place was chosen" }), button("Let go", () => { this.clear(); this.on_clear?.(); }));
    this.follow();
  }

  on_clear: (() => void) | undefined;

  /// The scene has changed.
  follow(): void {
    if (!this.texel || this.waits) return;
    this.waits = true;
    this.ask(this.texel.x, this.texel.y);
  }

  show(probe: Probe): void {
    this.waits = false;
    if (!this.texel || probe.x !== this.texel.x || probe.y !== this.texel.y) return;
    const last = this.samples[this.samples.length - 1];
    if (last && last.iteration > probe.iteration) this.samples = this.samples.filter((s) => s.iteration < probe.iteration);  // Back to the start, or undone.
    if (this.samples[this.samples.length - 1]?.iteration === probe.iteration) this.samples.pop();
    this.samples.push(probe);
    if (this.samples.length > kMostSamples) this.samples = this.samples.filter((_, i) => i % 2 === 0);
    this.draw_soon();
  }

  private draw(): void {
    const now = this.samples[this.samples.length - 1];
    if (!now?.amounts || !now.srgb || !this.element.isConnected) return;
    const [L, a, b] = lab_of_codes(...now.srgb);
    const facts: [string, string][] = [...Object.entries(now.amounts).map(([m, v]): [string, string] => [m, number_text(v, 4)]), ["height", `${number_text(now.height_mm ?? 0, 4)} mm`], ["L*  a*  b*", [L, a, b].map((v) => v.toFixed(1)).join("  ")], ["gloss", number_text(now.specular ?? 0, 2)]];
    replace(this.numbers, facts.map(([label, text]) => [h("dt", {}, label), h("dd", {}, text)]).flat());
    const { time_unit } = this.scene(), x = this.samples.map((s) => s.time);
    const line = (name: string, i: number, value: (s: Probe) => number): Parameters<typeof chart>[0][number] => ({ name, x, y: this.samples.map(value), style: `series-${(i % kNumStyles) + 1}` });
    const lines = this.what === "height" ? [line("height, mm", 0, (s) => s.height_mm ?? 0)]
      : this.what === "color" ? ["L*", "a*", "b*"].map((name, i) => line(name, i, (s) => lab_of_codes(...s.srgb!)[i as 0 | 1 | 2]))
        : Object.keys(now.amounts).filter((m) => this.samples.some((s) => (s.amounts?.[m] ?? 0) > 0)).map((m, i) => line(m, i, (s) => s.amounts?.[m] ?? 0));
    if (lines.length === 0 || this.samples.length < 2) replace(this.curve, h("p", { class: "hint" }, lines.length === 0 ? "There is nothing here yet." : "Its curve begins when the scene runs."));
    else replace(this.curve, chart(lines, { label: `${this.what} over time`, x_label: time_unit, height: 150, ...(this.what === "color" ? { strip: { x, css: this.samples.map((s) => hex_of(...s.srgb!)) } } : {}) }).element);
  }

  private save(): void {
    const { samples } = this, { time_unit, name } = this.scene();
    const columns: Column[] = [{ name: "iteration", values: samples.map((s) => s.iteration) }, { name: `time (${time_unit})`, values: samples.map((s) => s.time) },
      ...Object.keys(samples[0]?.amounts ?? {}).map((m) => ({ name: column_name(m, "amount"), values: samples.map((s) => s.amounts?.[m] ?? null) })),
      { name: "height (mm)", values: samples.map((s) => s.height_mm ?? null) }, { name: "specular", values: samples.map((s) => s.specular ?? null) },
      ...["L*", "a*", "b*"].map((n, i) => ({ name: n, values: samples.map((s) => lab_of_codes(...s.srgb!)[i as 0 | 1 | 2]) })), { name: "sRGB", values: samples.map((s) => hex_of(...s.srgb!)) }];
    download_csv(columns, `${name || "scene"}_texel_${this.texel?.x}_${this.texel?.y}.csv`);
  }
}
