// The textures of a running scene and their updates: what is in memory equals the server's to the bit, what is on screen is told to it.
import * as THREE from "three";
import type { SurfaceLook } from "../scene/material";
import { TilePlane } from "../scene/texture_tiles";
import type { Viewer } from "../scene/viewer";
import { color_text } from "../color/texel";
import type { Overlay, SceneState, TilesHeader } from "../types";
import { number_text } from "../ui/numbers";
import { xxh64 } from "../xxh64";

export class Planes {
  surface: TilePlane;
  relief: TilePlane;
  material: TilePlane;
  overlay: TilePlane;
  num_updates = 0;
  num_tiles = 0;
  iteration = 0;
  /// When the first tile has come.
  is_filled = false;
  private to_acknowledge: number[] = [];

  constructor(private readonly viewer: Viewer, private readonly look: SurfaceLook, readonly width: number, readonly height: number) {
    const calm = (): void => viewer.invalidate();
    this.surface = new TilePlane(width, height, 4, true, calm);
    this.relief = new TilePlane(width, height, 4, false, calm);
    this.material = new TilePlane(width, height, 4, false, calm);
    this.overlay = new TilePlane(width, height, 1, false, calm);
    this.relief.data.fill(128);
    look.uniforms.relief.value = this.relief.texture;
    look.uniforms.substance.value = this.material.texture;
    look.uniforms.overlay.value = this.overlay.texture;
    look.uniforms.overlay_range.value.set(0, 1);
    look.uniforms.gloss.value = 1;
  }

  get map(): THREE.Texture {
    return this.surface.texture;
  }

  apply(header: TilesHeader, message: ArrayBuffer, offset: number): void {
    const plane = this[header.plane];
    if (header.width !== plane.width || header.height !== plane.height) return;
    plane.apply(message, offset, header.count, header.tile);
    this.num_tiles += header.count;
    this.is_filled = true;
    this.iteration = header.iteration;
    if (!header.last) return;
    this.to_acknowledge.push(header.update);
    this.viewer.invalidate();
  }

  before_frame(): void {
    for (const plane of this.all()) plane.upload(this.viewer.renderer);
  }

  /// @param acknowledge  Told for every update that is on screen now.
  after_frame(acknowledge: (update: number) => void): void {
    for (const update of this.to_acknowledge.splice(0)) {
      ++this.num_updates;
      acknowledge(update);
    }
  }

  hashes(): { surface: string; relief: string; material: string } {
    return { surface: xxh64(this.surface.data), relief: xxh64(this.relief.data), material: xxh64(this.material.data) };
  }

  dispose(): void {
    for (const plane of this.all()) plane.dispose();
    this.look.uniforms.gloss.value = 0;
  }

  private all(): TilePlane[] {
    return [this.surface, this.relief, this.material, this.overlay];
  }
}

/// What the planes hold of a place, in words: the map that is shown, color, height. Bytes are rounded: a probe tells more digits.
export function words_at(uv: { x: number; y: number }, planes: Planes | undefined, overlay: Overlay | undefined, scene: SceneState): string[] {
  if (!planes) return [];
  const { width, height } = planes, at = (share: number, size: number): number => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
  const i = at(uv.y, height) * width + at(uv.x, width), { data } = planes.surface;
  const [low, high] = scene.relief_mm, relief = planes.relief.data[4 * i + 3]!;
  const words = [color_text(data[4 * i]!, data[4 * i + 1]!, data[4 * i + 2]!)];
  if (overlay) {
    const value = (overlay.high ?? 1) * (planes.overlay.data[i]! / 255) ** 2, unit = overlay.unit === "1" || !overlay.unit ? "" : ` ${overlay.unit}`;
    words.unshift(overlay.unit === "amount" ? `amount of ${overlay.name}: ${number_text(value)}` : `${overlay.name}: ${number_text(value)}${unit}`);
  }
  if (relief !== 127 && relief !== 128) words.push(`height ${number_text(low + ((high - low) * relief) / 255, 2)} mm`);
  return words;
}
