// How surfaces are drawn: as `render` does (lighting.ts), with what the studio adds: two times with a wipe, their difference, a map as colors, gloss,
// relief, metal and water from the server's planes, a history's material.
import * as THREE from "three";
import { kLabShader } from "../color/lab";
import { kRampShader } from "../color/ramp";
import { kLightingDeclarations, lighting_main, type Lighting } from "./lighting";
import { kSeamVertex } from "./seams";

export type Comparison = "one" | "wipe" | "difference";
const kComparisons: Comparison[] = ["one", "wipe", "difference"];
/// glTF's metallic-roughness model: base color, occlusion-roughness-metalness, reflectance of what is no metal.
export type MaterialMap = "base" | "orm" | "reflectance";
const kMaterialMaps: MaterialMap[] = ["base", "orm", "reflectance"];

/// Values that the shader reads, shared by all materials of a view.
export class SurfaceLook {
  readonly uniforms = {
    map_b: { value: null as THREE.Texture | null },
    overlay: { value: null as THREE.Texture | null },
    relief: { value: null as THREE.Texture | null },
    comparison: { value: 0 },
    wipe_px: { value: 0 },
    difference_top: { value: 20 },
    overlay_amount: { value: 0 },
    overlay_range: { value: new THREE.Vector2(0, 1) },
    overlay_kind: { value: 0 },
    overlay_is_log: { value: 0 },
    gloss: { value: 0 },
    relief_mm: { value: new THREE.Vector2(0, 0) },
    displacement: { value: 0 },
    normal_amount: { value: 1 },
    material_a: { value: [] as THREE.Texture[] },
    material_b: { value: [] as THREE.Texture[] },
    has_material: { value: [0, 0, 0] },
    /// Of a running scene: metalness, wetness, plants, and the light from all around that does not come.
    substance: { value: null as THREE.Texture | null },
    has_substance: { value: 0 },
  };

  constructor() {
    const gray = new THREE.DataTexture(new Uint8Array([128, 128, 255, 0]), 1, 1);
    gray.needsUpdate = true;
    this.uniforms.map_b.value = this.uniforms.overlay.value = this.uniforms.relief.value = this.uniforms.substance.value = gray;
    this.uniforms.material_a.value = kMaterialMaps.map(() => gray);
    this.uniforms.material_b.value = kMaterialMaps.map(() => gray);
  }

  set_comparison(comparison: Comparison): void {
    this.uniforms.comparison.value = kComparisons.indexOf(comparison);
  }
}

/// @param side  Of the comparison: the time that is shown, or the second one.
export function show_material(look: SurfaceLook, side: "a" | "b", map: MaterialMap, texture: THREE.Texture): void {
  const i = kMaterialMaps.indexOf(map);
  look.uniforms[side === "a" ? "material_a" : "material_b"].value[i] = texture;
  if (side === "a") look.uniforms.has_material.value[i] = 1;
}

const kDeclarations = /* glsl */ `
uniform sampler2D map_b, overlay;
uniform int comparison, overlay_kind, overlay_is_log;
uniform float wipe_px, difference_top, overlay_amount, gloss;
uniform vec2 overlay_range;
${kLabShader}${kRampShader}
float surface_gloss;
`;

// A metal's base color is what it mirrors, not the color that was photographed. Of two times each has its own material.
const kMaterial = /* glsl */ `
uniform sampler2D material_a[3], material_b[3];
uniform int has_material[3];
bool is_second() { return comparison == 1 && gl_FragCoord.x > wipe_px; }
vec3 base_color(vec3 color) { return has_material[0] == 0 ? color : is_second() ? texture2D(material_b[0], vMapUv).rgb : texture2D(material_a[0], vMapUv).rgb; }
vec3 occlusion_roughness_metalness() { return is_second() ? texture2D(material_b[1], vMapUv).rgb : texture2D(material_a[1], vMapUv).rgb; }
vec3 reflectance() { return has_material[2] == 0 ? vec3(0.04) : is_second() ? texture2D(material_b[2], vMapUv).rgb : texture2D(material_a[2], vMapUv).rgb; }
`;

// What `overlay` holds.
export const kOverlay = {
  numbers: 0,      ///< A number and whether it is known.
  coordinates: 1,  ///< Source coordinates in [0, 1] as two colors; below 0: none.
  roots: 2,        ///< Roots of numbers.
  directions: 3,   ///< x, y, z in [-1, 1] as red, green, blue; and whether they are known.
  colors: 4,       ///< Red, green, blue in [0, 1], as codes; and whether they are known.
} as const;

