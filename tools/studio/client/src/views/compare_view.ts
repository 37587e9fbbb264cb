// Two results side by side, with one camera and one time; or their difference, where both lie on the same texture.
import * as THREE from "three";
import { get_mesh, get_place, get_places, type Texture } from "../api";
import { ciede2000 } from "../color/lab";
import { codes_at, color_text, lab_of_codes } from "../color/texel";
import { FrameLoader } from "../history/frame_loader";
import { legend } from "../history/legends";
import { Timebar } from "../history/timebar";
import { Hover } from "../scene/hover";
import { color_texture, flat_material, lit_material, SurfaceLook } from "../scene/material";
import { dress, picture_plane, read_glb } from "../scene/mesh_loader";
import { Viewer } from "../scene/viewer";
import type { HistoryPlace } from "../types";
import { number_text, section, segmented, select, slider } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { progress, show_error } from "../ui/notices";
import type { View } from "./view";
import { facts_table, light_controls, toggle_full_screen, view_tools, workspace } from "./workspace";

const kMostSide = 2048;
const kDifferenceTop = 20;
const kMostCompared = 60000;  // Texels of the figures.
const kKinds = ["history", "transfer", "simulation"];

/// A list of what a result can be shown beside, filled when it is opened.
export function other_result(place: string): HTMLElement {
  const choice = select<string>("Beside", [["", "no other result"]], "", (other) => { if (other) location.hash = `#/${encodeURIComponent(place)}?${encodeURIComponent(`with:${other}`)}`; });
  const fill = (): void => {
    get_places().then(({ places }) => choice.set_options([["", "no other result"], ...places.filter((p) => kKinds.includes(p.kind) && p.place !== place).map((p): [string, string] => [p.place, p.place])]), show_error);
  };
  choice.element.querySelector("select")?.addEventListener("focus", fill, { once: true });
  choice.element.querySelector("select")?.addEventListener("pointerenter", fill, { once: true });
  return choice.element;
}

/// One of the two: its picture at a time.
class Side {
  readonly element: HTMLElement;
  readonly viewer: Viewer;
  readonly look = new SurfaceLook();
  readonly loader: FrameLoader;
  texture: Texture | undefined;
  made: THREE.DataTexture | undefined;
  private readonly material: THREE.MeshStandardMaterial | THREE.MeshBasicMaterial;

  constructor(readonly place: HistoryPlace, private readonly on_texture: () => void) {
    this.element = h("div", {}, h("span", { class: "title" }, place.name === "scene" ? place.place : place.name));
    this.viewer = new Viewer(this.element, place.mesh !== true);
    this.viewer.canvas.setAttribute("aria-label", `${place.name}; drag to ${place.mesh ? "turn" : "shift"} both`);
    const gray = color_texture(1, 1, new Uint8Array([128, 128, 128, 255]));
    this.material = place.mesh ? lit_material(this.look, this.viewer.lighting, gray) : flat_material(this.look, gray);
    const size = Math.max(place.width, place.height) > kMostSide ? { size: kMostSide } : {};
    this.loader = new FrameLoader({ place: place.place, ...size }, (texture) => this.show(texture), show_error);
  }

  async load(): Promise<void> {
    const { place } = this;
    const model = place.mesh ? await read_glb(await get_mesh(place.place)) : picture_plane(place.width, place.height);
    dress(model, this.material);
    this.viewer.content.add(model);
    this.viewer.content_has_come();
    this.viewer.fit();
  }

  dispose(): void {
    this.loader.dispose();
    this.made?.dispose();
    this.material.dispose();
    this.viewer.dispose();
  }

  private show(texture: Texture): void {
    this.texture = texture;
    this.made?.dispose();
    this.made = color_texture(texture.width, texture.height, texture.bytes.slice());
    this.material.map = this.made;
    this.on_texture();
    this.viewer.invalidate();
  }
}

/// Whether each texel of one lies at the same place of the other: the same triangles with the same coordinates.
function is_same_surface(a: THREE.Object3D, b: THREE.Object3D): boolean {
  const uvs = (content: THREE.Object3D): Float32Array[] => {
    const all: Float32Array[] = [];
    content.traverse((o) => { if (o instanceof THREE.Mesh) all.push((o.geometry as THREE.BufferGeometry).getAttribute("uv")?.array as Float32Array ?? new Float32Array()); });
    return all;
  };
  const [x, y] = [uvs(a), uvs(b)];
  return x.length === y.length && x.every((one, i) => one.length === y[i]!.length && one.every((v, k) => Math.abs(v - y[i]![k]!) < 1e-5));
}

