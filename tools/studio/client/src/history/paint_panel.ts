// Painting the control of a transfer: strokes go to the server, and the texels that it has searched again come back.
import * as THREE from "three";
import { post, url_of, type Texture } from "../api";
import type { Hit, Viewer } from "../scene/viewer";
import { way_between, type Spot } from "../simulation/way";
import type { HistoryPlace } from "../types";
import { button, number_text, section, select, slider, toggle, type Toggle } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { progress, settle, show_error } from "../ui/notices";

const kAbout = "/api/paint";
const kPause_ms = 1000;   ///< Without a stroke, before borders are refined.
const kMostPoints = 256;  ///< In one request.
const kRingColor = 0xf2a65a;

/// What the server says with every answer.
interface Painted {
  tile: number;
  count: number;
  width: number;
  height: number;
  texel_mm: number;
  controls: { name: string; low: number; high: number; unit: string }[];
  done: string[];
  undone: string[];
  can_refine: boolean;
  file: string;
  command: string;
}

export interface PaintOptions {
  place: HistoryPlace;
  viewer: Viewer;
  stage: HTMLElement;
  /// That is on screen, and what it was made with.
  shown(): { texture: Texture | undefined; time: number; between: string };
  /// Its bytes have changed.
  on_change(): void;
}

/// Puts tiles of `side` x `side` texels of four bytes into a texture.
export function put_tiles(texture: { width: number; height: number; bytes: Uint8Array }, numbers: Uint32Array, texels: Uint8Array, side: number): void {
  const columns = Math.ceil(texture.width / side);
  numbers.forEach((number, i) => {
    const x = (number % columns) * side, y = Math.floor(number / columns) * side, width = Math.min(side, texture.width - x);
    for (let row = 0; row < Math.min(side, texture.height - y); ++row) {
      const from = 4 * (i * side + row) * side;
      texture.bytes.set(texels.subarray(from, from + 4 * width), 4 * ((y + row) * texture.width + x));
    }
  });
}

export class PaintPanel {
  readonly element: HTMLDetailsElement;
  /// How long the last stroke took, from the request to its texels, ms.
  last_ms = 0;
  num_answers = 0;
  private readonly body = h("div", { class: "stack" });
  private readonly settings = h("div", { class: "stack" });
  private readonly steps = h("ol", { class: "steps-done", "aria-label": "Steps, the first one at the top" });
  private readonly command = h("div", { class: "stack" });
  private readonly on: Toggle;
  private readonly undo_button = button("Undo", () => void this.undo(), { icon: "undo", hint: "Takes the last step back", key: "Ctrl Z" });
  private readonly redo_button = button("Redo", () => void this.redo(), { icon: "redo", hint: "Does it again", key: "Ctrl Shift Z" });
  private readonly ring: THREE.LineLoop;
  private readonly listeners = new AbortController();
  private painted: Painted | undefined;
  private control = "";
  private value = 1;
  private flow = 0.5;
  private radius = 0;
  private is_on = false;
  private is_down = false;
  private gesture = Date.now();
  private trail: { x: number; y: number }[] = [];
  private last: Spot | undefined;
  private untold: { gesture: number; at: [number, number, number] }[] = [];
  private is_sending = false;
  private is_asked = false;
  private pause: number | undefined;
  private queue: Promise<void> = Promise.resolve();

  constructor(private readonly options: PaintOptions) {
    const { viewer, stage } = options;
    this.on = toggle("Paint", false, (is_on) => void this.set_active(is_on), "The left button, or one finger, then paints");
    this.element = section("Paint the control", false, this.on.element, this.body);
    const circle = Array.from({ length: 64 }, (_, i) => new THREE.Vector3(Math.cos((Math.PI * i) / 32), Math.sin((Math.PI * i) / 32), 0));
    this.ring = new THREE.LineLoop(new THREE.BufferGeometry().setFromPoints(circle), new THREE.LineBasicMaterial({ color: kRingColor, depthTest: false, transparent: true }));
    this.ring.renderOrder = 10;
    this.ring.visible = false;
    viewer.scene.add(this.ring);
    const { canvas } = viewer, { signal } = this.listeners;
    // Before the camera's own listeners, so that the left button and one finger paint.
    stage.addEventListener("pointerdown", (e) => { if (e.target === canvas) this.down(e); }, { capture: true, signal });
    canvas.addEventListener("pointermove", (e) => { if (e.isPrimary) this.move(e); }, { signal });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"] as const) canvas.addEventListener(name, () => this.up(), { signal });
    canvas.addEventListener("pointerleave", () => { if (!this.is_down) this.show_ring(undefined); }, { signal });
  }

