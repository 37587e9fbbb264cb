// Emitters and objects with handles: chosen, moved, turned and scaled while the scene runs.
import * as THREE from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";
import type { Emitter, SceneObject, SceneState } from "../types";
import { throttle } from "../ui/dom";
import { emitter_event, rounded, size_of, type SceneContext } from "./context";
import { emitter_frame, emitter_lines } from "./emitter_shapes";

export type HandleMode = "translate" | "rotate" | "scale";
export interface Chosen {
  kind: "emitter" | "object";
  name: string;
}

const kSend_ms = 50;
const kGrab_px = 26;
const kEmitterColor = 0x63c7b0, kChosenColor = 0xf2a65a;

export class Handles {
  /// Tells the panel what was chosen on the stage.
  on_choose: ((chosen: Chosen | undefined) => void) | undefined;
  chosen: Chosen | undefined;
  private mode: HandleMode = "translate";
  private readonly controls: TransformControls;
  private readonly emitters = new THREE.Group();
  private readonly shapes = new Map<string, THREE.LineSegments>();
  private readonly objects = new Map<string, THREE.Object3D>();
  private start_size: [number, number] = [0, 0];
  private readonly send: (chosen: Chosen) => void;

  constructor(private readonly context: SceneContext) {
    const { viewer } = context;
    this.controls = new TransformControls(viewer.camera, viewer.canvas);
    this.controls.setSize(0.85);
    this.controls.addEventListener("dragging-changed", (event) => {
      viewer.controls.enabled = !event.value;
      if (event.value) this.begin();
      else viewer.invalidate_shadows();
    });
    this.controls.addEventListener("change", () => viewer.invalidate());
    this.controls.addEventListener("objectChange", () => this.changed());
    viewer.scene.add(this.emitters, this.controls.getHelper());
    this.send = throttle(kSend_ms, (chosen: Chosen) => this.tell(chosen));
  }

  get is_dragging(): boolean {
    return this.controls.dragging;
  }

  /// The scene's objects by name, as the mesh has them.
  set_objects(objects: Map<string, THREE.Object3D>): void {
    this.objects.clear();
    for (const [name, object] of objects) this.objects.set(name, object);
  }

  show(scene: SceneState): void {
    const names = new Set(scene.emitters.map((e) => e.name));
    for (const [name, shape] of this.shapes) {
      if (names.has(name)) continue;
      this.emitters.remove(shape);
      this.shapes.delete(name);
    }
    for (const emitter of scene.emitters) this.show_emitter(emitter, scene);
    for (const object of scene.objects) this.show_object(object);
    this.context.viewer.invalidate();
  }

  set_visible(are_visible: boolean): void {
    this.emitters.visible = are_visible;
    if (!are_visible) this.choose(undefined);
    this.context.viewer.invalidate();
  }

  set_mode(mode: HandleMode): void {
    this.mode = mode;
    this.attach();
  }

  choose(chosen: Chosen | undefined): void {
    this.chosen = chosen;
    this.attach();
    for (const [name, shape] of this.shapes) (shape.material as THREE.LineBasicMaterial).color.set(chosen?.kind === "emitter" && chosen.name === name ? kChosenColor : kEmitterColor);
    this.context.viewer.invalidate();
  }

  /// A click on the stage: the emitter whose middle is near. @returns whether there was one.
  click(x: number, y: number): boolean {
    if (!this.emitters.visible) return false;
    let best: string | undefined;
    let least = kGrab_px;
    for (const [name, shape] of this.shapes) {
      const at = this.context.viewer.project(shape.position);
      const d = Math.hypot(at.x - x, at.y - y);
      if (d < least) [best, least] = [name, d];
    }
    if (best === undefined && this.chosen === undefined) return false;
    this.choose(best === undefined ? undefined : { kind: "emitter", name: best });
    this.on_choose?.(this.chosen);
    return best !== undefined;
  }

  dispose(): void {
    this.controls.detach();
    this.controls.dispose();
  }

  private target(): THREE.Object3D | undefined {
    if (!this.chosen) return undefined;
    return this.chosen.kind === "emitter" ? this.shapes.get(this.chosen.name) : this.objects.get(this.chosen.name);
  }

  // A sky has no position; a brush follows the surface; both are not moved by handles.
  private attach(): void {
    const target = this.target();
    const emitter = this.chosen?.kind === "emitter" ? this.context.scene.emitters.find((e) => e.name === this.chosen?.name) : undefined;
    const is_sky = emitter?.shape === "sky";
    if (!target || (is_sky && this.mode !== "rotate") || emitter?.shape === "surface") {
      this.controls.detach();
    } else {
      this.controls.attach(target);
      this.controls.setMode(this.mode);
      this.controls.setSpace(this.mode === "translate" ? "world" : "local");
    }
    this.context.viewer.invalidate();
  }