export class CompareView implements View {
  readonly element: HTMLElement;
  private readonly frame = workspace("Two results");
  private readonly two = h("div", { class: "two" });
  private readonly legend_box = h("div", { class: "legends" });
  private readonly figures = h("dl", { class: "facts" });
  private sides: [Side, Side] | undefined;
  private timebar: Timebar | undefined;
  private hovers: Hover[] = [];
  private readonly why_not = h("p", { class: "hint", hidden: true }, "They do not lie on the same texture, so there is no difference to show.");
  private are_alike = false;
  private is_difference = false;
  private is_following = false;
  private is_disposed = false;

  /// @param other  The place of the second one.
  constructor(private readonly first: HistoryPlace, private readonly other: string) {
    this.element = this.frame.element;
    this.frame.stage.prepend(this.two);
    this.frame.stage.append(h("div", { class: "legend-area" }, this.legend_box));
    const work = progress(this.frame.stage, "Reading both results ...");
    this.open().catch(show_error).finally(() => work.end());
  }

  on_key(key: string): boolean {
    switch (key) {
      case " ": this.timebar?.toggle(); return true;
      case "ArrowLeft": this.timebar?.jump(-1); return true;
      case "ArrowRight": this.timebar?.jump(1); return true;
      case "f": this.sides?.[0].viewer.fit(); return true;
      case "shift+f": toggle_full_screen(this.element); return true;
    }
    return false;
  }

  dispose(): void {
    this.is_disposed = true;
    this.timebar?.pause();
    for (const hover of this.hovers) hover.dispose();
    for (const side of this.sides ?? []) side.dispose();
  }

  private async open(): Promise<void> {
    const second = await get_place<HistoryPlace>(this.other);
    if (this.is_disposed) return;
    const sides: [Side, Side] = [new Side(this.first, () => this.textures_changed()), new Side(second, () => this.textures_changed())];
    this.sides = sides;
    this.two.append(...sides.map((s) => s.element));
    this.build(sides, second);
    await Promise.all(sides.map((s) => s.load()));
    if (this.is_disposed) return;
    this.are_alike = is_same_surface(sides[0].viewer.content, sides[1].viewer.content) && this.first.width === second.width && this.first.height === second.height;
    this.why_not.hidden = this.are_alike;
    for (const b of this.frame.panel.querySelectorAll<HTMLButtonElement>("button[data-value=difference]")) b.disabled = !this.are_alike;
    for (const [i, side] of sides.entries()) side.viewer.controls.addEventListener("change", () => this.follow(sides[i]!, sides[1 - i]!));
    this.hovers = sides.map((side) => new Hover(side.viewer, side.element, ({ uv }) => this.words(side, uv)));
    this.timebar?.set_time(this.timebar.last);
    window.patinate = { view: "compare", sides, is_ready: () => sides.every((s) => s.texture !== undefined), difference: () => this.is_difference };
  }

  private build(sides: [Side, Side], second: HistoryPlace): void {
    const { first } = this;
    // Of two units of time each result goes through its own, from its beginning to its end.
    const is_one_time = first.unit === second.unit;
    const share_of = (place: HistoryPlace, t: number): number => (100 * (t - place.times[0]!)) / (place.times[place.times.length - 1]! - place.times[0]! || 1);
    const time_of = ({ times: all }: HistoryPlace, t: number): number => (is_one_time ? t : all[0]! + (t / 100) * (all[all.length - 1]! - all[0]!));
    const times = [...new Set([first, second].flatMap((p) => (is_one_time ? p.times : p.times.map((t) => share_of(p, t)))))].sort((a, b) => a - b);
    this.timebar = new Timebar({ times, unit: is_one_time ? first.unit : "%", on_time: (_, time) => { for (const side of sides) side.loader.request(time_of(side.place, time)); } });
    this.frame.bar.append(this.timebar.element);
    const mode = segmented<"two" | "difference">("How they are shown", [["two", "Side by side"], ["difference", "Difference"]], "two", (chosen) => this.set_difference(chosen === "difference"));
    const top = slider({ label: "Brightest at", low: 2, high: 60, step: 1, value: kDifferenceTop, unit: "ΔE", hint: "CIEDE2000; 1 is just noticeable", on_input: (v) => {
      sides[0].look.uniforms.difference_top.value = v;
      this.show_legend();
      sides[0].viewer.invalidate();
    } });
    view_tools(sides[0].viewer, this.frame.tools, this.element);
    const light = light_controls(sides[0].viewer);
    this.frame.panel.append(h("header", { class: "panel-head" }, h("h1", {}, `${first.name} and ${second.name}`), h("p", { class: "kind" }, "comparison")),
      section("Compare", true, mode.element, top.element, this.figures, this.why_not),
      first.mesh ? section("Light of the left one", false, light) : "",
      section(`About ${first.name}`, false, facts_table(first.facts ?? [])), section(`About ${second.name}`, false, facts_table(second.facts ?? [])));
  }

