// A mesh alone.
import * as THREE from "three";
import { get_mesh } from "../api";
import { dress, read_glb } from "../scene/mesh_loader";
import { Viewer } from "../scene/viewer";
import type { PlaceBase } from "../types";
import { section } from "../ui/controls";
import { h } from "../ui/dom";
import { progress, show_error } from "../ui/notices";
import type { View } from "./view";
import { facts_table, light_controls, toggle_full_screen, view_tools, workspace } from "./workspace";

export class MeshView implements View {
  readonly element: HTMLElement;
  private readonly viewer: Viewer;

  constructor(place: PlaceBase) {
    const frame = workspace("Mesh");
    this.element = frame.element;
    this.element.classList.add("no-bar");
    this.viewer = new Viewer(frame.stage, false);
    this.viewer.canvas.setAttribute("aria-label", `${place.name}: a mesh; drag to turn`);
    view_tools(this.viewer, frame.tools, this.element);
    frame.panel.append(h("header", { class: "panel-head" }, h("h1", {}, place.name), h("p", { class: "kind" }, place.kind)),
      section("Light", true, light_controls(this.viewer)), section("About", true, facts_table(place.facts ?? [])));
    window.patinate = { view: "mesh", viewer: this.viewer };
    const work = progress(frame.stage, "Reading the mesh ...");
    get_mesh(place.place).then(read_glb).then((group) => {
      dress(group, new THREE.MeshStandardMaterial({ color: 0xb9b4aa, roughness: 0.75, side: THREE.DoubleSide }));
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
}
