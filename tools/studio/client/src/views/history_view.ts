// A history as a picture, a transfer or finished simulation on its mesh: time, comparison, maps, curves, and where colors come from.
import * as THREE from "three";
import { get_mesh, is_static, post, type Texture } from "../api";
import { ciede2000 } from "../color/lab";
import { codes_at, color_text, lab_of_codes } from "../color/texel";
import { CurvePanel } from "../history/curve_panel";
import { FrameLoader } from "../history/frame_loader";
import { RegionsPanel } from "../history/regions_panel";
import { has_relief, ReliefPanel } from "../history/relief_panel";
import { MaterialMaps } from "../history/material_maps";
import { legend } from "../history/legends";
import { OverlayPanel } from "../history/overlay_panel";
import { PaintPanel } from "../history/paint_panel";
import { Timebar } from "../history/timebar";
import { Wipe } from "../history/wipe";
import { job_buttons } from "../jobs/job_buttons";
import { color_texture, flat_material, lit_material, SurfaceLook, type Comparison } from "../scene/material";
import { Hover } from "../scene/hover";
import { dress, picture_plane, read_glb } from "../scene/mesh_loader";
import { Lasso } from "../scene/lasso";
import { NameTags, Pin } from "../scene/pin";
import { Viewer, type Hit } from "../scene/viewer";
import { stored_times } from "../session";
import type { HistoryPlace } from "../types";
import { button, number_text, section, segmented, select, slider, toggle, type Choice } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { download, progress, show_error } from "../ui/notices";
import { xxh64 } from "../xxh64";
import { other_result } from "./compare_view";
import { PicturePanel } from "./picture_panel";
import type { View } from "./view";
import { facts_table, light_controls, toggle_full_screen, view_tools, workspace } from "./workspace";

const kMostSide = 2048;
const kDifferenceTop = 20;

export class HistoryView implements View {
  readonly element: HTMLElement;
  private readonly frame = workspace("Picture");
  private readonly viewer: Viewer;
  private readonly look = new SurfaceLook();
  private readonly textures: { a?: THREE.DataTexture; b?: THREE.DataTexture } = {};
  private readonly shown: { a?: Texture; b?: Texture } = {};
  private readonly query: { place: string; size?: number };
  private readonly loader_a: FrameLoader;
  private readonly loader_b: FrameLoader;
  private readonly materials: Record<"a" | "b", MaterialMaps>;
  private readonly timebar: Timebar;
  private readonly wipe: Wipe;
  private readonly curve: CurvePanel;
  private readonly overlay: OverlayPanel;
  private readonly hover: Hover;
  private readonly lasso: Lasso;
  private readonly regions: RegionsPanel;
  private readonly names: NameTags;
  private readonly legend_box = h("div", { class: "legends" });
  private readonly difference_legend = h("div", { class: "legends" });
  private readonly pin: Pin;
  private comparison: Comparison = "one";
  private readonly compare_choice: Choice<Comparison>;
  private readonly placeholder = color_texture(1, 1, new Uint8Array([128, 128, 128, 255]));
  private lit: THREE.MeshStandardMaterial;
  private flat: THREE.MeshBasicMaterial;
  private model: THREE.Object3D | undefined;
  private relief: ReliefPanel | undefined;
  private paint: PaintPanel | undefined;
  private shown_at = { time: NaN, between: "" };  // Of `shown.a`.
  private is_disposed = false;

