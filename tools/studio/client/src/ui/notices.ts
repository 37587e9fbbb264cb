// Messages in the lower right corner, over the end of the panel, which scrolls: the picture neither moves nor is covered. Short ones go away;
// errors stay until they are read, or until what they are about works again.
import { button, icon_button } from "./controls";
import { h } from "./dom";

const stack = h("div", { class: "notices", role: "status", "aria-live": "polite" });
/// For the page.
export const notice_area: HTMLElement = stack;

// A panel ends above them, so that all of it can be scrolled to.
new ResizeObserver(() => document.documentElement.style.setProperty("--notices", `${stack.offsetHeight}px`)).observe(stack);

const kStays_ms = 6000, kRead_ms = 70;  ///< At least, and for each letter.

const all = (): HTMLElement[] => [...stack.children] as HTMLElement[];

// A newer message about the same takes the place of the older one.
function put(element: HTMLElement, about: string): void {
  const before = about ? all().find((child) => child.dataset["about"] === about) : undefined;
  if (before) before.replaceWith(element);
  else stack.append(element);
}

/// @param about  What it is about: a newer message about the same takes its place, settle() takes it away.
export function notice(text: string, kind: "info" | "error" = "info", about = ""): void {
  if (all().some((child) => child.firstChild?.textContent === text)) return;
  const element = h("div", { class: `notice ${kind}`, role: kind === "error" ? "alert" : undefined, "data-about": about || undefined }, h("span", {}, text), icon_button("close", "Dismiss", () => element.remove()));
  put(element, about);
  if (kind === "info") window.setTimeout(() => element.remove(), Math.max(kStays_ms, kRead_ms * text.length));
}

/// Something that can be done, with a button for it. It stays until that is pressed, it is dismissed, or settle() says that it cannot be done any more.
export function offer(text: string, action: string, about: string, go: () => void, dismiss: () => void): void {
  const end = (then: () => void) => (): void => {
    element.remove();
    then();
  };
  const element = h("div", { class: "notice info offer", "data-about": about }, h("span", {}, text), button(action, end(go)), icon_button("close", "Dismiss", end(dismiss)));
  put(element, about);
}

/// It works again: what was said about it is no longer true.
export function settle(about: string): void {
  for (const child of all()) if (about && child.dataset["about"] === about) child.remove();
}

/// Another page is shown: all that was said was about the one before.
export function clear_notices(): void {
  stack.replaceChildren();
}

/// For the end of a promise: its error as a notice; what the user has canceled is none. @param about  Unless the error knows.
export function show_error(error: unknown, about = ""): void {
  if (error instanceof DOMException && error.name === "AbortError") return;
  notice(error instanceof Error ? error.message : String(error), "error", (error as { about?: string }).about || about);
}

/// Gives the user a file to keep.
export function download(file: Blob, name: string): void {
  const link = h("a", { href: URL.createObjectURL(file), download: name });
  link.click();
  window.setTimeout(() => URL.revokeObjectURL(link.href), 10000);
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

/// What cannot be shown, where it would be: why, and what can be done.
export function failure(title: string, why: string): HTMLElement {
  return h("div", { class: "failure", role: "alert" }, h("h2", {}, title), h("p", {}, why),
    h("p", { class: "ways" }, h("button", { type: "button", class: "primary", onclick: () => location.reload() }, "Try again"), h("a", { href: "#/" }, "All places")));
}
