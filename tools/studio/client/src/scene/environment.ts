// Light to look at surfaces in, as `render` has it: radiance from all around, of which mirrors see a blurred picture and what is dull the mean over
// the side that it faces; and one lamp that casts shadows.
import * as THREE from "three";
import type { Vec3 } from "../types";

export interface Lamp {
  /// Radiance of a white surface that faces it.
  color: Vec3;
  height_deg: number;
  around_deg: number;
  half_angle_deg: number;
  /// Mirrors see it in the surroundings already.
  is_around: boolean;
}

export interface LightChoice {
  name: string;
  text: string;
  lamp: Lamp | undefined;
  /// Radiance from a direction (y up), linear.
  around: (way: Vec3) => Vec3;
  /// Where it is even: x + y (up . way) in all channels.
  even?: [number, number];
}

/// Radiance all around, linear RGB: rows from the lowest direction up, columns as three.js has them.
export interface RadianceMap {
  width: number;
  height: number;
  rgb: Float32Array;
}

const kWidth = 256, kHeight = 128;  // Of built-in lights.
const kCosineShare = [1, 2 / 3, 2 / 3, 2 / 3, 0.25, 0.25, 0.25, 0.25, 0.25];  // What a cosine lobe keeps of each band, over pi.
// As in libcommon/output/surroundings.cpp: what is brighter than so many times the mean is a lamp.
const kLampRadiance = 4, kMeanRadiance = 0.6;
const kWidestLamp_deg = 40;  // Lamps that are spread wider cast no shadow that one lamp could stand for.

const mix = (a: Vec3, b: Vec3, t: number): Vec3 => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])];
const color_of = (code: number): Vec3 => new THREE.Color(code).toArray() as Vec3;
const luminance = ([r, g, b]: Vec3): number => 0.2126729 * r + 0.7151522 * g + 0.072175 * b;

/// Unit vector, y up.
function direction(height_deg: number, around_deg: number): Vec3 {
  const [height, around] = [height_deg, around_deg].map((d) => (d * Math.PI) / 180) as [number, number];
  return [Math.cos(height) * Math.sin(around), Math.sin(height), Math.cos(height) * Math.cos(around)];
}

interface Sky {
  zenith: number;
  horizon: number;
  ground: number;
  lamp: { color: number; strength: number; height_deg: number; around_deg: number };
  ambient: number;
  /// Bright panels: [degrees around, height, half width, strength].
  panels: [number, number, number, number][];
}

function sky(name: string, text: string, { zenith, horizon, ground, lamp, ambient, panels }: Sky): LightChoice {
  const [up, side, down, lit] = [zenith, horizon, ground, lamp.color].map(color_of) as [Vec3, Vec3, Vec3, Vec3];
  const boards = panels.map(([around, height, half, strength]) => {
    const way = new THREE.Vector3(...direction(height, around)), right = new THREE.Vector3(0, 1, 0).cross(way).normalize();
    return { way, right, above: way.clone().cross(right), tangent: Math.tan((half * Math.PI) / 180), color: lit.map((c) => c * strength) as Vec3 };
  });
  const at = new THREE.Vector3();
  return {
    name, text,
    lamp: { color: lit.map((c) => (c * lamp.strength) / Math.PI) as Vec3, height_deg: lamp.height_deg, around_deg: lamp.around_deg, half_angle_deg: 2, is_around: panels.length > 0 },
    around: (way) => {
      at.set(...way);
      const board = boards.find((b) => at.dot(b.way) > 0 && Math.max(Math.abs(at.dot(b.right)), Math.abs(at.dot(b.above))) < b.tangent * at.dot(b.way));
      const h = way[1], t = Math.min(1, Math.max(0, -h / 0.12));
      const seen = board ? board.color : h > 0 ? mix(side, up, h ** 0.6) : mix(side, down, t * t * (3 - 2 * t));
      return seen.map((c) => ambient * c) as Vec3;
    },
  };
}

// The defaults of RenderOptions. `render` has its lamp 50 degrees to the left of the camera; here it stays where it is when the camera turns.
const kRender = { light: 0.8, light_elevation_deg: 42, light_size_deg: 7, light_azimuth_deg: -50, azimuth_deg: 30, ambient: 0.42, ambient_gradient: 0.35 };

function studio(): LightChoice {
  const { light, ambient, ambient_gradient: g } = kRender;
  const even: [number, number] = [ambient * (1 - 0.5 * g), ambient * 0.75 * g];
  return {
    name: "studio", text: "Studio, as render has it", even,
    lamp: { color: [light, light, light], height_deg: kRender.light_elevation_deg, around_deg: kRender.azimuth_deg + kRender.light_azimuth_deg, half_angle_deg: kRender.light_size_deg, is_around: false },
    around: ([, up]) => {
      const radiance = Math.max(0, even[0] + even[1] * up);
      return [radiance, radiance, radiance];
    },
  };
}

