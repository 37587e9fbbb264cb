// A scene file in the page: what can be done to its parts, and what of it then has changed.

export type Doc = Record<string, unknown>;
export type Kind = "object" | "emitter" | "material" | "rule";
export interface Operation { op: "add" | "remove" | "replace"; path: string; value?: unknown }

const kLists: Record<Kind, string> = { object: "objects", emitter: "emitters", material: "materials", rule: "rules" };
/// Members whose own members are called like materials.
const kByMaterial = ["appearance", "rates", "carries", "initial", "composition", "products", "reactants"];
/// Members that are expressions, or may be.
const kFormulas = ["driver", "where", "initial"];

const is_object = (value: unknown): value is Doc => typeof value === "object" && value !== null && !Array.isArray(value);
const escaped = (name: string): string => name.replace(/~/g, "~0").replace(/\//g, "~1");
const parts_of = (pointer: string): string[] => pointer.split("/").slice(1).map((part) => part.replace(/~1/g, "/").replace(/~0/g, "~"));

export const pointer_to = (...parts: (string | number)[]): string => parts.map((part) => `/${escaped(String(part))}`).join("");
export const copy_of = <T>(value: T): T => JSON.parse(JSON.stringify(value)) as T;

export function get_at(doc: Doc, pointer: string): unknown {
  return parts_of(pointer).reduce<unknown>((value, part) => (typeof value === "object" && value !== null ? (value as Doc)[part] : undefined), doc);
}

/// undefined removes it. Objects on the way are made.
export function set_at(doc: Doc, pointer: string, value: unknown): void {
  const parts = parts_of(pointer), last = parts.pop()!;
  let at: Doc = doc;
  for (const part of parts) at = (is_object(at[part]) || Array.isArray(at[part]) ? at[part] : (at[part] = {})) as Doc;
  if (value === undefined) delete at[last];
  else at[last] = value;
}

/// JSON Patch from one to the other, by the members at the top.
export function patch_of(before: Doc, after: Doc): Operation[] {
  const is_same = (name: string): boolean => JSON.stringify(before[name]) === JSON.stringify(after[name]);
  return [...Object.keys(before).filter((name) => !(name in after)).map((name): Operation => ({ op: "remove", path: pointer_to(name) })),
    ...Object.keys(after).filter((name) => !is_same(name)).map((name): Operation => ({ op: name in before ? "replace" : "add", path: pointer_to(name), value: after[name] }))];
}

export function list_of(doc: Doc, kind: Kind): unknown[] {
  const list = doc[kLists[kind]];
  return Array.isArray(list) ? list : [];
}

export const list_pointer = (kind: Kind, index?: number): string => (index === undefined ? `/${kLists[kind]}` : `/${kLists[kind]}/${index}`);

/// "rain 2" where there is a rain, as material "moss_2": formulas name those.
export function free_name(name: string, taken: string[], between = " "): string {
  const base = name.replace(/[ _]\d+$/, "");
  let free = name;
  for (let k = 2; taken.includes(free); ++k) free = `${base}${between}${k}`;
  return free;
}

const renamed_in = (formula: string, from: string, to: string): string => formula.replace(/[A-Za-z_][A-Za-z0-9_]*/g, (word) => (word === from ? to : word));

/// Every value with the name of its member, outermost first.
function walk(value: unknown, visit: (owner: Doc, name: string) => void): void {
  if (typeof value !== "object" || value === null) return;
  for (const name of Object.keys(value)) {
    visit(value as Doc, name);
    walk((value as Doc)[name], visit);
  }
}

function rename_key(owner: Doc, from: string, to: string | undefined): void {
  const entries = Object.entries(owner);
  for (const [name] of entries) delete owner[name];
  for (const [name, value] of entries) {
    if (name !== from) owner[name] = value;
    else if (to !== undefined) owner[to] = value;
  }
}

/// All that names a material names it so; undefined: nothing names it any more but formulas, and rules by their own names.
function rename_material(doc: Doc, from: string, to: string | undefined): void {
  walk(doc, (owner, name) => {
    const value = owner[name];
    if (kByMaterial.includes(name) && is_object(value) && from in value) rename_key(value, from, to);
    if (to === undefined) return;
    if (kFormulas.includes(name) && typeof value === "string") owner[name] = renamed_in(value, from, to);
    if (name === "initial" && is_object(value)) for (const [key, text] of Object.entries(value)) if (typeof text === "string") value[key] = renamed_in(text, from, to);
    if (name === "wet_material" && value === from) owner[name] = to;
    if (name === "target" && value === from && owner["op"] === "rate") owner[name] = to;
    if (name === "controls" && Array.isArray(value)) owner[name] = value.map((map) => (typeof map === "string" && map.startsWith(`${from}.`) ? to + map.slice(from.length) : map));
  });
  if (to === undefined && is_object(doc["run"]) && Array.isArray(doc["run"]["controls"])) doc["run"]["controls"] = doc["run"]["controls"].filter((map) => !String(map).startsWith(`${from}.`));
}

const events_of = (doc: Doc): Doc[] => (Array.isArray(doc["events"]) ? (doc["events"] as Doc[]) : []);
const is_about = (event: Doc, kind: Kind, name: string): boolean =>
  kind === "rule" ? event["op"] === "rule" && event["target"] === name
    : event["op"] !== "rule" && event["op"] !== "rate" && (event["target"] === name || (is_object(event["emitter"]) && event["emitter"]["name"] === name));

/// A part gets another name, also where others name it.
export function rename(doc: Doc, kind: Kind, index: number, to: string, from: string): void {
  const list = list_of(doc, kind);
  if (kind === "material") {
    list[index] = to;
    rename_material(doc, from, to);
    return;
  }
  (list[index] as Doc)["name"] = to;
  for (const event of events_of(doc)) {
    if (!is_about(event, kind, from)) continue;
    if (event["target"] === from) event["target"] = to;
    if (is_object(event["emitter"])) event["emitter"]["name"] = to;
  }
  if (kind !== "object") return;
  walk(doc, (owner, name) => {
    const value = owner[name];
    if ((name === "where" || name === "objects") && Array.isArray(value)) owner[name] = value.map((v) => (v === from ? to : v));
  });
}

export function remove(doc: Doc, kind: Kind, index: number, name: string): void {
  list_of(doc, kind).splice(index, 1);
  if (kind === "material") rename_material(doc, name, undefined);
  else if (doc["events"]) doc["events"] = events_of(doc).filter((event) => !is_about(event, kind, name));
}

/// @param names  Of all parts of its kind. @returns the name of the copy.
export function duplicate(doc: Doc, kind: Kind, index: number, names: string[]): string {
  const list = list_of(doc, kind), from = names[index]!, to = free_name(from, names, kind === "material" ? "_" : " ");
  if (kind === "material") {
    list.push(to);
    walk(doc, (owner, name) => {
      const value = owner[name];
      if (["appearance", "rates"].includes(name) && is_object(value) && from in value) value[to] = copy_of(value[from]);
    });
  } else {
    list.splice(index + 1, 0, { ...(copy_of(list[index]) as Doc), name: to });
  }
  return to;
}
