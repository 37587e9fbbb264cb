// What the server sends: docs/studio_protocol.md.

export type Vec3 = [number, number, number];

export interface PlaceSummary {
  place: string;
  kind: string;
  name: string;
  detail: string;
  modified: string | number;
}

export interface Places {
  folder: string;
  version: string;
  places: PlaceSummary[];
}

export interface ControlInfo {
  name: string;
  low: number;
  high: number;
  unit: string;
}

export interface PlaceBase {
  place: string;
  kind: string;
  name: string;
  facts?: [string, string][];
}

/// A history, a transfer or a finished simulation: something with color over time.
export interface HistoryPlace extends PlaceBase {
  width: number;
  height: number;
  unit: string;
  times: number[];
  texel_size_mm?: number;
  origin?: string;
  controls?: ControlInfo[];
  maps?: string[];
  frame_masks?: boolean;
  /// Maps that its frames have beside color.
  frame_maps?: string[];
  /// Materials whose amounts its frames have.
  amounts?: string[];
  /// The map that it is about, where its color says nothing.
  shows?: string;
  /// What it knows of its material beyond color.
  material?: ("base" | "orm" | "reflectance")[];
  mesh?: boolean;
  tiles?: string[];
  source?: string | null;
  can_recompose?: boolean;
}

export interface StepPicture {
  /// Where it lies, if in another place.
  place?: string;
  path: string;
  caption: string;
}

/// A photograph and the frame that was made of it; `roi`: the part of the photograph that the frame shows, if it is known.
export interface BesideInfo {
  photo: { name: string; place: string; path: string; image?: number; width: number; height: number };
  frame: { name: string; path: string; width: number; height: number };
  roi: [number, number, number, number] | null;
}

export interface StepsPlace extends PlaceBase {
  steps: { name: string; text: string; pictures: StepPicture[]; beside?: BesideInfo }[];
  mesh?: boolean;
  /// Of a capture: points can be marked in its photographs.
  has_marks?: boolean;
  /// The file with what `init` has found.
  hints?: string;
  /// Of a registration.
  scans?: ScanInfo[];
}

/// One scan of a registration.
export interface ScanInfo {
  name: string;
  status: string;
  residual: number;
  overlap: number;
  partner: string | null;
  is_reference: boolean;
  is_shown: boolean;
  text: string;
}

export interface Curve {
  times: number[];
  srgb: Vec3[];
  lab: Vec3[];
  /// Other numbers that are known of the texel at the same times; null where a frame does not know them.
  values?: { name: string; unit: string; values: (number | null)[] }[];
  /// The same of what is constant in time.
  constants?: { name: string; unit: string; value: number }[];
  source?: { place: string | null; x: number; y: number };
}

/// An emitter as scene files have it, lengths in mm.
export interface Emitter {
  name: string;
  shape: "point" | "disk" | "rectangle" | "sphere" | "sky" | "surface";
  position?: Vec3;
  direction?: Vec3;
  size?: number | [number, number];
  spread_deg?: number;
  speed?: number;
  distance?: number;
  gammatons?: number;
  carries?: Record<string, number>;
  on?: boolean;
}

export interface SceneObject {
  name: string;
  translate?: Vec3;
  rotate?: Vec3;
  scale?: number;
}

export interface Appearance {
  strength?: number;
  variation?: number;
  specular?: number;
  specular_variation?: number;
  height?: number;
  height_variation?: number;
  color?: Vec3;
}

export interface Behavior {
  bounce: number;
  float: number;
  absorb: number;
  deceleration_bounce: number;
  deceleration_float: number;
}

export interface Rule {
  name: string;
  driver: string;
  rate: number;
  products: Record<string, number>;
  reactants: Record<string, number>;
}

/// A rule that the scene does not have and could.
export interface MoreRule {
  name: string;
  about: string;
}

export interface Overlay {
  name: string;
  /// Byte b stands for high (b / 255)^2.
  high?: number;
  unit?: string;
  /// What colors should stand for: 2 % of the texels where there is something lie above.
  range?: [number, number];
  most?: number;
}

