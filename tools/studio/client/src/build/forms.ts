// The fields of the parts of a scene.
import { linear_from_srgb, srgb_from_linear } from "../color/lab";
import type { SceneState } from "../types";
import { button } from "../ui/controls";
import { h, type Child } from "../ui/dom";
import { list_of, list_pointer, pointer_to, rename, type Doc, type Kind } from "./document";
import type { Form } from "./form";

export const kPresets = ["iron", "painted_iron", "copper", "wood", "painted_wood", "stone", "plaster", "concrete"];
/// Materials that look like something by themselves.
export const kMaterials = ["water", "dirt", "rust", "metal", "wood", "organic", "stone", "patina", "moss", "dust", "pigment", "bleached"];
const kShapes: [string, string][] = [["sky", "Whole sky"], ["point", "Point"], ["disk", "Disk"], ["rectangle", "Rectangle"], ["sphere", "Sphere"], ["surface", "Brush on the surface"]];
const kUnits: Record<string, number> = { um: 0.001, mm: 1, cm: 10, m: 1000 };

export const unit_of = (doc: Doc): string => String(doc["unit"] ?? "mm");
export const mm_per_unit = (doc: Doc): number => kUnits[unit_of(doc)] ?? 1;
/// A length that a person would write.
export const neat = (value: number): number => Number(value.toPrecision(3));

function name_field(form: Form, kind: Kind, index: number, name: string, options: { list?: string[]; on?: (to: string) => void } = {}): HTMLElement {
  let now = name;
  const pointer = kind === "material" ? list_pointer(kind, index) : `${list_pointer(kind, index)}/name`;
  return form.text("Name", pointer, { value: name, words: ["name", "twice"], ...(options.list ? { list: options.list } : {}), on: (to) => {
    rename(form.draft, kind, index, to, now);
    now = to;
    options.on?.(to);
  } });
}

export function object_fields(index: number, meshes: string[], add_mesh: (take: (mesh: string) => void) => HTMLElement) {
  return (form: Form): Child[] => {
    const at = list_pointer("object", index), object = form.get(at) as Doc, unit = unit_of(form.draft);
    const presets = [...new Set([...kPresets, ...Object.keys((form.draft["presets"] ?? {}) as Doc)])];
    const take = (mesh: string): void => {
      meshes.push(mesh);
      form.set(`${at}/mesh`, mesh);
      form.render();
    };
    return [name_field(form, "object", index, String(object["name"])),
      form.select("Made of", `${at}/preset`, [["", "nothing in particular"], ...presets.map((p) => [p, p.replace("_", " ")] as [string, string])], String(object["preset"] ?? ""), (preset) => form.set(`${at}/preset`, preset || undefined)),
      form.select("Mesh", `${at}/mesh`, meshes.map((mesh) => [mesh, mesh]), String(object["mesh"] ?? ""), (mesh) => form.set(`${at}/mesh`, mesh)),
      add_mesh(take),
      form.numbers("Position", `${at}/translate`, [0, 0, 0], unit), form.numbers("Rotation", `${at}/rotate`, [0, 0, 0], "°"), form.numbers("Scale", `${at}/scale`, [1])];
  };
}

/// Members that a shape has and others do not.
function reshape(emitter: Doc, shape: string, scene: SceneState, per_unit: number): void {
  const [low, high] = scene.bounds_mm, size = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) / per_unit;
  emitter["shape"] = shape;
  if (shape === "sky") delete emitter["position"];
  else emitter["position"] ??= [neat((low[0] + high[0]) / 2 / per_unit), neat(high[1] / per_unit + size / 4), neat((low[2] + high[2]) / 2 / per_unit)];
  if (["disk", "rectangle", "sphere", "surface"].includes(shape)) emitter["size"] = shape === "rectangle" ? [neat(size / 5), neat(size / 5)] : neat(size / 5);
  else delete emitter["size"];
  if (shape === "surface") emitter["distance"] ??= neat(size / 50);
  else delete emitter["distance"];
}

/// @param name  Free.
export function new_emitter(name: string, doc: Doc, scene: SceneState): Doc {
  const per_unit = mm_per_unit(doc), gravity = (doc["gravity"] as number[] | undefined) ?? [0, -1, 0];
  const g = Math.hypot(...gravity) || 1, [low, high] = scene.bounds_mm;
  const size = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) / per_unit;
  const first = scene.materials[0]!;
  const emitter: Doc = { name, shape: "sky", direction: gravity.map((v) => neat(v / g)), spread_deg: 8, speed: neat(1.5 * Math.sqrt((9810 / per_unit) * size)), gammatons: 2000, carries: { [first]: 0.8 } };
  return emitter;
}

