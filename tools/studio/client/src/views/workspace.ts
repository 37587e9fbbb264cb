// The frame of all views with a picture: stage with its tools, panel beside it, bar below.
import { kLights } from "../scene/environment";
import type { Viewer } from "../scene/viewer";
import { read_surroundings } from "../scene/picture_file";
import { button, icon_button, select, slider, toggle } from "../ui/controls";
import { h, type Child } from "../ui/dom";
import { show_error } from "../ui/notices";

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
  const options = kLights.map((l) => [l.name, l.text] as [string, string]);
  const light = select("Light", options, name, (chosen) => {
    name = chosen;
    viewer.set_light(name, turn.get());
  });
  const shown = toggle("Show the surroundings", false, (on) => viewer.show_surroundings(on), "As background");
  const take = async (file: File): Promise<void> => {
    try {
      viewer.add_light(file.name, await read_surroundings(file));
      if (!options.some(([known]) => known === file.name)) options.push([file.name, file.name]);
      light.set_options(options);
      light.set(file.name);
      name = file.name;
      shown.set(true);
      viewer.set_light(name, turn.get());
      viewer.show_surroundings(true);
    } catch (error) {
      show_error(error);
    }
  };
  const input = h("input", { type: "file", accept: ".hdr,.exr", hidden: true, "aria-label": "A picture of surroundings", onchange: () => {
    const file = input.files?.[0];
    if (file) void take(file);
    input.value = "";
  } });
  return [light.element, turn.element, toggle("Shadows", true, (on) => viewer.set_shadows(on)).element, shown.element, h("div", { class: "actions" }, button("Light from a picture", () => input.click(), { hint: "HDR or EXR of what is all around, 360 degrees wide; the file stays in the browser" }), input)];
}

export function facts_table(facts: [string, string][]): HTMLElement {
  return h("dl", { class: "facts" }, facts.map(([label, text]) => [h("dt", {}, label), h("dd", {}, text)]).flat());
}
