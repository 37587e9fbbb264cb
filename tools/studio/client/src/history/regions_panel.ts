// Regions that are drawn around parts of the surface: their mean color and the mean of the map that is shown, now and over time, as a table.
import type { Vector3 } from "three";
import { get_texture, type Texture } from "../api";
import { hex_of } from "../color/texel";
import type { Hit } from "../scene/picking";
import type { HistoryPlace } from "../types";
import { chart, type Chart } from "../ui/chart";
import { button, number_text } from "../ui/controls";
import { column_name, download_csv, type Column } from "../ui/csv";
import { h, replace } from "../ui/dom";
import { show_error } from "../ui/notices";
import type { OverlayPanel } from "./overlay_panel";
import { mean_color, numbers_of, texels_at, type MeanColor, type Place } from "./regions";

const kCurveSize = 1024;
const kMostRegions = 12, kNumStyles = 4;

interface Region {
  name: string;
  places: Place[];
  middle: Vector3;
  /// Mean colors at the times of the frames.
  curve?: MeanColor[];
}

export interface RegionsOptions {
  place: HistoryPlace;
  overlay: OverlayPanel;
  texture: () => Texture | undefined;
  /// Draws a line around a region, or no more.
  set_drawing: (is_on: boolean) => void;
  /// Names stand at the middles.
  show_names: (names: { text: string; point: Vector3 }[]) => void;
  on_time: (time: number) => void;
}

export class RegionsPanel {
  readonly element = h("div", { class: "stack" });
  private regions: Region[] = [];
  private is_drawing = false;
  private readonly draw_button = button("Draw a region", () => this.draw(!this.is_drawing), { icon: "fit", hint: "Then drag a line around a part of the surface" });
  private readonly table = h("div", { class: "ledger-box", tabindex: 0, role: "region", "aria-label": "Means of regions" });
  private readonly curves = h("div", {});
  private readonly foot = h("div", { class: "stack" });
  private chart: Chart | undefined;
  private time = 0;

  constructor(private readonly options: RegionsOptions) {
    this.draw_button.setAttribute("aria-pressed", "false");
    this.element.append(this.draw_button, this.table, this.curves, this.foot);
    this.show();
  }

  draw(is_on: boolean): void {
    this.is_drawing = is_on;
    this.draw_button.setAttribute("aria-pressed", String(is_on));
    this.options.set_drawing(is_on);
  }

  add(hits: Hit[]): void {
    const middle = hits[0]!.point.clone().multiplyScalar(0);
    for (const { point } of hits) middle.addScaledVector(point, 1 / hits.length);
    const nearest = hits.reduce((best, hit) => (hit.point.distanceTo(middle) < best.point.distanceTo(middle) ? hit : best));
    if (this.regions.length === kMostRegions) this.regions.shift();
    const used = new Set(this.regions.map((r) => r.name));
    const name = Array.from({ length: kMostRegions + 1 }, (_, i) => String.fromCharCode(65 + i)).find((letter) => !used.has(letter))!;
    this.regions.push({ name, places: hits.map(({ uv }) => ({ x: uv.x, y: uv.y })), middle: nearest.point.clone() });
    this.draw(false);
    this.show();
  }

  /// Another time, map or texture is on screen.
  refresh(time: number): void {
    this.time = time;
    this.chart?.mark(time);
    if (this.regions.length > 0) this.show_table();
  }

  private show(): void {
    this.options.show_names(this.regions.map(({ name, middle }) => ({ text: name, point: middle })));
    this.show_table();
    this.show_curves();
    const has_some = this.regions.length > 0, has_time = this.options.place.times.length > 1;
    replace(this.foot, !has_some && h("p", { class: "hint" }, "Means of color and of the map that is shown."),
      has_some && has_time && button("Curves over time", () => void this.follow_time(), { icon: "history" }), has_some && button("Save as CSV", () => this.save(), { icon: "download" }),
      has_some && button("Remove all", () => { this.regions = []; this.show(); }, { kind: "quiet" }));
  }