function amounts(form: Form, pointer: string, materials: string[], label: (material: string) => string, given: Record<string, number>): HTMLElement[] {
  return materials.map((material) => form.numbers(label(material), pointer + pointer_to(material), [given[material] ?? 0]));
}

export function emitter_fields(index: number, scene: SceneState) {
  return (form: Form): Child[] => {
    const at = list_pointer("emitter", index), emitter = form.get(at) as Doc, unit = unit_of(form.draft), shape = String(emitter["shape"]);
    const materials = list_of(form.draft, "material") as string[];
    return [name_field(form, "emitter", index, String(emitter["name"])),
      form.select("Shape", `${at}/shape`, kShapes, shape, (to) => {
        reshape(emitter, to, scene, mm_per_unit(form.draft));
        form.render();
      }),
      shape !== "sky" && form.numbers("Position", `${at}/position`, [0, 0, 0], unit),
      shape === "rectangle" && form.numbers("Size", `${at}/size`, [0, 0], unit),
      ["disk", "sphere", "surface"].includes(shape) && form.numbers("Diameter", `${at}/size`, [Number(Array.isArray(emitter["size"]) ? emitter["size"][0] : emitter["size"] ?? 0)], unit),
      shape === "surface" ? form.numbers("Distance", `${at}/distance`, [1], unit) : shape !== "sphere" && form.numbers("Direction", `${at}/direction`, [0, -1, 0]),
      form.numbers("Spread", `${at}/spread_deg`, [0], "°"), form.numbers("Speed", `${at}/speed`, [1000], `${unit}/s`), form.numbers("Gammatons", `${at}/gammatons`, [1000], "an iteration"),
      form.draft["weather"] !== undefined && form.select("Follows", `${at}/follows`, [["", "nothing"], ...["rain", "humidity", "sunshine", "wind"].map((s) => [s, s] as [string, string])], String(emitter["follows"] ?? ""), (s) => form.set(`${at}/follows`, s || undefined)),
      h("h3", {}, "A drop carries"), h("div", { class: "fields" }, amounts(form, `${at}/carries`, materials, (m) => m, (emitter["carries"] ?? {}) as Record<string, number>))];
  };
}

const hex_of = (color: number[]): string => `#${color.map((c) => Math.round(255 * srgb_from_linear(c)).toString(16).padStart(2, "0")).join("")}`;
const color_of = (hex: string): number[] => [1, 3, 5].map((i) => Number(linear_from_srgb(parseInt(hex.slice(i, i + 2), 16) / 255).toFixed(4)));

export function material_fields(index: number, scene: SceneState) {
  return (form: Form): Child[] => {
    const name = String(list_of(form.draft, "material")[index]), look = pointer_to("appearance", name), now = scene.appearance[name] ?? {};
    const own = (form.get(look) ?? {}) as Doc, color = (own["color"] as number[] | undefined) ?? now.color;
    const picker = h("input", { type: "color", value: hex_of(Array.isArray(color) ? color : [0.2, 0.2, 0.2]) });
    picker.oninput = () => form.set(`${look}/color`, color_of(picker.value));
    const is_colored = own["colors"] === undefined && (Array.isArray(color) || color === undefined);
    return [name_field(form, "material", index, name, { list: kMaterials, on: (to) => {
      // A name that means nothing by itself needs a look.
      if (kMaterials.includes(to) || form.get(pointer_to("appearance", to)) !== undefined) return;
      form.set(pointer_to("appearance", to), { color: color_of(picker.value), strength: 1 });
    } }),
      is_colored ? form.field("Color", `${look}/color`, picker) : h("p", { class: "hint" }, "Its color follows the amount, or is a picture: change it in the scene file."),
      form.numbers("Strength", `${look}/strength`, [now.strength ?? 1]), form.numbers("Variation", `${look}/variation`, [now.variation ?? 0]),
      form.numbers("Gloss", `${look}/specular`, [now.specular ?? 0]), form.numbers("Height", `${look}/height`, [now.height ?? 0], "mm"),
      form.numbers("Exchange of drop and surface", pointer_to("exchange", "rates", name), [scene.exchange.rates[name] ?? 0])];
  };
}

