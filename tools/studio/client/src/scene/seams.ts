// What keeps a surface closed when heights move it: every position moves once, along the mean of its normals, by the mean of the heights at its UVs
// (move_positions() in libcommon/output/relief.cpp). Vertices of one position on both sides of a seam get the same numbers.
import * as THREE from "three";

const kMostUvs = 4;  // Of a position; where charts of more meet, the others do not count.
const kLeastNormal = 0.2;  // Length of the mean of unit normals below which they point all ways: nothing moves there.

export const kSeamVertex = {
  declarations: "attribute vec3 seam_normal;\nattribute vec4 seam_uv, seam_uv_more;\nuniform sampler2D relief;\nuniform vec2 relief_mm;\nuniform float displacement;",
  main: /* glsl */ `
if (displacement > 0.0) {
  float share = 0.25 * (texture2D(relief, seam_uv.xy).a + texture2D(relief, seam_uv.zw).a + texture2D(relief, seam_uv_more.xy).a + texture2D(relief, seam_uv_more.zw).a);
  transformed += seam_normal * displacement * mix(relief_mm.x, relief_mm.y, share);
}`,
};

/// Adds seam_normal, seam_uv and seam_uv_more, once. Without UVs or normals it stays as it is.
export function add_seams(geometry: THREE.BufferGeometry): void {
  const position = geometry.getAttribute("position"), normal = geometry.getAttribute("normal"), uv = geometry.getAttribute("uv");
  if (geometry.getAttribute("seam_normal") || !position || !normal || !uv) return;
  const n = position.count, vertices = new Map<string, number[]>();
  for (let i = 0; i < n; ++i) {
    const key = `${position.getX(i)} ${position.getY(i)} ${position.getZ(i)}`, found = vertices.get(key);
    if (found) found.push(i);
    else vertices.set(key, [i]);
  }
  const normals = new Float32Array(3 * n), uvs = new Float32Array(4 * n), more = new Float32Array(4 * n), sum = new THREE.Vector3(), one = new THREE.Vector3();
  for (const all of vertices.values()) {
    sum.set(0, 0, 0);
    const places = new Map<string, [number, number]>();
    for (const i of all) {
      sum.add(one.fromBufferAttribute(normal, i).normalize());
      places.set(`${uv.getX(i)} ${uv.getY(i)}`, [uv.getX(i), uv.getY(i)]);
    }
    if (sum.length() < kLeastNormal * all.length) sum.set(0, 0, 0);
    else sum.normalize();
    const some = [...places.values()].slice(0, kMostUvs), slot = (k: number): [number, number] => some[k % some.length]!;
    for (const i of all) {
      sum.toArray(normals, 3 * i);
      uvs.set([...slot(0), ...slot(1)], 4 * i);
      more.set([...slot(2), ...slot(3)], 4 * i);
    }
  }
  geometry.setAttribute("seam_normal", new THREE.BufferAttribute(normals, 3));
  geometry.setAttribute("seam_uv", new THREE.BufferAttribute(uvs, 4));
  geometry.setAttribute("seam_uv_more", new THREE.BufferAttribute(more, 4));
}
