// What lies under a ray: a tree of boxes for each geometry, made once, so that a look costs microseconds on large meshes too.
import * as THREE from "three";
import { MeshBVH } from "three-mesh-bvh";

export interface Hit {
  point: THREE.Vector3;
  normal: THREE.Vector3;
  uv: THREE.Vector2;
  object: THREE.Object3D;
}

const trees = new WeakMap<THREE.BufferGeometry, MeshBVH>();

function tree_of(geometry: THREE.BufferGeometry): MeshBVH {
  let tree = trees.get(geometry);
  if (!tree) {
    tree = new MeshBVH(geometry, { indirect: true } as ConstructorParameters<typeof MeshBVH>[1]);  // The triangles keep their order.
    trees.set(geometry, tree);
  }
  return tree;
}

function meshes_of(content: THREE.Object3D): THREE.Mesh[] {
  const meshes: THREE.Mesh[] = [];
  content.traverseVisible((o) => { if (o instanceof THREE.Mesh && !(o instanceof THREE.InstancedMesh)) meshes.push(o); });
  return meshes;
}

/// Makes the trees before somebody waits for them.
export function prepare_picking(content: THREE.Object3D): void {
  for (const mesh of meshes_of(content)) tree_of(mesh.geometry as THREE.BufferGeometry);
}

/// The nearest surface on a ray of the world, seen from either side. Vertices that a shader moves stand where they were.
export function first_hit(ray: THREE.Ray, content: THREE.Object3D): Hit | undefined {
  let best: Hit | undefined, least = Infinity;
  const inverse = new THREE.Matrix4(), local = new THREE.Ray();
  for (const mesh of meshes_of(content)) {
    local.copy(ray).applyMatrix4(inverse.copy(mesh.matrixWorld).invert());
    const found = tree_of(mesh.geometry as THREE.BufferGeometry).raycastFirst(local, THREE.DoubleSide);
    if (!found?.face) continue;
    const point = found.point.clone().applyMatrix4(mesh.matrixWorld);
    const distance = point.distanceTo(ray.origin);
    if (distance >= least) continue;
    least = distance;
    best = { point, normal: found.face.normal.clone().transformDirection(mesh.matrixWorld), uv: found.uv?.clone() ?? new THREE.Vector2(), object: mesh };
  }
  return best;
}
