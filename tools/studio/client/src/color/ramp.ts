// Numbers as colors that people with any color vision tell apart: the program's own ramp, a straight line in CIELAB.
import type { Vec3 } from "../types";
import { linear_from_lab, srgb_from_linear } from "./lab";

const kNight: Vec3 = [16, 12, -34], kYellow: Vec3 = [88, -4, 66];
/// Below 0, at 0 and above it: people with any color vision tell blue from orange, and how far it is from 0 by its lightness.
const kBelow: Vec3 = [30, 14, -52], kZero: Vec3 = [90, 0, 4], kAbove: Vec3 = [36, 44, 44];

/// Linear color of x in [0, 1].
export function ramp_color(x: number): Vec3 {
  const t = Math.min(Math.max(x, 0), 1);
  const lab = kNight.map((low, i) => low + t * (kYellow[i]! - low)) as Vec3;
  return linear_from_lab(lab).map((c) => Math.min(Math.max(c, 0), 1)) as Vec3;
}

/// The same of x in [0, 1] that stands for a number on both sides of 0; 0 is at 0.5.
export function diverging_color(x: number): Vec3 {
  const t = 2 * Math.min(Math.max(x, 0), 1) - 1, end = t < 0 ? kBelow : kAbove;
  const lab = kZero.map((middle, i) => middle + Math.abs(t) * (end[i]! - middle)) as Vec3;
  return linear_from_lab(lab).map((c) => Math.min(Math.max(c, 0), 1)) as Vec3;
}

export function ramp_css(x: number, is_diverging = false): string {
  return `rgb(${(is_diverging ? diverging_color : ramp_color)(x).map((c) => Math.round(255 * srgb_from_linear(c))).join(" ")})`;
}

/// For a legend: left is low.
export function ramp_gradient(is_diverging = false): string {
  return `linear-gradient(to right, ${Array.from({ length: 17 }, (_, i) => ramp_css(i / 16, is_diverging)).join(", ")})`;
}

const glsl = (lab: Vec3): string => `vec3(${lab.map((v) => v.toFixed(1)).join()})`;

/// `vec3 ramp_color(float)`, `vec3 diverging_color(float)`; needs kLabShader.
export const kRampShader = /* glsl */ `
vec3 diverging_color(float x) {
  float t = 2.0 * clamp(x, 0.0, 1.0) - 1.0;
  return clamp(linear_from_lab(mix(${glsl(kZero)}, t < 0.0 ? ${glsl(kBelow)} : ${glsl(kAbove)}, abs(t))), 0.0, 1.0);
}
vec3 ramp_color(float x) { return clamp(linear_from_lab(mix(vec3(${kNight.map((v) => v.toFixed(1)).join()}), vec3(${kYellow.map((v) => v.toFixed(1)).join()}), clamp(x, 0.0, 1.0))), 0.0, 1.0); }
`;

/// Linear color of a place in a picture, x and y in [0, 1]: the plane of CIELAB at one lightness.
export function plane_color(x: number, y: number): Vec3 {
  return linear_from_lab([66, 130 * (x - 0.5), 130 * (y - 0.5)]).map((c) => Math.min(Math.max(c, 0), 1)) as Vec3;
}

/// A square of all these colors.
export function plane_legend(side: number): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = side;
  const context = canvas.getContext("2d");
  const picture = context?.createImageData(side, side);
  if (!context || !picture) return canvas;
  for (let y = 0; y < side; ++y) {
    for (let x = 0; x < side; ++x) {
      const color = plane_color((x + 0.5) / side, (y + 0.5) / side).map((c) => 255 * srgb_from_linear(c));
      picture.data.set([...color, 255], 4 * (y * side + x));
    }
  }
  context.putImageData(picture, 0, 0);
  return canvas;
}
