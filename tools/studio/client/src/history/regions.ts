// Means over parts of a surface.
import { ciede2000, lab_from_linear, linear_from_srgb } from "../color/lab";
import type { Vec3 } from "../types";

/// A place in the unit square of a texture.
export interface Place {
  x: number;
  y: number;
}

export interface Numbers {
  mean: number;
  /// Standard deviation.
  sd: number;
  least: number;
  most: number;
  count: number;
}

const kLinear = Float64Array.from({ length: 256 }, (_, code) => linear_from_srgb(code / 255));

/// Numbers of the texels that are shown at some places, each texel once.
export function texels_at(places: Place[], { width, height }: { width: number; height: number }): number[] {
  const at = (share: number, size: number): number => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
  return [...new Set(places.map(({ x, y }) => at(y, height) * width + at(x, width)))];
}

/// Of what is known of them.
export function numbers_of(values: Float32Array, texels: number[]): Numbers {
  let count = 0, sum = 0, least = Infinity, most = -Infinity;
  for (const t of texels) {
    const v = values[t]!;
    if (!Number.isFinite(v)) continue;
    ++count;
    sum += v;
    if (v < least) least = v;
    if (v > most) most = v;
  }
  if (count === 0) return { mean: NaN, sd: NaN, least: NaN, most: NaN, count };
  const mean = sum / count;
  let squares = 0;
  for (const t of texels) if (Number.isFinite(values[t]!)) squares += (values[t]! - mean) ** 2;
  return { mean, sd: count > 1 ? Math.sqrt(squares / (count - 1)) : 0, least, most, count };
}

export interface MeanColor {
  lab: Vec3;
  srgb: Vec3;
  /// Mean CIEDE2000 of the texels to it.
  scatter: number;
}

/// The light that comes from all of them. @param bytes  RGBA rows.
export function mean_color(bytes: Uint8Array, texels: number[]): MeanColor {
  const linear = (t: number): Vec3 => [kLinear[bytes[4 * t]!]!, kLinear[bytes[4 * t + 1]!]!, kLinear[bytes[4 * t + 2]!]!];
  const sum: Vec3 = [0, 0, 0];
  for (const t of texels) linear(t).forEach((c, i) => { sum[i] = sum[i]! + c; });
  const mean = sum.map((c) => c / texels.length) as Vec3, lab = lab_from_linear(mean);
  const code = (c: number): number => Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
  const scatter = texels.reduce((all, t) => all + ciede2000(lab, lab_from_linear(linear(t))), 0) / texels.length;
  return { lab, srgb: mean.map(code) as Vec3, scatter };
}
