// A dialog of fields that change a copy of the scene file. It is checked while one types; what is wrong stands at its field.
import { button } from "../ui/controls";
import { open_dialog } from "../ui/dialog";
import { append, h, replace, type Child } from "../ui/dom";
import { parse_number, unique_id } from "../ui/numbers";
import { get_at, set_at, type Doc } from "./document";

const kCheck_ms = 250;

/// What is wrong with a scene file, and where.
export interface Problem {
  pointer: string;
  text: string;
}

export interface FormOptions {
  title: string;
  draft: Doc;
  action: string;
  /// All fields; called again after a choice that others depend on.
  fields: (form: Form) => Child[];
  check: (draft: Doc) => Promise<Problem | null>;
  apply: (draft: Doc) => Promise<void>;
}

interface Field {
  pointer: string;
  /// Words of a message that mean this field, where it names none.
  words: string[];
  input: HTMLElement;
  problem: HTMLElement;
  /// Of what is typed, where it cannot be a value at all.
  own: string;
}

export class Form {
  readonly draft: Doc;
  private fields: Field[] = [];
  private readonly body = h("div", { class: "form" });
  private readonly foot = h("p", { class: "problem", role: "alert" });
  private readonly accept: HTMLButtonElement;
  private readonly dialog: HTMLDialogElement;
  private timer: number | undefined;
  private num_checks = 0;
  private own = "";

