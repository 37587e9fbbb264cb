// A control, a map, an amount or the source coordinates as colors over the surface, with what the colors stand for.
import type { Texture as ThreeTexture, WebGLRenderer } from "three";
import { chosen_range, range_of, type MapRange } from "../color/range";
import { plane_legend } from "../color/ramp";
import { coordinate_texture, kOverlay, number_texture, vector_texture, type SurfaceLook } from "../scene/material";
import type { HistoryPlace } from "../types";
import { number_text, select, slider } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { show_error } from "../ui/notices";
import { range_legend, unit_text, vector_legend } from "./legends";
import { is_timed, MapReader, maps_of, part_of, part_ranges, type MapData } from "./map_data";
import { RangeControl } from "./range_control";

const kAsColor = "";

export interface OverlayOptions {
  place: HistoryPlace;
  look: SurfaceLook;
  renderer: WebGLRenderer;
  legend_box: HTMLElement;
  redraw: () => void;
  /// Other numbers are shown.
  on_map: () => void;
}

export class OverlayPanel {
  readonly element: HTMLElement;
  /// What is shown; its numbers are those under the cursor.
  data: MapData | undefined;
  private readonly reader: MapReader;
  private readonly range = new RangeControl(() => this.draw());
  private readonly choice;
  private readonly part = select<string>("Shown", [[kAsColor, "as a color"]], kAsColor, () => this.draw());
  private texture: ThreeTexture | undefined;
  private asked: AbortController | undefined;
  private amount = 1;
  private time = 0;
  private name = "";
  /// Of the last frame too, so that colors mean the same at all times.
  private automatic: { name: string; ranges: MapRange[] } | undefined;

  constructor(private readonly options: OverlayOptions) {
    const { place } = options;
    this.reader = new MapReader(place);
    const maps = maps_of(place);
    this.choice = select("Color by", [["", "nothing"], ...maps], "", (name) => void this.show(name));
    const amount = slider({ label: "Strength", low: 0, high: 1, value: this.amount, unit: "%", factor: 100, on_input: (v) => this.set_amount(v) });
    this.part.element.hidden = this.range.element.hidden = true;
    this.element = h("div", { class: "stack" }, maps.length > 0 ? [this.choice.element, this.part.element, this.range.element, amount.element] : h("p", { class: "hint" }, "It has no controls or maps."));
  }

  /// Shows one of maps_of(); "": none.
  async show(name: string): Promise<void> {
    this.choice.set(name);
    this.asked?.abort();
    if (name !== this.name) {
      this.range.begin();
      this.automatic = undefined;
    }
    this.name = name;
    this.part.element.hidden = this.range.element.hidden = true;
    if (name === "") {
      this.data = undefined;
      this.options.look.uniforms.overlay_amount.value = 0;
      replace(this.options.legend_box);
      this.options.redraw();
      this.options.on_map();
      return;
    }
    await this.load();
  }

  /// Maps of frames follow the time.
  set_time(time: number): void {
    if (time === this.time) return;
    this.time = time;
    if (is_timed(this.name)) void this.load();
  }

  /// The number of a place, as a user reads it; "" without a map.
  value_text(uv: { x: number; y: number }): string {
    const { data } = this;
    if (!data) return "";
    const i = texel_of(uv, data);
    const values = Array.from({ length: data.channels }, (_, c) => data.values[data.channels * i + c]!);
    const unit = data.unit === "amount" ? "" : unit_text(data.unit);
    const what = data.kind === "coordinates" ? (values[0]! < 0 ? "nowhere" : `pixel ${number_text(values[0]!, 4)}, ${number_text(values[1]!, 4)}`)
      : values.every((v) => Number.isFinite(v)) ? `${values.map((v) => number_text(v, 4)).join(", ")}${unit && unit !== "number" ? ` ${unit}` : ""}` : "not known";
    return `${data.name.startsWith("amount:") ? "amount of " : ""}${data.title}: ${what}`;
  }

  /// The numbers that the colors show, and their name.
  shown_numbers(): { values: Float32Array; width: number; height: number; title: string; unit: string } | undefined {
    const { data } = this;
    if (!data || data.kind === "coordinates") return undefined;
    const part = data.channels === 1 ? "" : this.part.get() || "length";
    return { values: data.channels === 1 ? data.values : part_of(data, part), width: data.width, height: data.height, title: data.channels === 1 ? data.title : `${data.title}, ${part}`, unit: data.unit };
  }

  dispose(): void {
    this.asked?.abort();
    this.texture?.dispose();
  }

  private async load(): Promise<void> {
    this.asked?.abort();
    const asked = this.asked = new AbortController();
    const { name } = this;
    try {
      const { times } = this.options.place, last = times[times.length - 1] ?? 0;
      if (is_timed(name) && this.automatic?.name !== name) {
        const end = await this.reader.read(name, last, asked.signal);
        this.automatic = { name, ranges: this.parts(end).map((part) => range_of(part)) };
      }
      const data = await this.reader.read(name, this.time, asked.signal);
      if (asked.signal.aborted) return;
      const is_other = this.data?.name !== name;
      this.data = data;
      if (is_other) this.offer_parts(data);
      this.draw();
    } catch (error) {
      show_error(error);
    }
  }

