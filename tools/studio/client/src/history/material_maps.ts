// What a history knows of its material beyond color, at the time that is shown: one loader and one texture a map.
import * as THREE from "three";
import type { TextureQuery } from "../api";
import { color_texture, show_material, type MaterialMap, type SurfaceLook } from "../scene/material";
import { FrameLoader } from "./frame_loader";

export class MaterialMaps {
  private readonly loaders = new Map<MaterialMap, FrameLoader>();
  private readonly textures = new Map<MaterialMap, THREE.DataTexture>();

  /// @param side  Of the comparison.
  constructor(query: Omit<TextureQuery, "time" | "between">, maps: MaterialMap[], private readonly side: "a" | "b", private readonly look: SurfaceLook, private readonly changed: () => void, fail: (error: unknown) => void) {
    for (const map of maps) {
      this.loaders.set(map, new FrameLoader({ ...query, map }, ({ width, height, bytes }) => {
        this.textures.get(map)?.dispose();
        const texture = color_texture(width, height, bytes.slice());
        if (map === "orm") texture.colorSpace = THREE.NoColorSpace;
        this.textures.set(map, texture);
        show_material(this.look, this.side, map, texture);
        this.changed();
      }, fail));
    }
  }

  set between(value: string) {
    for (const loader of this.loaders.values()) loader.between = value;
  }

  request(time: number): void {
    for (const loader of this.loaders.values()) loader.request(time);
  }

  async settled(): Promise<void> {
    await Promise.all([...this.loaders.values()].map((loader) => loader.settled()));
  }

  dispose(): void {
    for (const loader of this.loaders.values()) loader.dispose();
    for (const texture of this.textures.values()) texture.dispose();
  }
}
