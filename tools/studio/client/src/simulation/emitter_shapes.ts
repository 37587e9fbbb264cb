// Emitters as lines in the scene. In their own frame they emit along +z.
import * as THREE from "three";
import type { Emitter, SceneState } from "../types";
import { extent, size_of } from "./context";

const kArrows = 0.13;  // Length of arrows, in diagonals of the scene.
const kNumRim = 48;

/// Where an emitter is: a sky has no place of its own, it is shown above the scene.
export function emitter_frame(emitter: Emitter, scene: SceneState): THREE.Matrix4 {
  const z = new THREE.Vector3(...(emitter.direction ?? [0, -1, 0])).normalize();
  const side = Math.abs(z.x) > 0.99 ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(1, 0, 0);
  const x = side.addScaledVector(z, -side.dot(z)).normalize();
  const y = z.clone().cross(x);
  const matrix = new THREE.Matrix4().makeBasis(x, y, z);
  const [low, high] = scene.bounds_mm;
  const position = emitter.shape === "sky" || !emitter.position
    ? new THREE.Vector3((low[0] + high[0]) / 2, high[1] + 0.12 * extent(scene), (low[2] + high[2]) / 2) : new THREE.Vector3(...emitter.position);
  return matrix.setPosition(position);
}

function rim(radius: number, z = 0): number[] {
  const points: number[] = [];
  for (let i = 0; i < kNumRim; ++i) {
    for (const k of [i, i + 1]) points.push(radius * Math.cos((2 * Math.PI * k) / kNumRim), radius * Math.sin((2 * Math.PI * k) / kNumRim), z);
  }
  return points;
}

function arrow(x: number, y: number, length: number): number[] {
  const tip = 0.18 * length;
  return [x, y, 0, x, y, length, x, y, length, x + tip / 2, y, length - tip, x, y, length, x - tip / 2, y, length - tip];
}

function box(width: number, height: number): number[] {
  const [w, h] = [width / 2, height / 2];
  return [-w, -h, 0, w, -h, 0, w, -h, 0, w, h, 0, w, h, 0, -w, h, 0, -w, h, 0, -w, -h, 0];
}

export function emitter_lines(emitter: Emitter, scene: SceneState): Float32Array {
  const length = kArrows * extent(scene);
  const [width, depth] = size_of(emitter);
  const points: number[] = [];
  switch (emitter.shape) {
    case "disk":
      points.push(...rim(width / 2), ...arrow(0, 0, length));
      for (const [x, y] of [[1, 0], [-1, 0], [0, 1], [0, -1]] as const) points.push(...arrow((x * width) / 2, (y * width) / 2, 0.7 * length));
      break;
    case "rectangle":
      points.push(...box(width, depth), ...arrow(0, 0, length));
      for (const [x, y] of [[1, 1], [-1, 1], [1, -1], [-1, -1]] as const) points.push(...arrow((x * width) / 2, (y * depth) / 2, 0.7 * length));
      break;
    case "sphere": {
      points.push(...rim(width / 2));
      for (const p of [rim(width / 2), rim(width / 2)].entries()) {
        for (let i = 0; i < p[1].length; i += 3) points.push(...(p[0] === 0 ? [p[1][i]!, 0, p[1][i + 1]!] : [0, p[1][i]!, p[1][i + 1]!]));
      }
      break;
    }
    case "sky": {
      const half = 0.28 * extent(scene);
      points.push(...box(2 * half, 2 * half * 0.35));
      for (const x of [-1, -0.5, 0, 0.5, 1]) points.push(...arrow(x * half, 0, 0.7 * length));
      break;
    }
    default: points.push(...rim(0.012 * extent(scene)), ...arrow(0, 0, length));
  }
  const spread = emitter.spread_deg ?? 0;
  if (spread > 0.5 && spread <= 85 && emitter.shape !== "sphere" && emitter.shape !== "sky") {
    const radius = length * Math.tan((spread * Math.PI) / 180);
    points.push(...rim(radius, length), 0, 0, 0, radius, 0, length, 0, 0, 0, -radius, 0, length, 0, 0, 0, 0, radius, length, 0, 0, 0, 0, -radius, length);
  }
  return new Float32Array(points);
}
