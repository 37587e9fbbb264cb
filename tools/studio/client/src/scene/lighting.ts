// How surfaces reflect light, the same as libcommon/output/surface_material.cpp: a diffuse base, a rough mirror and a film of water over both. In
// place of rays: the lamp's shadow map, a blurred picture of the surroundings, ambient visibility that the server has found.
import * as THREE from "three";
import type { Vec3 } from "../types";

const kSide = 32, kSamples = 64;  // Of the table of lobes.
const kLeastCosine = 1e-3, kLeastRoughness = 0.05;
const kGolden = 0.7548776662466927, kGolden2 = 0.5698402909980532;  // A sequence that fills a square evenly [Roberts 2018].

/// What a GGX lobe reflects of light from all around, [scale, bias]: f0 scale + bias, as lobe_energy() in libcommon/output/microfacet.h.
export function lobe_energy(roughness: number, cos_view: number): [number, number] {
  const alpha = roughness * roughness, a2 = alpha * alpha, c = Math.max(kLeastCosine, cos_view), view = [Math.sqrt(1 - c * c), 0, c] as const;
  const masking = (cosine: number): number => (2 * cosine) / (cosine + Math.sqrt(a2 + (1 - a2) * cosine * cosine));
  const g_view = masking(c);
  let scale = 0, bias = 0;
  for (let i = 0; i < kSamples; ++i) {
    // Visible microfacets [Heitz 2018].
    const r = Math.sqrt((kGolden * (i + 0.5)) % 1), phi = 2 * Math.PI * ((kGolden2 * (i + 0.5)) % 1);
    const length = Math.hypot(alpha * view[0], view[2]), sx = (alpha * view[0]) / length, sz = view[2] / length;
    const x = r * Math.cos(phi), half = 0.5 * (1 + sz), y = (1 - half) * Math.sqrt(1 - x * x) + half * r * Math.sin(phi), z = Math.sqrt(Math.max(0, 1 - x * x - y * y));
    // Axes across the stretched view: y of the surface, and what is at right angles to both.
    const cap = [-sz * y + sx * z, x, sx * y + sz * z] as const;
    const h = [alpha * cap[0], alpha * cap[1], Math.max(1e-9, cap[2])], norm = Math.hypot(h[0]!, h[1]!, h[2]!);
    const vh = (view[0] * h[0]! + view[2] * h[2]!) / norm, light = (2 * vh * h[2]!) / norm - view[2];
    if (!(light > 0) || !(vh > 0)) continue;
    const g_light = masking(light), share = g_light / (g_view + g_light - g_view * g_light), grazing = (1 - vh) ** 5;
    scale += ((1 - grazing) * share) / kSamples;
    bias += (grazing * share) / kSamples;
  }
  return [scale, bias];
}

let lobes: THREE.DataTexture | undefined;

function lobe_table(): THREE.DataTexture {
  if (lobes) return lobes;
  const data = new Uint16Array(4 * kSide * kSide), half = THREE.DataUtils.toHalfFloat;
  for (let j = 0; j < kSide; ++j) {
    for (let i = 0; i < kSide; ++i) {
      const [scale, bias] = lobe_energy(Math.max(kLeastRoughness, j / (kSide - 1)), i / (kSide - 1));
      data.set([half(scale), half(bias), 0, half(1)], 4 * (j * kSide + i));
    }
  }
  lobes = new THREE.DataTexture(data, kSide, kSide, THREE.RGBAFormat, THREE.HalfFloatType);
  lobes.magFilter = lobes.minFilter = THREE.LinearFilter;
  lobes.needsUpdate = true;
  return lobes;
}

/// Of a view: what its lit materials share.
export class Lighting {
  readonly uniforms = {
    lobe_table: { value: lobe_table() as THREE.Texture },
    smooth_light: { value: Array.from({ length: 9 }, () => new THREE.Vector3()) },
    /// Radians, half of it; 0: a point.
    lamp_radius: { value: 0 },
    /// Mirrors have to look for it.
    is_lamp_mirrored: { value: 1 },
    /// Surroundings x + y (up . direction), where they are so even: no picture of them is looked up then.
    even_light: { value: new THREE.Vector2() },
    is_even: { value: 0 },
  };

