// Small plants where much has grown [Guenther et al. 2012, sec. 4.5], at the places where `render` has them: shown once there is enough, and taller as
// it grows. libcommon/output/plantlets.cpp says where they stand; here are their leaves.
import * as THREE from "three";
import { kLightingDeclarations, lighting_main, type Lighting } from "../scene/lighting";
import type { TilePlane } from "../scene/texture_tiles";

const kNumLeaves = 6, kRow = 17;
const kSeedling = 0.35, kGrowth = 0.25;  // A plant comes with this share of its height, and grows while the amount rises by that.
const kShades = [0.45, 0.85, 0.85, 1.15];  // Root, left, right and tip of a leaf.
// How leaves stand, in heights of the plant: shoots, tufts, rosettes.
const kForms = [{ lean: 0.16, more: 0.3, half: 0.06, tip: 1 }, { lean: 0.35, more: 0.25, half: 0.14, tip: 0.9 }, { lean: 0.7, more: 0.3, half: 0.17, tip: 0.5 }];

// Leaves around a stem, along +z.
function plant(form: (typeof kForms)[number]): THREE.BufferGeometry {
  const points: number[] = [], shades: number[] = [], corners: number[] = [];
  for (let i = 0; i < kNumLeaves; ++i) {
    const angle = (2 * Math.PI * i) / kNumLeaves, lean = form.lean + form.more * ((i * 7) % 3) / 2;
    const [c, s] = [Math.cos(angle), Math.sin(angle)], first = 4 * i;
    const at = (r: number, side: number, z: number): number[] => [r * c - side * s, r * s + side * c, z];
    points.push(...at(0, 0, 0), ...at(lean * 0.5, -form.half, 0.55 * form.tip), ...at(lean * 0.5, form.half, 0.55 * form.tip), ...at(lean, 0, form.tip));
    shades.push(...kShades);
    corners.push(first, first + 1, first + 2, first + 1, first + 3, first + 2);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(points.map((_, i) => (i % 3 === 2 ? 1 : 0))), 3));  // Shadows are looked up along it.
  geometry.setAttribute("shade", new THREE.BufferAttribute(new Float32Array(shades), 1));
  geometry.setIndex(corners);
  return geometry;
}

// Their color is half their own, half that of what they grow on.
function leaf_material(lighting: Lighting, ground: { value: THREE.Texture }): THREE.MeshStandardMaterial {
  const material = new THREE.MeshStandardMaterial({ side: THREE.DoubleSide, flatShading: true, roughness: 0.7 });
  const place = "p.normal = p.smooth_normal = normal; p.color = v_leaf; p.specular = vec3(0.04); p.roughness = roughnessFactor; p.metalness = p.wetness = 0.0; p.open = 1.0;";
  const lights = "#include <lights_physical_fragment>\n\t#include <lights_fragment_begin>\n\t#include <lights_fragment_maps>\n\t#include <lights_fragment_end>";
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, lighting.uniforms, { ground });
    shader.vertexShader = shader.vertexShader.replace("#include <common>", `#include <common>\nattribute float shade;\nattribute vec4 own;\nattribute vec2 place;\nuniform sampler2D ground;\nvarying vec3 v_leaf;`)
      .replace("#include <begin_vertex>", `#include <begin_vertex>\nv_leaf = shade * (own.rgb + own.a * texture2D(ground, place).rgb);`);
    shader.fragmentShader = shader.fragmentShader.replace("#include <common>", "#include <common>\nvarying vec3 v_leaf;").replace("void main() {", `${kLightingDeclarations}\nvoid main() {`).replace(lights, lighting_main(place, lights));
  };
  material.customProgramCacheKey = () => "patinate leaves";
  return material;
}

interface Field {
  instances: THREE.InstancedMesh;
  /// Of every place: its matrix when full-grown.
  matrices: Float32Array;
  own: Float32Array;
  places: Float32Array;
  thresholds: Float32Array;
}

export class Plantlets {
  private readonly fields: Field[] = [];
  private readonly geometries = kForms.map(plant);
  private readonly material: THREE.Material;
  num_shown = 0;

  /// @param rows  The server's places, in the scene's axes, mm. @param parts  Objects, by the numbers in them; what has none is left out.
  constructor(rows: Float32Array, parts: (THREE.Object3D | undefined)[], lighting: Lighting, ground: THREE.Texture) {
    this.material = leaf_material(lighting, { value: ground });
    parts.forEach((part, number) => {
      if (!part) return;
      part.updateWorldMatrix(true, false);
      const to_part = part.matrixWorld.clone().invert();
      this.geometries.forEach((geometry, kind) => {
        const found: number[] = [];
        for (let i = 0; i < rows.length; i += kRow) if (rows[i] === number && rows[i + 1] === kind) found.push(i);
        if (found.length > 0) this.add(part, geometry, rows, found, to_part);
      });
    });
  }