export function rule_fields(index: number, scene: SceneState) {
  return (form: Form): Child[] => {
    const at = list_pointer("rule", index), list = list_of(form.draft, "rule");
    if (typeof list[index] === "string") list[index] = { [String(list[index]).endsWith(".json") ? "file" : "name"]: list[index] };
    const rule = list[index] as Doc, materials = list_of(form.draft, "material") as string[], now = scene.rules[index];
    const is_new = rule["driver"] !== undefined && (rule["products"] !== undefined || rule["reactants"] !== undefined);
    const shares = (side: "products" | "reactants"): Record<string, number> => (rule[side] ?? now?.[side] ?? {}) as Record<string, number>;
    const share = (side: "products" | "reactants", material: string): HTMLElement => {
      const box = h("input", { type: "text", inputmode: "decimal", autocomplete: "off", value: String(shares(side)[material] ?? 0) });
      box.oninput = () => {
        const value = Number(box.value.replace(",", "."));
        const all = { ...shares(side), [material]: Number.isFinite(value) ? value : box.value };
        for (const [key, v] of Object.entries(all)) if (v === 0) delete all[key];
        form.set(`${at}/${side}`, all);
      };
      return form.field(material, `${at}/${side}${pointer_to(material)}`, box);
    };
    return [rule["file"] === undefined ? name_field(form, "rule", index, String(rule["name"]), { on: () => {
      if (!is_new && now) for (const [key, value] of Object.entries({ driver: now.driver, rate: now.rate, products: now.products, reactants: now.reactants })) rule[key] ??= value;
    } }) : h("p", { class: "hint" }, `From the file ${String(rule["file"])}`),
      form.text("Formula", `${at}/driver`, { value: now?.driver ?? "", lines: 3, words: ["driver"], hint: "Over materials and maps, slope, exposure, accessibility, height, age" }),
      typeof (rule["where"] ?? "") === "string" && form.text("Where", `${at}/where`, { words: ["where", "mask"], hint: "A factor from 0 to 1; empty: everywhere" }),
      form.numbers("Rate", `${at}/rate`, [now?.rate ?? 0.1], `/ ${scene.time_unit}`, ["rate"]),
      h("h3", {}, "Makes"), h("div", { class: "fields" }, materials.map((m) => share("products", m))), h("h3", {}, "Uses"), h("div", { class: "fields" }, materials.map((m) => share("reactants", m)))];
  };
}

const kSignals: [string, string][] = [["time", "Time"], ["rain", "Rain, mm/h"], ["temperature", "°C"], ["humidity", "Humidity, %"], ["sun", "Sun, 0 to 1"], ["wind", "Wind, m/s"], ["wind_direction", "From, °"]];

export function weather_fields(form: Form): Child[] {
  const rows = form.get("/weather/rows");
  if (!Array.isArray(rows)) return [h("p", { class: "hint" }, "The weather of this scene is a table in a file: ", h("code", {}, String(form.get("/weather/file") ?? form.get("/weather"))), ".")];
  const cell = (row: number, name: string, label: string): HTMLElement => {
    const pointer = pointer_to("weather", "rows", row, name);
    const input = h("input", { type: "text", autocomplete: "off", value: String(form.get(pointer) ?? ""), "aria-label": `${label}, row ${row + 1}` });
    input.oninput = () => {
      const number = Number(input.value.replace(",", "."));
      form.set(pointer, input.value.trim() === "" ? undefined : Number.isFinite(number) ? number : input.value);
    };
    return form.field(label, pointer, input);
  };
  const line = (_: unknown, row: number): HTMLElement => h("div", { class: "weather-row" }, kSignals.map(([name, label]) => cell(row, name, label)), button("Remove", () => {
    rows.splice(row, 1);
    form.render();
  }, { kind: "quiet" }));
  return [h("p", { class: "hint" }, "Each row holds until the next one. An empty field repeats the row above. Times may have a unit: 4 month."), ...rows.map(line),
    button("Add a row", () => {
      rows.push({ ...(rows[rows.length - 1] as Doc | undefined), time: Number((rows[rows.length - 1] as Doc | undefined)?.["time"] ?? 0) + 1 || 0 });
      form.render();
    }),
    form.text("Repeats every", "/weather/repeat", { hint: "A time, such as 1 a; empty: never" })];
}

export function run_fields(form: Form): Child[] {
  return [form.numbers("Iterations", "/run/iterations", [1000]), form.numbers("Time of an iteration", "/time/per_iteration", [0], String(form.get("/time/unit") ?? "d")),
    form.numbers("Texels along each side", "/atlas/resolution", [1024]), form.numbers("Seed of all random choices", "/seed", [0])];
}
