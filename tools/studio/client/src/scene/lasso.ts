// A line drawn around a part of the picture, and the places of the surface inside it.
import type { Hit } from "./picking";
import type { Viewer } from "./viewer";
import { svg } from "../ui/dom";

const kMostSamples = 12000;
const kLeast_px = 6;

interface Point {
  x: number;
  y: number;
}

/// Whether a point lies inside a closed line (even-odd).
export function is_inside({ x, y }: Point, line: Point[]): boolean {
  let inside = false;
  for (let i = 0, j = line.length - 1; i < line.length; j = i++) {
    const a = line[i]!, b = line[j]!;
    if (a.y > y !== b.y > y && x < a.x + ((b.x - a.x) * (y - a.y)) / (b.y - a.y)) inside = !inside;
  }
  return inside;
}

export class Lasso {
  private readonly line = svg("polygon", {});
  private readonly drawing = svg("svg", { class: "lasso", "aria-hidden": "true" }, this.line);
  private points: Point[] = [];
  private is_on = false;
  private readonly listeners = new AbortController();

  /// @param on_done  The places inside, spread evenly over the picture.
  constructor(private readonly viewer: Viewer, private readonly stage: HTMLElement, private readonly on_done: (hits: Hit[]) => void) {
    const { signal } = this.listeners;
    stage.append(this.drawing);
    stage.addEventListener("pointerdown", (e) => { if (this.is_on && e.target === viewer.canvas && e.button === 0 && e.isPrimary) this.begin(e); }, { capture: true, signal });
    viewer.canvas.addEventListener("pointermove", (e) => { if (this.points.length > 0) this.add(e); }, { signal });
    for (const name of ["pointerup", "pointercancel"] as const) viewer.canvas.addEventListener(name, () => this.end(), { signal });
  }

  get is_active(): boolean { return this.is_on; }

  set_active(is_on: boolean): void {
    this.is_on = is_on;
    this.viewer.canvas.classList.toggle("painting", is_on);
    if (!is_on) this.clear();
  }

  dispose(): void {
    this.listeners.abort();
  }

  private begin(event: PointerEvent): void {
    event.stopPropagation();
    this.viewer.controls.enabled = false;
    this.viewer.canvas.setPointerCapture(event.pointerId);
    this.points = [{ x: event.clientX, y: event.clientY }];
    this.show();
  }

  private add(event: PointerEvent): void {
    const last = this.points[this.points.length - 1]!;
    if (Math.hypot(event.clientX - last.x, event.clientY - last.y) < 2) return;
    this.points.push({ x: event.clientX, y: event.clientY });
    this.show();
  }

  private end(): void {
    if (this.points.length === 0) return;
    const line = this.points;
    this.clear();
    const hits = this.places(line);
    if (hits.length > 0) this.on_done(hits);
  }

  private clear(): void {
    this.points = [];
    this.viewer.controls.enabled = true;
    this.show();
  }

  private show(): void {
    const box = this.stage.getBoundingClientRect();
    this.line.setAttribute("points", this.points.map(({ x, y }) => `${x - box.left},${y - box.top}`).join(" "));
  }

  private places(line: Point[]): Hit[] {
    const xs = line.map((p) => p.x), ys = line.map((p) => p.y);
    const [x0, x1, y0, y1] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    if (x1 - x0 < kLeast_px && y1 - y0 < kLeast_px) return [];
    const step = Math.max(1, Math.sqrt(((x1 - x0) * (y1 - y0)) / kMostSamples));
    const hits: Hit[] = [];
    for (let y = y0 + step / 2; y < y1; y += step) {
      for (let x = x0 + step / 2; x < x1; x += step) {
        const hit = is_inside({ x, y }, line) ? this.viewer.pick(x, y) : undefined;
        if (hit) hits.push(hit);
      }
    }
    return hits;
  }
}
