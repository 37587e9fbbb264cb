// A running scene: seen, steered and painted. The simulation runs in the server; here are its picture and its handles.
import { kConnection, Live } from "../live";
import { SurfaceLook } from "../scene/material";
import { Hover } from "../scene/hover";
import { Pin } from "../scene/pin";
import { Viewer, type Hit } from "../scene/viewer";
import { Brush } from "../simulation/brush";
import { BrushPanel } from "../simulation/brush_panel";
import type { SceneContext } from "../simulation/context";
import { Builder } from "../build/builder";
import { job_buttons } from "../jobs/job_buttons";
import { EmittersPanel } from "../simulation/emitters_panel";
import { Exports, open_export, open_save } from "../simulation/files";
import { FlowPanel } from "../simulation/flow_panel";
import { GammatonPoints } from "../simulation/gammaton_points";
import { Handles, type HandleMode } from "../simulation/handles";
import { AppearancePanel } from "../simulation/appearance_panel";
import { OutcomePanel } from "../simulation/outcome_panel";
import { Pace } from "../simulation/pace";
import { LivePicture } from "../simulation/live_picture";
import { PlacePanel } from "../simulation/place_panel";
import { words_at } from "../simulation/planes";
import { ResumeOffer } from "../simulation/resume_offer";
import { RulesPanel } from "../simulation/rules_panel";
import { RunBar } from "../simulation/run_bar";
import { ShowPanel } from "../simulation/show_panel";
import { StatusPanel } from "../simulation/status_panel";
import { next_steps, StepsPanel } from "../simulation/steps_panel";
import type { PlaceBase, SceneState, Status } from "../types";
import { button, icon_button, number_text, section } from "../ui/controls";
import { h } from "../ui/dom";
import { ask } from "../ui/dialog";
import { gesture } from "../ui/gesture";
import { failure, notice, progress, settle, show_error, type Progress } from "../ui/notices";
import { PicturePanel } from "./picture_panel";
import type { View } from "./view";
import { facts_table, light_controls, toggle_full_screen, view_tools, workspace } from "./workspace";

export class SimulationView implements View, SceneContext {
  readonly element: HTMLElement;
  readonly viewer: Viewer;
  scene!: SceneState;
  is_running = false;
  private readonly frame = workspace("Scene");
  private readonly look = new SurfaceLook();
  private readonly live: Live;
  private readonly handles: Handles;
  private readonly brush: Brush;
  private readonly gammatons: GammatonPoints;
  private readonly builder: Builder;
  private readonly emitters: EmittersPanel;
  private readonly brush_panel: BrushPanel;
  private readonly flow: FlowPanel;
  private readonly rules: RulesPanel;
  private readonly appearance: AppearancePanel;
  private readonly shown: ShowPanel;
  private readonly status_panel = new StatusPanel();
  private readonly outcome_panel = new OutcomePanel(() => void this.send("outcome"));
  private readonly run_bar: RunBar;
  private readonly paint_button: HTMLButtonElement;
  private readonly undo_button = icon_button("undo", "Undo", () => void this.send("undo"), "Ctrl Z");
  private readonly redo_button = icon_button("redo", "Redo", () => void this.send("redo"), "Ctrl Shift Z");
  private is_lost = false;
  private work: Progress | undefined;
  private readonly picture: LivePicture;
  private readonly steps = new StepsPanel((op, steps) => void this.send(op, { steps }));
  private readonly exports = new Exports();
  private readonly place_panel = new PlacePanel((x, y) => void this.send("probe", { x, y }), () => this.scene);
  private readonly pin: Pin;
  private readonly hover: Hover;
  private status: Status | undefined;
  private num_steering = 0;
  private num_edits = 0;
  private is_disposed = false;
  private readonly pace = new Pace({ run: () => void this.send("run"), pause: () => void this.send("pause"), step: (iterations) => void this.send("step", { iterations }) });
  private readonly resume_offer = new ResumeOffer(() => this.resume(), () => this.is_disposed);

