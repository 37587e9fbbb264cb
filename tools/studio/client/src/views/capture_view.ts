// What was done on the way from photographs and scans to data: step by step, each with its pictures.
import { get, preview_url, url_of } from "../api";
import type { ScanInfo, StepPicture, StepsPlace } from "../types";
import { job_buttons } from "../jobs/job_buttons";
import { icon_button } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { kind_text } from "./places_view";
import { ScansStage } from "./scans_stage";
import type { View } from "./view";
import { facts_table } from "./workspace";

interface NumberedStep {
  step: StepsPlace["steps"][number];
  number: number;
}

/// The first of a sheet has its heading to jump to, the others their picture.
function anchor_of(number: number, group: NumberedStep[]): string | undefined {
  return number === group[0]!.number ? undefined : `step-${number}`;
}

const kTileWidth = 420, kLargeWidth = 1800;

export class CaptureView implements View {
  readonly element: HTMLElement;
  private readonly large = h("dialog", { class: "light-box", "aria-label": "Picture" });
  private readonly scans: ScansStage | undefined;
  private pictures: StepPicture[] = [];
  private at = 0;

  constructor(private readonly place: StepsPlace) {
    const steps = place.steps ?? [];
    this.pictures = steps.flatMap((s) => s.pictures);
    const list = h("ol", {}, steps.map((s, i) => h("li", {}, h("a", { href: `#step-${i}`, onclick: (e: Event) => { e.preventDefault(); this.element.querySelector(`#step-${i}`)?.scrollIntoView({ behavior: "smooth" }); } }, s.name,
      h("small", {}, s.pictures.length === 1 ? "1 picture" : `${s.pictures.length} pictures`)))));
    window.patinate = { view: "capture" };
    this.scans = place.mesh && place.scans ? new ScansStage(place.place, place.scans) : undefined;
    const body = h("div", { class: "steps" }, this.scans?.element, !this.scans && place.scans && this.scan_table(place.scans),
      steps.length === 0 && h("p", { class: "empty" }, "Nothing was kept of its steps."),
      this.groups().map((group) => h("section", {}, group.map(({ step, number }, i) => [
        i === 0 && h("h2", { id: `step-${number}` }, h("span", { class: "number" }, number + 1), group.length > 1 ? `${step.name} to ${group[group.length - 1]!.step.name}` : step.name),
        i === 0 && h("p", {}, step.text)]).flat(),
        h("div", { class: "pictures" }, group.map(({ step, number }) => step.pictures.map((p) => this.tile(p, group.length > 1 ? step.name : p.caption, anchor_of(number, group)))).flat()))));
    this.element = h("main", { class: "capture" }, h("aside", { class: "panel", "aria-label": "Steps" },
      h("header", { class: "panel-head" }, h("h1", {}, place.name), h("p", { class: "kind" }, kind_text(place.kind)), job_buttons(place)), h("nav", { "aria-label": "Steps" }, list), facts_table(place.facts ?? [])), body, this.large);
    if (place.hints) void this.show_draft(body, place.hints);
    this.large.addEventListener("click", (e) => { if (e.target === this.large) this.large.close(); });
    this.large.addEventListener("keydown", (e) => {
      if (e.key === "ArrowRight") this.show(this.at + 1);
      else if (e.key === "ArrowLeft") this.show(this.at - 1);
    });
  }

  dispose(): void {
    this.scans?.dispose();
  }

  // What `init` has found, and what is to be checked before `ingest`.
  private async show_draft(body: HTMLElement, path: string): Promise<void> {
    const text = await get(url_of("/api/file", { place: this.place.place, path })).then((reply) => new TextDecoder().decode(reply.bytes), () => "");
    const lines = text.split("\n").filter((line) => /^(found|check): /.test(line)).map((line) => line.split(/: (.*)/));
    if (lines.length > 0) body.prepend(h("section", { class: "draft" }, h("h2", {}, "What the draft says"), h("dl", {}, lines.map(([word, rest]) => [h("dt", { class: word }, word!), h("dd", {}, rest ?? "")]).flat()), h("p", { class: "hint" }, `All of this is in capture.json: ${this.place.has_marks ? "set crop, mask, scale and chart above, and the rest" : "change it"} with a text editor, then ingest.`)));
  }

  on_key(key: string): boolean {
    if (key !== "f" || !this.scans) return false;
    this.scans.fit();
    return true;
  }

  // Of scans that are all elsewhere.
  private scan_table(scans: ScanInfo[]): HTMLElement {
    return h("section", {}, h("h2", {}, "Scans"), facts_table(scans.map((s) => [s.name, s.text])));
  }

  // Steps of one photograph and no words, one after the other, are one sheet.
  private groups(): NumberedStep[][] {
    const groups: NumberedStep[][] = [];
    const is_plain = ({ step }: NumberedStep): boolean => step.text === "" && step.pictures.length <= 1;
    (this.place.steps ?? []).forEach((step, number) => {
      const last = groups[groups.length - 1];
      const numbered = { step, number };
      if (last && is_plain(last[0]!) && is_plain(numbered)) last.push(numbered);
      else groups.push([numbered]);
    });
    return groups;
  }

  private tile(picture: StepPicture, caption: string, id: string | undefined): HTMLElement {
    const number = this.pictures.indexOf(picture);
    return h("figure", { id }, h("button", { type: "button", onclick: () => this.show(number), "aria-label": `Enlarge: ${picture.caption}` },
      h("img", { src: preview_url(picture.place ?? this.place.place, picture.path, kTileWidth), alt: picture.caption, loading: "lazy", decoding: "async" })), h("figcaption", {}, caption));
  }

  private show(number: number): void {
    const picture = this.pictures[number];
    if (!picture) return;
    this.at = number;
    replace(this.large, h("header", {}, h("span", {}, `${picture.caption}  (${number + 1} of ${this.pictures.length})`), icon_button("back", "Picture before", () => this.show(number - 1), "←"),
      icon_button("step", "Next picture", () => this.show(number + 1), "→"), icon_button("close", "Close", () => this.large.close(), "Esc")),
      h("img", { src: preview_url(picture.place ?? this.place.place, picture.path, kLargeWidth), alt: picture.caption }));
    if (!this.large.open) this.large.showModal();
  }
}