  // The same place of both objects, from the same side; what differs in size is seen from as many sizes away.
  private follow(from: Side, to: Side): void {
    if (this.is_following) return;
    this.is_following = true;
    const [a, b] = [from, to].map(({ viewer }) => viewer.bounds().getBoundingSphere(new THREE.Sphere())) as [THREE.Sphere, THREE.Sphere];
    const is_near = a.center.distanceTo(b.center) < 0.5 * Math.max(a.radius, b.radius) && Math.abs(Math.log(a.radius / b.radius)) < 0.4;
    const scale = is_near ? 1 : b.radius / a.radius;
    const over = (p: THREE.Vector3): THREE.Vector3 => (is_near ? p.clone() : p.clone().sub(a.center).multiplyScalar(scale).add(b.center));
    to.viewer.camera.position.copy(over(from.viewer.camera.position));
    to.viewer.controls.target.copy(over(from.viewer.controls.target));
    to.viewer.camera.zoom = from.viewer.camera.zoom;
    to.viewer.camera.updateProjectionMatrix();
    to.viewer.controls.update();
    to.viewer.invalidate();
    this.is_following = false;
  }

  private set_difference(is_on: boolean): void {
    const [a, b] = this.sides!;
    this.is_difference = is_on;
    this.two.classList.toggle("one", is_on);
    b.element.hidden = is_on;
    a.look.set_comparison(is_on ? "difference" : "one");
    this.textures_changed();
    this.show_legend();
    a.viewer.invalidate();
  }

  private textures_changed(): void {
    const [a, b] = this.sides ?? [];
    if (!a || !b) return;
    if (b.made) a.look.uniforms.map_b.value = b.made;
    a.viewer.invalidate();
    this.show_figures(a, b);
  }

  private show_legend(): void {
    const top = this.sides![0].look.uniforms.difference_top.value;
    replace(this.legend_box, this.is_difference && legend("color difference, CIEDE2000", "0", `${number_text(top)} and more`));
  }

  // Of texels spread over the whole texture; where both are as in the gutters, the gutters count too.
  private show_figures(a: Side, b: Side): void {
    const [x, y] = [a.texture, b.texture];
    if (!x || !y || !this.are_alike) return;
    const step = Math.max(1, Math.floor((x.width * x.height) / kMostCompared)), all: number[] = [];
    for (let i = 0; i < x.width * x.height; i += step) {
      const at = (t: Texture): [number, number, number] => [t.bytes[4 * i]!, t.bytes[4 * i + 1]!, t.bytes[4 * i + 2]!];
      all.push(ciede2000(lab_of_codes(...at(x)), lab_of_codes(...at(y))));
    }
    all.sort((p, q) => p - q);
    const mean = all.reduce((sum, v) => sum + v, 0) / all.length;
    replace(this.figures, [["Mean difference", `${mean.toFixed(2)} ΔE`], ["95 % are below", `${all[Math.floor(0.95 * (all.length - 1))]!.toFixed(2)} ΔE`]].map(([label, text]) => [h("dt", {}, label!), h("dd", {}, text!)]).flat());
  }

  private words(side: Side, uv: { x: number; y: number }): string[] {
    const [a, b] = this.sides!;
    if (!side.texture) return [];
    const own = color_text(...codes_at(side.texture, uv));
    if (!a.texture || !b.texture || !this.are_alike) return [own];
    const difference = ciede2000(lab_of_codes(...codes_at(a.texture, uv)), lab_of_codes(...codes_at(b.texture, uv)));
    return [own, `ΔE ${difference.toFixed(1)} to the other`];
  }
}
