// The form of a command, made of what the command says about its arguments. What is wrong stands at its field; the command line stands below.
import { get_json, get_place, get_places, post, StudioError } from "../api";
import { Form, type Problem } from "../build/form";
import { pointer_to, type Doc } from "../build/document";
import type { HistoryPlace, JobArgument, JobCommand, JobCommands, JobValues, PlaceSummary } from "../types";
import { append, h, replace, type Child } from "../ui/dom";
import { show_error } from "../ui/notices";
import { unique_id } from "../ui/numbers";

const kAbout = "/api/jobs";
const kOutput = "/output";
/// What the ending of the result's name decides.
const kEndings: Record<string, string> = {
  render: "A picture: .png, .jpg, .tif or .exr; a movie: .mp4, .webm or .gif. ",
  export: "A model: .glb, .usdz, .usda or .obj; a movie: .mp4, .webm or .gif; without an ending: a folder of pictures. ",
};

const pointer_of = (argument: JobArgument): string => pointer_to("arguments", argument.key);

/// "spatial_sigma" and "HISTORY" as words.
export function label_of(key: string): string {
  const words = key.replace(/_/g, " ").replace(/^num /, "number of ").toLowerCase();
  return words.charAt(0).toUpperCase() + words.slice(1);
}

const sentence = (text: string): string => (/^\w+\.\w/.test(text) ? text : text.charAt(0).toUpperCase() + text.slice(1));  // Not names of files.

class JobForm {
  private readonly line = h("code", { class: "command", "aria-label": "The command" });
  private readonly more = h("details", { class: "more" });
  private readonly draft: Doc;
  /// Controls of the history that is chosen.
  private controls: string[] = [];

  constructor(private readonly info: JobCommands, private readonly command: JobCommand, private readonly places: PlaceSummary[], given: JobValues, output: string, private readonly started: () => void) {
    const begin = Object.fromEntries(command.arguments.filter((a) => a.value !== "").map((a) => [a.key, a.kind === "repeated" ? [a.value] : a.value]));
    this.draft = { arguments: { ...begin, ...given }, ...(output ? { output } : {}) };
    this.positionals().forEach((argument, i) => {
      const values = this.values(), [first] = this.choices(i).filter(([name]) => !Object.values(given).flat().includes(name));
      if (values[argument.key] === undefined && first && (argument.is_required || i > 0)) values[argument.key] = argument.kind === "positionals" ? [first[0]] : first[0];
    });
  }

  async open(): Promise<void> {
    await this.learn_controls();
    const { command } = this;
    const form: Form = new Form({ title: command.title, draft: this.draft, action: "Start", fields: (made) => this.fields(made), check: (draft): Promise<Problem | null> => this.check(form, draft), apply: async (draft) => {
      await post(kAbout, { command: command.name, ...draft });
      this.started();
    } });
  }

  private values(): JobValues { return this.draft["arguments"] as JobValues; }
  private positionals(): JobArgument[] { return this.command.arguments.filter((a) => a.kind.startsWith("positional")); }

  // What an input may be: [value, text].
  private choices(index: number): [string, string][] {
    const input = this.command.inputs[index];
    if (!input) return [];
    const names = input.kinds.includes("photographs") ? this.info.photographs.map((name) => [name, name === "." ? "this folder" : name] as [string, string])
      : this.places.filter(({ kind }) => input.kinds.includes(kind)).map(({ place, name }) => [place, place.endsWith(name) ? place : `${place} (${name})`] as [string, string]);
    return [...names, ...(input.may_be_library ? this.info.library.map(({ name }) => [name, name] as [string, string]) : [])];
  }

  // A history with several controls must be told which one is meant.
  private async learn_controls(): Promise<void> {
    const source = this.positionals()[0], control = this.command.arguments.find((a) => a.key === "control");
    const name = source && this.values()[source.key];
    if (!control || this.command.name !== "transfer" || typeof name !== "string") return;
    const kept = this.info.library.find((entry) => entry.name === name);
    this.controls = kept ? kept.controls : await get_place<HistoryPlace>(name).then((place) => (place.controls ?? []).map((c) => c.name), () => []);
    const now = this.values()[control.key], is_untouched = Array.isArray(now) && now.length === 1 && now[0]!.split("=").pop() === control.value;
    if (is_untouched) this.values()[control.key] = [this.controls.length > 1 ? `${this.controls[0]}=${control.value}` : control.value];
  }

  private fields(form: Form): Child[] {
    const { command } = this, all = command.arguments, has_usual = all.some((a) => a.is_usual);
    const is_first = (a: JobArgument): boolean => a.is_required || a.kind.startsWith("positional") || (has_usual ? a.is_usual : a.key !== "seed");
    const positionals = this.positionals();
    const field = (a: JobArgument): HTMLElement => this.field(form, a, positionals.indexOf(a));
    const rest = all.filter((a) => !is_first(a));
    replace(this.more, h("summary", {}, rest.length === 1 ? "1 more option" : `${rest.length} more options`), h("div", { class: "form" }, rest.map(field)));
    const output = form.text("Name of the result", kOutput, { hint: `${kEndings[command.name] ?? ""}In this folder; without a name, one that is free is taken.` });
    return [h("p", { class: "hint" }, command.brief), ...all.filter(is_first).map(field), output, rest.length > 0 && this.more, h("div", { class: "as-command" }, h("span", { class: "hint" }, "The same in a terminal, in the folder that is served:"), this.line)];
  }