  // In the order of the choice.
  private parts(data: MapData): Float32Array[] {
    return data.channels === 1 ? [data.values] : data.parts.map((part) => part_of(data, part));
  }

  private offer_parts(data: MapData): void {
    const is_vector = data.channels > 1 && data.kind !== "coordinates";
    const options: [string, string][] = data.parts.map((p) => [p, p]);
    if (data.channels === 3) options.unshift([kAsColor, "as a color"]);
    if (data.kind === "vector" || data.kind === "direction") options.push(["length", "length"]);
    if (is_vector) {
      this.part.set_options(options);
      this.part.set(options[0]![0]);
    }
    this.part.element.hidden = !is_vector;
  }

  private draw(): void {
    const { data } = this, { look, legend_box, redraw, renderer, on_map } = this.options;
    if (!data) return;
    const { uniforms } = look;
    const is_smooth = renderer.extensions.has("OES_texture_float_linear");
    this.texture?.dispose();
    const part = data.channels === 1 ? "" : this.part.get();
    const is_color = data.channels === 3 && part === kAsColor;
    this.range.element.hidden = data.kind === "coordinates" || is_color;
    if (data.kind === "coordinates") {
      this.texture = coordinate_texture(data.width, data.height, normalized(data));
      uniforms.overlay_kind.value = kOverlay.coordinates;
      replace(legend_box, h("div", { class: "legend plane" }, h("b", {}, data.title), plane_legend(84)));
    } else if (is_color) {
      const ranges = data.kind === "direction" ? data.parts.map((name) => ({ name, low: -1, high: 1 })) : data.kind === "color" ? data.parts.map((name) => ({ name, low: 0, high: 1 })) : part_ranges(data);
      this.texture = vector_texture(data.width, data.height, data.kind === "vector" ? spread_out(data, ranges) : data.values, is_smooth);
      uniforms.overlay_kind.value = data.kind === "direction" ? kOverlay.directions : kOverlay.colors;
      replace(legend_box, vector_legend(data.title, unit_text(data.unit), ranges, data.has_unknown));
    } else {
      const values = data.channels === 1 ? data.values : part_of(data, part);
      const index = data.channels === 1 ? 0 : data.parts.indexOf(part);
      const automatic = this.automatic?.name === data.name ? this.automatic.ranges[index] : undefined;
      const range = chosen_range(values, this.range.choice, automatic && wider(automatic, range_of(values)));
      const { is_log } = this.range.choice;
      this.texture = number_texture(data.width, data.height, values, is_smooth);
      uniforms.overlay_kind.value = kOverlay.numbers;
      uniforms.overlay_is_log.value = is_log ? 1 : 0;
      uniforms.overlay_range.value.set(range.low, range.high > range.low ? range.high : range.low + 1);
      this.range.show(range, data.unit);
      replace(legend_box, range_legend({ name: part ? `${data.title}, ${part}` : data.title, unit: unit_text(data.unit), range, is_log, has_unknown: data.has_unknown }));
    }
    uniforms.overlay.value = this.texture;
    this.set_amount(this.amount || 1, true);
    redraw();
    on_map();
  }

  private set_amount(amount: number, is_shown = this.options.look.uniforms.overlay_amount.value > 0): void {
    this.amount = amount;
    this.options.look.uniforms.overlay_amount.value = is_shown ? Math.max(amount, 0.001) : 0;
    this.options.redraw();
  }
}

/// The texel of a place.
export function texel_of(uv: { x: number; y: number }, { width, height }: { width: number; height: number }): number {
  const at = (share: number, size: number): number => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
  return at(uv.y, height) * width + at(uv.x, width);
}

function wider(a: MapRange, b: MapRange): MapRange {
  return { low: Math.min(a.low, b.low), high: Math.max(a.high, b.high), least: Math.min(a.least, b.least), most: Math.max(a.most, b.most) };
}

// Source pixels as shares of the largest; -1 stays: nothing there.
function normalized(map: MapData): Float32Array {
  const out = map.values.slice();
  let most = 1;
  for (const v of out) if (v > most) most = v;
  for (let i = 0; i < out.length; ++i) if (out[i]! >= 0) out[i]! /= most;
  return out;
}

// Each part over its own range.
function spread_out(map: MapData, ranges: { low: number; high: number }[]): Float32Array {
  const out = map.values.slice();
  ranges.forEach(({ low, high }, c) => {
    for (let i = c; i < out.length; i += map.channels) out[i] = high > low ? (out[i]! - low) / (high - low) : 0.5;
  });
  return out;
}
