// Small pictures of what lies in the folder, for the start page: objects as they are, not the textures that are wrapped around them.
import * as THREE from "three";
import { get_map, get_mesh, get_place, get_texture, preview_url, thumbnail_url } from "../api";
import { diverging_color, ramp_color } from "../color/ramp";
import { chosen_range, kAutomatic, share_in } from "../color/range";
import { srgb_from_linear } from "../color/lab";
import type { HistoryPlace, PlaceSummary, StepsPlace } from "../types";
import { read_dressed_glb } from "./dressed_glb";
import { Environments, lamp_direction } from "./environment";
import { distance_to_fit } from "./framing";
import { color_texture } from "./material";
import { dress, read_glb } from "./mesh_loader";

const kWidth = 430, kHeight = 270, kTexture = 512, kFlat = 360;
const kMost_mb = 60;  // Of a mesh that is read only for its picture.
const kClay = 0xb9b4aa;
const kFov_deg = 28, kMargin = 1.07;

/// Made once for each state of a place.
const made = new Map<string, string>();

export class Thumbnails {
  private renderer: THREE.WebGLRenderer | undefined;
  private environments: Environments | undefined;
  private last: Promise<unknown> = Promise.resolve();
  private readonly stop = new AbortController();

  /// The address of a picture; nothing for what has none. One after the other, in the order in which they are asked for.
  of(place: PlaceSummary): Promise<string | undefined> {
    const key = `${place.place} ${place.modified}`;
    const found = made.get(key);
    if (found) return Promise.resolve(found);
    const next = this.last.then(async () => {
      if (this.stop.signal.aborted) return undefined;
      const url = await this.make(place);
      if (url) made.set(key, url);
      return url;
    }).catch(() => undefined);
    this.last = next;
    return next;
  }

  dispose(): void {
    this.stop.abort();
    this.environments?.dispose();
    this.renderer?.dispose();
    this.renderer?.forceContextLoss();
  }

  private async make(place: PlaceSummary): Promise<string | undefined> {
    const { signal } = this.stop;
    switch (place.kind) {
      case "history": {
        const { times, shows } = await get_place<HistoryPlace>(place.place, signal);
        return shows ? this.map(place.place, shows, times[times.length - 1] ?? 0) : thumbnail_url(place.place, times[times.length - 1] ?? 0, kFlat);
      }
      case "transfer":
      case "simulation": {
        const { times } = await get_place<HistoryPlace>(place.place, signal);
        const texture = await get_texture({ place: place.place, time: times[times.length - 1] ?? 0, size: kTexture }, signal);
        const map = color_texture(texture.width, texture.height, texture.bytes);
        const group = await read_glb(await get_mesh(place.place, signal));
        return this.draw(group, new THREE.MeshStandardMaterial({ map, roughness: 0.8, side: THREE.DoubleSide }));
      }
      case "scene": return this.draw(await read_glb(await get_mesh(place.place, signal)), clay());
      case "mesh": {
        if (Number(/^[\d.]+/.exec(place.detail)?.[0] ?? 0) > kMost_mb) return undefined;
        if (/\.glb$/i.test(place.place)) return this.draw((await read_dressed_glb(place.place, signal)).group);
        return this.draw(await read_glb(await get_mesh(place.place, signal)), clay());
      }
      case "ingest":
      case "registration":
      case "unlit": {
        const { steps } = await get_place<StepsPlace>(place.place, signal);
        const path = steps.flatMap((s) => s.pictures)[0]?.path;
        return path ? preview_url(place.place, path, kFlat) : undefined;
      }
    }
    return undefined;
  }

  // The numbers of a map as colors; what is not known is left out.
  private async map(place: string, name: string, time: number): Promise<string | undefined> {
    const { width, height, channels, values } = await get_map(place, name, kFlat, this.stop.signal, time);
    const numbers = values.filter((_, i) => i % channels === 0), range = chosen_range(numbers, kAutomatic);
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [width, height];
    const context = canvas.getContext("2d"), picture = context?.createImageData(width, height);
    if (!context || !picture || !(range.high > range.low)) return undefined;
    const color = range.low < 0 && range.high > 0 ? diverging_color : ramp_color;
    numbers.forEach((v, i) => { if (v !== 0) picture.data.set([...color(share_in(v, range, false)).map((c) => 255 * srgb_from_linear(c)), 255], 4 * i); });
    context.putImageData(picture, 0, 0);
    return canvas.toDataURL();
  }

  private draw(group: THREE.Group, material?: THREE.Material): string | undefined {
    this.renderer ??= new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.environments ??= new Environments(this.renderer);
    const { renderer } = this;
    renderer.setSize(kWidth, kHeight, false);
    renderer.toneMapping = THREE.NoToneMapping;
    if (material) dress(group, material);
    const scene = new THREE.Scene(), { surroundings: { lamp: shining }, mirror } = this.environments.get("studio");
    const lamp = new THREE.DirectionalLight(new THREE.Color(...(shining?.color ?? [0, 0, 0])), Math.PI);
    if (shining) lamp.position.copy(lamp_direction(shining));
    scene.add(group, lamp);
    scene.environment = mirror;
    const box = new THREE.Box3().setFromObject(group);
    if (box.isEmpty()) return undefined;
    const center = box.getCenter(new THREE.Vector3()), way = new THREE.Vector3(0.55, 0.32, 1).normalize();
    const distance = kMargin * distance_to_fit(box, way, kFov_deg, kWidth / kHeight);
    const camera = new THREE.PerspectiveCamera(kFov_deg, kWidth / kHeight, distance / 200, 40 * distance);
    camera.position.copy(center).addScaledVector(way, distance);
    camera.lookAt(center);
    renderer.render(scene, camera);
    const url = renderer.domElement.toDataURL();
    scene.traverse((o) => {
      if (!(o instanceof THREE.Mesh)) return;
      (o.geometry as THREE.BufferGeometry).dispose();
      for (const used of [o.material].flat() as THREE.MeshStandardMaterial[]) {
        used.map?.dispose();
        used.dispose();
      }
    });
    return url;
  }
}

function clay(): THREE.Material {
  return new THREE.MeshStandardMaterial({ color: kClay, roughness: 0.75, side: THREE.DoubleSide });
}
