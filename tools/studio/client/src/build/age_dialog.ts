// "Age this": from a mesh to a scene that runs.
import { get_json, post, url_of } from "../api";
import { button, number_text, segmented, select } from "../ui/controls";
import { open_dialog } from "../ui/dialog";
import { h, replace } from "../ui/dom";
import { show_error } from "../ui/notices";

interface Begin {
  size: [number, number, number];
  unit: string;
  has_unit: boolean;
  presets: { name: string; title: string; about: string }[];
}

const kAbout = "/api/begin";
const kUnits: [string, string][] = [["um", "micrometers"], ["mm", "millimeters"], ["cm", "centimeters"], ["m", "meters"]];
const kMm: Record<string, number> = { um: 0.001, mm: 1, cm: 10, m: 1000 };

function length_text(mm: number): string {
  return mm >= 1000 ? `${number_text(mm / 1000)} m` : mm >= 10 ? `${number_text(mm / 10)} cm` : `${number_text(mm)} mm`;
}

/// @param done  Gets the place of the scene.
export async function open_age(mesh: string, done: (place: string) => void): Promise<void> {
  try {
    const begin = await get_json<Begin>(url_of(kAbout, { place: mesh }));
    let unit = begin.unit, preset = begin.presets[0]!.name, detail = "512";
    const size = h("p", { class: "hint", role: "status" });
    const show_size = (): void => replace(size, `It is then ${begin.size.map((s) => length_text(s * kMm[unit]!)).join(" x ")}.`);
    show_size();
    const up = segmented("Up is", [["y", "+y"], ["z", "+z"]], /\.stl$/i.test(mesh) ? "z" : "y", () => {});
    const cards = begin.presets.map(({ name, title, about }) => {
      const radio = h("input", { type: "radio", name: "preset", value: name, checked: name === preset, onchange: () => { preset = name; } });
      return h("label", { class: "way" }, radio, h("b", {}, title), h("span", {}, about));
    });
    const accept = button("Age this", () => {
      accept.disabled = true;
      post(url_of(kAbout, { place: mesh }), { preset, unit, up: up.get(), resolution: Number(detail) }).then(async (answer) => {
        const { place } = JSON.parse(await answer.text()) as { place: string };
        dialog.close();
        done(place);
      }).catch((error: unknown) => {
        accept.disabled = false;
        show_error(error, kAbout);
        dialog.close();
      });
    }, { kind: "primary" });
    const dialog = open_dialog("Age this", [h("div", { class: "ways", role: "radiogroup", "aria-label": "What ages it" }, cards),
      !begin.has_unit && select("The file is in", kUnits, unit, (chosen) => {
        unit = chosen;
        show_size();
      }).element, size,
      h("div", { class: "control row" }, h("span", { class: "label" }, "Up is"), up.element),
      select("Detail", [["256", "256 texels a side: fast"], ["512", "512"], ["1024", "1024: finer, four times slower"], ["2048", "2048"]], detail, (chosen) => { detail = chosen; }).element,
      h("p", { class: "hint" }, "A scene file comes into the folder, beside the mesh. Everything in it can be changed afterwards.")], [button("Cancel", () => dialog.close()), accept]);
    dialog.classList.add("wide");
    dialog.querySelector<HTMLElement>("input[type=radio]")?.focus();
  } catch (error) {
    show_error(error, kAbout);
  }
}
