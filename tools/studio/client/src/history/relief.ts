// Normals of a flat history, from its height map or its normal map, as codes that the material reads: x right, y up, z to the viewer.
import type { FloatMap } from "../api";

/// RGBA8 rows: 127.5 + 127.5 n, and 0.
export type NormalCodes = Uint8Array;

function put(codes: NormalCodes, i: number, x: number, y: number, z: number): void {
  const length = Math.hypot(x, y, z) || 1;
  codes[4 * i] = Math.round(127.5 + (127.5 * x) / length);
  codes[4 * i + 1] = Math.round(127.5 + (127.5 * y) / length);
  codes[4 * i + 2] = Math.round(127.5 + (127.5 * z) / length);
}

const kMostSamples = 50000;

/// The middle one of what is known, of some when they are many.
function median(values: Float32Array): number {
  const every = Math.max(1, Math.floor(values.length / kMostSamples));
  const known = values.filter((v, i) => i % every === 0 && !Number.isNaN(v)).sort();
  const half = known.length >> 1;
  return known.length === 0 ? 0 : known.length % 2 === 1 ? known[half]! : (known[half - 1]! + known[half]!) / 2;
}

/// Of heights toward the viewer, over the slope of the whole: a plate that was photographed aslant is level. 0 and what is no number stand
/// for "not known" and lie flat.
/// @param texel  Width of a texel of the map, in the heights' unit.
export function normals_of_heights(map: FloatMap, texel: number): NormalCodes {
  const { width, height, values, channels } = map;
  const at = (x: number, y: number): number | undefined => {
    if (x < 0 || y < 0 || x >= width || y >= height) return undefined;
    const v = values[channels * (y * width + x)]!;
    return v === 0 || !Number.isFinite(v) ? undefined : v;
  };
  /// Rise per length, between what is known of the two neighbors and the texel itself.
  const slope = (before: number | undefined, here: number, after: number | undefined): number => {
    if (before !== undefined && after !== undefined) return (after - before) / (2 * texel);
    if (after !== undefined) return (after - here) / texel;
    return before !== undefined ? (here - before) / texel : 0;
  };
  const [right, down] = [new Float32Array(width * height).fill(NaN), new Float32Array(width * height).fill(NaN)];
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const here = at(x, y);
      if (here === undefined) continue;
      right[y * width + x] = slope(at(x - 1, y), here, at(x + 1, y));
      down[y * width + x] = slope(at(x, y - 1), here, at(x, y + 1));
    }
  }
  const [right_of_all, down_of_all] = [median(right), median(down)];
  const codes: NormalCodes = new Uint8Array(4 * width * height);
  for (let i = 0; i < width * height; ++i) {
    if (Number.isNaN(right[i]!)) put(codes, i, 0, 0, 1);
    else put(codes, i, right_of_all - right[i]!, down[i]! - down_of_all, 1);  // Rows go down, y goes up.
  }
  return codes;
}

/// Of normals as photometric stereo gives them: x right, y up, z to the camera; 0 0 0 lies flat.
export function codes_of_normals(map: FloatMap): NormalCodes {
  const codes: NormalCodes = new Uint8Array(4 * map.width * map.height);
  for (let i = 0; i < map.width * map.height; ++i) {
    const [x, y, z] = [0, 1, 2].map((c) => map.values[map.channels * i + c]!) as [number, number, number];
    const is_known = Math.hypot(x, y, z) > 0.5;
    put(codes, i, is_known ? x : 0, is_known ? y : 0, is_known ? z : 1);
  }
  return codes;
}
