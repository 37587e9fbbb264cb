// The picture of a running scene: its mesh, the planes that the server sends, plantlets; and whether it is what the server has.
import * as THREE from "three";
import { get_mesh, get_plants } from "../api";
import { lit_material, type SurfaceLook } from "../scene/material";
import { add_seams } from "../scene/seams";
import { dress, read_glb } from "../scene/mesh_loader";
import type { Viewer } from "../scene/viewer";
import type { SceneState, TilesHeader } from "../types";
import { throttle } from "../ui/dom";
import { show_error } from "../ui/notices";
import { own_coordinates, type Handles } from "./handles";
import { Planes } from "./planes";
import { Plantlets } from "./plantlets";
import type { ShowPanel } from "./show_panel";

const kPlantlets_ms = 500, kReload_ms = 1000;

export interface Hashes {
  surface: string;
  relief: string;
  material: string;
}
export interface HashPair {
  server: Hashes;
  here: Hashes;
}

export interface PictureOptions {
  place: string;
  viewer: Viewer;
  look: SurfaceLook;
  handles: Handles;
  shown: ShowPanel;
  /// Objects that are not shown.
  hidden: ReadonlySet<string>;
  /// The mesh is there, or it could not be read.
  on_loaded: () => void;
}

export class LivePicture {
  planes: Planes | undefined;
  model: THREE.Group | undefined;
  private scene: SceneState | undefined;
  private material: THREE.MeshStandardMaterial | undefined;
  private plantlets: Plantlets | undefined;
  private is_asking_plants = false;
  private is_displaced = false;  ///< The mesh is cut to texels.
  private has_object_nodes = false;
  private is_other = false;  ///< The scene has another extent than the one before.
  private is_disposed = false;
  private hash_expected: Hashes | undefined;
  private hash_waiting: ((pair: HashPair) => void)[] = [];
  private readonly grow = throttle(kPlantlets_ms, () => this.update_plantlets());
  private readonly reload = throttle(kReload_ms, () => void this.load_mesh());

  constructor(private readonly options: PictureOptions) {}

  get num_plantlets(): number { return this.plantlets?.num_shown ?? 0; }
  get is_ready(): boolean { return this.model !== undefined && this.planes?.is_filled === true; }

  /// After hello.
  begin(scene: SceneState): void {
    const { viewer, look } = this.options;
    const before = this.scene, is_first = before === undefined;
    this.scene = scene;
    if (!this.planes || this.planes.width !== scene.width || this.planes.height !== scene.height) {
      this.planes?.dispose();
      this.planes = new Planes(viewer, look, scene.width, scene.height);
      this.forget_plantlets();
      this.material?.dispose();
      this.material = lit_material(look, viewer.lighting, this.planes.map);
      if (this.model) dress(this.model, this.material);
    }
    look.uniforms.relief_mm.value.set(...scene.relief_mm);
    look.uniforms.has_substance.value = 1;
    if (is_first || JSON.stringify(before?.objects) !== JSON.stringify(scene.objects)) void this.load_mesh();
    this.is_other = before !== undefined && JSON.stringify(before.bounds_mm) !== JSON.stringify(scene.bounds_mm);
  }

  changed(change: Partial<SceneState>): void {
    if (change.relief_mm) this.options.look.uniforms.relief_mm.value.set(...change.relief_mm);
    if (change.objects && !this.has_object_nodes) this.reload();
    if (change.objects) this.options.viewer.invalidate_shadows();
  }

  set_visible(name: string, is_visible: boolean): void {
    this.model?.children.find((child) => (child.userData["name"] ?? child.name) === name)?.traverse((node) => { node.visible = is_visible; });
    this.options.viewer.invalidate_shadows();
  }

  apply(header: TilesHeader, message: ArrayBuffer, offset: number): void {
    this.planes?.apply(header, message, offset);
    if (header.plane === "material" && this.scene?.look.plants) this.grow();
    if (header.last) this.compare_hash();
  }

