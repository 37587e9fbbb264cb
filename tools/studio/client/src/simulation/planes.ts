// The textures of a running scene and their updates: what is in memory equals the server's to the bit, what is on screen is told to it.
import * as THREE from "three";
import type { SurfaceLook } from "../scene/material";
import { TilePlane } from "../scene/texture_tiles";
import type { Viewer } from "../scene/viewer";
import type { TilesHeader } from "../types";
import { xxh64 } from "../xxh64";

export class Planes {
  surface: TilePlane;
  relief: TilePlane;
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
    this.overlay = new TilePlane(width, height, 1, false, calm);
    this.relief.data.fill(128);
    look.uniforms.relief.value = this.relief.texture;
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
    for (const plane of [this.surface, this.relief, this.overlay]) plane.upload(this.viewer.renderer);
  }

  /// @param acknowledge  Told for every update that is on screen now.
  after_frame(acknowledge: (update: number) => void): void {
    for (const update of this.to_acknowledge.splice(0)) {
      ++this.num_updates;
      acknowledge(update);
    }
  }

  hashes(): { surface: string; relief: string } {
    return { surface: xxh64(this.surface.data), relief: xxh64(this.relief.data) };
  }

  dispose(): void {
    for (const plane of [this.surface, this.relief, this.overlay]) plane.dispose();
    this.look.uniforms.gloss.value = 0;
  }
}
