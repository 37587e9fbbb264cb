// What can be made of a place, as buttons on its page.
import { get_json, is_static } from "../api";
import type { JobArgument, JobCommand, JobCommands, JobValues, PlaceBase } from "../types";
import { button } from "../ui/controls";
import { append, h } from "../ui/dom";
import { open_job } from "./job_form";
import { jobs_panel } from "./jobs_panel";

let known: Promise<JobCommand[]> | undefined;

// They are the same as long as the program runs.
function commands(): Promise<JobCommand[]> {
  known ??= get_json<JobCommands>("/api/commands").then((info) => info.commands, () => {
    known = undefined;
    return [];
  });
  return known;
}

export function start_job(command: string, given: JobValues, output = ""): void {
  void open_job(command, given, jobs_panel.started, output);
}

export function job_buttons(place: PlaceBase): HTMLElement {
  const box = h("div", { class: "actions job-buttons" });
  if (!is_static()) void commands().then((all) => append(box, all.map((command) => button_of(command, place))));
  return box;
}

function button_of(command: JobCommand, place: PlaceBase): HTMLElement | null {
  const at = command.inputs.findIndex((input) => input.title !== "" && input.kinds.includes(place.kind));
  const argument: JobArgument | undefined = command.arguments.filter((a) => a.kind.startsWith("positional"))[at];
  if (!argument) return null;
  return button(command.inputs[at]!.title, () => start_job(command.name, { [argument.key]: argument.kind === "positionals" ? [place.place] : place.place }), { hint: command.brief });
}
