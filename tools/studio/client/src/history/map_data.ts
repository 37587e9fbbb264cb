// A map as numbers in their units: what is not known is no number.
import { get_map, url_of, type FloatMap } from "../api";
import { answer_from } from "../session";
import type { HistoryPlace } from "../types";

export type MapKind = "number" | "direction" | "vector" | "color" | "coordinates";

export interface MapData {
  name: string;
  title: string;
  unit: string;
  kind: MapKind;
  width: number;
  height: number;
  channels: number;
  /// NaN where it is not known.
  values: Float32Array;
  /// Names of the channels.
  parts: string[];
  has_unknown: boolean;
}

const kMapSize = 2048;

/// What can be shown over a surface: [name of the request, what a user reads].
export function maps_of(place: HistoryPlace): [string, string][] {
  const all: [string, string][] = (place.controls ?? []).map((c) => [`control:${c.name}`, c.name]);
  all.push(...(place.amounts ?? []).map((m): [string, string] => [`amount:${m}`, `${m}, amount`]));
  all.push(...(place.frame_maps ?? []).map((m): [string, string] => [`frame:${m}`, `${m} over time`]));
  all.push(...(place.maps ?? []).map((m): [string, string] => [`map:${m}`, m]));
  if (place.kind === "transfer") all.push(["coordinates", "where it comes from"]);
  const session = window.PATINATE_SESSION;  // A saved page holds some of them.
  return session ? all.filter(([name]) => answer_from(session, url_of("/api/map", { place: place.place, name }))) : all;
}

export function is_timed(name: string): boolean {
  return name.startsWith("amount:") || name.startsWith("frame:");
}

function kind_of(name: string, channels: number): MapKind {
  const what = name.slice(name.indexOf(":") + 1);
  if (name === "coordinates") return "coordinates";
  if (channels === 1 || name.startsWith("control:")) return "number";
  return what === "normal" ? "direction" : what === "tint" || what === "stddev" ? "color" : channels === 3 ? "vector" : "number";
}

function parts_of(name: string, channels: number): string[] {
  if (channels === 1) return [""];
  if (channels === 2) return name.endsWith("specular") ? ["strength", "roughness"] : ["x", "y"];
  return /(tint|stddev)$/.test(name) ? ["red", "green", "blue"] : ["x", "y", "z"];
}

/// Unknown are: what the coverage leaves out, what is no number, vectors without a length, and 0 in maps that are constant in time and lie where the surface is.
/// @param is_mesh  What lies outside the charts is no surface. @returns whether any of the surface is not known.
function hide_unknown(map: FloatMap, name: string, coverage: FloatMap | undefined, is_mesh: boolean): boolean {
  const { channels, values } = map, count = map.width * map.height;
  const is_zero_unknown = channels === 3 || name === "map:height" || name === "map:texel_size";
  let has_unknown = false;
  for (let i = 0; i < count; ++i) {
    const is_covered = coverage === undefined || coverage.values[i]! > 0.5;
    let is_known = is_covered, is_zero = true;
    for (let c = 0; c < channels; ++c) {
      const v = values[channels * i + c]!;
      if (!Number.isFinite(v)) is_known = false;
      if (v !== 0) is_zero = false;
    }
    if (is_known && !(is_zero && is_zero_unknown)) continue;
    values.fill(NaN, channels * i, channels * (i + 1));
    has_unknown ||= is_covered || !is_mesh;
  }
  return has_unknown;
}

/// Reads maps of one place; its coverage once.
export class MapReader {
  private coverage: Promise<FloatMap> | undefined;

  constructor(private readonly place: HistoryPlace) {}

  async read(name: string, time: number, signal?: AbortSignal): Promise<MapData> {
    const { place } = this, is_coordinates = name === "coordinates";
    const size = Math.max(place.width, place.height) > kMapSize && !is_coordinates ? kMapSize : undefined;
    const map = await get_map(place.place, name, size, signal, is_timed(name) ? time : undefined);
    const control = place.controls?.find((c) => name === `control:${c.name}`);
    const title = name.slice(name.indexOf(":") + 1);
    const base = { name, title, width: map.width, height: map.height, channels: map.channels, values: map.values, parts: parts_of(name, map.channels), kind: kind_of(name, map.channels) };
    if (is_coordinates) return { ...base, title: "place in the photograph", unit: "px", has_unknown: false };
    const coverage = await this.covered(name, time, size);
    if (control) for (let i = 0; i < map.values.length; ++i) map.values[i] = control.low + map.values[i]! * (control.high - control.low);
    const has_unknown = hide_unknown(map, name, coverage && coverage.width === map.width && coverage.height === map.height ? coverage : undefined, place.mesh === true);
    return { ...base, unit: control?.unit ?? map.unit, has_unknown };
  }

  // Of the whole, and of frames that know of their own where they are the surface's. A saved page holds the maps without either.
  private async covered(name: string, time: number, size: number | undefined): Promise<FloatMap | undefined> {
    const { place, times } = { place: this.place.place, times: this.place.times };
    this.coverage ??= get_map(place, "coverage", size);
    const all = await this.coverage.catch(() => undefined);
    if (!name.startsWith("frame:") || !this.place.frame_masks) return all;
    const nearest = times.reduce((best, t, i) => (Math.abs(t - time) < Math.abs(times[best]! - time) ? i : best), 0);
    return get_map(place, `mask:${nearest}`, size).catch(() => all);
  }
}

/// One number a texel: a part of a vector, or its length.
export function part_of(map: MapData, part: string): Float32Array {
  const { channels, values } = map, out = new Float32Array(map.width * map.height);
  const c = map.parts.indexOf(part);
  for (let i = 0; i < out.length; ++i) {
    if (c >= 0) out[i] = values[channels * i + c]!;
    else out[i] = Math.hypot(values[channels * i]!, values[channels * i + 1] ?? 0, values[channels * i + 2] ?? 0);
  }
  return out;
}

/// Of each part, over all that is known.
export function part_ranges(map: MapData): { name: string; low: number; high: number }[] {
  return map.parts.map((name, c) => {
    let low = Infinity, high = -Infinity;
    for (let i = c; i < map.values.length; i += map.channels) {
      const v = map.values[i]!;
      if (v < low) low = v;
      if (v > high) high = v;
    }
    return low <= high ? { name, low, high } : { name, low: 0, high: 0 };
  });
}
