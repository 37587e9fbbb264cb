// The way of a brush between two places of the pointer, along the surface.
import type { Vector3 } from "three";

/// A place of the pointer, and the surface under it, if any.
export interface Spot {
  x: number;
  y: number;
  point?: Vector3 | undefined;
  /// The brush was lifted before this one: the surface has a gap there.
  is_jump?: boolean;
}

export interface WayOptions {
  /// Neighbors are not farther apart on the surface, mm, unless they are next to each other on the screen.
  spacing: number;
  /// Of a surface that faces the camera, where the way begins.
  mm_per_px: number;
  /// The surface under a place of the pointer.
  pick(x: number, y: number): Vector3 | undefined;
}

const kLeast_px = 2;   // Nearer places of the pointer have nothing between them.
const kMostDepth = 7;  // Of halving: 128 parts.
const kMostBare = 3;   // The same where neither end has a surface.
const kSteep = 12;     // A surface that is seen at less than 5 degrees is taken for an edge.

/// What follows `from` on the way to `to`, which comes last if it has a surface. Where the surface ends or two neighbors lie at different depths, the
/// later one is a jump.
export function way_between(from: Spot, to: Spot, options: WayOptions, depth = 0): Spot[] {
  const px = Math.hypot(to.x - from.x, to.y - from.y), is_near = px <= kLeast_px || depth >= kMostDepth;
  if (from.point && to.point) {
    const apart = from.point.distanceTo(to.point);
    if (apart <= options.spacing) return [to];
    if (is_near) return [apart > kSteep * Math.max(1, px) * options.mm_per_px ? { ...to, is_jump: true } : to];
  } else if (is_near || (!from.point && !to.point && depth >= kMostBare)) {
    return to.point ? [{ ...to, is_jump: true }] : [];
  }
  const [x, y] = [(from.x + to.x) / 2, (from.y + to.y) / 2];
  const middle: Spot = { x, y, point: options.pick(x, y) };
  return [...way_between(from, middle, options, depth + 1), ...way_between(middle, to, options, depth + 1)];
}