  private show_table(): void {
    const texture = this.options.texture(), numbers = this.options.overlay.shown_numbers();
    if (this.regions.length === 0 || !texture) return replace(this.table);
    const unit = numbers?.unit && numbers.unit !== "1" ? numbers.unit : "";
    const rows = this.regions.map((region) => {
      const color = mean_color(texture.bytes, texels_at(region.places, texture));
      const n = numbers && numbers_of(numbers.values, texels_at(region.places, numbers));
      return h("tr", {}, h("th", { scope: "row" }, h("i", { class: "swatch", style: `background:${hex_of(...color.srgb)}` }), region.name), color.lab.map((v) => h("td", {}, v.toFixed(1))), h("td", { title: "Mean CIEDE2000 of its texels to the mean" }, color.scatter.toFixed(1)),
        n && h("td", { title: `standard deviation ${number_text(n.sd)}, from ${number_text(n.least)} to ${number_text(n.most)}, ${n.count} texels` }, `${number_text(n.mean)} \u00b1 ${number_text(n.sd, 2)}`));
    });
    replace(this.table, h("table", { class: "ledger regions" }, h("thead", {}, h("tr", {}, ["", "L*", "a*", "b*", "scatter"].map((text) => h("th", { scope: "col" }, text)), numbers && h("th", { scope: "col" }, column_name(numbers.title, unit)))), h("tbody", {}, rows)));
  }

  // Textures of all frames, smaller than on screen.
  private async follow_time(): Promise<void> {
    const { place } = this.options;
    const curves = this.regions.map((): MeanColor[] => []);
    try {
      for (const time of place.times) {
        const texture = await get_texture({ place: place.place, time, ...(Math.max(place.width, place.height) > kCurveSize ? { size: kCurveSize } : {}) });
        this.regions.forEach((region, i) => curves[i]?.push(mean_color(texture.bytes, texels_at(region.places, texture))));
      }
      this.regions.forEach((region, i) => { if (curves[i]?.length === place.times.length) region.curve = curves[i]!; });
      this.show_curves();
    } catch (error) {
      show_error(error);
    }
  }

  private show_curves(): void {
    const { times, unit } = this.options.place, known = this.regions.filter((r) => r.curve);
    this.chart = undefined;
    if (known.length === 0) return replace(this.curves);
    this.chart = chart(known.map((r, i) => ({ name: `L* of ${r.name}`, x: times, y: r.curve!.map((c) => c.lab[0]), style: `series-${(i % kNumStyles) + 1}` })), { label: "Mean lightness of each region over time", x_label: unit, height: 150, on_x: this.options.on_time });
    this.chart.mark(this.time);
    replace(this.curves, this.chart.element);
  }

  private save(): void {
    const { place } = this.options, texture = this.options.texture(), numbers = this.options.overlay.shown_numbers();
    if (!texture) return;
    const rows = this.regions.flatMap((region) => region.curve ? region.curve.map((color, i) => ({ region, color, time: place.times[i]! })) : [{ region, color: mean_color(texture.bytes, texels_at(region.places, texture)), time: this.time }]);
    const columns: Column[] = [{ name: "region", values: rows.map((r) => r.region.name) }, { name: `time (${place.unit})`, values: rows.map((r) => r.time) },
      ...["L*", "a*", "b*"].map((name, i) => ({ name, values: rows.map((r) => r.color.lab[i as 0 | 1 | 2]) })), { name: "scatter (CIEDE2000)", values: rows.map((r) => r.color.scatter) }];
    if (numbers) {
      const all = rows.map((r) => numbers_of(numbers.values, texels_at(r.region.places, numbers)));
      const name = (what: string): string => column_name(`${numbers.title}, ${what}, at ${number_text(this.time, 4)} ${place.unit}`, numbers.unit);
      columns.push({ name: name("mean"), values: all.map((n) => n.mean) }, { name: name("standard deviation"), values: all.map((n) => n.sd) }, { name: "texels", values: all.map((n) => n.count) });
    }
    download_csv(columns, `${place.name}_regions.csv`);
  }
}
