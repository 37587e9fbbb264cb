// A flat history under a lamp: its relief from the height or normal map. Level places keep their color.
import * as THREE from "three";
import { get_map } from "../api";
import type { SurfaceLook } from "../scene/material";
import type { Viewer } from "../scene/viewer";
import type { HistoryPlace } from "../types";
import { section, slider, toggle, type Toggle } from "../ui/controls";
import { h } from "../ui/dom";
import { show_error } from "../ui/notices";
import { codes_of_normals, normals_of_heights } from "./relief";

const kMostSide = 2048;
const kAmbient = 0.3;  ///< Share of the light that comes from everywhere.
const kAround_deg = 135, kHeight_deg = 30;

export function has_relief(place: HistoryPlace): boolean {
  return place.mesh !== true && (place.maps ?? []).some((m) => m === "height" || m === "normal");
}

export class ReliefPanel {
  readonly element: HTMLElement;
  private readonly lamp = new THREE.DirectionalLight(0xffffff, 1);
  private readonly ambient = new THREE.AmbientLight(0xffffff, Math.PI * kAmbient);
  private readonly on: Toggle;
  private around_deg = kAround_deg;
  private height_deg = kHeight_deg;
  private texture: THREE.DataTexture | undefined;

  /// @param dress  Shows the picture with light, or without.
  constructor(private readonly place: HistoryPlace, private readonly look: SurfaceLook, private readonly viewer: Viewer, private readonly dress: (is_lit: boolean) => void) {
    this.on = toggle("Light its relief", false, (is_on) => void this.light(is_on), "From its height map, or its normals; level places keep their color");
    const around = slider({ label: "Lamp from", low: -180, high: 180, step: 1, value: kAround_deg, unit: "°", hint: "0°: from the right; 90°: from above", on_input: (v) => { this.around_deg = v; this.turn_on(); } });
    const height = slider({ label: "Lamp above the picture", low: 5, high: 85, step: 1, value: kHeight_deg, unit: "°", hint: "Low: raking light", on_input: (v) => { this.height_deg = v; this.turn_on(); } });
    const depth = slider({ label: "Depth", low: 0, high: 5, step: 0.05, value: 1, hint: "1: as measured", on_input: (v) => { look.uniforms.normal_amount.value = v; this.turn_on(); } });
    this.element = section("Light", false, this.on.element, h("div", { class: "stack" }, around.element, height.element, depth.element));
    viewer.scene.add(this.lamp.target);
  }

  /// Also for tests.
  async light(is_on: boolean): Promise<void> {
    this.on.set(is_on);
    try {
      if (is_on && !this.texture) await this.read();
    } catch (error) {
      this.on.set(false);
      show_error(error);
      return;
    }
    if (is_on) this.viewer.scene.add(this.lamp, this.ambient);
    else this.viewer.scene.remove(this.lamp, this.ambient);
    this.aim();
    this.dress(is_on);
    this.viewer.invalidate();
  }

  dispose(): void {
    this.texture?.dispose();
  }

  // Whoever moves its lamp wants to see it.
  private turn_on(): void {
    if (!this.on.get()) void this.light(true);
    this.aim();
    this.viewer.invalidate();
  }

  private aim(): void {
    const [around, height] = [this.around_deg, this.height_deg].map((d) => (d * Math.PI) / 180) as [number, number];
    this.lamp.position.set(Math.cos(height) * Math.cos(around), Math.cos(height) * Math.sin(around), Math.sin(height)).multiplyScalar(10);
    this.lamp.intensity = (Math.PI * (1 - kAmbient)) / Math.sin(height);  // A level place gets as much from everywhere and the lamp as without light.
  }

  private async read(): Promise<void> {
    const { place } = this;
    const size = Math.max(place.width, place.height) > kMostSide ? kMostSide : undefined;
    const is_height = (place.maps ?? []).includes("height");
    const map = await get_map(place.place, is_height ? "map:height" : "map:normal", size);
    const texel_mm = (place.texel_size_mm ?? 1) * (place.width / map.width);
    const texture = new THREE.DataTexture(is_height ? normals_of_heights(map, texel_mm) : codes_of_normals(map), map.width, map.height);
    texture.minFilter = texture.magFilter = THREE.LinearFilter;
    texture.needsUpdate = true;
    this.texture = texture;
    this.look.uniforms.relief.value = texture;
  }
}
