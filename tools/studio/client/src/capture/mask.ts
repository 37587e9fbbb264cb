// A mask that is painted: strokes and regions of one color, each a step that can be undone.
import { ciede2000, lab_from_linear, linear_from_srgb } from "../color/lab";
import type { Vec3 } from "../types";

/// Of pixels; x1 and y1 are the first behind it.
export interface Box { x0: number; y0: number; x1: number; y1: number }
interface Kept { box: Box; bytes: Uint8Array }

const kTile = 64;
export const kMostSteps = 60;  ///< That can be undone.

export class Mask {
  readonly inside: Uint8Array;  ///< Row by row: 255 inside, 0 outside.
  private readonly steps: Map<number, Kept>[] = [];  ///< Of each step the tiles as they were before.

  constructor(readonly width: number, readonly height: number) {
    this.inside = new Uint8Array(width * height).fill(255);
  }

  get whole(): Box { return { x0: 0, y0: 0, x1: this.width, y1: this.height }; }
  get is_everything(): boolean { return this.inside.every((value) => value === 255); }

  /// From here on undo() comes back to.
  begin(): void {
    this.steps.push(new Map());
    if (this.steps.length > kMostSteps) this.steps.shift();
  }

  /// All pixels within `radius` of the way from a to b. @returns where something may have changed.
  stroke([ax, ay]: [number, number], [bx, by]: [number, number], radius: number, value: number): Box {
    const box = this.clamped({ x0: Math.floor(Math.min(ax, bx) - radius), y0: Math.floor(Math.min(ay, by) - radius), x1: Math.ceil(Math.max(ax, bx) + radius) + 1, y1: Math.ceil(Math.max(ay, by) + radius) + 1 });
    this.keep(box);
    const dx = bx - ax, dy = by - ay, square = dx * dx + dy * dy || 1, most = Math.max(radius, 0.5) ** 2;
    for (let y = box.y0; y < box.y1; ++y) {
      for (let x = box.x0; x < box.x1; ++x) {
        const t = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / square)), u = x - ax - t * dx, v = y - ay - t * dy;
        if (u * u + v * v <= most) this.inside[y * this.width + x] = value;
      }
    }
    return box;
  }

  /// All pixels where a picture of the same place, of any size, is not 0.
  fill(picture: Uint8Array, width: number, height: number, value: number): Box {
    this.keep(this.whole);
    for (let y = 0; y < this.height; ++y) {
      const row = Math.floor(((y + 0.5) * height) / this.height) * width;
      for (let x = 0; x < this.width; ++x) if (picture[row + Math.floor(((x + 0.5) * width) / this.width)]) this.inside[y * this.width + x] = value;
    }
    return this.whole;
  }

  undo(): void {
    for (const { box, bytes } of this.steps.pop()?.values() ?? []) {
      const width = box.x1 - box.x0;
      for (let y = box.y0; y < box.y1; ++y) this.inside.set(bytes.subarray((y - box.y0) * width, (y - box.y0 + 1) * width), y * this.width + box.x0);
    }
  }

  clamped({ x0, y0, x1, y1 }: Box): Box {
    return { x0: Math.max(0, x0), y0: Math.max(0, y0), x1: Math.min(this.width, x1), y1: Math.min(this.height, y1) };
  }

  private keep(box: Box): void {
    const step = this.steps[this.steps.length - 1], columns = Math.ceil(this.width / kTile);
    if (!step) return;
    for (let row = Math.floor(box.y0 / kTile); row * kTile < box.y1; ++row) {
      for (let column = Math.floor(box.x0 / kTile); column * kTile < box.x1; ++column) {
        const number = row * columns + column;
        if (step.has(number)) continue;
        const tile = this.clamped({ x0: column * kTile, y0: row * kTile, x1: (column + 1) * kTile, y1: (row + 1) * kTile }), width = tile.x1 - tile.x0;
        const bytes = new Uint8Array(width * (tile.y1 - tile.y0));
        for (let y = tile.y0; y < tile.y1; ++y) bytes.set(this.inside.subarray(y * this.width + tile.x0, y * this.width + tile.x1), (y - tile.y0) * width);
        step.set(number, { box: tile, bytes });
      }
    }
  }
}

/// Where a picture has nearly the color of one of its pixels: 1, else 0. @param tolerance  CIEDE2000. @param is_connected  Only what can be reached from there.
export function color_region({ data, width, height }: { data: Uint8ClampedArray; width: number; height: number }, x: number, y: number, tolerance: number, is_connected: boolean): Uint8Array {
  const lab = (r: number, g: number, b: number): Vec3 => lab_from_linear([r, g, b].map((code) => linear_from_srgb(code / 255)) as Vec3);
  const start = y * width + x, center = lab(data[4 * start]!, data[4 * start + 1]!, data[4 * start + 2]!);
  const known = new Int8Array(1 << 18).fill(-1);  // By color, to 6 bits.
  const is_near = (i: number): boolean => {
    const r = data[4 * i]!, g = data[4 * i + 1]!, b = data[4 * i + 2]!, key = ((r >> 2) << 12) | ((g >> 2) << 6) | (b >> 2);
    if (known[key] === -1) known[key] = ciede2000(center, lab((r & 252) + 1.5, (g & 252) + 1.5, (b & 252) + 1.5)) <= tolerance ? 1 : 0;
    return known[key] === 1;
  };
  const region = new Uint8Array(width * height);
  region[start] = 1;
  if (!is_connected) {
    for (let i = 0; i < region.length; ++i) if (is_near(i)) region[i] = 1;
    return region;
  }
  const open = [start];
  while (open.length > 0) {
    const i = open.pop()!, column = i % width;
    for (const [next, is_there] of [[i - 1, column > 0], [i + 1, column < width - 1], [i - width, i >= width], [i + width, i + width < region.length]] as const) {
      if (!is_there || region[next] || !is_near(next)) continue;
      region[next] = 1;
      open.push(next);
    }
  }
  return region;
}
