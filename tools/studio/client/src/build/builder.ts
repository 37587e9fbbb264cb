// Building a scene: its parts are added, changed, copied and removed, each as one step that can be undone.
import { get_places } from "../api";
import type { SceneContext } from "../simulation/context";
import { button, section } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { show_error } from "../ui/notices";
import { copy_of, duplicate, free_name, list_of, list_pointer, patch_of, remove, type Doc, type Kind } from "./document";
import { Form, type Problem } from "./form";
import { emitter_fields, material_fields, new_emitter, object_fields, rule_fields, run_fields, weather_fields } from "./forms";
import { relative_path } from "./paths";
import { choose_mesh } from "./upload";

const kAbout = "build";
const kAgain = "The scene begins again with it. Undo brings everything back.";

export interface Asker {
  /// A command; what goes wrong is thrown. @returns what the server answers.
  ask(op: string, fields: Record<string, unknown>): Promise<Record<string, unknown>>;
}

export class Builder {
  readonly element: HTMLDetailsElement;
  on_hide: ((name: string, is_hidden: boolean) => void) | undefined;
  readonly hidden = new Set<string>();
  private readonly body = h("div", { class: "stack" });

  constructor(private readonly context: SceneContext, private readonly asker: Asker, private readonly place: string) {
    this.element = section("Scene file", false, this.body);
    this.element.addEventListener("toggle", () => { if (this.element.open) void this.show(); });
  }

  get can_edit(): boolean { return this.context.scene?.can_edit === true; }

  names(kind: Kind): string[] {
    const { scene } = this.context;
    return kind === "material" ? scene.materials : { object: scene.objects, emitter: scene.emitters, rule: scene.rules }[kind].map((part) => part.name);
  }

  /// Buttons for one part.
  actions(kind: Kind, name: string): HTMLElement | null {
    if (!this.can_edit) return null;
    const hide = button(this.hidden.has(name) ? "Show" : "Hide", () => {
      if (!this.hidden.delete(name)) this.hidden.add(name);
      hide.querySelector("span")!.textContent = this.hidden.has(name) ? "Show" : "Hide";
      this.on_hide?.(name, this.hidden.has(name));
    }, { hint: "In the picture only; it takes part in everything" });
    return h("div", { class: "actions", role: "group", "aria-label": name }, button("Edit", () => void this.edit(kind, name), { hint: "Name and all values" }),
      button("Duplicate", () => void this.change(`Duplicate ${name}`, (doc) => duplicate(doc, kind, this.index(kind, name), this.names(kind))), { hint: kAgain }),
      kind === "object" && hide, button("Delete", () => void this.change(`Delete ${name}`, (doc) => remove(doc, kind, this.index(kind, name), name)), { hint: kAgain }));
  }

  add_button(kind: Kind): HTMLElement | null {
    return this.can_edit ? button(`Add ${kind === "material" ? "a material" : kind === "rule" ? "a rule" : kind === "object" ? "an object" : "an emitter"}`, () => void this.add(kind), { icon: "plus", kind: "quiet", hint: kAgain }) : null;
  }

  /// What is wrong with a formula that is being typed.
  async formula_problem(rule: string, driver: string): Promise<string> {
    const { document, state } = await this.read();
    const draft = copy_of(document), list = list_of(draft, "rule"), i = this.index("rule", rule);
    list[i] = typeof list[i] === "string" ? { name: list[i], driver } : { ...(list[i] as Doc), driver };
    return (await this.check(document, draft, state))?.text ?? "";
  }

  /// Of what is in the panel.
  async show(): Promise<void> {
    if (!this.element.open || !this.context.scene) return;
    try {
      const { document, text } = await this.read();
      const saved = this.context.scene.edited ? [h("p", { class: "hint" }, "The scene was changed: save it, and its own command repeats it.")] : this.command();
      replace(this.body, saved, this.can_edit && h("div", { class: "actions" }, button("Run and detail", () => void this.edit_part("Run and detail", run_fields)),
        document["weather"] !== undefined && button("Weather", () => void this.edit_part("Weather", weather_fields)), button("Edit as text", () => void this.edit_text())),
      h("details", { class: "scene-text" }, h("summary", {}, "What it says"), h("pre", { tabindex: "0" }, text)));
    } catch (error) {
      show_error(error, kAbout);
    }
  }

  private command(): HTMLElement[] {
    const name = this.place.split("/").pop()!.replace(/\.json$/, "");
    return [h("p", { class: "hint" }, "This command repeats it in the served folder:"), h("code", { class: "command" }, `patinate simulate ${this.place} -o ${name}`)];
  }

  private index(kind: Kind, name: string): number {
    return this.names(kind).indexOf(name);
  }

