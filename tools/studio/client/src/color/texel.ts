// The color of one texel of a texture, in words.
import type { Vec3 } from "../types";
import { lab_from_linear, linear_from_srgb } from "./lab";

export function lab_of_codes(r: number, g: number, b: number): Vec3 {
  return lab_from_linear([linear_from_srgb(r / 255), linear_from_srgb(g / 255), linear_from_srgb(b / 255)]);
}

export function color_text(r: number, g: number, b: number): string {
  const [L, a, bb] = lab_of_codes(r, g, b).map((v) => (Math.abs(v) < 0.05 ? "0.0" : v.toFixed(1)));
  return `L* ${L}  a* ${a}  b* ${bb}`.replaceAll("-", "\u2212");
}

export function hex_of(r: number, g: number, b: number): string {
  return `#${[r, g, b].map((c) => Math.round(c).toString(16).padStart(2, "0")).join("")}`;
}

/// RGBA rows, v = 0 at the top.
export function codes_at(texture: { width: number; height: number; bytes: Uint8Array }, uv: { x: number; y: number }): [number, number, number] {
  const at = (share: number, size: number): number => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
  const i = 4 * (at(uv.y, texture.height) * texture.width + at(uv.x, texture.width));
  return [texture.bytes[i]!, texture.bytes[i + 1]!, texture.bytes[i + 2]!];
}