const kOverlayColor = /* glsl */ `
float overlay_share(float v) {
  float low = overlay_range.x, high = overlay_range.y;
  if (overlay_is_log != 0) return log(max(v, 1e-30) / low) / log(high / low);
  if (low < 0.0 && high > 0.0) return v < 0.0 ? 0.5 - 0.5 * v / low : 0.5 + 0.5 * v / high;
  return (v - low) / (high - low);
}
// Stripes stand for what nobody knows.
vec3 unknown_color(vec3 seen) { return mix(seen, mod(gl_FragCoord.x + gl_FragCoord.y, 10.0) < 5.0 ? vec3(0.13) : vec3(0.30), 0.85); }
vec3 overlay_color(vec3 seen, vec4 value) {
  if (overlay_kind == 1) return value.r < 0.0 ? seen : clamp(linear_from_lab(vec3(66.0, 130.0 * (value.xy - 0.5))), 0.0, 1.0);
  if (overlay_kind == 3 || overlay_kind == 4) {
    if (value.a < 0.02) return unknown_color(seen);
    vec3 code = value.rgb / value.a;
    return pow(clamp(overlay_kind == 3 ? 0.5 + 0.5 * code : code, 0.0, 1.0), vec3(2.2));
  }
  if (overlay_kind == 0 && !(value.g >= 0.02)) return unknown_color(seen);
  float share = overlay_share(overlay_kind == 2 ? value.r * value.r : value.r / value.g);
  return overlay_range.x < 0.0 && overlay_range.y > 0.0 ? diverging_color(share) : ramp_color(share);
}
`;

const kColor = /* glsl */ `
vec4 now = texture2D(map, vMapUv);
surface_gloss = now.a;
vec3 seen = now.rgb;
if (comparison == 1 && gl_FragCoord.x > wipe_px) seen = texture2D(map_b, vMapUv).rgb;
#ifdef STANDARD
seen = base_color(seen);
#endif
if (comparison == 2) seen = ramp_color(ciede2000(lab_from_linear(now.rgb), lab_from_linear(texture2D(map_b, vMapUv).rgb)) / difference_top);
if (overlay_amount > 0.0) seen = mix(seen, overlay_color(seen, texture2D(overlay, vMapUv)), overlay_amount);
diffuseColor.rgb *= seen;
#ifdef STANDARD
// Maps are read by their colors: light shapes them, and no more.
as_map = comparison == 2 ? 1.0 : overlay_amount;
totalEmissiveRadiance += 0.6 * as_map * seen;
diffuseColor.rgb *= 1.0 - 0.6 * as_map;
#endif
`;

/// Roughness as exported GLB files have it: what the specular value leaves, mirrors of 8 bit flicker.
const kRoughness = /* glsl */ `
float roughnessFactor = mix(roughness, max(1.0 - surface_gloss, 0.05), gloss);
if (has_material[1] != 0) roughnessFactor = max(occlusion_roughness_metalness().g, 0.05);
roughnessFactor = mix(roughnessFactor, 0.8, as_map);
`;

const kMetalness = /* glsl */ `
vec4 made_of = has_substance == 0 ? vec4(0.0) : texture2D(substance, vMapUv);
if (has_material[1] != 0) made_of.r = occlusion_roughness_metalness().b;
made_of.rg *= 1.0 - as_map;
float metalnessFactor = made_of.r;
`;

const kPlace = /* glsl */ `
  p.normal = normal;
  p.smooth_normal = nonPerturbedNormal;
  p.color = diffuseColor.rgb;
  p.specular = reflectance();
  p.roughness = roughnessFactor;
  p.metalness = metalnessFactor;
  p.wetness = made_of.g;
  p.open = 1.0 - made_of.a;
`;

const kLights = THREE.ShaderChunk.lights_physical_fragment.replace("mix( vec3( 0.04 ), diffuseColor.rgb", "mix( reflectance(), diffuseColor.rgb");

const kReliefNormal = /* glsl */ `
if (normal_amount > 0.0) {
  vec3 bent = texture2D(relief, vMapUv).xyz * 2.0 - 1.0;
  bent.xy *= normal_amount * vec2(1.0, -1.0);
  vec3 q0 = dFdx(-vViewPosition), q1 = dFdy(-vViewPosition);
  vec2 st0 = dFdx(vMapUv), st1 = dFdy(vMapUv);
  vec3 q1perp = cross(q1, normal), q0perp = cross(normal, q0);
  vec3 T = q1perp * st0.x + q0perp * st1.x, B = q1perp * st0.y + q0perp * st1.y;
  float det = max(dot(T, T), dot(B, B));
  float s = det == 0.0 ? 0.0 : inversesqrt(det);
  normal = normalize(T * (bent.x * s) + B * (bent.y * s) + normal * bent.z);
}
`;

