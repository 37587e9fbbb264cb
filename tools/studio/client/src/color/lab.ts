// CIELAB under D65 and the CIEDE2000 difference [Sharma, Wu, Dalal 2005], as the program counts them; and the same in GLSL.
import type { Vec3 } from "../types";

const kWhite: Vec3 = [0.950489, 1.0, 1.08884];

export function linear_from_srgb(code: number): number {
  return code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4;
}

export function srgb_from_linear(x: number): number {
  return x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
}

const kDelta = 6 / 29;
const forward = (t: number): number => (t > kDelta ** 3 ? Math.cbrt(t) : t / (3 * kDelta * kDelta) + 4 / 29);
const backward = (f: number): number => (f > kDelta ? f ** 3 : 3 * kDelta * kDelta * (f - 4 / 29));

export function lab_from_linear([r, g, b]: Vec3): Vec3 {
  const x = forward((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / kWhite[0]);
  const y = forward(0.2126729 * r + 0.7151522 * g + 0.072175 * b);
  const z = forward((0.0193339 * r + 0.119192 * g + 0.9503041 * b) / kWhite[2]);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

export function linear_from_lab([L, a, b]: Vec3): Vec3 {
  const f = (L + 16) / 116;
  const [x, y, z] = [kWhite[0] * backward(f + a / 500), backward(f), kWhite[2] * backward(f - b / 200)];
  return [3.2404542 * x - 1.5371385 * y - 0.4985314 * z, -0.969266 * x + 1.8760108 * y + 0.041556 * z, 0.0556434 * x - 0.2040259 * y + 1.0572252 * z];
}

const deg = Math.PI / 180;
const hue = (a: number, b: number): number => (a === 0 && b === 0 ? 0 : (Math.atan2(b, a) / deg + 360) % 360);

export function ciede2000([L1, a1, b1]: Vec3, [L2, a2, b2]: Vec3): number {
  const c7 = ((Math.hypot(a1, b1) + Math.hypot(a2, b2)) / 2) ** 7;
  const g = 0.5 * (1 - Math.sqrt(c7 / (c7 + 25 ** 7)));
  const [p1, p2] = [(1 + g) * a1, (1 + g) * a2];
  const [C1, C2] = [Math.hypot(p1, b1), Math.hypot(p2, b2)];
  const [h1, h2] = [hue(p1, b1), hue(p2, b2)];
  let dh = C1 * C2 === 0 ? 0 : h2 - h1;
  if (dh > 180) dh -= 360;
  else if (dh < -180) dh += 360;
  const dH = 2 * Math.sqrt(C1 * C2) * Math.sin((dh / 2) * deg);
  const L = (L1 + L2) / 2, C = (C1 + C2) / 2;
  let H = h1 + h2;
  if (C1 * C2 !== 0) H = Math.abs(h1 - h2) <= 180 ? H / 2 : H < 360 ? (H + 360) / 2 : (H - 360) / 2;
  const T = 1 - 0.17 * Math.cos((H - 30) * deg) + 0.24 * Math.cos(2 * H * deg) + 0.32 * Math.cos((3 * H + 6) * deg) - 0.2 * Math.cos((4 * H - 63) * deg);
  const SL = 1 + (0.015 * (L - 50) ** 2) / Math.sqrt(20 + (L - 50) ** 2), SC = 1 + 0.045 * C, SH = 1 + 0.015 * C * T;
  const RT = -2 * Math.sqrt(C ** 7 / (C ** 7 + 25 ** 7)) * Math.sin(60 * Math.exp(-(((H - 275) / 25) ** 2)) * deg);
  const [l, c, k] = [(L2 - L1) / SL, (C2 - C1) / SC, dH / SH];
  return Math.sqrt(l * l + c * c + k * k + RT * c * k);
}

/// `vec3 lab_from_linear(vec3)`, `vec3 linear_from_lab(vec3)`, `float ciede2000(vec3, vec3)`.
export const kLabShader = /* glsl */ `
vec3 lab_f(vec3 t) { return mix(t * 7.787037 + 0.137931, pow(max(t, 0.0), vec3(1.0 / 3.0)), step(0.008856452, t)); }
vec3 lab_g(vec3 f) { return mix(0.1284185 * (f - 0.137931), f * f * f, step(0.2068966, f)); }
vec3 lab_from_linear(vec3 c) {
  vec3 f = lab_f(vec3(dot(c, vec3(0.4124564, 0.3575761, 0.1804375)) / 0.950489, dot(c, vec3(0.2126729, 0.7151522, 0.072175)), dot(c, vec3(0.0193339, 0.119192, 0.9503041)) / 1.08884));
  return vec3(116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z));
}
vec3 linear_from_lab(vec3 lab) {
  float f = (lab.x + 16.0) / 116.0;
  vec3 c = lab_g(vec3(f + lab.y / 500.0, f, f - lab.z / 200.0)) * vec3(0.950489, 1.0, 1.08884);
  return vec3(dot(c, vec3(3.2404542, -1.5371385, -0.4985314)), dot(c, vec3(-0.969266, 1.8760108, 0.041556)), dot(c, vec3(0.0556434, -0.2040259, 1.0572252)));
}
float hue_deg(float a, float b) { return a == 0.0 && b == 0.0 ? 0.0 : mod(degrees(atan(b, a)) + 360.0, 360.0); }
float ciede2000(vec3 x, vec3 y) {
  float c1 = length(x.yz), c2 = length(y.yz);
  float m = (c1 + c2) / 50.0, m7 = m * m * m * m * m * m * m;
  float g = 0.5 * (1.0 - sqrt(m7 / (m7 + 1.0)));
  float p1 = (1.0 + g) * x.y, p2 = (1.0 + g) * y.y;
  c1 = length(vec2(p1, x.z)); c2 = length(vec2(p2, y.z));
  float h1 = hue_deg(p1, x.z), h2 = hue_deg(p2, y.z);
  float dh = c1 * c2 == 0.0 ? 0.0 : h2 - h1;
  if (dh > 180.0) dh -= 360.0; else if (dh < -180.0) dh += 360.0;
  float dH = 2.0 * sqrt(c1 * c2) * sin(radians(dh / 2.0));
  float L = (x.x + y.x) / 2.0, C = (c1 + c2) / 2.0, H = h1 + h2;
  if (c1 * c2 != 0.0) H = abs(h1 - h2) <= 180.0 ? H / 2.0 : (H < 360.0 ? (H + 360.0) / 2.0 : (H - 360.0) / 2.0);
  float T = 1.0 - 0.17 * cos(radians(H - 30.0)) + 0.24 * cos(radians(2.0 * H)) + 0.32 * cos(radians(3.0 * H + 6.0)) - 0.2 * cos(radians(4.0 * H - 63.0));
  float q = (L - 50.0) * (L - 50.0);
  float SL = 1.0 + 0.015 * q / sqrt(20.0 + q), SC = 1.0 + 0.045 * C, SH = 1.0 + 0.015 * C * T;
  float n = C / 25.0, n7 = n * n * n * n * n * n * n, e = (H - 275.0) / 25.0;
  float RT = -2.0 * sqrt(n7 / (n7 + 1.0)) * sin(radians(60.0 * exp(-e * e)));
  float l = (y.x - x.x) / SL, c = (c2 - c1) / SC, k = dH / SH;
  return sqrt(max(0.0, l * l + c * c + k * k + RT * c * k));
}
`;
