// A mark over the picture that stays on a place of the scene.
import type * as THREE from "three";
import { h } from "../ui/dom";
import type { Viewer } from "./viewer";

export class Pin {
  readonly element = h("i", { class: "pin", hidden: true });
  private point: THREE.Vector3 | undefined;

  constructor(private readonly viewer: Viewer, private readonly stage: HTMLElement) {
    stage.append(this.element);
  }

  set(point: THREE.Vector3 | undefined): void {
    this.point = point;
    this.place();
    this.viewer.invalidate();
  }

  /// After each frame.
  place(): void {
    this.element.hidden = !this.point;
    if (!this.point) return;
    const box = this.stage.getBoundingClientRect();
    const { x, y } = this.viewer.project(this.point);
    this.element.style.left = `${x - box.left}px`;
    this.element.style.top = `${y - box.top}px`;
  }
}

/// Short names that stay on places.
export class NameTags {
  private tags: { element: HTMLElement; point: THREE.Vector3 }[] = [];

  constructor(private readonly viewer: Viewer, private readonly stage: HTMLElement) {}

  set(names: { text: string; point: THREE.Vector3 }[]): void {
    for (const { element } of this.tags) element.remove();
    this.tags = names.map(({ text, point }) => ({ element: h("b", { class: "name-tag" }, text), point }));
    this.stage.append(...this.tags.map((t) => t.element));
    this.place();
  }

  /// After each frame.
  place(): void {
    if (this.tags.length === 0) return;
    const box = this.stage.getBoundingClientRect();
    for (const { element, point } of this.tags) {
      const { x, y } = this.viewer.project(point);
      element.style.left = `${x - box.left}px`;
      element.style.top = `${y - box.top}px`;
    }
  }
}
