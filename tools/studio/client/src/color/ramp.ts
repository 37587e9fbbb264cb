// Numbers as colors that people with any color vision tell apart: the program's own ramp, a straight line in CIELAB.
import type { Vec3 } from "../types";
import { linear_from_lab, srgb_from_linear } from "./lab";

const kNight: Vec3 = [16, 12, -34], kYellow: Vec3 = [88, -4, 66];

/// Linear color of x in [0, 1].
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
