// What the parts of the simulation view share.
import type { Viewer } from "../scene/viewer";
import type { Emitter, Overlay, SceneState, Vec3 } from "../types";

export interface SceneContext {
  readonly scene: SceneState;
  readonly viewer: Viewer;
  readonly is_running: boolean;
  /// A command; what goes wrong is shown to the user.
  send(op: string, fields?: Record<string, unknown>): Promise<void>;
  /// One event as scene files have them: recorded, replayable. @param label  What the step is called; several of one name are one.
  event(event: Record<string, unknown>, label?: string): void;
}

export function overlay_of(entry: string | Overlay): Overlay {
  return typeof entry === "string" ? { name: entry } : entry;
}

export function size_of(emitter: Emitter): [number, number] {
  const { size } = emitter;
  return typeof size === "number" ? [size, 0] : [size?.[0] ?? 0, size?.[1] ?? 0];
}

/// Diagonal of the scene, mm.
export function extent(scene: SceneState): number {
  const [low, high] = scene.bounds_mm;
  return Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

/// All of an emitter as an event wants it: a sky has no position, a brush no direction of its own.
export function emitter_event(emitter: Emitter): Record<string, unknown> {
  const all: Partial<Emitter> = { ...emitter };
  if (emitter.shape === "sky") delete all.position;
  if (emitter.distance !== undefined && !(emitter.distance > 0)) delete all.distance;
  return { op: "emitter", emitter: all };
}

export function rounded(v: { x: number; y: number; z: number }): Vec3 {
  return [v.x, v.y, v.z].map((c) => Number(c.toFixed(4))) as Vec3;
}
