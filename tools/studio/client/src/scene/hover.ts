// What stands under the cursor, in words beside it.
import { h, replace } from "../ui/dom";
import type { Hit } from "./picking";
import type { Viewer } from "./viewer";

const kAside_px = 16;

export class Hover {
  private readonly tag = h("div", { class: "hover-tag", "aria-hidden": "true", hidden: true });
  private at: { x: number; y: number } | undefined;
  private is_asked = false;
  private readonly listeners = new AbortController();

  /// @param lines  What is said of a place; nothing: no words.
  constructor(private readonly viewer: Viewer, private readonly stage: HTMLElement, private readonly lines: (hit: Hit) => string[]) {
    const { signal } = this.listeners, { canvas } = viewer;
    stage.append(this.tag);
    canvas.addEventListener("pointermove", (e) => {
      if (e.pointerType === "touch") return;
      this.at = e.buttons === 0 ? { x: e.clientX, y: e.clientY } : undefined;
      this.ask();
    }, { signal });
    canvas.addEventListener("pointerleave", () => { this.at = undefined; this.ask(); }, { signal });
  }

  /// What stands there has changed.
  refresh(): void {
    if (this.at) this.ask();
  }

  dispose(): void {
    this.listeners.abort();
    this.tag.remove();
  }

  private ask(): void {
    if (this.is_asked) return;
    this.is_asked = true;
    requestAnimationFrame(() => {
      this.is_asked = false;
      this.show();
    });
  }

  private show(): void {
    const { at, viewer } = this;
    const hit = at && this.stage.isConnected ? viewer.pick(at.x, at.y) : undefined;
    const lines = hit ? this.lines(hit) : [];
    this.tag.hidden = !at || lines.length === 0;
    if (!at || this.tag.hidden) return;
    replace(this.tag, lines.map((line) => h("span", {}, line)));
    const box = this.stage.getBoundingClientRect();
    const is_right = at.x - box.left > box.width - this.tag.offsetWidth - 2 * kAside_px, is_low = at.y - box.top > box.height - this.tag.offsetHeight - 2 * kAside_px;
    this.tag.style.left = `${at.x - box.left + (is_right ? -kAside_px - this.tag.offsetWidth : kAside_px)}px`;
    this.tag.style.top = `${at.y - box.top + (is_low ? -kAside_px - this.tag.offsetHeight : kAside_px)}px`;
  }
}