  constructor(private readonly place: HistoryPlace) {
    this.element = this.frame.element;
    const has_mesh = place.mesh === true;
    this.viewer = new Viewer(this.frame.stage, !has_mesh);
    this.viewer.canvas.setAttribute("aria-label", `${place.name}: ${has_mesh ? "the aged object; drag to turn" : "the picture; drag to shift, wheel to enlarge"}`);
    this.lit = lit_material(this.look, this.viewer.lighting, this.placeholder);
    if (!has_mesh) this.lit.roughness = 1;  // No highlights over a picture's own.
    this.flat = flat_material(this.look, this.placeholder);
    const longest = Math.max(place.width, place.height);
    const query = this.query = { place: place.place, ...(longest > kMostSide ? { size: kMostSide } : {}) };
    this.loader_a = new FrameLoader(query, (texture, time) => {
      this.shown_at = { time, between: this.loader_a.between };
      this.show_texture("a", texture);
      this.paint?.refresh();
    }, show_error);
    this.loader_b = new FrameLoader(query, (texture) => this.show_texture("b", texture), show_error);
    const material = (side: "a" | "b"): MaterialMaps => new MaterialMaps(query, place.material ?? [], side, this.look, () => this.viewer.invalidate(), show_error);
    this.materials = { a: material("a"), b: material("b") };
    this.timebar = new Timebar({ times: place.times, unit: place.unit, only: window.PATINATE_SESSION ? stored_times(window.PATINATE_SESSION) : undefined, on_time: (which, time) => this.go(which, time) });
    this.wipe = new Wipe(this.frame.stage, () => {
      this.place_wipe();
      this.viewer.invalidate();
    });
    this.overlay = new OverlayPanel({ place, look: this.look, renderer: this.viewer.renderer, legend_box: this.legend_box, redraw: () => this.viewer.invalidate(), on_map: () => this.regions?.refresh(this.timebar.time) });
    this.names = new NameTags(this.viewer, this.frame.stage);
    this.regions = new RegionsPanel({ place, overlay: this.overlay, texture: () => this.shown.a, set_drawing: (is_on) => this.lasso.set_active(is_on), show_names: (names) => this.names.set(names), on_time: (time) => this.timebar.set_time(time) });
    this.lasso = new Lasso(this.viewer, this.frame.stage, (hits) => this.regions.add(hits));
    this.curve = new CurvePanel(place, (time) => this.timebar.set_time(time));
    this.compare_choice = segmented<Comparison>("Compare", [["one", "One time"], ["wipe", "Wipe"], ["difference", "Difference"]], "one", (c) => this.compare(c));
    this.build_panel(has_mesh);
    this.pin = new Pin(this.viewer, this.frame.stage);
    this.frame.stage.append(h("div", { class: "legend-area" }, this.legend_box, this.difference_legend));
    this.frame.bar.append(this.timebar.element);
    view_tools(this.viewer, this.frame.tools, this.element);
    this.viewer.on_click = (hit) => { if (!this.lasso.is_active && !this.paint?.is_active) this.pick(hit); };
    this.viewer.after_frame = () => {
      this.pin.place();
      this.names.place();
    };
    this.viewer.on_resize = () => this.place_wipe();
    this.hover = new Hover(this.viewer, this.frame.stage, (hit) => this.words_of(hit));
    void this.load(has_mesh);
    this.tell_tests();
  }

  on_key(key: string): boolean {
    switch (key) {
      case " ": this.timebar.toggle(); return true;
      case "ArrowLeft": this.timebar.jump(-1); return true;
      case "ArrowRight": this.timebar.jump(1); return true;
      case "f": this.viewer.fit(); return true;
      case "shift+f": toggle_full_screen(this.element); return true;
      case "1": this.compare_by_key("one"); return true;
      case "2": this.compare_by_key("wipe"); return true;
      case "3": this.compare_by_key("difference"); return true;
      case "Escape":
        this.regions.draw(false);
        void this.paint?.set_active(false);
        return true;
      case "ctrl+z": return this.step("undo");
      case "ctrl+y":
      case "ctrl+shift+z": return this.step("redo");
    }
    return false;
  }

  private step(what: "undo" | "redo"): boolean {
    if (!this.paint?.is_open) return false;
    void this.paint[what]();
    return true;
  }

  dispose(): void {
    this.is_disposed = true;
    this.paint?.dispose();
    this.timebar.pause();
    this.loader_a.dispose();
    this.loader_b.dispose();
    this.materials.a.dispose();
    this.materials.b.dispose();
    this.textures.a?.dispose();
    this.textures.b?.dispose();
    this.relief?.dispose();
    this.overlay.dispose();
    this.hover.dispose();
    this.lasso.dispose();
    this.lit.dispose();
    this.flat.dispose();
    this.viewer.dispose();
  }

