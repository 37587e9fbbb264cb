// Saving the scene and exporting what has aged, below the served folder; and downloading it from there.
import { zipSync } from "three/addons/libs/fflate.module.js";
import { get, url_of } from "../api";
import type { Exported } from "../types";
import { button, number_text, toggle } from "../ui/controls";
import { ask_path, open_dialog } from "../ui/dialog";
import { h, replace } from "../ui/dom";
import { download, show_error } from "../ui/notices";
import type { SceneContext } from "./context";

export interface Sender {
  /// As SceneContext.send(), but what goes wrong is thrown.
  ask(op: string, fields: Record<string, unknown>): Promise<unknown>;
}

export function bytes_text(bytes: number): string {
  return bytes >= 1e6 ? `${number_text(bytes / 1e6)} MB` : bytes >= 1e3 ? `${number_text(bytes / 1e3)} kB` : `${bytes} bytes`;
}

const file_url = (place: string, path: string): string => url_of("/api/file", { place, path });
const last_of = (path: string): string => path.split("/").pop() ?? path;

export function open_save(sender: Sender, context: SceneContext): void {
  ask_path("Save the scene", "Scene file, below the served folder", `${context.scene.name || "scene"}_edited.json`,
    [h("p", { class: "hint" }, "With everything that was done here as events: `patinate simulate` gives the same bytes.")],
    async (path) => {
      await sender.ask("save", { path });
      open_dialog("The scene is saved", [h("p", {}, "It is in ", h("code", {}, path), ". The same bytes come of"), h("p", {}, h("code", {}, `patinate simulate ${path} -o ${last_of(path).replace(/\.json$/, "")}`))],
        [h("a", { class: "button", href: file_url(path, last_of(path)), download: last_of(path) }, "Download")]);
    });
}

const kWhat: [string, string, boolean][] = [["textures", "Textures (color, gloss, normals, height)", true], ["glb", "GLB model", true], ["controls", "Parameter maps, for transfer", true], ["history", "Material history", false]];

export function open_export(sender: Sender, context: SceneContext): void {
  const toggles = kWhat.map(([name, text, on]) => ({ name, toggle: toggle(text, on, () => {}) }));
  ask_path("Export what has aged", "Folder, below the served folder", `${context.scene.name || "scene"}_aged`, toggles.map((t) => t.toggle.element), async (path) => {
    await sender.ask("export", { path, what: toggles.filter((t) => t.toggle.get()).map((t) => t.name) });
  });
}

const kMostZip_bytes = 1e9;

/// What an export has left: every file as a link, and all of them as one.
export class Exports {
  private dialog: HTMLDialogElement | undefined;
  private readonly list = h("div", { class: "export-files" });
  private shown: Exported | undefined;

  /// Again once a history has come to it.
  show(exported: Exported): void {
    this.shown = exported;
    const folder = exported.place.replace(/\/?scene\.json$/, "");
    const sum = exported.files.reduce((all, { bytes }) => all + bytes, 0);
    replace(this.list, h("table", { class: "files" }, h("tbody", {}, exported.files.map(({ path, bytes }) => h("tr", {},
      h("td", {}, h("a", { href: file_url(exported.place, path), download: last_of(path) }, path)), h("td", {}, bytes_text(bytes)))))));
    if (this.dialog?.open) return;
    const glb = exported.files.find(({ path }) => path === "model.glb");
    this.dialog = open_dialog("Exported", [h("p", {}, "The files are in ", h("code", {}, folder), " of the served folder."), this.list], [
      glb && h("a", { class: "button", href: `#/${encodeURIComponent(`${folder}/model.glb`)}`, onclick: () => this.dialog?.close() }, "Look at the model"),
      sum < kMostZip_bytes && button(`Download all (${bytes_text(sum)})`, () => void this.zip(folder), { kind: "primary", icon: "download" })].filter((e): e is HTMLButtonElement => e instanceof HTMLElement));
  }

  private async zip(folder: string): Promise<void> {
    const { shown } = this;
    if (!shown) return;
    try {
      const files: Record<string, [Uint8Array, { level: 0 }]> = {};  // Pictures are compressed already.
      for (const { path } of shown.files) files[`${last_of(folder)}/${path}`] = [new Uint8Array((await get(file_url(shown.place, path))).bytes), { level: 0 }];
      download(new Blob([zipSync(files)], { type: "application/zip" }), `${last_of(folder)}.zip`);
    } catch (error) {
      show_error(error);
    }
  }
}
