// Where a camera stands to see all of something.
import * as THREE from "three";

/// From the middle of a box, against `way` (unit): all corners lie in the frustum.
export function distance_to_fit(box: THREE.Box3, way: THREE.Vector3, fov_deg: number, aspect: number): number {
  const center = box.getCenter(new THREE.Vector3()), half = Math.tan((fov_deg * Math.PI) / 360);
  const right = new THREE.Vector3(0, 1, 0).cross(way).normalize(), up = way.clone().cross(right);
  let distance = 0;
  for (let i = 0; i < 8; ++i) {
    const corner = new THREE.Vector3(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z).sub(center);
    const reach = Math.max(Math.abs(corner.dot(up)) / half, Math.abs(corner.dot(right)) / (half * aspect));
    distance = Math.max(distance, corner.dot(way) + reach);
  }
  return distance;
}