  constructor(private readonly options: FormOptions) {
    this.draft = options.draft;
    this.accept = button(options.action, () => void this.apply(), { kind: "primary" });
    this.dialog = open_dialog(options.title, [this.body, this.foot], [button("Cancel", () => this.dialog.close()), this.accept]);
    this.dialog.classList.add("wide");
    this.dialog.addEventListener("close", () => { window.clearTimeout(this.timer); ++this.num_checks; });
    this.dialog.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && (event.target as HTMLElement).matches("input")) {
        event.preventDefault();
        this.accept.click();
      }
    });
    this.render();
    this.body.querySelector<HTMLElement>("input, select, textarea")?.focus();
  }

  /// Makes all fields again.
  render(): void {
    this.fields = [];
    replace(this.body, this.options.fields(this));
    this.changed();
  }

  get(pointer: string): unknown { return get_at(this.draft, pointer); }

  set(pointer: string, value: unknown): void {
    set_at(this.draft, pointer, value);
    this.changed();
  }

  /// What is wrong with what is typed, where it is no draft at all; "" = nothing.
  fail(text: string): void {
    this.own = text;
    this.changed();
  }

  /// A line of text. `value`: shown where the draft has none.
  text(label: string, pointer: string, options: { value?: string; list?: string[]; lines?: number; words?: string[]; hint?: string; on?: (text: string) => void } = {}): HTMLElement {
    const value = String(this.get(pointer) ?? options.value ?? "");
    const list = options.list ? h("datalist", { id: unique_id() }, options.list.map((text) => h("option", { value: text }))) : undefined;
    const input = options.lines ? h("textarea", { rows: options.lines, class: "formula", spellcheck: "false" }) : h("input", { type: "text", autocomplete: "off", spellcheck: "false", list: list?.id });
    input.value = value;
    const field = this.field(label, pointer, input, options.words, options.hint);
    input.oninput = () => {
      if (options.on) options.on(input.value);
      else set_at(this.draft, pointer, input.value === "" ? undefined : input.value);
      this.changed();
    };
    if (list) field.append(list);
    return field;
  }

  /// `count` numbers side by side; one is a number, more are a list.
  numbers(label: string, pointer: string, fallback: number[], unit = "", words: string[] = []): HTMLElement {
    const count = fallback.length, given = this.get(pointer);
    const now: number[] = (count === 1 ? [given ?? fallback[0]] : Array.isArray(given) ? given : fallback) as number[];
    const box = h("div", { class: "numbers" });
    const element = this.field(label, pointer, box, words);
    const field = this.fields[this.fields.length - 1]!;
    const names = count === 3 ? ["x", "y", "z"] : ["width", "depth"];
    const inputs = now.map((value, i) => h("input", { type: "text", inputmode: "decimal", autocomplete: "off", spellcheck: "false", value: String(value), "aria-label": count > 1 ? `${label} ${names[i]}` : label }));
    for (const input of inputs) {
      input.oninput = () => {
        const values = inputs.map((each) => parse_number(each.value));
        field.own = values.every((value) => value !== undefined) ? "" : "This is no number.";
        if (!field.own) set_at(this.draft, pointer, count === 1 ? values[0] : values);
        this.changed();
      };
    }
    append(box, [...inputs, unit && h("span", { class: "unit" }, unit)]);
    return element;
  }

  select(label: string, pointer: string, choices: [string, string][], value: string, on: (value: string) => void): HTMLElement {
    const all = choices.some(([name]) => name === value) ? choices : [...choices, [value, value] as [string, string]];
    const input = h("select", {}, all.map(([name, text]) => h("option", { value: name }, text)));
    input.value = value;
    input.onchange = () => {
      on(input.value);
      this.changed();
    };
    return this.field(label, pointer, input);
  }

  /// Any control that shows `pointer`.
  field(label: string, pointer: string, input: HTMLElement, words: string[] = [], hint = ""): HTMLElement {
    const id = unique_id(), problem = h("span", { class: "problem", id: `${id}-problem` });
    input.id = id;
    input.setAttribute("aria-describedby", problem.id);
    this.fields.push({ pointer, words, input, problem, own: "" });
    return h("div", { class: "field" }, h("label", { for: id }, label), input, hint ? h("span", { class: "hint" }, hint) : null, problem);
  }

  /// Where the value of a pointer is shown.
  input_of(pointer: string): HTMLElement | undefined { return this.fields.find((field) => field.pointer === pointer)?.input; }

  /// Something has changed: it is checked soon.
  changed(): void {
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.check(), kCheck_ms);
  }

  private async check(): Promise<boolean> {
    const number = ++this.num_checks;
    let problem: Problem | null = null;
    if (this.own) problem = { pointer: "", text: this.own };
    else if (!this.fields.some((field) => field.own)) problem = await this.options.check(this.draft).catch((error: Error) => ({ pointer: "", text: error.message }));
    if (number !== this.num_checks) return false;
    this.show(problem);
    return problem === null && !this.fields.some((field) => field.own);
  }

  private show(problem: Problem | null): void {
    // The longest pointer that leads there; else what the message speaks of; else the end of the form.
    const leads = (field: Field): boolean => problem !== null && problem.pointer !== "" && (problem.pointer === field.pointer || problem.pointer.startsWith(`${field.pointer}/`));
    const speaks = (field: Field): boolean => problem !== null && field.words.some((word) => problem.text.includes(word));
    const at = this.fields.filter(leads).sort((a, b) => b.pointer.length - a.pointer.length)[0] ?? this.fields.find(speaks);
    for (const field of this.fields) {
      field.problem.textContent = field.own || (field === at ? problem!.text : "");
      field.input.classList.toggle("wrong", field.problem.textContent !== "");
      field.input.setAttribute("aria-invalid", String(field.problem.textContent !== ""));
    }
    this.foot.textContent = problem && !at ? `${problem.pointer ? `${problem.pointer}: ` : ""}${problem.text}` : "";
    this.accept.disabled = problem !== null || this.fields.some((field) => field.own !== "");
  }

  private async apply(): Promise<void> {
    window.clearTimeout(this.timer);
    if (!(await this.check())) return;
    this.accept.disabled = true;
    try {
      await this.options.apply(this.draft);
      this.dialog.close();
    } catch (error) {
      this.foot.textContent = error instanceof Error ? error.message : String(error);
      this.accept.disabled = false;
    }
  }
}