  /// @param substance  Its third byte is the amount of what they grow of; nothing: no plants.
  update(substance: TilePlane | undefined): void {
    this.num_shown = 0;
    for (const { instances, matrices, own, places, thresholds } of this.fields) {
      const to = instances.instanceMatrix.array as Float32Array, colors = instances.geometry.getAttribute("own").array as Float32Array, uvs = instances.geometry.getAttribute("place").array as Float32Array;
      let count = 0;
      for (let i = 0; substance && i < thresholds.length; ++i) {
        const x = Math.min(substance.width - 1, Math.floor(places[2 * i]! * substance.width)), y = Math.min(substance.height - 1, Math.floor(places[2 * i + 1]! * substance.height));
        const over = substance.data[4 * (y * substance.width + x) + 2]! / 255 - thresholds[i]!;
        if (over < 0) continue;
        const height = kSeedling + (1 - kSeedling) * Math.min(1, over / kGrowth);
        for (let k = 0; k < 12; ++k) to[16 * count + k] = height * matrices[16 * i + k]!;
        for (let k = 12; k < 16; ++k) to[16 * count + k] = matrices[16 * i + k]!;
        for (let k = 0; k < 4; ++k) colors[4 * count + k] = own[4 * i + k]!;
        for (let k = 0; k < 2; ++k) uvs[2 * count + k] = places[2 * i + k]!;
        ++count;
      }
      instances.count = count;
      instances.instanceMatrix.needsUpdate = true;
      for (const name of ["own", "place"]) (instances.geometry.getAttribute(name) as THREE.InstancedBufferAttribute).needsUpdate = true;
      this.num_shown += count;
    }
  }

  dispose(): void {
    for (const { instances } of this.fields) {
      instances.removeFromParent();
      instances.geometry.dispose();
      instances.dispose();
    }
    for (const geometry of this.geometries) geometry.dispose();
    this.material.dispose();
  }

  private add(part: THREE.Object3D, shape: THREE.BufferGeometry, rows: Float32Array, found: number[], to_part: THREE.Matrix4): void {
    const n = found.length, geometry = shape.clone();
    const field: Field = { instances: new THREE.InstancedMesh(geometry, this.material, n), matrices: new Float32Array(16 * n), own: new Float32Array(4 * n), places: new Float32Array(2 * n), thresholds: new Float32Array(n) };
    const matrix = new THREE.Matrix4(), up = new THREE.Vector3(), a = new THREE.Vector3(), b = new THREE.Vector3(), x = new THREE.Vector3(), y = new THREE.Vector3();
    found.forEach((at, i) => {
      const [rx, ry, rz, ux, uy, uz, u, v, size, turn, threshold, below, red, green, blue] = rows.subarray(at + 2, at + kRow) as unknown as number[];
      up.set(ux!, uy!, uz!);
      // As tangents() of libcommon/output/sampling.h has them.
      const sign = up.z < 0 ? -1 : 1, p = -1 / (sign + up.z), q = up.x * up.y * p;
      a.set(1 + sign * up.x * up.x * p, sign * q, -sign * up.x);
      b.set(q, sign + up.y * up.y * p, -up.y);
      const c = Math.cos(turn!), s = Math.sin(turn!);
      x.copy(a).multiplyScalar(c).addScaledVector(b, s).multiplyScalar(size!);
      y.copy(b).multiplyScalar(c).addScaledVector(a, -s).multiplyScalar(size!);
      matrix.makeBasis(x, y, up.multiplyScalar(size!)).setPosition(rx!, ry!, rz!).premultiply(to_part).toArray(field.matrices, 16 * i);
      field.own.set([red!, green!, blue!, below!], 4 * i);
      field.places.set([u!, v!], 2 * i);
      field.thresholds[i] = threshold!;
    });
    geometry.setAttribute("own", new THREE.InstancedBufferAttribute(new Float32Array(4 * n), 4));
    geometry.setAttribute("place", new THREE.InstancedBufferAttribute(new Float32Array(2 * n), 2));
    const { instances } = field;
    instances.count = 0;
    instances.castShadow = instances.receiveShadow = true;
    instances.frustumCulled = false;
    instances.raycast = () => {};
    part.add(instances);
    this.fields.push(field);
  }
}