  private show_emitter(emitter: Emitter, scene: SceneState): void {
    let shape = this.shapes.get(emitter.name);
    if (!shape) {
      shape = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: kEmitterColor, transparent: true, depthTest: true }));
      this.shapes.set(emitter.name, shape);
      this.emitters.add(shape);
    }
    (shape.material as THREE.LineBasicMaterial).opacity = emitter.on === false ? 0.3 : 0.95;
    shape.visible = emitter.shape !== "surface";
    if (this.is_dragging && this.target() === shape) return;
    shape.geometry.dispose();
    shape.geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(emitter_lines(emitter, scene), 3));
    emitter_frame(emitter, scene).decompose(shape.position, shape.quaternion, shape.scale);
  }

  private show_object(object: SceneObject): void {
    const shown = this.objects.get(object.name);
    if (!shown || (this.is_dragging && this.target() === shown)) return;
    place_object(shown, object);
  }

  private begin(): void {
    const emitter = this.context.scene.emitters.find((e) => e.name === this.chosen?.name);
    if (emitter) this.start_size = size_of(emitter);
  }

  private changed(): void {
    if (!this.chosen || !this.is_dragging) return;
    const target = this.target();
    if (target && this.mode === "scale" && this.chosen.kind === "object") target.scale.setScalar(Math.max(1e-3, Math.cbrt(Math.abs(target.scale.x * target.scale.y * target.scale.z))));
    this.send(this.chosen);
    this.context.viewer.invalidate_shadows();
  }

  private tell(chosen: Chosen): void {
    const target = chosen.kind === "emitter" ? this.shapes.get(chosen.name) : this.objects.get(chosen.name);
    if (!target) return;
    if (chosen.kind === "object") this.tell_object(chosen.name, target);
    else this.tell_emitter(chosen.name, target);
  }

  private tell_object(name: string, target: THREE.Object3D): void {
    if (this.mode === "translate") this.context.event({ op: "move", target: name, position: rounded(target.position) });
    else if (this.mode === "scale") this.context.event({ op: "scale", target: name, scale: Number(target.scale.x.toFixed(5)) });
    else {
      const angles = new THREE.Euler().setFromQuaternion(target.quaternion, "ZYX");
      const deg = THREE.MathUtils.RAD2DEG;
      this.context.event({ op: "turn", target: name, rotate: rounded({ x: angles.x * deg, y: angles.y * deg, z: angles.z * deg }) });
    }
  }

  private tell_emitter(name: string, target: THREE.Object3D): void {
    const emitter = this.context.scene.emitters.find((e) => e.name === name);
    if (!emitter) return;
    if (this.mode === "translate") {
      this.context.event({ op: "move", target: name, position: rounded(target.position) });
      return;
    }
    const direction = rounded(new THREE.Vector3(0, 0, 1).applyQuaternion(target.quaternion));
    const size = this.start_size.map((s, i) => Number((s * Math.abs(i === 0 ? target.scale.x : target.scale.y)).toFixed(3))) as [number, number];
    this.context.event(emitter_event(this.mode === "rotate" ? { ...emitter, direction } : { ...emitter, size }));
  }
}

/// As the scene says: about x, then y, then z of the world.
export function place_object(shown: THREE.Object3D, object: SceneObject): void {
  shown.position.set(...(object.translate ?? [0, 0, 0]));
  const [x, y, z] = (object.rotate ?? [0, 0, 0]).map((d) => (d * Math.PI) / 180) as [number, number, number];
  shown.rotation.set(x, y, z, "ZYX");
  shown.scale.setScalar(object.scale ?? 1);
}

/// A mesh whose vertices lie where the object is now gets them in the object's own coordinates, and is placed by its node instead.
export function own_coordinates(node: THREE.Object3D, object: SceneObject): void {
  const placed = new THREE.Object3D();
  place_object(placed, object);
  placed.updateMatrix();
  node.updateMatrix();
  const is_placed_by_node = !node.matrix.equals(new THREE.Matrix4());
  if (!is_placed_by_node) {
    const inverse = placed.matrix.clone().invert();
    node.traverse((o) => { if (o instanceof THREE.Mesh) (o.geometry as THREE.BufferGeometry).applyMatrix4(inverse); });
  }
  place_object(node, object);
}