  /// @param begins  It runs as soon as it is there.
  constructor(private readonly place: PlaceBase, private begins = false) {
    this.element = this.frame.element;
    this.viewer = new Viewer(this.frame.stage, false);
    this.viewer.canvas.setAttribute("aria-label", `${place.name}: the scene; drag to turn`);
    this.viewer.margin = 1.25;  // Emitters stand around the scene.
    this.gammatons = new GammatonPoints(this.viewer.scene);
    this.handles = new Handles(this);
    this.brush = new Brush(this, this.frame.stage);
    this.builder = new Builder(this, { ask: (op, fields) => this.ask(op, fields) }, place.place);
    this.builder.on_hide = (name, is_hidden) => this.picture.set_visible(name, !is_hidden);
    this.emitters = new EmittersPanel(this, this.handles, this.builder);
    this.brush_panel = new BrushPanel(this.brush, () => this.scene);
    this.flow = new FlowPanel(this);
    this.rules = new RulesPanel(this, this.builder);
    this.appearance = new AppearancePanel(this, this.builder);
    this.shown = new ShowPanel(this.look, () => this.viewer.invalidate(), () => this.watch());
    this.run_bar = new RunBar({ run: () => this.toggle_run(), step: () => void this.send("step", { iterations: 1 }), reset: () => this.reset(), pace: (n) => this.set_pace(n) });
    this.paint_button = button("Paint", () => this.set_painting(!this.brush.is_active), { icon: "brush", hint: "Paint with an emitter on the surface", key: "P" });
    this.paint_button.setAttribute("aria-pressed", "false");
    this.undo_button.disabled = this.redo_button.disabled = true;
    this.picture = new LivePicture({ place: place.place, viewer: this.viewer, look: this.look, handles: this.handles, shown: this.shown, hidden: this.builder.hidden, on_loaded: () => {
      this.work?.end();
      this.work = undefined;
    } });
    this.shown.plane = () => this.picture.planes?.overlay;
    this.pin = new Pin(this.viewer, this.frame.stage);
    this.place_panel.on_clear = () => this.pin.set(undefined);
    this.hover = new Hover(this.viewer, this.frame.stage, (hit) => (this.brush.is_active || this.handles.is_dragging ? [] : words_at(hit.uv, this.picture.planes, this.shown.shown_overlay(), this.scene)));
    this.build();
    this.viewer.before_frame = () => this.picture.planes?.before_frame();
    this.viewer.after_frame = () => {
      this.picture.planes?.after_frame((update) => this.live.acknowledge(update));
      this.pin.place();
    };
    this.viewer.on_click = (hit, event) => this.click(hit, event);
    this.work = progress(this.frame.stage, "Opening the scene ...", () => location.hash = "#/");
    this.live = new Live(place.place, {
      hello: (scene) => this.hello(scene),
      scene: (change) => this.changed(change),
      status: (status) => this.show_status(status),
      tiles: (header, message, offset) => {
        this.picture.apply(header, message, offset);
        if (header.last) {
          this.pace.picture();
          this.hover.refresh();
        }
      },
      gammatons: (positions) => { this.gammatons.show(this.shown.shown.gammatons > 0 ? positions : new Float32Array()); this.viewer.invalidate(); },
      hash: (hash) => this.picture.expect(hash),
      outcome: (outcome) => this.outcome_panel.show(outcome),
      probe: (probe) => this.place_panel.show(probe),
      exported: (exported) => this.exports.show(exported),
      progress: (text, done, total) => this.show_progress(text, done, total),
      notice: (text) => notice(text),
      problem: (message) => notice(message, "error"),
      connection: (state, why) => this.show_connection(state, why),
      refused: (why) => this.refused(why),
    });
    this.tell_tests();
  }

  async send(op: string, fields: Record<string, unknown> = {}): Promise<void> {
    const is_steering = ["run", "pause", "reset"].includes(op);
    if (is_steering) {  // What counts is what the user wants; a status that was sent before says otherwise.
      this.is_running = op === "run";
      ++this.num_steering;
    }
    try {
      await this.live.send(op, fields);
      settle(`op ${op}`);
    } catch (error) {
      if (!this.is_disposed) show_error(error, `op ${op}`);
    } finally {
      if (is_steering) --this.num_steering;
    }
  }

  /// An edit builds the scene anew: nothing can be done meanwhile.
  private async ask(op: string, fields: Record<string, unknown>): Promise<Record<string, unknown>> {
    this.num_edits += op === "edit" ? 1 : 0;
    try {
      return await this.live.send(op, fields);
    } finally {
      this.num_edits -= op === "edit" ? 1 : 0;
    }
  }

  event(event: Record<string, unknown>, label?: string): void {
    void this.send("event", { event, gesture: gesture(), ...(label ? { label } : {}) });
  }