export const kLights: LightChoice[] = [
  studio(),
  sky("boxes", "Soft boxes", { zenith: 0x8d9094, horizon: 0x7c7f83, ground: 0x6b6661, lamp: { color: 0xfff3e4, strength: 1.7, height_deg: 46, around_deg: 35 }, ambient: 0.8, panels: [[40, 45, 16, 4.5], [-60, 30, 22, 1.8], [165, 38, 14, 3]] }),
  sky("overcast", "Overcast sky", { zenith: 0xe2e8ee, horizon: 0xc2c8cc, ground: 0x77736b, lamp: { color: 0xffffff, strength: 0.7, height_deg: 75, around_deg: 20 }, ambient: 0.95, panels: [] }),
  sky("sun", "Sun", { zenith: 0x5d8fcc, horizon: 0xbfd4e6, ground: 0x59503f, lamp: { color: 0xfff0d2, strength: 2.6, height_deg: 52, around_deg: -40 }, ambient: 0.7, panels: [[-40, 52, 5, 12]] }),
  sky("evening", "Evening", { zenith: 0x2d3f66, horizon: 0xe2955a, ground: 0x2c2522, lamp: { color: 0xffb06a, strength: 2.4, height_deg: 14, around_deg: 60 }, ambient: 0.6, panels: [[60, 12, 7, 12]] }),
  sky("raking", "Raking light (relief)", { zenith: 0x2a2b2d, horizon: 0x242527, ground: 0x18181a, lamp: { color: 0xffffff, strength: 3.6, height_deg: 9, around_deg: 75 }, ambient: 0.5, panels: [[75, 12, 10, 6]] }),
];

export function light_named(name: string): LightChoice {
  return kLights.find((l) => l.name === name) ?? kLights[0]!;
}

/// Unit vector toward a lamp, y up.
export function lamp_direction(lamp: Lamp, turn_deg = 0): THREE.Vector3 {
  return new THREE.Vector3(...direction(lamp.height_deg, lamp.around_deg + turn_deg));
}

/// As three.js's equirectangular pictures have it.
function way_of(x: number, y: number, width: number, height: number): Vec3 {
  const around = 2 * Math.PI * ((x + 0.5) / width - 0.5), up = Math.PI * ((y + 0.5) / height - 0.5);
  return [Math.cos(up) * Math.cos(around), Math.sin(up), Math.cos(up) * Math.sin(around)];
}

function solid_angle(y: number, width: number, height: number): number {
  return ((2 * Math.PI) / width) * (Math.sin(Math.PI * ((y + 1) / height - 0.5)) - Math.sin(Math.PI * (y / height - 0.5)));
}

/// The first nine real spherical harmonics.
function harmonics([x, y, z]: Vec3): number[] {
  return [0.282095, 0.488603 * y, 0.488603 * z, 0.488603 * x, 1.092548 * x * y, 1.092548 * y * z, 0.315392 * (3 * z * z - 1), 1.092548 * x * z, 0.546274 * (x * x - y * y)];
}

/// What a light does to surfaces.
export interface Surroundings {
  map: RadianceMap;
  lamp: Lamp | undefined;
  /// Light of all but the lamp on a white surface: coefficients of spherical harmonics, as in libcommon/output/surroundings.cpp.
  smooth: Vec3[];
  even?: [number, number];
}

/// @param weight  The part of a texel's radiance that counts.
function smooth_light({ width, height, rgb }: RadianceMap, weight: (color: Vec3) => number): Vec3[] {
  const sum = kCosineShare.map((): Vec3 => [0, 0, 0]);
  for (let y = 0; y < height; ++y) {
    const angle = solid_angle(y, width, height);
    for (let x = 0; x < width; ++x) {
      const i = 3 * (y * width + x), color: Vec3 = [rgb[i]!, rgb[i + 1]!, rgb[i + 2]!], share = weight(color) * angle;
      harmonics(way_of(x, y, width, height)).forEach((basis, k) => { for (let c = 0; c < 3; ++c) sum[k]![c]! += kCosineShare[k]! * basis * share * color[c]!; });
    }
  }
  return sum;
}

export function surroundings_of(light: LightChoice): Surroundings {
  const map: RadianceMap = { width: kWidth, height: kHeight, rgb: new Float32Array(3 * kWidth * kHeight) };
  for (let y = 0; y < kHeight; ++y) {
    for (let x = 0; x < kWidth; ++x) map.rgb.set(light.around(way_of(x, y, kWidth, kHeight)), 3 * (y * kWidth + x));
  }
  return { map, lamp: light.lamp, smooth: smooth_light(map, () => 1), ...(light.even ? { even: light.even } : {}) };
}