  update_plantlets(): void {
    const { scene, planes, model } = this, { shown, viewer } = this.options;
    if (this.is_disposed || !scene || !planes || !model) return;
    const are_shown = shown.shown.plantlets && scene.look.plants !== null && shown.shown.overlay === "";  // They would hide the colors of a map.
    if (are_shown && !this.plantlets) void this.load_plantlets(model);
    this.plantlets?.update(are_shown ? planes.material : undefined);
    viewer.invalidate_shadows();
  }

  /// Whether heights move the mesh was changed.
  update_displacement(): void {
    if (this.options.look.uniforms.displacement.value > 0 !== this.is_displaced) void this.load_mesh();
  }

  /// The server's hash of the state that the next update completes.
  expect(hash: Hashes): void {
    this.hash_expected = hash;
  }

  /// What this client has, and what the server says it should have. @param ask  Asks for expect().
  check_hash(ask: () => void): Promise<HashPair> {
    return new Promise((resolve) => {
      this.hash_waiting.push(resolve);
      ask();
    });
  }

  dispose(): void {
    this.is_disposed = true;
    this.plantlets?.dispose();
    this.planes?.dispose();
    this.material?.dispose();
  }

  private compare_hash(): void {
    const server = this.hash_expected;
    if (!server || !this.planes) return;
    this.hash_expected = undefined;
    const here = this.planes.hashes();
    for (const resolve of this.hash_waiting.splice(0)) resolve({ server, here });
  }

  private async load_mesh(): Promise<void> {
    try {
      const { look } = this.options, is_displaced = this.is_displaced = look.uniforms.displacement.value > 0;
      const group = await read_glb(await get_mesh(this.options.place, undefined, is_displaced ? this.scene?.width : undefined));
      if (is_displaced) group.traverse((o) => { if (o instanceof THREE.Mesh) add_seams(o.geometry as THREE.BufferGeometry); });
      this.put(group);
    } catch (error) {
      if (!this.is_disposed) show_error(error);
    }
    if (!this.is_disposed) this.options.on_loaded();
  }

  /// Where plants can grow, once for each mesh.
  private async load_plantlets(model: THREE.Group): Promise<void> {
    if (this.is_asking_plants) return;
    this.is_asking_plants = true;
    try {
      const rows = await get_plants(this.options.place);
      const { scene, planes, model: now } = this;
      if (this.is_disposed || !scene || !planes) return;
      const parts = scene.objects.map((object) => model.children.find((child) => (child.userData["name"] ?? child.name) === object.name));
      if (now === model) this.plantlets = new Plantlets(rows, parts, this.options.viewer.lighting, planes.map);
    } catch (error) {
      if (!this.is_disposed) show_error(error);
      return;  // Asked for again with the next mesh.
    }
    this.is_asking_plants = false;
    this.update_plantlets();
  }

  private forget_plantlets(): void {
    this.plantlets?.dispose();
    this.plantlets = undefined;
    this.is_asking_plants = false;
  }

  private put(group: THREE.Group): void {
    const { viewer, handles } = this.options;
    if (this.is_disposed || !this.material || !this.scene) return;
    const objects = new Map<string, THREE.Object3D>();
    for (const object of this.scene.objects) {
      const node = group.children.find((child) => (child.userData["name"] ?? child.name) === object.name);
      if (!node) continue;
      own_coordinates(node, object);
      objects.set(object.name, node);
    }
    for (const name of this.options.hidden) objects.get(name)?.traverse((node) => { node.visible = false; });
    this.has_object_nodes = objects.size === this.scene.objects.length;
    dress(group, this.material);
    const is_first = !this.model;
    if (this.model) viewer.content.remove(this.model);
    this.forget_plantlets();
    this.model = group;
    viewer.content.add(group);
    viewer.content_has_come();
    if (this.has_object_nodes) handles.set_objects(objects);
    handles.show(this.scene);
    if (is_first || this.is_other) viewer.fit();
    else viewer.invalidate_shadows();
    this.is_other = false;
    this.update_plantlets();
  }
}
