// Numbers as colours that people with any colour vision tell apart: the program's own ramp, a straight line in CIELAB.
import type { Vec3 } from "../types";
import { linear_from_lab, srgb_from_linear } from "./lab";

const kNight: Vec3 = [16, 12, -34], kYellow: Vec3 = [88, -4, 66];

/// Linear colour of x in [0, 1].
export function ramp_color(x: number): Vec3 {
  const t = Math.min(Math.max(x, 0), 1);
  const lab = kNight.map((low, i) => low + t * (kYellow[i]! - low)) as Vec3;
  return linear_from_lab(lab).map((c) => Math.min(Math.max(c, 0), 1)) as Vec3;
}

export function ramp_css(x: number): string {
  return `rgb(${ramp_color(x).map((c) => Math.round(255 * srgb_from_linear(c))).join(" ")})`;
}

/// For a legend: left is low.
export function ramp_gradient(): string {
  return `linear-gradient(to right, ${Array.from({ length: 9 }, (_, i) => ramp_css(i / 8)).join(", ")})`;
}

/// `vec3 ramp_color(float)`; needs kLabShader.
export const kRampShader = /* glsl */ `
vec3 ramp_color(float x) { return clamp(linear_from_lab(mix(vec3(${kNight.map((v) => v.toFixed(1)).join()}), vec3(${kYellow.map((v) => v.toFixed(1)).join()}), clamp(x, 0.0, 1.0))), 0.0, 1.0); }
`;
