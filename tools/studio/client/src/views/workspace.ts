// The frame of all views with a picture: stage with its tools, panel beside it, bar below.
import { kLights } from "../scene/environment";
import type { Viewer } from "../scene/viewer";
import { icon_button, select, slider, toggle } from "../ui/controls";
import { h, type Child } from "../ui/dom";

export interface Workspace {
  element: HTMLElement;
  stage: HTMLElement;
  panel: HTMLElement;
  bar: HTMLElement;
  /// In the upper left corner of the stage.
  tools: HTMLElement;
}

export function workspace(label: string): Workspace {
  const tools = h("div", { class: "tools", role: "toolbar", "aria-label": "View" });
  const stage = h("div", { class: "stage", role: "region", "aria-label": label }, tools);
  const panel = h("aside", { class: "panel", "aria-label": "Settings" });
  const bar = h("div", { class: "bar" });
  return { element: h("main", { class: "workspace" }, bar, stage, panel), stage, panel, bar, tools };
}

export function toggle_full_screen(element: HTMLElement): void {
  if (document.fullscreenElement) void document.exitFullscreen();
  else void element.requestFullscreen?.();
}

/// Fit and full screen, and for meshes the light.
export function view_tools(viewer: Viewer, place: HTMLElement, full: HTMLElement): void {
  place.append(icon_button("fit", "Fit the view", () => viewer.fit(), "F"), icon_button("full", "Full screen", () => toggle_full_screen(full), "Shift F"));
}

/// Controls of light and shadows, for a panel.
export function light_controls(viewer: Viewer): Child[] {
  let name = "studio";
  const turn = slider({ label: "Turn the light", low: -180, high: 180, step: 1, value: 0, unit: "°", on_input: (v) => viewer.set_light(name, v) });
  const light = select("Light", kLights.map((l) => [l.name, l.text] as [string, string]), name, (chosen) => {
    name = chosen;
    viewer.set_light(name, turn.get());
  });
  return [light.element, turn.element, toggle("Shadows", true, (on) => viewer.set_shadows(on)).element];
}

export function facts_table(facts: [string, string][]): HTMLElement {
  return h("dl", { class: "facts" }, facts.map(([label, text]) => [h("dt", {}, label), h("dd", {}, text)]).flat());
}
