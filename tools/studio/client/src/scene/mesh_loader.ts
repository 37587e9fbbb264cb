// The server's GLB as geometry in mm.
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { StudioError } from "../api";

const kMmPerMeter = 1000;

/// One group; objects keep their names, place and own coordinates.
export async function read_glb(bytes: ArrayBuffer): Promise<THREE.Group> {
  const gltf = await new GLTFLoader().parseAsync(bytes, "").catch((error: Error) => {
    throw new StudioError(`The mesh cannot be shown: ${error.message}`);
  });
  const group = new THREE.Group();
  group.add(...gltf.scene.children);
  group.traverse((o) => {
    if (o instanceof THREE.Mesh || o instanceof THREE.Points) (o.geometry as THREE.BufferGeometry).scale(kMmPerMeter, kMmPerMeter, kMmPerMeter);
    if (o !== group) o.position.multiplyScalar(kMmPerMeter);
  });
  return group;
}

/// All meshes get this material.
export function dress(group: THREE.Object3D, material: THREE.Material): void {
  group.traverse((o) => {
    if (!(o instanceof THREE.Mesh)) return;
    o.material = material;
    o.castShadow = o.receiveShadow = true;
  });
}

/// A picture as a plane with u right and v down, its longest side 1.
export function picture_plane(width: number, height: number): THREE.Mesh {
  const longest = Math.max(width, height);
  const geometry = new THREE.PlaneGeometry(width / longest, height / longest);
  const uv = geometry.getAttribute("uv") as THREE.BufferAttribute;
  for (let i = 0; i < uv.count; ++i) uv.setY(i, 1 - uv.getY(i));
  return new THREE.Mesh(geometry);
}
