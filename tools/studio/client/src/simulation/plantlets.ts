// Small plants where organic material is high [Guenther et al. 2012, sec. 4.5]: fixed places on the surface, shown once there is enough, and taller as it grows.
import * as THREE from "three";
import { MeshSurfaceSampler } from "three/addons/math/MeshSurfaceSampler.js";
import type { TilePlane } from "../scene/texture_tiles";

const kNumPlaces = 6000;
const kLeast = 0.18, kMost = 0.75;  // Amounts: the first grows here, the last there.
const kNumLeaves = 6;
const kSeedling = 0.35, kGrowth = 0.25;  // A plant comes with this share of its height, and grows while the amount rises by that.
// How leaves stand, in heights of the plant, as in libcommon/output/plantlets.cpp: shoots, tufts, rosettes.
const kForms = [{ lean: 0.16, more: 0.3, half: 0.06, tip: 1 }, { lean: 0.35, more: 0.25, half: 0.14, tip: 0.9 }, { lean: 0.7, more: 0.3, half: 0.17, tip: 0.5 }];
const kSize = 1 / 90;               // Of the scene's diagonal.

/// A repeatable stream of numbers in [0, 1) (mulberry32).
function numbers(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

// Leaves around a stem, along +z.
function plant(form: (typeof kForms)[number]): THREE.BufferGeometry {
  const points: number[] = [], colors: number[] = [];
  for (let i = 0; i < kNumLeaves; ++i) {
    const angle = (2 * Math.PI * i) / kNumLeaves, lean = form.lean + form.more * ((i * 7) % 3) / 2;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const at = (r: number, side: number, z: number): number[] => [r * c - side * s, r * s + side * c, z];
    const root = at(0, 0, 0), left = at(lean * 0.5, -form.half, 0.55 * form.tip), right = at(lean * 0.5, form.half, 0.55 * form.tip), tip = at(lean, 0, form.tip);
    points.push(...root, ...left, ...right, ...left, ...tip, ...right);
    for (const shade of [0.45, 0.85, 0.85, 0.85, 1.15, 0.85]) colors.push(0.16 * shade, 0.3 * shade, 0.06 * shade);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
  geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(colors), 3));
  geometry.computeVertexNormals();
  return geometry;
}

interface Field {
  instances: THREE.InstancedMesh;
  places: { u: number; v: number; threshold: number; position: THREE.Vector3; turn: THREE.Quaternion; size: number }[];
}

export class Plantlets {
  private readonly fields: Field[] = [];
  private readonly geometries = kForms.map(plant);
  private readonly material = new THREE.MeshStandardMaterial({ vertexColors: true, side: THREE.DoubleSide, roughness: 0.7 });
  num_shown = 0;

  constructor(model: THREE.Object3D, diagonal: number) {
    const meshes: THREE.Mesh[] = [];
    model.traverse((o) => { if (o instanceof THREE.Mesh) meshes.push(o); });
    const random = numbers(1);
    for (const mesh of meshes) {
      const sampler = new MeshSurfaceSampler(mesh);
      (sampler as unknown as { setRandomGenerator(f: () => number): void }).setRandomGenerator(random);  // Missing in the types.
      sampler.build();
      for (const geometry of this.geometries) {
        const num_places = Math.ceil(kNumPlaces / meshes.length / this.geometries.length);
        const field: Field = { instances: new THREE.InstancedMesh(geometry, this.material, num_places), places: [] };
        const normal = new THREE.Vector3(), color = new THREE.Color(), uv = new THREE.Vector2();
        for (let i = 0; i < num_places; ++i) {
          const position = new THREE.Vector3();
          sampler.sample(position, normal, color, uv);
          const grows = normal.clone().lerp(new THREE.Vector3(0, 1, 0), 0.35).normalize();
          const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), grows).multiply(new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(0, 0, 1), 6.283 * random()));
          field.places.push({ u: uv.x, v: uv.y, threshold: kLeast + (kMost - kLeast) * random(), position, turn, size: diagonal * kSize * (0.5 + random()) });
        }
        field.instances.count = 0;
        field.instances.castShadow = true;
        field.instances.frustumCulled = false;
        field.instances.raycast = () => {};
        mesh.add(field.instances);
        this.fields.push(field);
      }
    }
  }

  /// @param amounts  The map of the material; nothing: no plants. @param high  What a byte b stands for: high (b / 255)^2.
  update(amounts: TilePlane | undefined, high = 1): void {
    this.num_shown = 0;
    for (const { instances, places } of this.fields) {
      let count = 0;
      if (amounts) {
        const matrix = new THREE.Matrix4(), scale = new THREE.Vector3();
        for (const { u, v, threshold, position, turn, size } of places) {
          const x = Math.min(amounts.width - 1, Math.floor(u * amounts.width)), y = Math.min(amounts.height - 1, Math.floor(v * amounts.height));
          const amount = high * (amounts.data[y * amounts.width + x]! / 255) ** 2;
          if (amount < threshold) continue;
          scale.setScalar(size * (kSeedling + (1 - kSeedling) * Math.min(1, (amount - threshold) / kGrowth)));
          instances.setMatrixAt(count++, matrix.compose(position, turn, scale));
        }
      }
      instances.count = count;
      instances.instanceMatrix.needsUpdate = true;
      this.num_shown += count;
    }
  }

  dispose(): void {
    for (const { instances } of this.fields) {
      instances.removeFromParent();
      instances.dispose();
    }
    for (const geometry of this.geometries) geometry.dispose();
    this.material.dispose();
  }
}
