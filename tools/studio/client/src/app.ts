// The application: header, addresses (#/PLACE), keys, and one view at a time.
import { get_place, is_static, kServer, on_answer, on_busy } from "./api";
import type { HistoryPlace, PlaceBase, StepsPlace } from "./types";
import { jobs_panel } from "./jobs/jobs_panel";
import { button, icon_button } from "./ui/controls";
import { open_help } from "./ui/dialog";
import { h, replace } from "./ui/dom";
import { icon } from "./ui/icons";
import { key_of } from "./ui/keys";
import { clear_notices, failure, notice_area, settle } from "./ui/notices";
import { current_theme, on_theme, start_theme, toggle_theme } from "./ui/theme";
import { BesideView } from "./views/beside_view";
import { CaptureView } from "./views/capture_view";
import { CompareView } from "./views/compare_view";
import { HistoryView } from "./views/history_view";
import { LandmarksView } from "./views/landmarks_view";
import { MeshView } from "./views/mesh_view";
import { PlacesView } from "./views/places_view";
import { PrepareView } from "./views/prepare_view";
import { ReportView } from "./views/report_view";
import { SimulationView } from "./views/simulation_view";
import type { View } from "./views/view";

const kHistoryKinds = ["history", "transfer", "simulation"];
const kWith = "with:";  // The mode of an address that names a second result.

export class App {
  private view: View | undefined;
  private num_opened = 0;
  private readonly body = h("div", { class: "body-of-app" });
  private readonly crumbs = h("nav", { "aria-label": "Where you are" });
  private readonly busy = h("div", { class: "busy", "aria-hidden": "true" });

  constructor(root: HTMLElement) {
    start_theme();
    const theme = icon_button("sun", "Dark or light", toggle_theme, "T");
    const show_theme = (): void => theme.replaceChildren(icon(current_theme() === "dark" ? "sun" : "moon"));
    on_theme(show_theme);
    show_theme();
    const home = h("a", { class: "brand", href: "#/", "aria-label": "patinate studio: all places" }, h("i", { class: "logo", "aria-hidden": "true" }), h("b", {}, "patinate"), h("span", {}, "studio"));
    // What is worked with comes first for Tab and for screen readers; the header stands above it.
    replace(root, this.body, h("header", { class: "top" }, home, this.crumbs, h("div", { class: "spacer" }), jobs_panel.opener, theme, icon_button("help", "Help and keys", open_help, "?")), jobs_panel.element, this.busy, notice_area);
    if (!is_static()) void jobs_panel.look();
    on_answer((path) => { settle(kServer); settle(path); });
    on_busy((num) => this.busy.classList.toggle("on", num > 0));
    window.addEventListener("hashchange", () => void this.open());
    window.addEventListener("keydown", (event) => this.key(event));
    // After a click with the mouse, Space plays again, and does not press the same button once more.
    window.addEventListener("click", (event) => { if (event.detail > 0 && document.activeElement?.matches("button, summary, input[type=checkbox]")) (document.activeElement as HTMLElement).blur(); });
    void this.open();
  }

