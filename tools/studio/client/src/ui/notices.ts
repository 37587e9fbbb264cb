// Short messages that go away, errors that stay until read, and the line that shows long work.
import { icon_button } from "./controls";
import { h } from "./dom";

const stack = h("div", { class: "notices", role: "status", "aria-live": "polite" });
document.body.append(stack);

const kStays_ms = 6000, kRead_ms = 70;  ///< At least, and for each letter.

export function notice(text: string, kind: "info" | "error" = "info"): void {
  if ([...stack.children].some((child) => child.firstChild?.textContent === text)) return;
  const element = h("div", { class: `notice ${kind}`, role: kind === "error" ? "alert" : undefined }, h("span", {}, text), icon_button("close", "Dismiss", () => element.remove()));
  stack.append(element);
  if (kind === "info") window.setTimeout(() => element.remove(), Math.max(kStays_ms, kRead_ms * text.length));
}

/// For the end of a promise: its error as a notice; what the user has cancelled is none.
export function show_error(error: unknown): void {
  if (error instanceof DOMException && error.name === "AbortError") return;
  notice(error instanceof Error ? error.message : String(error), "error");
}

export interface Progress {
  set(text: string, share?: number): void;
  end(): void;
}

/// Work that takes a while. `cancel` adds a button.
export function progress(parent: HTMLElement, text: string, cancel?: () => void): Progress {
  const label = h("span", {}, text);
  const bar = h("progress", { max: 1, "aria-label": text });
  const stop = (): void => {
    cancel?.();
    element.remove();
  };
  const element = h("div", { class: "progress", role: "status" }, label, bar, cancel && h("button", { type: "button", onclick: stop }, "Cancel"));
  parent.append(element);
  return {
    set: (said, share) => {
      label.textContent = said;
      if (share === undefined) bar.removeAttribute("value");
      else bar.value = share;
    },
    end: () => element.remove(),
  };
}