  get is_active(): boolean { return this.is_on; }
  get is_open(): boolean { return this.painted !== undefined; }

  /// When everything that was asked for has come.
  async settled(): Promise<void> {
    do await this.queue; while (this.is_sending || this.untold.length > 0);
  }

  async set_active(is_on: boolean): Promise<void> {
    const { viewer, stage } = this.options;
    if (is_on && !this.painted) {
      const work = progress(stage, "Preparing the transfer for painting ...");
      try {
        await this.ask({ do: "look" });
      } catch (error) {
        show_error(error, kAbout);
        this.on.set(false);
        return;
      } finally {
        work.end();
      }
    }
    this.is_on = is_on;
    this.on.set(is_on);
    viewer.controls.mouseButtons.LEFT = is_on ? null : THREE.MOUSE.ROTATE;
    viewer.controls.touches.ONE = is_on ? null : THREE.TOUCH.ROTATE;
    viewer.canvas.classList.toggle("painting", is_on);
    if (!is_on) this.show_ring(undefined);
  }

  /// Another time is on screen.
  refresh(): void {
    if (this.painted) void this.ask({ do: "look" }).catch((error: unknown) => show_error(error, kAbout));
  }

  undo(): Promise<void> { return this.step("undo"); }
  redo(): Promise<void> { return this.step("redo"); }

  dispose(): void {
    window.clearTimeout(this.pause);
    this.listeners.abort();
    this.ring.geometry.dispose();
  }

  private async step(what: "undo" | "redo" | "refine"): Promise<void> {
    window.clearTimeout(this.pause);
    await this.ask({ do: what }).catch((error: unknown) => show_error(error, kAbout));
  }

  // One request after the other: each answer is of the state that the next one changes.
  private ask(what: object): Promise<void> {
    const asked = this.queue.then(() => this.exchange(what));
    this.queue = asked.catch(() => undefined);
    return asked;
  }

  private async exchange(what: object): Promise<void> {
    const { place } = this.options, { time, between } = this.options.shown();
    const message = await (await post(url_of(kAbout, { place: place.place }), { ...what, time, between })).arrayBuffer();
    settle(kAbout);
    const header_bytes = new DataView(message).getUint32(0, true);
    const painted = JSON.parse(new TextDecoder().decode(new Uint8Array(message, 4, header_bytes))) as Painted;
    const begin = 4 + header_bytes, now = this.options.shown();
    // Of a time that is not shown any more, nothing counts: refresh() has asked again.
    if (now.texture && now.time === time && now.between === between) {
      put_tiles(now.texture, new Uint32Array(message, begin, painted.count), new Uint8Array(message, begin + 4 * painted.count), painted.tile);
      this.options.on_change();
    }
    ++this.num_answers;
    this.show(painted);
  }

  private show(painted: Painted): void {
    const is_first = !this.painted;
    this.painted = painted;
    if (is_first) this.build(painted);
    this.undo_button.disabled = painted.done.length === 0;
    this.redo_button.disabled = painted.undone.length === 0;
    replace(this.steps, painted.done.map((label, i) => h("li", { class: "done" }, h("span", { "aria-current": i === painted.done.length - 1 ? "step" : undefined }, label))),
      painted.undone.slice().reverse().map((label) => h("li", { class: "undone" }, h("span", {}, label))));
    this.steps.scrollTop = this.steps.scrollHeight;
    replace(this.command, painted.done.length > 0 && h("p", { class: "hint" }, `Kept in ${painted.file}.`),
      painted.done.length > 0 && painted.command !== "" && [h("p", { class: "hint" }, "This command makes it again, to the byte:"), h("code", { class: "command" }, painted.command)]);
  }

