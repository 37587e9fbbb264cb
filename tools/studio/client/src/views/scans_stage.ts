// Registered scans in one frame: each in its color, with what the registration says of it; any can be hidden.
import * as THREE from "three";
import { get_mesh } from "../api";
import { read_glb } from "../scene/mesh_loader";
import { Viewer } from "../scene/viewer";
import type { ScanInfo } from "../types";
import { icon_button } from "../ui/controls";
import { h } from "../ui/dom";
import { progress, show_error } from "../ui/notices";

/// Told apart with any color vision [Okabe and Ito 2008].
const kColors = ["#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7", "#999999"];
const kPoint_px = 2;

export class ScansStage {
  readonly element: HTMLElement;
  private readonly viewer: Viewer;
  private readonly stage = h("div", { class: "mesh-stage" });
  private readonly nodes = new Map<string, THREE.Object3D>();
  private readonly materials: THREE.Material[] = [];

  constructor(place: string, private readonly scans: ScanInfo[]) {
    const all = h("input", { type: "checkbox", checked: true, onchange: () => this.show_all(all.checked) });
    const boxes = h("div", { class: "scan-list", role: "group", "aria-label": "Scans that are shown" },
      h("label", { class: "all" }, all, h("b", {}, "All scans")), scans.map((scan, i) => this.row(scan, i)));
    this.element = h("section", { class: "scans", "aria-label": "Registered scans" }, this.stage, boxes);
    this.viewer = new Viewer(this.stage, false);
    this.viewer.canvas.setAttribute("aria-label", "The registered scans in one frame; drag to turn");
    this.viewer.set_shadows(false);  // Surfaces that lie in one another would shade each other.
    this.stage.append(h("div", { class: "tools" }, icon_button("fit", "Fit the view", () => this.fit(), "F")));
    const work = progress(this.stage, "Reading the scans ...");
    get_mesh(place).then(read_glb).then((group) => this.take(group)).catch(show_error).finally(() => work.end());
    window.patinate = { view: "capture", viewer: this.viewer, scans: () => Object.fromEntries([...this.nodes].map(([name, node]) => [name, node.visible])) };
  }

  fit(): void {
    this.viewer.fit(new THREE.Vector3(0.35, 0.3, 1));
  }

  dispose(): void {
    for (const material of this.materials) material.dispose();
    this.viewer.dispose();
  }

  private row(scan: ScanInfo, i: number): HTMLElement {
    const box = h("input", { type: "checkbox", "data-scan": scan.name, checked: scan.is_shown, disabled: !scan.is_shown, onchange: () => this.show(scan.name, box.checked) });
    return h("label", { class: scan.is_shown ? "" : "missing" }, box, h("i", { class: "swatch", style: `background:${kColors[i % kColors.length]}`, "aria-hidden": "true" }),
      h("b", {}, scan.name), h("small", {}, scan.text));
  }

  private take(group: THREE.Group): void {
    for (const child of [...group.children]) {
      const name = String(child.userData["name"] ?? child.name);
      const number = Math.max(0, this.scans.findIndex((s) => s.name === name));
      const color = new THREE.Color(kColors[number % kColors.length]);
      const surface = new THREE.MeshStandardMaterial({ color, roughness: 0.75, side: THREE.DoubleSide });
      const points = new THREE.PointsMaterial({ color, size: kPoint_px, sizeAttenuation: false });
      this.materials.push(surface, points);
      child.traverse((o) => {
        if (o instanceof THREE.Mesh) o.material = surface;
        if (o instanceof THREE.Points) o.material = points;
      });
      this.nodes.set(name, child);
    }
    this.viewer.content.add(group);
    this.fit();
  }

  private show(name: string, is_visible: boolean): void {
    const node = this.nodes.get(name);
    if (node) node.visible = is_visible;
    this.viewer.invalidate();
  }

  private show_all(are_visible: boolean): void {
    for (const box of this.element.querySelectorAll<HTMLInputElement>("input[data-scan]:enabled")) {
      box.checked = are_visible;
      this.show(box.dataset["scan"]!, are_visible);
    }
  }
}
