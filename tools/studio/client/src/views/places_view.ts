// The start page: everything in the served folder that can be shown.
import { get_places } from "../api";
import { choose_mesh, drop_files, is_mesh_file, upload } from "../build/upload";
import { is_photograph } from "../capture/photograph_files";
import { dropped_files, open_photographs } from "../capture/photographs_dialog";
import { kJobEnded } from "../jobs/jobs_panel";
import { Thumbnails } from "../scene/thumbnails";
import type { Places, PlaceSummary } from "../types";
import { button } from "../ui/controls";
import { h, replace } from "../ui/dom";
import { icon } from "../ui/icons";
import { failure, show_error } from "../ui/notices";
import type { View } from "./view";

interface Group {
  title: string;
  text: string;
  kinds: string[];
}

const kGroups: Group[] = [
  { title: "Scenes to simulate", text: "Open one and let it rain: emitters can be moved and painted with while it runs.", kinds: ["scene"] },
  { title: "Aged objects", text: "Transferred or simulated aging on a mesh, with time.", kinds: ["transfer", "simulation"] },
  { title: "Material histories", text: "How a surface changed: captured, simulated, or made.", kinds: ["history"] },
  { title: "Captures", text: "From photographs and scans to a history, step by step.", kinds: ["ingest", "registration", "unlit", "calibration"] },
  { title: "Meshes and reports", text: "", kinds: ["mesh", "report"] },
];

export function place_link(place: string): string {
  return `#/${encodeURIComponent(place)}`;
}

/// What is made of photographs by `ingest` is a capture.
export const kind_text = (kind: string): string => (kind === "ingest" ? "capture" : kind);

/// A mesh has come: it is shown, and asked how it is to age.
function age(place: string): void {
  location.hash = `${place_link(place)}?age`;
}

/// What was dropped: a mesh, or photographs.
async function begin_with(data: DataTransfer): Promise<void> {
  const files = await dropped_files(data);
  if (!files.some(({ file }) => is_mesh_file(file.name)) && files.some(({ file }) => is_photograph(file.name))) return open_photographs(files);
  const place = await upload(files.map(({ file }) => file));
  if (place) age(place);
}

const photographs = (): HTMLElement => button("Begin with photographs", () => void open_photographs(), { icon: "ingest", hint: "Copies photographs of one surface into a new folder, and drafts a capture of them" });

/// Every second scene is called "scene": then its folder says which it is.
function title_of({ name, place }: PlaceSummary): string {
  const folders = place.split("/");
  return name === "scene" && folders.length > 1 ? folders[folders.length - 2]! : name;
}

export class PlacesView implements View {
  readonly element = h("main", { class: "places" }, h("p", { class: "empty", role: "status" }, "Looking through the folder ..."));
  private readonly stop = new AbortController();
  private readonly thumbnails = new Thumbnails();
  private readonly watch = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      this.watch.unobserve(entry.target);
      this.pending.get(entry.target)?.();
    }
  });
  private readonly pending = new Map<Element, () => void>();

  constructor() {
    window.patinate = { view: "places" };
    drop_files(this.element, (data) => void begin_with(data).catch(show_error));
    window.addEventListener(kJobEnded, () => this.list(), { signal: this.stop.signal });
    this.list();
  }

  private list(): void {
    get_places(this.stop.signal).then((places) => this.show(places), (error: unknown) => {
      if (!this.stop.signal.aborted) replace(this.element, failure("The folder cannot be listed", error instanceof Error ? error.message : String(error)));
    });
  }

  dispose(): void {
    this.stop.abort();
    this.thumbnails.dispose();
    this.watch.disconnect();
  }

  private show({ folder, places, version }: Places): void {
    if (places.length === 0) {
      replace(this.element, this.nothing(folder));
      return;
    }
    const shown = kGroups.map((g) => ({ ...g, places: places.filter((p) => g.kinds.includes(p.kind)) })).filter((g) => g.places.length > 0);
    replace(this.element, h("div", { class: "places-head" }, h("h1", {}, "What is here"), h("p", { class: "folder" }, folder), h("div", { class: "spacer" }), h("div", { class: "begin" }, photographs(), choose_mesh("Begin with a mesh", age, "primary"))),
      shown.map((g) => h("section", { "aria-label": g.title }, h("h2", {}, g.title, h("small", {}, g.text)), h("div", { class: "cards" }, g.places.map((p) => this.card(p))))),
      h("p", { class: "version" }, `patinate ${version}`));
  }

  private card(place: PlaceSummary & { problem?: string }): HTMLElement {
    const picture = h("div", { class: "picture" }, icon(place.kind, 44));
    const card = h("a", { class: `card ${place.kind}`, href: place_link(place.place) }, picture,
      h("div", { class: "card-text" }, h("b", {}, title_of(place)), h("span", { class: "kind" }, kind_text(place.kind)), h("span", { class: "detail" }, place.problem || place.detail), h("span", { class: "path" }, place.place)));
    this.pending.set(card, () => void this.thumbnail(place, picture));
    this.watch.observe(card);
    return card;
  }

  // The last frame: aged, where there is something to see. What has no picture keeps its icon.
  private async thumbnail(place: PlaceSummary, picture: HTMLElement): Promise<void> {
    const url = await this.thumbnails.of(place);
    if (!url || this.stop.signal.aborted) return;
    const image = h("img", { alt: "", decoding: "async", class: url.startsWith("data:") ? "object" : "" });
    image.onload = () => replace(picture, image);
    image.src = url;
  }

  private nothing(folder: string): HTMLElement {
    const command = (text: string, why: string) => h("li", {}, h("code", {}, text), h("span", {}, why));
    return h("div", { class: "nothing" }, h("h1", {}, "Begin with a mesh"),
      h("div", { class: "drop" }, icon("mesh", 44), h("p", {}, "Drop a mesh here, or choose one: OBJ, PLY, STL or GLB."), choose_mesh("Choose a mesh", age, "primary"),
        h("p", { class: "hint" }, "It is copied into ", h("code", {}, folder), ". Then say what ages it: rain and dirt, rust, moss or patina.")),
      h("div", { class: "actions" }, photographs(), h("span", { class: "hint" }, "Photographs of one surface at several times become a material history. They can be dropped here, too.")),
      h("details", {}, h("summary", {}, "Or make something in the terminal"), h("ul", {},
        command("patinate synth ledge -o ledge", "a wall with sills: a scene to simulate right here"),
        command("patinate synth mold -o mold", "scans and photographs of a copper mold that patinates"),
        command("patinate synth crackle -o crackle", "photographs of paint that cracks while it dries"),
        command("patinate ingest crackle/capture.json -o history", "makes a material history of them"),
        command("patinate synth sculpture -o urn", "a mesh to age with it: patinate transfer")),
        h("p", { class: "hint" }, "Then load this page again. Or start patinate studio with another folder.")));
  }
}
