// A mesh alone; a GLB with the materials that are in it.
import * as THREE from "three";
import { get_mesh, url_of } from "../api";
import { read_dressed_glb } from "../scene/dressed_glb";
import { dress, read_glb } from "../scene/mesh_loader";
import { Viewer } from "../scene/viewer";
import { open_age } from "../build/age_dialog";
import { job_buttons } from "../jobs/job_buttons";
import type { PlaceBase } from "../types";
import { button, section, select } from "../ui/controls";
import { h } from "../ui/dom";
import { icon } from "../ui/icons";
import { progress, show_error } from "../ui/notices";
import type { View } from "./view";
import { facts_table, light_controls, toggle_full_screen, view_tools, workspace } from "./workspace";

export class MeshView implements View {
  readonly element: HTMLElement;
  private readonly viewer: Viewer;
  private readonly looks = h("div", {});

  /// @param ages  Asks at once how it is to age.
  constructor(private readonly place: PlaceBase, ages = false) {
    const frame = workspace("Mesh");
    this.element = frame.element;
    this.element.classList.add("no-bar");
    this.viewer = new Viewer(frame.stage, false);
    this.viewer.canvas.setAttribute("aria-label", `${place.name}: a mesh; drag to turn`);
    view_tools(this.viewer, frame.tools, this.element);
    const name = place.place.split("/").pop() ?? place.name;
    const age = (): void => void open_age(place.place, (scene) => { location.hash = `#/${encodeURIComponent(scene)}?run`; });
    frame.panel.append(h("header", { class: "panel-head" }, h("h1", {}, place.name), h("p", { class: "kind" }, place.kind)),
      h("div", { class: "panel-foot" }, button("Age this", age, { kind: "primary", icon: "simulation", hint: "Makes a scene of it that runs: rain and dirt, rust, moss, patina" }), job_buttons(place)), this.looks,
      section("Light", true, light_controls(this.viewer)), section("About", true, facts_table(place.facts ?? [])),
      h("div", { class: "panel-foot" }, h("a", { class: "button", href: url_of("/api/file", { place: place.place, path: name }), download: name }, icon("download"), "Download")));
    window.patinate = { view: "mesh", viewer: this.viewer, is_ready: () => this.viewer.content.children.length > 0 };
    if (ages) {
      window.history.replaceState(null, "", `#/${encodeURIComponent(place.place)}`);
      age();
    }
    const work = progress(frame.stage, "Reading the mesh ...");
    this.load().then((group) => {
      this.viewer.content.add(group);
      this.viewer.fit();
    }).catch(show_error).finally(() => work.end());
  }

  on_key(key: string): boolean {
    if (key === "f") this.viewer.fit();
    else if (key === "shift+f") toggle_full_screen(this.element);
    else return false;
    return true;
  }

  dispose(): void {
    this.viewer.dispose();
  }

  private async load(): Promise<THREE.Group> {
    if (!/\.glb$/i.test(this.place.place)) {
      const group = await read_glb(await get_mesh(this.place.place));
      dress(group, new THREE.MeshStandardMaterial({ color: 0xb9b4aa, roughness: 0.75, side: THREE.DoubleSide }));
      return group;
    }
    const { group, variants, show } = await read_dressed_glb(this.place.place);
    if (variants.length > 1) {
      this.looks.append(h("div", { class: "panel-foot" }, select("Look", variants.map((v) => [v, v] as [string, string]), variants[0]!, (v) => void show(v).then(() => this.viewer.invalidate()).catch(show_error)).element));
    }
    return group;
  }
}