  on_key(key: string): boolean {
    if (this.frame.bar.inert) return false;
    const modes: Record<string, HandleMode> = { g: "translate", r: "rotate", s: "scale" };
    const mode = modes[key];
    if (mode) {
      this.emitters.mode.set(mode);
      this.handles.set_mode(mode);
      return true;
    }
    switch (key) {
      case "ctrl+z": void this.send("undo"); return true;
      case "ctrl+shift+z":
      case "ctrl+y": void this.send("redo"); return true;
      case " ": this.toggle_run(); return true;
      case "ArrowRight": void this.send("step", { iterations: 1 }); return true;
      case "f": this.viewer.fit(); return true;
      case "shift+f": toggle_full_screen(this.element); return true;
      case "p": this.set_painting(!this.brush.is_active); return true;
      case "Escape":
        this.set_painting(false);
        this.emitters.choose(undefined);
        return true;
    }
    return false;
  }

  dispose(): void {
    this.is_disposed = true;
    this.live.close();
    this.brush.dispose();
    this.handles.dispose();
    this.gammatons.dispose();
    this.hover.dispose();
    this.picture.dispose();
    this.viewer.dispose();
  }

  private build(): void {
    const { tools, panel, bar, stage } = this.frame;
    view_tools(this.viewer, tools, this.element);
    tools.append(h("span", { class: "divider" }), this.paint_button, this.undo_button, this.redo_button);
    stage.append(h("div", { class: "legend-area" }, this.shown.legend_box));
    bar.append(this.run_bar.element);
    const sender = { ask: (op: string, fields: Record<string, unknown>) => this.ask(op, fields) };
    panel.append(h("header", { class: "panel-head" }, h("h1", {}, this.place.name), h("p", { class: "kind" }, this.place.kind), this.place.kind === "scene" && job_buttons(this.place)),
      this.steps.element, this.emitters.element, this.brush_panel.element, ...this.flow.elements, this.rules.element, this.appearance.element, this.shown.element, this.place_panel.element, this.outcome_panel.element, section("Light", false, light_controls(this.viewer)), new PicturePanel(this.viewer, this.place).element, this.status_panel.element, this.builder.element,
      section("About", false, facts_table(this.place.facts ?? [])),
      h("div", { class: "panel-foot" }, button("Save the scene", () => open_save(sender, this), { icon: "save", hint: "As a scene file that patinate simulate reproduces" }),
        button("Export", () => open_export(sender, this), { icon: "download", hint: "Textures, GLB, parameter maps, history" })));
  }

  private hello(scene: SceneState): void {
    this.scene = scene;
    this.outcome_panel.forget();
    this.picture.begin(scene);
    this.flow.build(scene);
    this.rules.build(scene);
    this.appearance.build(scene);
    this.shown.build(scene);
    this.shown.show(scene);
    this.handles.show(scene);
    this.emitters.build(scene);
    this.brush_panel.show(scene);
    this.watch();
    void this.builder.show();
    if (this.begins) {
      this.begins = false;
      window.history.replaceState(null, "", `#/${encodeURIComponent(this.place.place)}`);
      this.pace.start();
    }
    for (const text of scene.notes ?? []) notice(text);
    this.resume_offer.show(scene.recording);
    this.show_steps();
  }

  private changed(change: Partial<SceneState>): void {
    Object.assign(this.scene, change);
    this.picture.changed(change);
    if (change.steps) this.show_steps();
    if (change.steps || change.edited !== undefined) void this.builder.show();
    if (change.behavior || change.exchange || change.slider !== undefined) this.flow.show(this.scene);
    if (change.rules || change.more_rules) this.rules.show(this.scene);
    if (change.overlays) this.shown.show(this.scene);
    if (change.appearance) {
      this.appearance.show(this.scene);
      this.outcome_panel.forget();
    }
    if (change.emitters || change.objects) {
      this.handles.show(this.scene);
      this.emitters.show(this.scene);
      this.brush_panel.show(this.scene);
    }
    if (change.recording !== undefined) this.resume_offer.show(change.recording);
  }

  private show_steps(): void {
    this.steps.show(this.scene);
    const { undo, redo } = next_steps(this.scene);
    this.undo_button.title = undo ? `Undo: ${undo} (Ctrl Z)` : "Undo (Ctrl Z)";
    this.redo_button.title = redo ? `Redo: ${redo} (Ctrl Shift Z)` : "Redo (Ctrl Shift Z)";
  }

  // An emitter under the pointer, else the place of the surface.
  private click(hit: Hit | undefined, event: PointerEvent): void {
    if (this.brush.is_active || this.handles.click(event.clientX, event.clientY) || !hit) return;
    this.place_panel.choose(hit.point, hit.uv);
    this.pin.set(hit.point);
  }