  private field(form: Form, a: JobArgument, input: number): HTMLElement {
    const pointer = pointer_of(a), label = label_of(a.key), hint = this.hint(a);
    const choices = input >= 0 ? this.choices(input) : [];
    if (a.kind === "positionals") return this.several(form, a, choices);
    if (input >= 0) return this.with_hint(form.select(label, pointer, choices, String(form.get(pointer) ?? ""), (name) => {
      form.set(pointer, name);
      if (input === 0) void this.learn_controls().then(() => form.render());
    }), choices.length > 0 ? hint : `There is none in this folder; copy one into it. ${hint}`);
    if (a.kind === "flag") return this.flag(form, a);
    if (a.kind === "repeated") return this.lines(form, a);
    if (a.is_closed) {
      const options = a.choices.map((c) => [c, c] as [string, string]);
      return this.with_hint(form.select(label, pointer, a.default ? options : [["", "(not given)"], ...options], String(form.get(pointer) ?? a.default), (value) => form.set(pointer, value === a.default || value === "" ? undefined : value)), hint);
    }
    const is_said = a.default.includes(" ");
    const made = form.text(label, pointer, { hint: is_said ? `${hint}; default: ${a.default}` : hint, ...(a.choices.length > 0 ? { list: a.choices } : {}) });
    made.querySelector("input")!.placeholder = is_said ? "" : a.default || (a.type === "path" ? "a name in this folder" : "");
    return made;
  }

  // The command's help, with options under the names that they have here.
  private hint(a: JobArgument): string {
    const label = (name: string): string => this.command.arguments.filter((other) => other.name === name).map(({ key }) => `"${label_of(key)}"`)[0] ?? name;
    return sentence(a.help).replace(/--[a-z][a-z-]*/g, label);
  }

  private with_hint(field: HTMLElement, hint: string): HTMLElement {
    field.querySelector(".problem")?.before(h("span", { class: "hint" }, hint));
    return field;
  }

  private flag(form: Form, a: JobArgument): HTMLElement {
    const pointer = pointer_of(a), is_on = a.default === "true";
    const input = h("input", { type: "checkbox", role: "switch", checked: (form.get(pointer) ?? is_on) === true, onchange: () => form.set(pointer, input.checked === is_on ? undefined : input.checked) });
    return form.field(label_of(a.key), pointer, input, [], this.hint(a));
  }

  // Several places: each is taken or not.
  private several(form: Form, a: JobArgument, choices: [string, string][]): HTMLElement {
    const pointer = pointer_of(a), chosen = (): string[] => (form.get(pointer) as string[] | undefined) ?? [];
    const box = h("div", { class: "several", role: "group", "aria-label": label_of(a.key) }, choices.map(([name, text]) => {
      const input = h("input", { type: "checkbox", value: name, checked: chosen().includes(name), onchange: () => form.set(pointer, choices.map(([each]) => each).filter((each) => (each === name ? input.checked : chosen().includes(each)))) });
      return h("label", {}, input, text);
    }));
    return form.field(label_of(a.key), pointer, box, [], choices.length > 0 ? this.hint(a) : `There is none in this folder; copy one into it. ${this.hint(a)}`);
  }

  // One value a line.
  private lines(form: Form, a: JobArgument): HTMLElement {
    const pointer = pointer_of(a), values = (): string[] => (form.get(pointer) as string[] | undefined) ?? [];
    const words = a.key === "control" && this.controls.length > 0 ? this.controls.flatMap((control) => a.choices.map((kind) => `${control}=${kind}`)) : a.choices;
    const list = h("datalist", { id: unique_id() }, words.map((word) => h("option", { value: word })));
    const box = h("div", { class: "lines" });
    const put = (): void => form.set(pointer, [...box.querySelectorAll("input")].map((input) => input.value).filter((value) => value !== ""));
    const add = (value: string): HTMLInputElement => {
      const input = h("input", { type: "text", value, autocomplete: "off", spellcheck: "false", list: list.id, placeholder: a.form, "aria-label": label_of(a.key), oninput: put });
      box.insertBefore(input, another);
      return input;
    };
    const another = h("button", { type: "button", class: "quiet", onclick: () => add("").focus() }, "Add another");
    append(box, [another, list]);
    for (const value of values().length > 0 ? values() : [""]) add(value);
    return form.field(label_of(a.key), pointer, box, [], this.hint(a));
  }

  private async check(form: Form, draft: Doc): Promise<Problem | null> {
    try {
      const { line, output } = JSON.parse(await (await post(kAbout, { command: this.command.name, check: true, ...draft })).text()) as { line: string; output: string };
      this.line.textContent = line;
      (form.input_of(kOutput) as HTMLInputElement).placeholder = output;
      return null;
    } catch (error) {
      if (!(error instanceof StudioError)) throw error;
      const key = error.argument, pointer = key === "output" ? kOutput : key ? pointer_to("arguments", key) : "";
      const input = pointer ? form.input_of(pointer) : undefined;
      if (input && this.more.contains(input)) this.more.open = true;
      this.line.textContent = "";
      return { pointer: input ? pointer : "", text: sentence(error.message) };
    }
  }
}

/// Asks what a command is to be given, and starts it. @param started  Is called when it has been.
export async function open_job(name: string, given: JobValues, started: () => void, output = ""): Promise<void> {
  try {
    const [info, { places }] = await Promise.all([get_json<JobCommands>("/api/commands"), get_places()]);
    const command = info.commands.find((each) => each.name === name);
    if (command) await new JobForm(info, command, places, given, output, started).open();
  } catch (error) {
    show_error(error, kAbout);
  }
}
