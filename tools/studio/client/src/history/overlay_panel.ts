// A control, map or the source coordinates as colors over the surface, with what the colors stand for.
import type { Texture as ThreeTexture } from "three";
import { range_of } from "../color/range";
import { get_map, type FloatMap } from "../api";
import { plane_legend, ramp_gradient } from "../color/ramp";
import { float_texture, type SurfaceLook } from "../scene/material";
import type { HistoryPlace } from "../types";
import { number_text, select, slider } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { show_error } from "../ui/notices";

const kMapSize = 2048;

export function legend(title: string, low: string, high: string, more = ""): HTMLElement {
  return h("div", { class: "legend", role: "img", "aria-label": `${title}: from ${low} (dark) to ${high} (bright)${more && `; ${more}`}` }, h("b", {}, title), h("i", { class: "ramp", style: `background:${ramp_gradient()}` }), h("span", {}, low),
    h("span", {}, high), more && h("small", {}, more));
}

/// As servers write units: "1" is a number of something.
export function unit_text(unit: string | undefined): string {
  return unit === undefined || unit === "" ? "" : unit === "1" ? "number" : unit;
}

/// @param most  The largest of all, which may lie above the range.
export function range_legend(name: string, unit: string, low: number, high: number, most: number): HTMLElement {
  const title = unit ? `${name} (${unit})` : name;
  if (!(high > low)) return h("div", { class: "legend", role: "img", "aria-label": `${title}: there is nothing yet` }, h("b", {}, title), h("small", {}, "there is nothing yet"));
  return legend(title, low === 0 ? "0" : `${number_text(low)} and less`, most > high ? `${number_text(high)} and more` : number_text(high), most > high ? `the most is ${number_text(most)}` : "");
}

export class OverlayPanel {
  readonly element: HTMLElement;
  private texture: ThreeTexture | undefined;
  private asked: AbortController | undefined;
  private amount = 1;

  constructor(private readonly place: HistoryPlace, private readonly look: SurfaceLook, private readonly legend_box: HTMLElement, private readonly redraw: () => void) {
    const options: [string, string][] = [["", "nothing"], ...(place.controls ?? []).map((c) => [`control:${c.name}`, c.name] as [string, string]),
      ...(place.maps ?? []).map((m) => [`map:${m}`, m] as [string, string])];
    if (place.kind === "transfer") options.push(["coordinates", "where it comes from"]);
    const choice = select("Color by", options, "", (name) => void this.show(name));
    const amount = slider({ label: "Strength", low: 0, high: 1, value: this.amount, text: (v) => `${Math.round(100 * v)} %`, on_input: (v) => this.set_amount(v) });
    this.element = h("div", {}, options.length > 1 ? [choice.element, amount.element] : h("p", { class: "hint" }, "It has no controls or maps."));
  }

  async show(name: string): Promise<void> {
    this.asked?.abort();
    if (name === "") {
      this.look.uniforms.overlay_amount.value = 0;
      replace(this.legend_box);
      this.redraw();
      return;
    }
    this.asked = new AbortController();
    try {
      const is_coordinates = name === "coordinates";
      const size = Math.max(this.place.width, this.place.height) > kMapSize && !is_coordinates ? kMapSize : undefined;
      const map = await get_map(this.place.place, name, size, this.asked.signal);
      if (is_coordinates) this.normalize(map);
      this.texture?.dispose();
      this.texture = float_texture(map.width, map.height, map.channels, map.values, !is_coordinates);
      const control = this.place.controls?.find((c) => name === `control:${c.name}`);
      const { low, high, most } = range_of(map.values);
      this.look.uniforms.overlay.value = this.texture;
      this.look.uniforms.overlay_range.value.set(low, high);
      this.look.uniforms.overlay_kind.value = is_coordinates ? 1 : 0;
      this.set_amount(this.amount || 1, true);
      // A control's map runs from 0 to 1; what they stand for is said beside it.
      const real = (share: number): number => (control ? control.low + share * (control.high - control.low) : share);
      replace(this.legend_box, is_coordinates ? h("div", { class: "legend plane" }, h("b", {}, "place in the photograph"), plane_legend(84))
        : range_legend(control?.name ?? name.replace(/^map:/, ""), unit_text(control?.unit), real(low), real(high), real(most)));
      this.redraw();
    } catch (error) {
      show_error(error);
    }
  }

  private set_amount(amount: number, is_shown = this.look.uniforms.overlay_amount.value > 0): void {
    this.amount = amount;
    this.look.uniforms.overlay_amount.value = is_shown ? Math.max(amount, 0.001) : 0;
    this.redraw();
  }

  // Source pixels as shares of the largest; -1 stays: nothing there.
  private normalize(map: FloatMap): void {
    let most = 1;
    for (const v of map.values) if (v > most) most = v;
    for (let i = 0; i < map.values.length; ++i) if (map.values[i]! >= 0) map.values[i]! /= most;
  }
}