/// hello, and what `scene` messages replace.
export interface SceneState {
  name: string;
  width: number;
  height: number;
  materials: string[];
  appearance: Record<string, Appearance>;
  emitters: Emitter[];
  objects: SceneObject[];
  behavior: Behavior;
  slider?: number | null;
  exchange: { ratio: number; rates: Record<string, number> };
  rules: Rule[];
  more_rules: MoreRule[];
  time_unit: string;
  time_per_iteration: number;
  overlays: (string | Overlay)[];
  /// Whether anything is of metal; the materials that are seen as a film, and of which plants grow.
  look: { metal: boolean; film: string | null; plants: string | null };
  relief_mm: [number, number];
  bounds_mm: [Vec3, Vec3];
  notes?: string[];
  /// Both in the order in which they were done.
  steps?: { done: Step[]; undone: Step[] };
  /// It is not as its file says any more.
  edited?: boolean;
  /// Its parts may be changed: it is no finished simulation.
  can_edit?: boolean;
  /// What can be resumed; null where nothing can, or it is being gone through.
  recording?: Recording | null;
}

/// One entry of the list that undo goes back in.
export interface Step {
  label: string;
  iteration: number;
}

/// Files of an export, below the folder of `place`.
export interface Exported {
  place: string;
  files: { path: string; bytes: number }[];
}

/// All that is known of one texel of a running scene.
export interface Probe {
  x: number;
  y: number;
  iteration: number;
  time: number;
  /// It lies inside the charts.
  is_surface: boolean;
  amounts?: Record<string, number>;
  srgb?: Vec3;
  specular?: number;
  height_mm?: number;
}

/// What an earlier run of the program has left of a scene.
export interface Recording {
  iterations: number;
  events: number;
  /// "2026-11-21T15:04:05Z".
  saved: string;
}

/** Of one material, as simulation.json has it. */
export interface LedgerRow {
  emitted: number;
  made: number;
  on_surfaces: number;
  carried: number;
  absorbed: number;
  rested: number;
  left: number;
  used: number;
  residual: number;
}

export interface Status {
  running: boolean;
  iteration: number;
  time: number;
  iterations_per_s: number;
  counters: Record<string, number>;
  ledger: Record<string, LedgerRow>;
  clients: number;
  /// A stroke continues: everything else stands still.
  painting?: boolean;
  can_undo?: boolean;
  can_redo?: boolean;
  /// The iteration to which it runs again after a stroke was undone.
  catching_up?: number | null;
  exporting?: boolean;
  memory_mb: number;
}

/** Of one material on one object, as simulation.json has it; shares of its area. */
export interface MaterialOutcome {
  mean: number;
  largest: number;
  shows_share: number;
  hides_share: number;
  full_share: number;
}

export interface ObjectOutcome {
  change_mean: number;
  change_p95: number;
  never_met_share?: number;
  materials: Record<string, MaterialOutcome>;
}

export interface Outcome {
  iteration: number;
  objects: Record<string, ObjectOutcome>;
  advice: string[];
}

export interface TilesHeader {
  type: "tiles";
  update: number;
  iteration: number;
  plane: "surface" | "relief" | "material" | "overlay";
  tile: number;
  count: number;
  width: number;
  height: number;
  last: boolean;
}

/// An argument of a command, as the command describes it.
export interface JobArgument {
  key: string;
  name: string;
  kind: "positional" | "positionals" | "option" | "repeated" | "flag";
  type: "text" | "path" | "number" | "integer" | "numbers";
  form: string;
  help: string;
  default: string;
  value: string;
  choices: string[];
  is_closed: boolean;
  is_required: boolean;
  is_usual: boolean;
}

export interface JobCommand {
  name: string;
  title: string;
  brief: string;
  inputs: { kinds: string[]; title: string; may_be_library: boolean }[];
  arguments: JobArgument[];
}

export interface JobCommands {
  folder: string;
  commands: JobCommand[];
  library: { name: string; controls: string[] }[];
  photographs: string[];
}

export type JobValues = Record<string, string | string[] | boolean>;

export interface JobInfo {
  id: number;
  command: string;
  line: string;
  output: string;
  arguments: JobValues;
  state: "waiting" | "running" | "done" | "failed" | "canceled";
  stage: string;
  share: number | null;
  left: string;
  messages: string[];
  seconds: number;
  exit_code: number | null;
  place: string | null;
  is_file: boolean;
}

export interface StoredResponse {
  type: string;
  headers?: Record<string, string>;
  base64: string;
}

/// A static session: the server's answers in the page itself.
export interface StaticSession {
  place: string;
  view?: Record<string, unknown>;
  responses: Record<string, StoredResponse>;
}

declare global {
  interface Window {
    PATINATE_SESSION?: StaticSession;
    /// For tests: what is on screen.
    patinate?: Record<string, unknown>;
  }
}