  private build_panel(has_mesh: boolean): void {
    const { place } = this;
    const between = select("Between frames", [["blend", "blend"], ["hold", "hold the frame before"], ["nearest", "nearest frame"]], "blend", (value) => {
      for (const loaders of [this.loader_a, this.loader_b, this.materials.a, this.materials.b]) loaders.between = value;
      this.go("a", this.timebar.time);
      this.go("b", this.timebar.second_time);
    });
    const top = slider({ label: "Brightest at", low: 2, high: 60, step: 1, value: kDifferenceTop, unit: "ΔE", hint: "CIEDE2000; 1 is just noticeable", on_input: (v) => {
      this.look.uniforms.difference_top.value = v;
      this.show_difference_legend();
      this.viewer.invalidate();
    } });
    const compare = section("Compare", true, this.compare_choice.element, h("div", { class: "only-difference" }, top.element), !is_static() && between.element, !is_static() && other_result(place.place));
    const exact = toggle("Exact colors, without light", false, (on) => {
      if (this.model) dress(this.model, on ? this.flat : this.lit);
      this.viewer.invalidate();
    }, "Shows the texture as it is");
    if (!is_static() && has_relief(place)) this.relief = new ReliefPanel(place, this.look, this.viewer, (is_lit) => { if (this.model) dress(this.model, is_lit ? this.lit : this.flat); });
    if (!is_static() && place.kind === "transfer" && !("size" in this.query)) {
      const show_painted = (): void => {
        this.look.uniforms.has_material.value = [0, 0, 0];  // Only the color follows the brush.
        if (this.shown.a) this.show_texture("a", this.shown.a);
      };
      this.paint = new PaintPanel({ place, viewer: this.viewer, stage: this.frame.stage, shown: () => ({ texture: this.shown.a, ...this.shown_at }), on_change: show_painted });
    }
    const save = button("Save as one HTML file", () => void this.save_session(), { icon: "download", hint: "A page that opens without a server, for a paper's supplement" });
    this.frame.panel.append(
      h("header", { class: "panel-head" }, h("h1", {}, place.name), h("p", { class: "kind" }, place.kind), job_buttons(place)),
      compare, this.paint?.element ?? "", section("Color of a place", true, this.curve.element), section("Map over the surface", true, this.overlay.element), section("Regions", false, this.regions.element),
      has_mesh ? section("Light", false, light_controls(this.viewer), exact.element) : this.relief?.element ?? "",
      has_mesh ? new PicturePanel(this.viewer, place).element : "",
      section("About", false, facts_table(place.facts ?? [])),
      is_static() ? "" : h("div", { class: "panel-foot" }, save));
  }

  private async load(has_mesh: boolean): Promise<void> {
    const stop = new AbortController();
    const work = progress(this.frame.stage, "Reading the mesh and the first frame ...", () => { stop.abort(); location.hash = "#/"; });
    try {
      if (has_mesh) {
        const group = await read_glb(await get_mesh(this.place.place, stop.signal));
        if (this.is_disposed) return;
        dress(group, this.lit);
        this.model = group;
      } else {
        const plane = picture_plane(this.place.width, this.place.height);
        plane.material = this.flat;
        this.model = plane;
      }
      this.viewer.content.add(this.model);
      this.viewer.content_has_come();
      this.viewer.fit();
      const { times } = this.place;
      const session = window.PATINATE_SESSION?.view as { time?: number; second_time?: number; comparison?: Comparison } | undefined;
      // A page that was saved without a view of somebody opens aged.
      const opens_at = window.PATINATE_SESSION || this.place.shows ? times[times.length - 1] : times[0];
      this.timebar.set_time(session?.time ?? opens_at ?? 0);
      this.timebar.set_second_time(session?.second_time ?? times[times.length - 1] ?? 0);
      if (session?.comparison) this.compare_by_key(session.comparison);
      await this.loader_a.settled();
      if (this.place.shows && !is_static()) await this.open_map(this.place.shows);
    } catch (error) {
      show_error(error);
    } finally {
      work.end();
    }
  }

  /// A result whose color says nothing opens as the map that it is about, in a light that shapes it.
  private async open_map(name: string): Promise<void> {
    await this.overlay.show(name);
    await this.relief?.light(true);
  }

  private go(which: "a" | "b", time: number): void {
    if (which === "a") {
      this.loader_a.request(time);
      this.materials.a.request(time);
      this.curve.set_time(time);
      this.overlay.set_time(time);
    } else if (this.comparison !== "one") {
      this.loader_b.request(time);
      this.materials.b.request(time);
    }
    this.label_wipe();
  }

