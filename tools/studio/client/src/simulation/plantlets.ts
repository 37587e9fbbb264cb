// Small plants where organic material is high [Guenther et al. 2012, sec. 4.5]: fixed places on the surface, shown once there is enough.
import * as THREE from "three";
import { MeshSurfaceSampler } from "three/addons/math/MeshSurfaceSampler.js";
import type { TilePlane } from "../scene/texture_tiles";

const kNumPlaces = 6000;
const kLeast = 0.18, kMost = 0.75;  // Amounts: the first grows here, the last there.
const kNumLeaves = 5;
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
function tuft(): THREE.BufferGeometry {
  const points: number[] = [], colors: number[] = [];
  for (let i = 0; i < kNumLeaves; ++i) {
    const angle = (2 * Math.PI * i) / kNumLeaves, lean = 0.35 + 0.25 * ((i * 7) % 3) / 2;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const at = (r: number, side: number, z: number): number[] => [r * c - side * s, r * s + side * c, z];
    const root = at(0, 0, 0), left = at(lean * 0.5, -0.16, 0.55), right = at(lean * 0.5, 0.16, 0.55), tip = at(lean, 0, 1);
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
  places: { u: number; v: number; threshold: number; matrix: THREE.Matrix4 }[];
}

export class Plantlets {
  private readonly fields: Field[] = [];
  private readonly geometry = tuft();
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
      const field: Field = { instances: new THREE.InstancedMesh(this.geometry, this.material, Math.ceil(kNumPlaces / meshes.length)), places: [] };
      const position = new THREE.Vector3(), normal = new THREE.Vector3(), color = new THREE.Color(), uv = new THREE.Vector2();
      for (let i = 0; i < field.instances.count; ++i) {
        sampler.sample(position, normal, color, uv);
        const grows = normal.clone().lerp(new THREE.Vector3(0, 1, 0), 0.35).normalize();
        const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), grows).multiply(new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(0, 0, 1), 6.283 * random()));
        const size = diagonal * kSize * (0.5 + random());
        field.places.push({ u: uv.x, v: uv.y, threshold: kLeast + (kMost - kLeast) * random(), matrix: new THREE.Matrix4().compose(position, turn, new THREE.Vector3(size, size, size)) });
      }
      field.instances.count = 0;
      field.instances.castShadow = true;
      field.instances.frustumCulled = false;
      field.instances.raycast = () => {};
      mesh.add(field.instances);
      this.fields.push(field);
    }
  }

  /// @param amounts  The map of the material; nothing: no plants. @param high  What a byte b stands for: high (b / 255)^2.
  update(amounts: TilePlane | undefined, high = 1): void {
    this.num_shown = 0;
    for (const { instances, places } of this.fields) {
      let count = 0;
      if (amounts) {
        for (const { u, v, threshold, matrix } of places) {
          const x = Math.min(amounts.width - 1, Math.floor(u * amounts.width)), y = Math.min(amounts.height - 1, Math.floor(v * amounts.height));
          if (high * (amounts.data[y * amounts.width + x]! / 255) ** 2 >= threshold) instances.setMatrixAt(count++, matrix);
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
    this.geometry.dispose();
    this.material.dispose();
  }
}