  private async read(): Promise<{ document: Doc; state: number; text: string }> {
    const answer = await this.asker.ask("document", {});
    return { document: answer["document"] as Doc, state: answer["state"] as number, text: String(answer["text"]) };
  }

  private async check(before: Doc, after: Doc, state: number): Promise<Problem | null> {
    return (await this.asker.ask("check", { patch: patch_of(before, after), state }))["problem"] as Problem | null;
  }

  private async commit(label: string, before: Doc, after: Doc, state: number): Promise<void> {
    const patch = patch_of(before, after);
    if (patch.length > 0) await this.asker.ask("edit", { patch, state, label: label.slice(0, 90) });
  }

  private async change(label: string, change: (doc: Doc) => void): Promise<void> {
    try {
      const { document, state } = await this.read(), after = copy_of(document);
      change(after);
      const problem = await this.check(document, after, state);
      if (problem) throw new Error(`${label}: ${problem.text}`);
      await this.commit(label, document, after, state);
    } catch (error) {
      show_error(error, kAbout);
    }
  }

  private async form(title: string, action: string, prepare: (draft: Doc) => (form: Form) => ReturnType<typeof weather_fields>, label: (draft: Doc) => string): Promise<void> {
    try {
      const { document, state } = await this.read(), draft = copy_of(document), fields = prepare(draft);
      new Form({ title, draft, action, fields, check: (after) => this.check(document, after, state), apply: (after) => this.commit(label(after), document, after, state) });
    } catch (error) {
      show_error(error, kAbout);
    }
  }

  private async fields_of(kind: Kind, index: number) {
    const { scene } = this.context;
    if (kind === "emitter") return emitter_fields(index, scene);
    if (kind === "material") return material_fields(index, scene);
    if (kind === "rule") return rule_fields(index, scene);
    const meshes = (await get_places()).places.filter((p) => p.kind === "mesh").map((p) => relative_path(this.place, p.place));
    return object_fields(index, meshes, (take) => choose_mesh("Another mesh ...", (place) => take(relative_path(this.place, place))));
  }

  private async edit(kind: Kind, name: string): Promise<void> {
    const index = this.index(kind, name), fields = await this.fields_of(kind, index);
    await this.form(`${kind[0]!.toUpperCase()}${kind.slice(1)}: ${name}`, "Apply", () => fields, (after) => {
      const to = kind === "material" ? list_of(after, kind)[index] : (list_of(after, kind)[index] as Doc)["name"] ?? name;
      return to === name ? `Change ${name}` : `${name} becomes ${String(to)}`;
    });
  }

  private edit_part(title: string, fields: (form: Form) => ReturnType<typeof weather_fields>): Promise<void> {
    return this.form(title, "Apply", () => fields, () => title);
  }

  private async add(kind: Kind): Promise<void> {
    const { scene } = this.context, index = this.names(kind).length, fields = await this.fields_of(kind, index);
    const name_of = (draft: Doc): string => String(kind === "material" ? list_of(draft, kind)[index] : (list_of(draft, kind)[index] as Doc)["name"]);
    await this.form(`A new ${kind}`, "Add", (draft) => {
      const taken = this.names(kind), all = list_of(draft, kind);
      if (!Array.isArray(draft[list_pointer(kind).slice(1)])) draft[list_pointer(kind).slice(1)] = all;
      if (kind === "object") all.push({ ...(copy_of(all[0]) as Doc), name: free_name("object", [...taken, ...this.names("emitter")]) });
      if (kind === "emitter") all.push(new_emitter(free_name("rain", [...taken, ...this.names("object")]), draft, scene));
      if (kind === "rule") all.push({ name: free_name("rule", taken), driver: scene.materials[0], rate: 0.1, products: {}, reactants: { [scene.materials[0]!]: 1 } });
      if (kind === "material") {
        const name = free_name("lichen", taken, "_");
        all.push(name);
        draft["appearance"] = { ...((draft["appearance"] ?? {}) as Doc), [name]: { color: [0.3, 0.32, 0.2], strength: 1 } };
      }
      return fields;
    }, (after) => `Add ${name_of(after)}`);
  }

  private async edit_text(): Promise<void> {
    const { text: now } = await this.read();
    await this.form("Scene file", "Apply", () => {
      const text = h("textarea", { class: "scene-source", rows: 22, spellcheck: "false", "aria-label": "Scene file" });
      text.value = now;
      return (form) => {
        text.oninput = () => {
          try {
            const typed = JSON.parse(text.value) as Doc;
            for (const name of Object.keys(form.draft)) delete form.draft[name];
            Object.assign(form.draft, typed);
            form.fail("");
          } catch (error) {
            form.fail(error instanceof Error ? error.message : String(error));
          }
        };
        return [text];
      };
    }, () => "Scene file");
  }
}
