// The line between two times, to be dragged across the stage.
import { h } from "../ui/dom";

const kStep = 0.02;

export class Wipe {
  readonly element: HTMLElement;
  share = 0.5;
  private readonly left = h("span", { class: "tag left" });
  private readonly right = h("span", { class: "tag right" });

  constructor(private readonly stage: HTMLElement, private readonly on_move: (share: number) => void) {
    const grip = h("div", { class: "grip", "aria-hidden": "true" }, "◂ ▸");
    this.element = h("div", { class: "wipe", role: "slider", tabindex: 0, "aria-label": "Line between the two times", "aria-valuemin": 0, "aria-valuemax": 100 }, this.left, grip, this.right);
    this.element.addEventListener("pointerdown", (event) => {
      this.element.setPointerCapture(event.pointerId);
      event.preventDefault();
      this.element.focus();
    });
    this.element.addEventListener("pointermove", (event) => {
      if (!this.element.hasPointerCapture(event.pointerId)) return;
      const box = this.stage.getBoundingClientRect();
      this.set((event.clientX - box.left) / box.width);
    });
    this.element.addEventListener("keydown", (event) => {
      const by = event.key === "ArrowLeft" ? -kStep : event.key === "ArrowRight" ? kStep : 0;
      if (by === 0) return;
      event.preventDefault();
      event.stopPropagation();
      this.set(this.share + by);
    });
    stage.append(this.element);
    this.set(0.5);
    this.show(false);
  }

  show(is_shown: boolean): void { this.element.hidden = !is_shown; }

  label(left: string, right: string): void {
    this.left.textContent = left;
    this.right.textContent = right;
  }

  set(share: number): void {
    this.share = Math.min(Math.max(share, 0), 1);
    this.element.style.left = `${100 * this.share}%`;
    this.element.setAttribute("aria-valuenow", String(Math.round(100 * this.share)));
    this.on_move(this.share);
  }
}