  private toggle_run(): void {
    if (this.is_running) this.pace.stop();
    else this.pace.start();
  }

  private set_pace(iterations: number): void {
    const was_running = this.is_running;
    if (was_running) this.pace.stop();
    this.pace.iterations = iterations;
    if (was_running) this.pace.start();
  }

  private async resume(): Promise<void> {
    if (this.is_running) this.pace.stop();
    await this.live.send("resume");
  }

  private reset(): void {
    const { iteration = 0, time = 0 } = this.status ?? {};
    const far = iteration > 0 ? `The scene is at iteration ${iteration}, after ${number_text(time)} ${this.scene.time_unit}. ` : "";
    ask("Back to the start?", `${far}Everything that was painted, moved and set since the start goes; appearance parameters stay. Undo (Ctrl Z) brings it back.`, "Back to the start", () => {
      if (this.is_running) this.pace.stop();
      void this.send("reset");
    });
  }

  private set_painting(is_on: boolean): void {
    this.brush.set_active(is_on);
    this.paint_button.setAttribute("aria-pressed", String(is_on));
    if (is_on) this.emitters.choose(undefined);
  }

  private watch(): void {
    const { shown } = this.shown;
    if (shown.gammatons === 0) this.gammatons.show(new Float32Array());
    this.live.set_watch({ overlay: this.shown.wanted(), gammatons: shown.gammatons });
    this.picture.update_plantlets();
    this.picture.update_displacement();
    this.viewer.invalidate();
  }

  private show_status(status: Status): void {
    this.status = status;
    this.place_panel.follow();
    if (this.num_steering === 0) this.is_running = status.running || this.pace.is_pacing;
    this.viewer.set_moving(this.is_running);
    this.run_bar.show(status, this.is_running, this.scene?.time_unit ?? "", this.picture.planes?.num_updates ?? 0);
    this.status_panel.show(status);
    this.outcome_panel.show_status(status);
    this.undo_button.disabled = status.can_undo !== true;
    this.redo_button.disabled = status.can_redo !== true;
  }

  private show_progress(text: string, done: number, total: number): void {
    if (total > 0 && done >= total) {
      if (this.picture.model) {
        this.work?.end();
        this.work = undefined;
      }
      return;
    }
    const cancel = (): void => {
      this.work = undefined;
      if (this.picture.model) void this.send("cancel");
      else location.hash = "#/";
    };
    this.work ??= progress(this.frame.stage, text, this.num_edits > 0 ? undefined : cancel);
    this.work.set(text, total > 0 ? done / total : undefined);
  }

  private show_connection(state: "connecting" | "open" | "lost", why?: string): void {
    if (state === "open") {
      this.is_lost = false;
      settle(kConnection);
    }
    if (state !== "lost") return;
    if (!this.is_lost) notice(`The connection is lost; trying again. ${why ?? ""}`, "error", kConnection);  // Once: who has closed it knows.
    this.is_lost = true;
    this.stand("no connection");
  }

  /// The server says why there is no scene, or none any more.
  private refused(why: string): void {
    this.work?.end();
    this.work = undefined;
    settle(kConnection);
    if (this.picture.model) notice(`The scene has stopped: ${why}`, "error", kConnection);
    else this.frame.stage.append(failure("This scene cannot be opened", why));
    for (const part of [this.frame.tools, this.frame.panel, this.frame.bar]) part.inert = this.picture.model === undefined;
    this.stand(this.picture.model ? "stopped" : "cannot be opened");
  }

  private stand(state: string): void {
    this.run_bar.show_state(state);
    if (this.pace.is_pacing) this.pace.stop();
    this.is_running = false;
    this.viewer.set_moving(false);
  }

  private tell_tests(): void {
    window.patinate = {
      view: "simulation", viewer: this.viewer, live: this.live, brush: this.brush, handles: this.handles,
      scene: () => this.scene, status: () => this.status, planes: () => this.picture.planes, plantlets: () => this.picture.num_plantlets,
      is_ready: () => this.picture.is_ready,
      set_pace: (iterations: number) => this.set_pace(iterations), toggle_run: () => this.toggle_run(),
      check_hash: () => this.picture.check_hash(() => void this.send("hash")),
      send: (op: string, fields: Record<string, unknown>) => this.live.send(op, fields),
      send_shown: (op: string, fields: Record<string, unknown>) => this.send(op, fields),
    };
  }
}
