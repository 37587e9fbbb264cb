// What the colors of a map stand for.
import { ramp_gradient } from "../color/ramp";
import type { MapRange } from "../color/range";
import { number_text } from "../ui/numbers";
import { h } from "../ui/dom";

export function legend(title: string, low: string, high: string, more = ""): HTMLElement {
  return h("div", { class: "legend", role: "img", "aria-label": `${title}: from ${low} (dark) to ${high} (bright)${more && `; ${more}`}` }, h("b", {}, title), h("i", { class: "ramp", style: `background:${ramp_gradient()}` }), h("span", {}, low),
    h("span", {}, high), more && h("small", {}, more));
}

/// As servers write units: "1" is a number of something.
export function unit_text(unit: string | undefined): string {
  return unit === undefined || unit === "" ? "" : unit === "1" ? "number" : unit;
}

export interface NumberLegend {
  name: string;
  unit: string;
  range: MapRange;
  is_log?: boolean;
  /// Some texels are not known: they have stripes.
  has_unknown?: boolean;
}

const unknown = (): HTMLElement => h("small", { class: "unknown" }, h("i", { class: "stripes", "aria-hidden": "true" }), "not known");

/// Of one number a texel.
export function range_legend({ name, unit, range, is_log, has_unknown }: NumberLegend): HTMLElement {
  const { low, high, least, most } = range;
  const title = unit ? `${name} (${unit})` : name;
  if (!(high > low)) {
    const what = most === least && most !== 0 ? `${number_text(most)} everywhere` : "there is nothing yet";
    return h("div", { class: "legend", role: "img", "aria-label": `${title}: ${what}` }, h("b", {}, title), h("small", {}, what), has_unknown && unknown());
  }
  const is_diverging = low < 0 && high > 0 && !is_log;
  const [first, last] = [least < low ? `${number_text(low)} and less` : number_text(low), most > high ? `${number_text(high)} and more` : number_text(high)];
  const beyond = [least < low && low !== 0 ? `the least is ${number_text(least)}` : "", most > high ? `the most is ${number_text(most)}` : ""].filter(Boolean).join(", ");
  const middle = is_diverging ? "0" : is_log ? number_text(Math.sqrt(low * high)) : "";
  return h("div", { class: `legend ${middle ? "three" : ""}`, role: "img", "aria-label": `${title}: from ${first} to ${last}${is_log ? ", logarithmic" : ""}${is_diverging ? "; 0 is light" : ""}${beyond && `; ${beyond}`}` },
    h("b", {}, title), h("i", { class: "ramp", style: `background:${ramp_gradient(is_diverging)}` }), h("span", {}, first), middle && h("span", { class: "middle" }, middle), h("span", { class: "last" }, last),
    (beyond || is_log) && h("small", {}, [is_log ? "logarithmic" : "", beyond].filter(Boolean).join("; ")), has_unknown && unknown());
}

/// Of three numbers a texel, as red, green and blue. @param ranges  What each color stands for.
export function vector_legend(name: string, unit: string, parts: { name: string; low: number; high: number }[], has_unknown: boolean): HTMLElement {
  const colors = ["#d9483b", "#3fa34d", "#3f73d9"];
  return h("div", { class: "legend vector", role: "img", "aria-label": `${name}: ${parts.map((p) => `${p.name} from ${number_text(p.low)} to ${number_text(p.high)} ${unit}`).join(", ")}` }, h("b", {}, unit ? `${name} (${unit})` : name),
    parts.map((p, i) => [h("span", {}, h("i", { class: "dot", style: `background:${colors[i]}` }), p.name), h("span", { class: "last" }, `${number_text(p.low, 4)} to ${number_text(p.high, 4)}`)]).flat(), has_unknown && unknown());
}