  private async open(): Promise<void> {
    const number = ++this.num_opened;
    const [place = "", mode = ""] = location.hash.replace(/^#\/?/, "").split("?").map(decodeURIComponent);
    this.view?.dispose();
    this.view = undefined;
    clear_notices();
    jobs_panel.show(false);  // It would cover what is opened.
    replace(this.crumbs);
    const shown = is_static() ? window.PATINATE_SESSION?.place ?? "" : place;
    if (shown === "") {
      document.title = "patinate studio";
      this.show(new PlacesView());
      return;
    }
    replace(this.body, h("p", { class: "empty", role: "status" }, "Opening ..."));
    try {
      const info = await get_place<PlaceBase>(shown);
      if (number !== this.num_opened) return;
      document.title = `${info.name} - patinate studio`;
      this.show_crumbs(info, mode);
      this.show(this.make(info, mode));
    } catch (error) {
      if (number !== this.num_opened) return;
      replace(this.body, failure("This cannot be opened", error instanceof Error ? error.message : String(error)));
    }
  }

  private make(info: PlaceBase, mode: string): View {
    const is_live = mode === "live";
    if (mode === "landmarks") return new LandmarksView(info);
    if (mode === "prepare") return new PrepareView(info);
    if (mode === "beside" && (info as Partial<StepsPlace>).steps?.some(({ beside }) => beside)) return new BesideView(info as StepsPlace);
    if (mode === "page") return new ReportView(info);
    if (mode === "steps") return new CaptureView(info as StepsPlace);
    if (info.kind === "report") return new ReportView(info);
    if (info.kind === "scene" || (info.kind === "simulation" && is_live)) return new SimulationView(info, mode === "run");
    if (kHistoryKinds.includes(info.kind) && mode.startsWith(kWith)) return new CompareView(info as HistoryPlace, mode.slice(kWith.length));
    if (kHistoryKinds.includes(info.kind)) return new HistoryView(info as HistoryPlace);
    if (info.kind === "mesh") return new MeshView(info, mode === "age");
    return new CaptureView(info as StepsPlace);
  }

  private show(view: View): void {
    this.view = view;
    replace(this.body, view.element);
  }

  // Where this is, and what else can be seen of the same place.
  private show_crumbs(info: PlaceBase, mode: string): void {
    const { steps, live_problem, page } = info as Partial<StepsPlace> & { live_problem?: string; page?: string };
    const other = (text: string, wanted: string, picture: string, hint: string): HTMLElement =>
      button(text, () => { location.hash = `#/${encodeURIComponent(info.place)}${wanted ? `?${wanted}` : ""}`; }, { kind: "quiet", icon: picture, hint });
    const has_marks = (info as Partial<StepsPlace>).has_marks === true && !is_static();
    const has_time = kHistoryKinds.includes(info.kind) && !is_static();
    replace(this.crumbs, h("span", { class: "slash", "aria-hidden": "true" }, "/"), icon(info.kind, 16), h("span", { "aria-current": "page" }, info.name),
      has_marks && mode === "" && other("Crop, mask, scale", "prepare", "scale", "Crop, mask, size of a pixel and color chart, set in a photograph"),
      has_marks && mode === "" && other("Mark points", "landmarks", "fit", "Click the same places in photographs that cannot be laid over one another otherwise"),
      has_marks && mode !== "" && other("Its photographs", "", "ingest", "What the project names, step by step"),
      has_time && mode !== "" && other("Its history", "", "history", "Color over time"),
      has_time && mode === "" && steps && steps.length > 0 && other("How it was made", "steps", "ingest", "Photographs, masks and residuals, step by step"),
      has_time && mode !== "beside" && steps?.some(({ beside }) => beside) && other("Before and after", "beside", "ingest", "Each frame beside the photograph that it was made of, with one zoom"),
      has_time && mode === "" && page !== undefined && other("Its report", "page", "report", "What was found in every photograph, and what was done about it"),
      has_time && mode === "" && info.kind === "simulation" && !live_problem && other("Change it, or resume", "live", "simulation", "Opens it where it ended: other appearance parameters at once; it can resume, or start again"));
  }

  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (document.querySelector("dialog[open]") !== null) return;
    const is_typing = target.matches("input[type=text], textarea, select");
    // In a number field that nothing has been typed into, undo is that of the scene.
    const is_untouched = target instanceof HTMLInputElement && target.matches(".number-field") && target.value === target.defaultValue;
    if (is_typing && !(is_untouched && (event.ctrlKey || event.metaKey))) return;
    const is_slider = target.matches("input[type=range]") && event.key.startsWith("Arrow");
    const is_pressed = event.key === " " && target.matches("button, summary, a, input");
    if (is_slider || is_pressed || (event.key.startsWith("Arrow") && target.matches("[role=radio], [role=slider]"))) return;
    const key = key_of(event);
    if (key === "?") open_help();
    else if (key === "Escape" && jobs_panel.is_open) jobs_panel.show(false);
    else if (key === "t") toggle_theme();
    else if (!this.view?.on_key?.(key)) return;
    event.preventDefault();
  }
}
