// The picture as a file: what is on screen in any size, a turntable, and the command that draws the same.
import * as THREE from "three";
import { is_static } from "../api";
import { start_job } from "../jobs/job_buttons";
import type { Viewer } from "../scene/viewer";
import type { JobValues, PlaceBase } from "../types";
import { button, number_field, section } from "../ui/controls";
import { open_dialog } from "../ui/dialog";
import { h } from "../ui/dom";
import { download, show_error } from "../ui/notices";

const kLeast_px = 16, kMost_px = 8192;  // Of `render`.
const kTurn = 72, kRendered = ["simulation", "transfer"];
const degrees = (radians: number): number => (radians * 180) / Math.PI;
const rounded = (value: number): string => String(Number(value.toFixed(3)));

/// Options of `render` for the camera and light of a viewer. @param width,height  Of the picture.
export function render_options(viewer: Viewer, width: number, height: number): Record<string, string> {
  const camera = viewer.camera as THREE.PerspectiveCamera, { target } = viewer.controls, way = camera.position.clone().sub(target);
  const distance = way.length(), azimuth = degrees(Math.atan2(way.x, way.z)), elevation = degrees(Math.asin(way.y / distance));
  // Of `render` the larger side has the field of view; here the height has it.
  const half = Math.tan(THREE.MathUtils.degToRad(camera.fov / 2)), fov = 2 * degrees(Math.atan(half * Math.max(1, width / height)));
  return {
    width: String(width), height: String(height), azimuth: rounded(azimuth), elevation: rounded(elevation), fov: rounded(fov), target: target.toArray().map(rounded).join(","), distance: rounded(distance),
    ...viewer.light_options(azimuth),
  };
}

function command(place: string, output: string, options: Record<string, string>): string {
  const words = Object.entries(options).map(([key, value]) => `--${key.replace(/_/g, "-")} ${value.startsWith("-") ? `"${value}"` : value}`.replace(/ "(-[^"]*)"$/, "=$1"));
  return `patinate render ${place} -o ${output} ${words.join(" ")}`;
}

export class PicturePanel {
  readonly element: HTMLElement;
  private width = 0;
  private height = 0;

  constructor(private readonly viewer: Viewer, private readonly place: PlaceBase) {
    const width = number_field("Width", 1920, "px", (v) => { this.width = this.size(v); width.set(this.width); }), height = number_field("Height", 1080, "px", (v) => { this.height = this.size(v); height.set(this.height); });
    [this.width, this.height] = [1920, 1080];
    this.element = section("Picture", false, width.element, height.element, h("div", { class: "actions" },
      button("Save the picture", () => void this.save(), { icon: "download", hint: "A PNG of this size, without emitters and handles" }),
      !is_static() && button("Turntable", () => this.turn(), { icon: "rotate", hint: "A movie of render, once around" })));
  }

  private size(value: number): number {
    return Math.min(kMost_px, Math.max(kLeast_px, Math.round(value)));
  }

  private get base(): string { return (this.place.place.split("/").pop() || this.place.name).replace(/\.json$/, ""); }

  // What `render` is to draw: a finished result as it is; a scene has to be run first.
  private get lines(): { before: string[]; subject: string } {
    if (kRendered.includes(this.place.kind)) return { before: [], subject: this.place.place };
    return { before: [`patinate simulate ${this.place.place} -o ${this.base}`], subject: this.base };
  }

  private async save(): Promise<void> {
    const { width, height, viewer } = this, { before, subject } = this.lines;
    try {
      const file = await viewer.picture(width, height);
      download(file, `${this.base}.png`);
      const said = Object.keys(viewer.light_options(0)).length > 0 ? [] : [h("p", { class: "hint" }, "This light is the studio's own; render has the light \"Studio\", or a picture of surroundings.")];
      open_dialog("The picture is saved", [h("p", {}, before.length > 0 ? "Save the scene first if it was changed. render draws the same of a finished simulation:" : "render draws the same:"),
        ...[...before, command(subject, `${this.base}.png`, render_options(viewer, width, height))].map((line) => h("p", {}, h("code", { class: "command" }, line))), ...said]);
    } catch (error) {
      show_error(error);
    }
  }

  private turn(): void {
    const options = { ...render_options(this.viewer, this.width, this.height), turntable: String(kTurn) }, { before, subject } = this.lines, output = `${this.base}_turn.mp4`;
    if (before.length === 0) return start_job("render", { ...(options as JobValues), SUBJECT: this.place.place }, output);
    open_dialog("A turntable", [h("p", {}, "render turns finished simulations. Save the scene first if it was changed, then give these commands, or press Simulate and open the result:"),
      ...[...before, command(subject, output, options)].map((line) => h("p", {}, h("code", { class: "command" }, line)))]);
  }
}