  private show_texture(which: "a" | "b", texture: Texture): void {
    if (this.is_disposed) return;
    this.shown[which] = texture;
    let made = this.textures[which];
    if (made && made.image.width === texture.width && made.image.height === texture.height) {
      made.image.data.set(texture.bytes);
      made.needsUpdate = true;
    } else {
      made?.dispose();
      made = color_texture(texture.width, texture.height, texture.bytes.slice());
      this.textures[which] = made;
      if (which === "a") this.lit.map = this.flat.map = made;
      else this.look.uniforms.map_b.value = made;
    }
    if (which === "a") this.regions.refresh(this.timebar.time);
    this.hover.refresh();
    this.viewer.invalidate();
  }

  private compare_by_key(comparison: Comparison): void {
    this.compare_choice.set(comparison);
    this.compare(comparison);
  }

  private compare(comparison: Comparison): void {
    this.comparison = comparison;
    this.look.set_comparison(comparison);
    this.timebar.show_second(comparison !== "one");
    this.wipe.show(comparison === "wipe");
    this.frame.panel.classList.toggle("comparing-difference", comparison === "difference");
    this.show_difference_legend();
    if (comparison !== "one") this.go("b", this.timebar.second_time);
    this.place_wipe();
    this.viewer.invalidate();
  }

  private show_difference_legend(): void {
    const top = this.look.uniforms.difference_top.value;
    replace(this.difference_legend, this.comparison === "difference" && legend("color difference, CIEDE2000", "0", `${number_text(top)} and more`));
  }

  private label_wipe(): void {
    const text = (time: number): string => `${number_text(time, 4)} ${this.place.unit}`;
    this.wipe.label(text(this.timebar.time), text(this.timebar.second_time));
  }

  private place_wipe(): void {
    this.look.uniforms.wipe_px.value = this.wipe ? this.wipe.share * this.viewer.renderer.domElement.width : 0;
  }

  private pick(hit: Hit | undefined): void {
    this.pin.set(hit?.point);
    if (!hit || is_static()) return;
    const texel = (share: number, size: number): number => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
    void this.curve.show(texel(hit.uv.x, this.place.width), texel(hit.uv.y, this.place.height));
  }

  // Of the time on whose side of the wipe it lies; of a difference, how large it is.
  private words_of(hit: Hit): string[] {
    const { a, b } = this.shown;
    const words = [this.overlay.value_text(hit.uv)].filter(Boolean);
    if (!a) return words;
    const first = codes_at(a, hit.uv), second = b && this.comparison !== "one" ? codes_at(b, hit.uv) : undefined;
    if (this.comparison === "difference" && second) return [...words, `ΔE ${ciede2000(lab_of_codes(...first), lab_of_codes(...second)).toFixed(1)}`];
    const is_second = this.comparison === "wipe" && second && this.viewer.project(hit.point).x > this.frame.stage.getBoundingClientRect().left + this.wipe.share * this.frame.stage.clientWidth;
    return [...words, color_text(...(is_second ? second : first))];
  }

  private async save_session(): Promise<void> {
    const work = progress(this.frame.stage, "Making the file ...");
    try {
      const view = { time: this.timebar.time, second_time: this.timebar.second_time, comparison: this.comparison };
      const times = [...new Set([...this.place.times, this.timebar.time, this.timebar.second_time])].sort((a, b) => a - b);
      const file = await post("/api/session", { place: this.place.place, times, size: 1024, view });
      download(file, `${this.place.name}.html`);
    } catch (error) {
      show_error(error);
    } finally {
      work.end();
    }
  }

  private tell_tests(): void {
    window.patinate = {
      view: "history", viewer: this.viewer,
      settled: () => Promise.all([this.loader_a, this.loader_b, this.materials.a, this.materials.b].map((loaders) => loaders.settled())),
      texture_hash: () => (this.textures.a ? xxh64(this.textures.a.image.data as unknown as Uint8Array) : null),
      server_hash: () => this.shown.a?.hash ?? null,
      overlay: () => this.overlay,
      light_relief: (is_on: boolean) => this.relief?.light(is_on),
      paint: () => this.paint,
      set_time: (time: number) => this.timebar.set_time(time),
    };
  }
}
