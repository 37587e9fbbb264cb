// How the color of a clicked texel changes over time; of a transfer, also where in the source it came from.
import { get_curve, get_place, is_static, thumbnail_url } from "../api";
import type { Curve, HistoryPlace } from "../types";
import { chart, type Chart } from "../ui/chart";
import { number_text } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { show_error } from "../ui/notices";

const kSourceSize = 640;

export class CurvePanel {
  readonly element = h("div", { class: "curve-panel", "aria-live": "polite" });
  private chart: Chart | undefined;
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
    this.chart?.mark(time);
    this.refresh_source();
  }

  private draw(x: number, y: number, curve: Curve): void {
    const css = curve.srgb.map((c) => `rgb(${c.map((v) => Math.round(v)).join(" ")})`);
    const line = (name: string, i: 0 | 1 | 2, style: string) => ({ name, x: curve.times, y: curve.lab.map((c) => c[i]), style });
    this.chart = chart([line("L* lightness", 0, "series-1"), line("a* green to red", 1, "series-2"), line("b* blue to yellow", 2, "series-3")],
      { label: `Color over time of texel ${x}, ${y}`, x_label: this.place.unit, strip: { x: curve.times, css }, on_x: this.on_time, height: 170 });
    this.chart.mark(this.time);
    this.source_image = undefined;
    this.source_place = undefined;
    replace(this.element, h("p", { class: "texel" }, `Texel ${x}, ${y}`, curve.source ? ` comes from pixel ${number_text(curve.source.x, 4)}, ${number_text(curve.source.y, 4)}` : ""), this.chart.element,
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