  /// @param even  [x, y] of such surroundings.
  set(smooth: Vec3[], lamp_half_angle_deg: number, is_lamp_mirrored: boolean, even?: [number, number]): void {
    this.uniforms.is_even.value = even ? 1 : 0;
    this.uniforms.even_light.value.set(...(even ?? [0, 0]));
    smooth.forEach((c, k) => this.uniforms.smooth_light.value[k]!.set(...c));
    this.uniforms.lamp_radius.value = Math.tan((lamp_half_angle_deg * Math.PI) / 180);
    this.uniforms.is_lamp_mirrored.value = is_lamp_mirrored ? 1 : 0;
  }
}

export const kLightingDeclarations = /* glsl */ `
#ifdef USE_ENVMAP
uniform sampler2D lobe_table;
uniform vec3 smooth_light[9];
uniform float lamp_radius, is_lamp_mirrored;
uniform vec2 even_light;
uniform int is_even;

const float kWaterF0 = 0.0201, kWaterIndex = 1.33, kFilmRoughness = 0.12, kFilmLevels = 0.7;
const float kWaterInside = 1.0 - (1.0 - 0.066) / (kWaterIndex * kWaterIndex);

struct SurfacePlace { vec3 normal, smooth_normal, color, specular; float roughness, metalness, wetness, open; };

vec2 lobe_energy(float rough, float cosine) { return texture2D(lobe_table, (clamp(vec2(cosine, rough), 0.0, 1.0) * 31.0 + 0.5) / 32.0).rg; }
vec3 compensation(vec3 f0, vec2 energy) { return 1.0 + f0 * (1.0 / (energy.x + energy.y) - 1.0); }
vec3 lobe_reflected(vec3 f0, vec2 energy) { return compensation(f0, energy) * (f0 * energy.x + energy.y); }

// GGX with height-correlated masking, times the cosine, without Fresnel's term. A lamp of some size is a lobe that is wider by half of it.
float lobe_shape(vec3 normal, vec3 view, vec3 light, float rough, out float grazing) {
  float nl = dot(normal, light), nv = max(dot(normal, view), 1e-3);
  vec3 middle = normalize(view + light);
  float rest = 1.0 - clamp(dot(middle, view), 0.0, 1.0), rest2 = rest * rest;
  grazing = rest2 * rest2 * rest;
  if (nl <= 0.0) return 0.0;
  float a2 = rough * rough * rough * rough + 0.25 * lamp_radius * lamp_radius;
  vec3 across = cross(normal, middle);
  float d = a2 + (1.0 - a2) * dot(across, across);
  float g_view = 2.0 * nv / (nv + sqrt(a2 + (1.0 - a2) * nv * nv)), g_light = 2.0 * nl / (nl + sqrt(a2 + (1.0 - a2) * nl * nl));
  return a2 / (PI * d * d) * g_view * g_light / (g_view + g_light - g_view * g_light) / (4.0 * nv);
}

vec3 smooth_light_on(vec3 normal) {
  if (is_even != 0) return vec3(even_light.x + even_light.y * 2.0 / 3.0 * dot(normal, viewMatrix[1].xyz));
  vec3 n = envMapRotation * inverseTransformDirection(normal, viewMatrix);
  vec3 sum = smooth_light[0] * 0.282095 + 0.488603 * (smooth_light[1] * n.y + smooth_light[2] * n.z + smooth_light[3] * n.x);
  sum += 1.092548 * (smooth_light[4] * n.x * n.y + smooth_light[5] * n.y * n.z + smooth_light[7] * n.x * n.z);
  return max(vec3(0.0), sum + smooth_light[6] * 0.315392 * (3.0 * n.z * n.z - 1.0) + smooth_light[8] * 0.546274 * (n.x * n.x - n.y * n.y));
}

vec3 mirrored_light(vec3 view, vec3 normal, float rough) {
  if (is_even == 0) return getIBLRadiance(view, normal, rough);
  return vec3(even_light.x + even_light.y * dot(mix(reflect(-view, normal), normal, rough * rough), viewMatrix[1].xyz));
}

// Reflectance of what is no metal when water is on it in place of air.
vec3 under_water(vec3 f0) {
  vec3 root = sqrt(clamp(f0, 0.0, 0.99)), index = (1.0 + root) / (1.0 - root), ratio = (index - kWaterIndex) / (index + kWaterIndex);
  return ratio * ratio;
}

vec3 facing_viewer(vec3 normal, vec3 view) {
  float lack = 0.02 - dot(normal, view);
  return lack > 0.0 ? normalize(normal + lack * view) : normal;
}

vec3 lit_color(SurfacePlace p, vec3 view) {
  p.normal = facing_viewer(p.normal, view);
  p.smooth_normal = facing_viewer(p.smooth_normal, view);
  float closed = clamp(2.0 * p.wetness - 1.0, 0.0, 1.0), nv = dot(p.normal, view);
  vec2 energy = lobe_energy(p.roughness, nv);
  vec3 film_normal = normalize(mix(p.normal, p.smooth_normal, kFilmLevels * closed)), coat_reflected = vec3(0.0);
  float coat = 0.0;
  if (closed > 0.0) {
    vec2 film = lobe_energy(kFilmRoughness, dot(film_normal, view));
    coat = closed * compensation(vec3(kWaterF0), film).x;
    coat_reflected = closed * lobe_reflected(vec3(kWaterF0), film);
  }
  vec3 through = 1.0 - coat_reflected, below = min(p.color, 1.0);
  vec3 albedo = min(mix(p.color, (1.0 - kWaterInside) * below / (1.0 - kWaterInside * below), p.wetness), 1.0);
  vec3 f0 = mix(p.specular, under_water(p.specular), closed), has_mirror = min(vec3(1.0), f0 / 0.003), tint = below;
  vec3 dull_share = (1.0 - p.metalness) * has_mirror * through * compensation(f0, energy), metal_share = p.metalness * through * compensation(tint, energy);
  vec3 level = dull_share * f0 + metal_share * tint, rise = dull_share * (1.0 - f0) + metal_share * (1.0 - tint);
  vec3 reflected = (1.0 - p.metalness) * has_mirror * through * lobe_reflected(f0, energy) + p.metalness * through * lobe_reflected(tint, energy);
  vec3 dull = (1.0 - p.metalness) * through * albedo * (1.0 - has_mirror * lobe_reflected(f0, energy));

  vec3 around = p.open * smooth_light_on(p.normal), sum = dull * around;
#if NUM_DIR_LIGHTS > 0
  DirectionalLight lamp = directionalLights[0];
  float share = 1.0, grazing;
#if defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 0
  DirectionalLightShadow thrown = directionalLightShadows[0];
  if (receiveShadow) share = getShadow(directionalShadowMap[0], thrown.shadowMapSize, thrown.shadowIntensity, thrown.shadowBias, thrown.shadowRadius, vDirectionalShadowCoord[0]);
#endif
  vec3 seen = dull * max(0.0, dot(p.normal, lamp.direction)) / PI;
  if (is_lamp_mirrored > 0.0) {
    float shape = lobe_shape(p.normal, view, lamp.direction, p.roughness, grazing);
    seen += shape * (level + grazing * rise);
    if (closed > 0.0) {
      shape = lobe_shape(film_normal, view, lamp.direction, kFilmRoughness, grazing);
      seen += coat * shape * (kWaterF0 + grazing * (1.0 - kWaterF0));
    }
  }
  sum += share * lamp.color * seen;
#endif
  // What hides the surroundings from a mirror is taken to look as its own place does.
  vec3 own = (dull + reflected + coat_reflected) * around;
  sum += reflected * mix(own, mirrored_light(view, p.normal, p.roughness), p.open);
  if (closed > 0.0) sum += coat_reflected * mix(own, mirrored_light(view, film_normal, kFilmRoughness), p.open);
  return sum;
}
#endif
`;

/// In place of three.js's lights, where there are surroundings: flat pictures have none. @param place  GLSL that fills a SurfacePlace `p`.
export function lighting_main(place: string, lights: string): string {
  return /* glsl */ `
#ifdef USE_ENVMAP
  SurfacePlace p;
  ${place}
  reflectedLight.directDiffuse = lit_color(p, normalize(vViewPosition));
#else
  ${lights}
  #include <lights_fragment_begin>
  #include <lights_fragment_maps>
  #include <lights_fragment_end>
#endif
`;
}
