// Saving the scene and exporting what has aged, below the served folder.
import { toggle } from "../ui/controls";
import { ask_path } from "../ui/dialog";
import { h } from "../ui/dom";
import { notice } from "../ui/notices";
import type { SceneContext } from "./context";

export interface Sender {
  /// As SceneContext.send(), but what goes wrong is thrown.
  ask(op: string, fields: Record<string, unknown>): Promise<void>;
}

export function open_save(sender: Sender, context: SceneContext): void {
  ask_path("Save the scene", "Scene file, below the served folder", `${context.scene.name || "scene"}_edited.json`,
    [h("p", { class: "hint" }, "With everything that was done here as events: `patinate simulate` gives the same bytes.")],
    async (path) => {
      await sender.ask("save", { path });
      notice(`The scene is in ${path}.`);
    });
}

const kWhat: [string, string, boolean][] = [["textures", "Textures (color, gloss, normals, height)", true], ["glb", "GLB model", true], ["controls", "Parameter maps, for transfer", true], ["history", "Material history", false]];

export function open_export(sender: Sender, context: SceneContext): void {
  const toggles = kWhat.map(([name, text, on]) => ({ name, toggle: toggle(text, on, () => {}) }));
  ask_path("Export what has aged", "Folder, below the served folder", `${context.scene.name || "scene"}_aged`, toggles.map((t) => t.toggle.element), async (path) => {
    await sender.ask("export", { path, what: toggles.filter((t) => t.toggle.get()).map((t) => t.name) });
    notice(`Exported to ${path}.`);
  });
}
