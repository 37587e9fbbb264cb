// Painting: an emitter follows the surface under the pointer. While the button is down nothing else lives; one stroke is one undo.
import * as THREE from "three";
import type { Hit } from "../scene/viewer";
import type { Emitter } from "../types";
import { throttle } from "../ui/dom";
import { notice, settle } from "../ui/notices";
import { emitter_event, extent, rounded, size_of, type SceneContext } from "./context";
import { way_between, type Spot } from "./way";

const kMove_ms = 25;
const kWheelFactor = 1.0015;
const kPinch_ms = 250;
const kBrushColor = 0xf2a65a, kEraserColor = 0xffffff;

export class Brush {
  /// Name of the emitter that paints.
  emitter = "";
  /// Materials that it takes away, in place of laying any down; none: it paints.
  erased: string[] = [];
  on_change: (() => void) | undefined;
  /// When a stroke began and moved: for measuring.
  last_sent = 0;
  private is_on = false;
  private is_down = false;
  private began = 0;
  /// Where the pointer was since the last frame.
  private trail: { x: number; y: number }[] = [];
  private is_asked = false;
  /// Where the brush was last, on the surface.
  private last: Spot | undefined;
  /// Of the way that is not told yet.
  private untold: Spot[] = [];
  private readonly ring: THREE.LineSegments;
  private readonly tell_soon: () => void;
  private readonly send_emitter: (emitter: Emitter) => void;
  private readonly listeners = new AbortController();

  constructor(private readonly context: SceneContext, stage: HTMLElement) {
    this.ring = new THREE.LineSegments(ring_geometry(), new THREE.LineBasicMaterial({ color: kBrushColor, depthTest: false, transparent: true }));
    this.ring.renderOrder = 10;
    this.ring.visible = false;
    context.viewer.scene.add(this.ring);
    this.tell_soon = throttle(kMove_ms, () => { if (this.is_down) this.tell("move"); });
    this.send_emitter = throttle(60, (emitter: Emitter) => this.context.event(emitter_event(emitter)));
    const { canvas } = context.viewer;
    const { signal } = this.listeners;
    // Before the camera's own listeners, so that the left button and one finger paint.
    stage.addEventListener("pointerdown", (e) => { if (e.target === canvas) this.down(e); }, { capture: true, signal });
    stage.addEventListener("pointerdown", (e) => { if (!e.isPrimary) this.second_finger(); }, { capture: true, signal });
    canvas.addEventListener("pointermove", (e) => { if (e.isPrimary) this.hover(e); }, { signal });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"] as const) canvas.addEventListener(name, () => this.up(), { signal });
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
    if (!emitter) return;
    if (!hit) return notice("A stroke begins on the surface: beside it nothing is painted.", "info", "stroke");
    settle("stroke");
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
    this.trail = [];
    this.last = { x: event.clientX, y: event.clientY, point: hit.point };
    this.untold = [this.last];
    this.tell("begin");
  }

  // Once a frame: looking for the surface under the pointer costs milliseconds on large meshes. All places since the last one count.
  private hover(event: { clientX: number; clientY: number; getCoalescedEvents?: () => PointerEvent[] }): void {
    if (!this.is_on) return;
    const all = this.is_down ? event.getCoalescedEvents?.() ?? [] : [];
    for (const e of all.length > 0 ? all : [event]) this.trail.push({ x: e.clientX, y: e.clientY });
    if (this.is_asked) return;
    this.is_asked = true;
    requestAnimationFrame(() => this.follow());
  }

  private follow(): void {
    this.is_asked = false;
    const trail = this.trail.splice(0), at = trail[trail.length - 1];
    if (!at || !this.is_on) return;
    this.show_ring(this.is_down ? this.paint_along(trail) : this.context.viewer.pick(at.x, at.y));
    if (this.untold.length > 0) this.tell_soon();
  }

  // However rarely pictures come, the way has no gaps but those of the surface.
  private paint_along(trail: { x: number; y: number }[]): Hit | undefined {
    const { viewer } = this.context;
    let hit: Hit | undefined;
    const pick = (x: number, y: number): THREE.Vector3 | undefined => (hit = viewer.pick(x, y))?.point;
    for (const { x, y } of trail) {
      const to: Spot = { x, y, point: pick(x, y) };
      const found = hit;
      const from = this.last ?? to;
      this.untold.push(...way_between(from, to, { spacing: this.width() / 2, mm_per_px: viewer.mm_per_px(from.point ?? to.point), pick }));
      this.last = to;
      hit = found;
    }
    return hit;
  }

  private width(): number {
    const emitter = this.current();
    return (emitter && (size_of(emitter)[0] || emitter.distance)) || 0.01 * extent(this.context.scene);
  }

  private up(): void {
    if (!this.is_down) return;
    this.paint_along(this.trail.splice(0));
    this.is_down = false;
    this.tell("end");
  }

  // Two fingers move the camera: the stroke of the first ends, and was none if it has only just begun.
  private second_finger(): void {
    if (!this.is_down) return;
    this.up();
    if (performance.now() - this.began < kPinch_ms) void this.context.send("undo");
  }

  // Where the surface ends under the brush it is lifted: `jump` says that a part of the way is not joined to the one before.
  private tell(phase: "begin" | "move" | "end"): void {
    this.last_sent = performance.now();
    const emitter = this.current()?.name;
    const parts: Spot[][] = [[]];
    for (const spot of this.untold.splice(0)) {
      if (spot.is_jump) parts.push([]);
      if (spot.point) parts[parts.length - 1]!.push(spot);
    }
    parts.forEach((part, i) => {
      const is_last = i === parts.length - 1;
      if (part.length === 0 && !(is_last && phase === "end")) return;
      const positions = part.map((spot) => rounded(spot.point!));
      const erase = phase === "begin" && i === 0 && this.erased.length > 0 ? { erase: this.erased } : {};
      void this.context.send("stroke", { emitter, positions, phase: is_last ? phase : "move", ...(i > 0 ? { jump: true } : {}), ...erase });
    });
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
    (this.ring.material as THREE.LineBasicMaterial).color.set(this.erased.length > 0 ? kEraserColor : kBrushColor);
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