  private build(painted: Painted): void {
    this.control = painted.controls[0]!.name;
    this.radius = 32 * painted.texel_mm;
    const value_of = (): { low: number; high: number; unit: string } => painted.controls.find((c) => c.name === this.control)!;
    const words = h("p", { class: "hint" });
    const say = (): void => {
      const { low, high, unit } = value_of();
      replace(words, `0 is the least ${this.control} of the history (${number_text(low)} ${unit}), 1 the greatest (${number_text(high)} ${unit}).`);
    };
    say();
    replace(this.settings,
      painted.controls.length > 1 && select("Control", painted.controls.map((c) => [c.name, c.name] as [string, string]), this.control, (name) => {
        this.control = name;
        say();
      }).element,
      slider({ label: "Value", low: 0, high: 1, step: 0.01, value: this.value, on_input: (v) => { this.value = v; } }).element, words,
      slider({ label: "Flow", low: 0.02, high: 1, step: 0.01, value: this.flow, hint: "How much of the way to the value one place of the brush goes; a brush that stays goes on", on_input: (v) => { this.flow = v; } }).element,
      slider({ label: "Radius", low: 2 * painted.texel_mm, high: 256 * painted.texel_mm, value: this.radius, logarithmic: true, unit: "mm", on_input: (v) => { this.radius = v; } }).element);
    replace(this.body, this.settings, h("div", { class: "control row" }, this.undo_button, this.redo_button), this.steps, this.command);
  }

  private down(event: PointerEvent): void {
    if (!this.is_on || event.button !== 0 || !event.isPrimary) return;
    const hit = this.options.viewer.pick(event.clientX, event.clientY);
    if (!hit) return;
    window.clearTimeout(this.pause);
    this.options.viewer.canvas.setPointerCapture(event.pointerId);
    this.is_down = true;
    ++this.gesture;
    this.trail = [];
    this.last = { x: event.clientX, y: event.clientY, point: hit.point };
    this.untold.push({ gesture: this.gesture, at: rounded(hit.point) });
    void this.send();
  }

  private move(event: PointerEvent): void {
    if (!this.is_on) return;
    this.trail.push({ x: event.clientX, y: event.clientY });
    if (this.is_asked) return;
    this.is_asked = true;
    requestAnimationFrame(() => {
      this.is_asked = false;
      const trail = this.trail.splice(0), at = trail[trail.length - 1];
      if (!at || !this.is_on) return;
      if (this.is_down) this.paint_along(trail);
      this.show_ring(this.options.viewer.pick(at.x, at.y));
    });
  }

  private paint_along(trail: { x: number; y: number }[]): void {
    const { viewer } = this.options, pick = (x: number, y: number): THREE.Vector3 | undefined => viewer.pick(x, y)?.point;
    for (const { x, y } of trail) {
      const to: Spot = { x, y, point: pick(x, y) }, from = this.last ?? to;
      for (const spot of way_between(from, to, { spacing: this.radius / 2, mm_per_px: viewer.mm_per_px(from.point ?? to.point), pick })) {
        if (spot.point) this.untold.push({ gesture: this.gesture, at: rounded(spot.point) });
      }
      this.last = to;
    }
    void this.send();
  }

  private up(): void {
    if (!this.is_down) return;
    this.paint_along(this.trail.splice(0));
    this.is_down = false;
    this.refine_later();
  }

  // The whole stroke is to be there first: it would be two steps otherwise.
  private refine_later(): void {
    window.clearTimeout(this.pause);
    this.pause = window.setTimeout(() => {
      if (this.is_sending) this.refine_later();
      else if (this.painted?.can_refine && !this.is_down) void this.step("refine");
    }, kPause_ms);
  }

  // While an answer is on its way, places gather: each request has all since the last one.
  private async send(): Promise<void> {
    if (this.is_sending) return;
    this.is_sending = true;
    try {
      while (this.untold.length > 0) {
        const { gesture } = this.untold[0]!, began = performance.now();
        const num = this.untold.findIndex((place) => place.gesture !== gesture);
        const points_mm = this.untold.splice(0, Math.min(kMostPoints, num < 0 ? Infinity : num)).map(({ at }) => at);
        await this.ask({ do: "stroke", gesture, edit: { kind: "stroke", control: this.control, value: this.value, flow: this.flow, radius_mm: this.radius, points_mm } });
        this.last_ms = performance.now() - began;
      }
    } catch (error) {
      this.untold = [];
      show_error(error, kAbout);
    } finally {
      this.is_sending = false;
    }
  }

  private show_ring(hit: Hit | undefined): void {
    this.ring.visible = hit !== undefined;
    if (hit) {
      this.ring.position.copy(hit.point);
      this.ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), hit.normal);
      this.ring.scale.setScalar(this.radius);
    }
    this.options.viewer.invalidate();
  }
}

function rounded(point: THREE.Vector3): [number, number, number] {
  const to = (v: number): number => Math.round(v * 1e4) / 1e4;
  return [to(point.x), to(point.y), to(point.z)];
}
