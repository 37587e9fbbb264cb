// Painting: an emitter follows the surface under the pointer. While the button is down the scene runs; one stroke is one undo.
import * as THREE from "three";
import type { Hit } from "../scene/viewer";
import type { Emitter, Vec3 } from "../types";
import { throttle } from "../ui/dom";
import { emitter_event, extent, rounded, size_of, type SceneContext } from "./context";

const kMove_ms = 25;
const kWheelFactor = 1.0015;
const kPinch_ms = 250;

export class Brush {
  /// Name of the emitter that paints.
  emitter = "";
  on_change: (() => void) | undefined;
  /// When a stroke began and moved: for measuring.
  last_sent = 0;
  private is_on = false;
  private is_down = false;
  private began = 0;
  private was_running = true;
  private pointer: { x: number; y: number } | undefined;
  private readonly ring: THREE.LineSegments;
  private readonly move: (at: Vec3) => void;
  private readonly send_emitter: (emitter: Emitter) => void;
  private readonly listeners = new AbortController();

  constructor(private readonly context: SceneContext, stage: HTMLElement) {
    this.ring = new THREE.LineSegments(ring_geometry(), new THREE.LineBasicMaterial({ color: 0xf2a65a, depthTest: false, transparent: true }));
    this.ring.renderOrder = 10;
    this.ring.visible = false;
    context.viewer.scene.add(this.ring);
    this.move = throttle(kMove_ms, (at) => this.tell("move", at));
    this.send_emitter = throttle(60, (emitter: Emitter) => this.context.event(emitter_event(emitter)));
    const { canvas } = context.viewer;
    const { signal } = this.listeners;
    // Before the camera's own listeners, so that the left button and one finger paint.
    stage.addEventListener("pointerdown", (e) => { if (e.target === canvas) this.down(e); }, { capture: true, signal });
    stage.addEventListener("pointerdown", (e) => { if (!e.isPrimary) this.second_finger(); }, { capture: true, signal });
    canvas.addEventListener("pointermove", (e) => { if (e.isPrimary) this.hover(e); }, { signal });
    for (const name of ["pointerup", "pointercancel"] as const) canvas.addEventListener(name, () => this.up(), { signal });
    canvas.addEventListener("pointerleave", () => { if (!this.is_down) this.show_ring(undefined); }, { signal });
    stage.addEventListener("wheel", (e) => this.wheel(e), { capture: true, passive: false, signal });
  }

  get is_active(): boolean { return this.is_on; }

  /// The emitter that paints now, undefined where the scene has none.
  current(): Emitter | undefined {
    const { emitters } = this.context.scene;
    return emitters.find((e) => e.name === this.emitter) ?? emitters.find((e) => e.shape === "surface") ?? emitters[0];
  }

  set_active(is_on: boolean): void {
    this.is_on = is_on;
    this.context.viewer.controls.mouseButtons.LEFT = is_on ? null : THREE.MOUSE.ROTATE;
    this.context.viewer.controls.touches.ONE = is_on ? null : THREE.TOUCH.ROTATE;
    if (!is_on) this.show_ring(undefined);
    this.context.viewer.canvas.classList.toggle("painting", is_on);
  }

  /// Width, distance or spread; all others stay.
  change(fields: Partial<Emitter>): void {
    const emitter = this.current();
    if (!emitter) return;
    Object.assign(emitter, fields);
    this.send_emitter(emitter);
    this.on_change?.();
  }

  dispose(): void {
    this.listeners.abort();
    this.ring.geometry.dispose();
  }

  private down(event: PointerEvent): void {
    if (!this.is_on || event.button !== 0 || !event.isPrimary) return;
    const hit = this.context.viewer.pick(event.clientX, event.clientY);
    const emitter = this.current();
    if (!hit || !emitter) return;
    this.context.viewer.canvas.setPointerCapture(event.pointerId);
    const at = rounded(hit.point);
    // An emitter of another shape becomes a brush: from now on it waits for strokes.
    if (emitter.shape !== "surface") {
      const width = size_of(emitter)[0];
      const brush: Emitter = { ...emitter, shape: "surface", position: at, on: false, size: width > 0 ? Math.min(width, 0.2 * extent(this.context.scene)) : 0.06 * extent(this.context.scene), distance: 0.05 * extent(this.context.scene), spread_deg: Math.min(emitter.spread_deg ?? 0, 60) };
      Object.assign(emitter, brush);
      this.context.event(emitter_event(brush));
    }
    this.is_down = true;
    this.began = performance.now();
    this.was_running = this.context.is_running;
    this.tell("begin", at);
    if (!this.was_running) void this.context.send("run");
  }

  // Once a frame: looking for the surface under the pointer costs milliseconds on large meshes.
  private hover(event: { clientX: number; clientY: number }): void {
    if (!this.is_on) return;
    const is_asked = this.pointer !== undefined;
    this.pointer = { x: event.clientX, y: event.clientY };
    if (!is_asked) requestAnimationFrame(() => this.follow());
  }

  private follow(): void {
    const at = this.pointer;
    this.pointer = undefined;
    if (!at || !this.is_on) return;
    const hit = this.context.viewer.pick(at.x, at.y);
    this.show_ring(hit);
    if (this.is_down && hit) this.move(rounded(hit.point));
  }

  private up(): void {
    if (!this.is_down) return;
    this.is_down = false;
    void this.context.send("stroke", { emitter: this.current()?.name, phase: "end" });
    if (!this.was_running) void this.context.send("pause");
  }

  // Two fingers move the camera: the stroke of the first ends, and was none if it has only just begun.
  private second_finger(): void {
    if (!this.is_down) return;
    this.up();
    if (performance.now() - this.began < kPinch_ms) void this.context.send("undo");
  }

  private tell(phase: "begin" | "move", position: Vec3): void {
    if (phase === "move" && !this.is_down) return;
    this.last_sent = performance.now();
    void this.context.send("stroke", { emitter: this.current()?.name, position, phase });
  }

  private wheel(event: WheelEvent): void {
    if (!this.is_on || event.ctrlKey || event.metaKey) return;
    const emitter = this.current();
    if (!emitter || event.target !== this.context.viewer.canvas) return;
    event.preventDefault();
    event.stopPropagation();
    const factor = kWheelFactor ** -(event.deltaY || event.deltaX);
    if (event.shiftKey) this.change({ size: Math.max(0.01, size_of(emitter)[0] * factor) });
    else this.change({ distance: Math.max(0.01, (emitter.distance ?? 10) * factor) });
    this.hover(event);
  }

  // A circle as wide as the brush on the surface, another where the emitter is, and a line between.
  private show_ring(hit: Hit | undefined): void {
    const emitter = this.current();
    this.ring.visible = hit !== undefined && emitter !== undefined;
    if (hit && emitter) {
      const is_brush = emitter.shape === "surface";
      const width = is_brush ? size_of(emitter)[0] : 0.06 * extent(this.context.scene);
      const distance = is_brush ? (emitter.distance ?? 10) : 0.05 * extent(this.context.scene);
      this.ring.position.copy(hit.point);
      this.ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), hit.normal);
      this.ring.scale.set(width / 2, width / 2, distance);
    }
    this.context.viewer.invalidate();
  }
}

function ring_geometry(): THREE.BufferGeometry {
  const points: number[] = [];
  const num = 56;
  for (const z of [0, 1]) {
    for (let i = 0; i < num; ++i) {
      for (const k of [i, i + 1]) points.push(Math.cos((2 * Math.PI * k) / num), Math.sin((2 * Math.PI * k) / num), z);
    }
  }
  points.push(0, 0, 0, 0, 0, 1);
  return new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
}