function extend(material: THREE.Material, look: SurfaceLook, lighting?: Lighting): void {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, look.uniforms, lighting?.uniforms);
    shader.fragmentShader = shader.fragmentShader.replace("#include <common>", `#include <common>\n${kDeclarations}${kOverlayColor}`).replace("#include <map_fragment>", kColor);
    if (!lighting) return;
    const lights = "#include <lights_physical_fragment>\n\t#include <lights_fragment_begin>\n\t#include <lights_fragment_maps>\n\t#include <lights_fragment_end>";
    shader.fragmentShader = shader.fragmentShader.replace("#include <common>", "#include <common>\nuniform sampler2D relief, substance;\nuniform float normal_amount;\nuniform int has_substance;\nfloat as_map;")
      .replace("#include <roughnessmap_fragment>", kRoughness).replace("#include <metalnessmap_fragment>", kMetalness).replace(lights, lighting_main(kPlace, kLights))
      .replace("void main() {", `${kMaterial}${kLightingDeclarations}\nvoid main() {`).replace("#include <normal_fragment_maps>", kReliefNormal);
    shader.vertexShader = shader.vertexShader.replace("#include <common>", `#include <common>\n${kSeamVertex.declarations}`)
      .replace("#include <displacementmap_vertex>", kSeamVertex.main);
  };
  material.customProgramCacheKey = () => `patinate ${lighting !== undefined}`;
}

/// For meshes: lit. `map` must be set.
export function lit_material(look: SurfaceLook, lighting: Lighting, map: THREE.Texture): THREE.MeshStandardMaterial {
  const material = new THREE.MeshStandardMaterial({ map, roughness: 0.8, metalness: 0, side: THREE.DoubleSide, shadowSide: THREE.DoubleSide });
  extend(material, look, lighting);
  return material;
}

/// For pictures, and for meshes where exact colors are to be read.
export function flat_material(look: SurfaceLook, map: THREE.Texture): THREE.MeshBasicMaterial {
  const material = new THREE.MeshBasicMaterial({ map, side: THREE.DoubleSide, toneMapped: false });
  extend(material, look);
  return material;
}

/// RGBA8 rows, the first at the top (v = 0 in glTF's UVs).
export function color_texture(width: number, height: number, bytes: Uint8Array): THREE.DataTexture {
  const texture = new THREE.DataTexture(bytes, width, height, THREE.RGBAFormat, THREE.UnsignedByteType);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.magFilter = THREE.LinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}

function data_texture(data: Float32Array, width: number, height: number, format: THREE.PixelFormat, is_smooth: boolean): THREE.DataTexture {
  const texture = new THREE.DataTexture(data, width, height, format, THREE.FloatType);
  texture.magFilter = texture.minFilter = is_smooth ? THREE.LinearFilter : THREE.NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

/// For kOverlay.numbers: what is no number is not known. @param is_smooth  The graphics card filters floats, and neighbors have to do with each other.
export function number_texture(width: number, height: number, values: Float32Array, is_smooth: boolean): THREE.DataTexture {
  const both = new Float32Array(2 * width * height);
  for (let i = 0; i < width * height; ++i) {
    const v = values[i]!;
    if (Number.isFinite(v)) [both[2 * i], both[2 * i + 1]] = [v, 1];
  }
  return data_texture(both, width, height, THREE.RGFormat, is_smooth);
}

/// For kOverlay.directions and colors: three floats a texel.
export function vector_texture(width: number, height: number, values: Float32Array, is_smooth: boolean): THREE.DataTexture {
  const all = new Float32Array(4 * width * height);
  for (let i = 0; i < width * height; ++i) {
    if (Number.isFinite(values[3 * i]!)) all.set([values[3 * i]!, values[3 * i + 1]!, values[3 * i + 2]!, 1], 4 * i);
  }
  return data_texture(all, width, height, THREE.RGBAFormat, is_smooth);
}

/// For kOverlay.coordinates: two floats a texel, which have nothing to do with their neighbors'.
export function coordinate_texture(width: number, height: number, values: Float32Array): THREE.DataTexture {
  return data_texture(values, width, height, THREE.RGFormat, false);
}
