// How the color of a clicked texel changes over time; of a transfer, also where in the source it came from.
import { get_curve, get_place, is_static, thumbnail_url } from "../api";
import type { Curve, HistoryPlace } from "../types";
import { chart, type Chart } from "../ui/chart";
import { hex_of } from "../color/texel";
import { button, number_text } from "../ui/controls";
import { column_name, download_csv, type Column } from "../ui/csv";
import { h, replace } from "../ui/dom";
import { show_error } from "../ui/notices";

const kSourceSize = 640;

/// All that is known of a texel at every time.
function columns_of(curve: Curve, unit: string): Column[] {
  const lab = (name: string, i: 0 | 1 | 2): Column => ({ name, values: curve.lab.map((c) => c[i]) });
  return [{ name: `time (${unit})`, values: curve.times }, lab("L*", 0), lab("a*", 1), lab("b*", 2), { name: "sRGB", values: curve.srgb.map((c) => hex_of(...c)) },
    ...(curve.values ?? []).map((v) => ({ name: column_name(v.name, v.unit), values: v.values })),
    ...(curve.constants ?? []).map((v) => ({ name: column_name(v.name, v.unit), values: curve.times.map(() => v.value) }))];
}

function facts(constants: { name: string; unit: string; value: number }[]): HTMLElement {
  return h("dl", { class: "facts" }, constants.map(({ name, unit, value }) => [h("dt", {}, name), h("dd", {}, `${number_text(value, 4)}${unit && unit !== "1" ? ` ${unit}` : ""}`)]).flat());
}

export class CurvePanel {
  readonly element = h("div", { class: "curve-panel", "aria-live": "polite" });
  private charts: Chart[] = [];
  private source_image: HTMLImageElement | undefined;
  private source_place: HistoryPlace | undefined;
  private source_time: number | undefined;
  private asked: AbortController | undefined;
  private time = 0;

  constructor(private readonly place: HistoryPlace, private readonly on_time: (time: number) => void) {
    const what = place.kind === "transfer" ? "how its color changes, and where in the photographs it comes from" : "how its color changes";
    replace(this.element, h("p", { class: "hint" }, is_static() ? "Curves need a running studio." : `Click a place of the surface to see ${what}.`));
  }

  async show(x: number, y: number): Promise<void> {
    this.asked?.abort();
    this.asked = new AbortController();
    try {
      const curve = await get_curve(this.place.place, x, y, this.asked.signal);
      this.draw(x, y, curve);
      if (curve.source?.place) await this.show_source(curve.source.place, curve.source.x, curve.source.y);
    } catch (error) {
      show_error(error);
    }
  }

  set_time(time: number): void {
    this.time = time;
    for (const one of this.charts) one.mark(time);
    this.refresh_source();
  }

  private draw(x: number, y: number, curve: Curve): void {
    const css = curve.srgb.map((c) => `rgb(${c.map((v) => Math.round(v)).join(" ")})`);
    const line = (name: string, i: 0 | 1 | 2, style: string) => ({ name, x: curve.times, y: curve.lab.map((c) => c[i]), style });
    const unit = this.place.unit;
    this.charts = [chart([line("L* lightness", 0, "series-1"), line("a* green to red", 1, "series-2"), line("b* blue to yellow", 2, "series-3")],
      { label: `Color over time of texel ${x}, ${y}`, x_label: unit, strip: { x: curve.times, css }, on_x: this.on_time, height: 170 })];
    const values = (curve.values ?? []).filter((v) => v.values.some((value) => value !== null && value !== 0));
    for (const one of [...new Set(values.map((v) => v.unit))]) {
      const lines = values.filter((v) => v.unit === one).map((v, i) => ({ name: column_name(v.name, v.unit === "amount" ? "" : v.unit), x: curve.times, y: v.values, style: `series-${(i % 4) + 1}` }));
      this.charts.push(chart(lines, { label: `${one === "amount" ? "Amounts" : lines.map((l) => l.name).join(", ")} over time of texel ${x}, ${y}`, x_label: unit, on_x: this.on_time, height: 130 }));
    }
    for (const one of this.charts) one.mark(this.time);
    this.source_image = undefined;
    this.source_place = undefined;
    replace(this.element, h("p", { class: "texel" }, `Texel ${x}, ${y}`, curve.source ? ` comes from pixel ${number_text(curve.source.x, 4)}, ${number_text(curve.source.y, 4)}` : ""), this.charts.map((c) => c.element),
      curve.constants && curve.constants.length > 0 && facts(curve.constants),
      curve.times.length > 0 && button("Save as CSV", () => download_csv(columns_of(curve, unit), `${this.place.name}_texel_${x}_${y}.csv`), { icon: "download" }),
      curve.source && !curve.source.place && h("p", { class: "hint" }, "The photographs it comes from are not in the served folder."));
  }

  // The source's photograph at the same time, with a mark on the pixel.
  private async show_source(place: string, x: number, y: number): Promise<void> {
    const source = await get_place<HistoryPlace>(place, this.asked?.signal);
    this.source_place = source;
    this.source_time = undefined;
    this.source_image = h("img", { alt: `${source.name}: the photograph that this place of the surface shows` });
    const mark = h("i", { class: "source-mark", style: `left:${(100 * (x + 0.5)) / source.width}%;top:${(100 * (y + 0.5)) / source.height}%` });
    this.element.append(h("figure", { class: "source" }, h("div", { class: "frame" }, this.source_image, mark), h("figcaption", {}, `in ${source.name}`)));
    this.refresh_source();
  }

  // Only at time stamps: photographs, not blends of them.
  private refresh_source(): void {
    const source = this.source_place;
    if (!source || !this.source_image) return;
    const nearest = source.times.reduce((best, t) => (Math.abs(t - this.time) < Math.abs(best - this.time) ? t : best), source.times[0] ?? 0);
    if (nearest === this.source_time) return;
    this.source_time = nearest;
    this.source_image.src = thumbnail_url(source.place, nearest, kSourceSize);
  }
}