/// Of a picture: scaled as `render` does, and what is bright in it, if it lies together, as a lamp.
/// @param given  Rows from the top, its middle at -z. @throws Error where it is black
export function surroundings_of_picture(given: RadianceMap): Surroundings {
  const { width, height } = given, map: RadianceMap = { width, height, rgb: new Float32Array(3 * width * height) };
  const quarter = Math.round(width / 4);
  let mean = 0;
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const from = 3 * ((height - 1 - y) * width + ((x + quarter) % width)), color = [0, 1, 2].map((c) => Math.max(0, given.rgb[from + c]!)) as Vec3;
      map.rgb.set(color, 3 * (y * width + x));
      mean += (solid_angle(y, width, height) / (4 * Math.PI)) * luminance(color);
    }
  }
  if (!(mean > 0) || !Number.isFinite(mean)) throw new Error("the picture is black, or brighter than can be summed");
  const factor = kMeanRadiance / mean, limit = kLampRadiance * kMeanRadiance;
  for (let i = 0; i < map.rgb.length; ++i) map.rgb[i]! *= factor;
  const share_of_lamp = (color: Vec3): number => Math.max(0, 1 - limit / Math.max(1e-9, luminance(color)));
  const lamp = lamp_of(map, share_of_lamp);
  return { map, lamp, smooth: smooth_light(map, (color) => (lamp ? 1 - share_of_lamp(color) : 1)) };
}

function lamp_of({ width, height, rgb }: RadianceMap, share: (color: Vec3) => number): Lamp | undefined {
  const light: Vec3 = [0, 0, 0], way = new THREE.Vector3(), at = new THREE.Vector3();
  let total = 0;
  for (let y = 0; y < height; ++y) {
    const angle = solid_angle(y, width, height);
    for (let x = 0; x < width; ++x) {
      const i = 3 * (y * width + x), color: Vec3 = [rgb[i]!, rgb[i + 1]!, rgb[i + 2]!], part = share(color) * angle;
      if (!(part > 0)) continue;
      for (let c = 0; c < 3; ++c) light[c]! += part * color[c]!;
      way.addScaledVector(at.set(...way_of(x, y, width, height)), part * luminance(color));
      total += part * luminance(color);
    }
  }
  if (!(total > 0)) return undefined;
  // Directions even over a cap of this half angle have such a mean.
  const half_angle_deg = (Math.acos(Math.min(1, Math.max(-1, (2 * way.length()) / total - 1))) * 180) / Math.PI;
  if (half_angle_deg > kWidestLamp_deg) return undefined;
  way.normalize();
  const height_deg = (Math.asin(way.y) * 180) / Math.PI, around_deg = (Math.atan2(way.x, way.z) * 180) / Math.PI;
  return { color: light.map((c) => c / Math.PI) as Vec3, height_deg, around_deg, half_angle_deg, is_around: true };
}

/// RGBA, which all graphics cards filter.
export function radiance_texture({ width, height, rgb }: RadianceMap): THREE.DataTexture {
  const data = new Uint16Array(4 * width * height), most = 65504, half = THREE.DataUtils.toHalfFloat;
  for (let i = 0; i < width * height; ++i) {
    for (let c = 0; c < 3; ++c) data[4 * i + c] = half(Math.min(most, rgb[3 * i + c]!));
    data[4 * i + 3] = half(1);
  }
  const texture = new THREE.DataTexture(data, width, height, THREE.RGBAFormat, THREE.HalfFloatType);
  texture.mapping = THREE.EquirectangularReflectionMapping;
  texture.magFilter = texture.minFilter = THREE.LinearFilter;
  texture.wrapS = THREE.RepeatWrapping;
  texture.needsUpdate = true;
  return texture;
}

/// What mirrors see of lights, blurred by roughness; made once each.
export class Environments {
  private readonly made = new Map<string, { surroundings: Surroundings; target: THREE.WebGLRenderTarget; picture: THREE.DataTexture }>();

  constructor(private readonly renderer: THREE.WebGLRenderer) {}

  /// @param name  Of kLights, or of a picture that was added.
  get(name: string): { surroundings: Surroundings; mirror: THREE.Texture; picture: THREE.DataTexture } {
    const { surroundings, target, picture } = this.made.get(name) ?? this.add(name, surroundings_of(light_named(name)));
    return { surroundings, mirror: target.texture, picture };
  }

  add(name: string, surroundings: Surroundings): { surroundings: Surroundings; target: THREE.WebGLRenderTarget; picture: THREE.DataTexture } {
    const generator = new THREE.PMREMGenerator(this.renderer), picture = radiance_texture(surroundings.map);
    const made = { surroundings, target: generator.fromEquirectangular(picture), picture };
    generator.dispose();
    this.forget(name);
    this.made.set(name, made);
    return made;
  }

  dispose(): void {
    for (const name of [...this.made.keys()]) this.forget(name);
  }

  private forget(name: string): void {
    const made = this.made.get(name);
    made?.target.dispose();
    made?.picture.dispose();
    this.made.delete(name);
  }
}
