#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/controls/control_store.h"
#include "app/controls/scene_controls.h"
#include "app/request/history_library.h"
#include "app/request/output_file.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/controls/distance_io.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/history_warnings.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/commands/destination.h"
#include "tools/patinate/commands/device_words.h"
#include "tools/patinate/commands/kind_options.h"
#include "tools/patinate/commands/mesh_source.h"
#include "transfer/exemplar/appearance_cache.h"
#include "transfer/job/forecast.h"
#include "transfer/job/transfer_job.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::cli {

namespace {

/// A file that is no manifest stands where the history belongs: most often the mesh. @throws IoError
void require_history_place(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error) || app::lower_extension(path) == ".json") return;
  throw IoError(path.string(), "is no history; the order is patinate transfer HISTORY MESH");
}

/// Least and greatest value inside the charts.
std::pair<float, float> covered_range(const ImageF& values, const TexelMap& map) {
  std::pair<float, float> range{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    range.first = std::min(range.first, values.data()[t]);
    range.second = std::max(range.second, values.data()[t]);
  }
  return range;
}

/// What was found in the source, and what was done about it.
std::string error_text(const transfer::StructureFacts& s, transfer::TransferQuality quality) {
  const bool has_lines = s.kind != transfer::StructureKind::Regions;
  std::string text = !has_lines                                     ? "regions: two materials; the rarer covers "
                     : s.kind == transfer::StructureKind::DarkLines ? "lines: dark ones cover "
                                                                    : "lines: bright ones cover ";
  text += percent_text(s.share, 2) + " of the source; copied pieces are ";
  text += quality == transfer::TransferQuality::Draft ? "not cut (--quality draft)"
          : has_lines                                 ? "cut so that lines go on"
                                                      : "cut so that borders go on";
  return text + "; --structure 0 does without";
}

/// Whether they could turn as was asked.
std::string turning_text(transfer::PieceTurning asked, transfer::PieceTurning made) {
  if (made == transfer::PieceTurning::Free) return "copied pieces turn where --flow does; --turning never does without";
  if (asked != transfer::PieceTurning::Free) return "";
  return "--turning free: copied pieces follow --flow; only those of a history with lines turn, "
         "with --method fast, and not with --flow uv";
}

/// Says what the values of a library's control mean, and that it would help. Candidates are drawn by the first two
/// controls: it becomes one of them.
void note_library(const std::vector<LibraryPart>& library, std::vector<transfer::TransferControl>& controls,
                  CommandRun& run) {
  if (library.empty()) return;
  const auto found = std::find_if(controls.begin(), controls.end(),
                                  [](const transfer::TransferControl& c) { return c.source == kLibraryControl; });
  std::string list;
  for (std::size_t p = 0; p < library.size(); ++p)
    list += (p == 0 ? "" : ", ") + std::to_string(p) + " " + library[p].name;
  if (found == controls.end()) {
    run.note("a library (" + list + "): nothing says where which history applies; --control " +
             std::string(kLibraryControl) + "=MAP does");
    return;
  }
  run.note(std::string(kLibraryControl) + ": " + list);
  if (found - controls.begin() > 1) std::rotate(controls.begin() + 1, found, found + 1);
}

/// A map of few values is not matched by rank, as others are.
void note_mapping(const transfer::TransferControl& control, const ImageU8& coverage, CommandRun& run) {
  if (control.mapping != transfer::ControlMapping::Linear) return;
  const double tied = transfer::suited_mapping(control.values, coverage).tied_share;
  run.note("control `" + control.source + "`: `" + control.destination + "` has few values on " +
           percent_text(tied, 2) + " of the mesh: its least and greatest become the history's (linear); write " +
           control.destination + ":" + number_text(control.weight) + ":rank to match how often values occur");
}

std::vector<transfer::TransferControl> transfer_controls(std::span<const transfer::ControlSpec> specs,
                                                         const HistoryReader& history, const TexelMap& map,
                                                         const ControlKindOptions& kinds, const ControlSource& made_by,
                                                         CommandRun& run) {
  std::vector<std::pair<float, float>> ranges;
  std::vector<transfer::TransferControl> controls = transfer::make_transfer_controls(
      history, specs, map.coverage(), [&](std::size_t, const transfer::ControlSpec& spec) {
        ControlMap made =
            make_control_expression(spec.destination, map, kinds, run.control("control " + spec.source), made_by);
        run.notes(made.notes);
        ranges.push_back(covered_range(made.values, map));
        return made;
      });
  for (std::size_t i = 0; i < controls.size(); ++i) {
    if (!specs[i].mapping) note_mapping(controls[i], map.coverage(), run);
    if (!(ranges[i].first < ranges[i].second) && controls[i].mapping != transfer::ControlMapping::Physical) {
      run.note("control `" + controls[i].source + "`: `" + specs[i].destination +
               "` is the same all over the mesh, so that it decides nothing");
    }
  }
  note_library(history.facts().parts, controls, run);
  return controls;
}

/// A file that says what may be copied. @throws IoError
ImageU8 read_source_mask(const std::filesystem::path& file, const HistoryReader& history) {
  ImageU8 mask = read_mask(file);
  try {
    (void)transfer::usable_mask(history, mask);
  } catch (const InvalidInput& e) {
    throw IoError(file.string(), e.what());
  }
  return mask;
}

const std::string_view* find_flow(const std::string& flow) {
  return std::find(kDirectionKindNames.begin(), kDirectionKindNames.end(), flow);
}

/// A typo is said before work starts.
void check_flow(const std::string& flow) {
  if (find_flow(flow) != kDirectionKindNames.end() || std::filesystem::exists(flow)) return;
  const std::vector<std::string> kinds(kDirectionKindNames.begin(), kDirectionKindNames.end());
  throw app::UsageError("--flow: found `" + flow + "`; expected gravity, curvature, uv, or a file of curves" +
                        did_you_mean(flow, kinds));
}

/// A kind, or a file of curves. @returns nothing for UVs.
std::shared_ptr<const FlowFrames> make_flow(const std::string& flow, const TexelMap& map,
                                            const std::array<double, 3>& up, CommandRun& run) {
  const RunControl control = run.control("flow");
  const auto* const kind = find_flow(flow);
  if (kind == kDirectionKindNames.end()) {
    const std::vector<std::vector<Vec3>> curves = read_curves(flow);
    if (std::none_of(curves.begin(), curves.end(), [](const auto& c) {
          return std::any_of(c.begin(), c.end(), [&](const Vec3& p) { return p != c.front(); });
        })) {
      throw IoError(flow, "no curve has two different points");
    }
    return std::make_shared<const FlowFrames>(curve_frames(map, curves, control));
  }
  const auto chosen = static_cast<DirectionKind>(kind - kDirectionKindNames.begin());
  if (chosen == DirectionKind::Uv) return nullptr;
  return std::make_shared<const FlowFrames>(direction_frames(map, chosen, Vec3(up[0], up[1], up[2]), control));
}

/// @throws UsageError
void check_transfer_device(const device::DeviceOptions& device, transfer::TransferMethod method) {
  if (device.device == "auto" || device.device == "cpu") return;
  if (method != transfer::TransferMethod::Fast)
    throw app::UsageError("--device: --method reference runs on the CPU; leave --device out");
}

}  // namespace

int cmd_transfer(CommandRun& run) {
  std::filesystem::path history_path, output;
  std::vector<std::string> control_texts;
  MeshSource mesh_source;
  AtlasOptions atlas;
  std::optional<double> texel_size_mm;
  transfer::TransferOptions options;
  ControlKindOptions kinds;
  std::string flow = "gravity";
  std::filesystem::path source_mask;
  transfer::CacheOptions cache;
  device::DeviceOptions device;
  run.line.positional("HISTORY", "A material history, or a simulation", history_path);
  declare_mesh(run.line, mesh_source);
  run.line.output("TRANSFER", "Folder to make", output);
  run.line.repeated(
      "control", "SPEC",
      "[SOURCE=]DESTINATION[:weight[:mapping]]: a control of the history, and where on the mesh it is high: a kind "
      "(accessibility, facing(direction=x): `patinate control --help-all`), a map file or an expression; mapping: "
      "auto, rank, linear, physical",
      control_texts);
  run.line.required();
  run.line.options(atlas);
  run.line.default_text("resolution",
                        "as many as show every pixel of the history, 256 to 4096 along a side of all tiles together, "
                        "where its texel size and the mesh's unit are known, else " +
                            std::to_string(atlas.resolution));
  run.line.option("texel_size", "MM", "Surface length of one pixel of the history; default: what the history says",
                  texel_size_mm);
  run.line.option("source_mask", "FILE", "8-bit image of the history's size; what is 0 there is not copied",
                  source_mask);
  run.line.option(
      "flow", "FLOW",
      "Which way the history's photographs lie on the surface: gravity (their down runs down, by --up), curvature "
      "(along tubes and ridges), uv (as each chart lies), "
      "or a CSV of curves (x,y,z in mm, an empty line ends one) that their down follows",
      flow);
  run.line.former_flag("by_tile", "is not needed any more; a transfer takes 23 to 35 bytes a texel of the atlas");
  run.line.options(options);
  run.line.options(cache);
  run.line.options(device);
  declare_kind_options(run.line, kinds, {"up"});  // --flow looks at it too.
  run.line.usual({"unit", "resolution", "texel_size", "quality"});
  run.line.example(
      "transfer copper hydrant.gltf --material fire_hydrant --control progress=accessibility -o copper_hydrant");
  run.line.example("transfer library bust.glb --control thickness=accessibility --control history=which.png -o aged");
  run.line.example(
      "transfer crackle vase.obj --unit mm --control 'thickness=0.7*facing + 0.3*!accessibility' -o crackle_vase");
  run.line.checked([&] {
    if (texel_size_mm && !(*texel_size_mm >= kLeastTexel_mm && *texel_size_mm <= kLargestTexel_mm))
      throw app::UsageError("--texel-size: found `" + number_text(*texel_size_mm) + "`; expected a number [1e-9, 1e9]");
    check_transfer_device(device, options.method);
  });
  if (!run.parse()) return 0;
  app::require_no_file_name(output);  // Said before the mesh and its controls are made ready.
  check_flow(flow);
  std::vector<transfer::ControlSpec> specs = transfer::parse_controls(control_texts);  // Before work starts.

  transfer::TransferTask task;
  if (options.method == transfer::TransferMethod::Fast)
    task.input.device = app::open_search_device(device, words_of(run));
  task.mesh_name = mesh_source.path.filename().string();
  task.options = options;
  task.options.seed = run.line.common().seed;
  require_history_place(history_path);
  history_path = app::history_place(history_path);
  task.history = std::make_shared<const HistoryReader>(history_path);
  const HistoryReader& history = *task.history;
  task.is_history_installed = app::library_name(history_path).has_value();
  specs = transfer::with_sources(history, std::move(specs));  // A typo is said before the mesh is unwrapped.
  if (!source_mask.empty()) {
    task.input.source_mask = read_source_mask(source_mask, history);
    task.source_mask_name = source_mask.filename().string();
  }
  const std::optional<double> pixel_mm = texel_size_mm ? texel_size_mm : history.facts().texel_size_mm;
  const Destination destination = make_destination(mesh_source, atlas, run.line.is_given("resolution"), pixel_mm, run);
  task.atlas = destination.atlas;
  task.input.map = destination.map;
  task.unit = destination.unit;
  task.mm_per_mesh_unit = destination.mm_per_mesh_unit;
  task.input.texel_size_mm = destination.texel_size_mm;
  for (const transfer::ControlSpec& spec : specs) app::refuse_scene_maps(spec.destination, mesh_source.path);
  task.input.controls = transfer_controls(specs, history, *task.input.map, kinds,
                                          control_source(app::user_control_cache(cache.cache)), run);
  task.input.frames = make_flow(flow, *task.input.map, kinds.up, run);
  task.flow = task.input.frames ? std::filesystem::path(flow).filename().string() : "uv";
  task.input.appearance = transfer::appearance_source(history, cache);
  task.input.history = task.history;
  refer_to_history_warnings(run, history.label(), history.facts().warnings);
  const auto forecast = transfer::forecast_transfer(task.input, options.neighborhood_radius_px);
  for (const std::string& warning : transfer::warnings_of(forecast)) run.note(warning);
  const std::optional<JobStatus> status = run.make_folder(transfer::plan_transfer(std::move(task), output), "transfer");
  if (!status) return 0;
  const transfer::TransferManifest made = transfer::read_transfer_manifest(output);
  if (made.structure) run.note(error_text(*made.structure, options.quality));
  if (made.refused_line_share > 0.0)
    run.note("no lines found: what looks like lines would cover " + percent_text(made.refused_line_share, 2) +
             " of the source; --structure-map NAME keeps those whole that a control of the history marks");
  if (const std::string turning = turning_text(options.turning, made.measured_with.turning); !turning.empty())
    run.note(turning);
  run.report_output(*status, output, transfer::energy_json(made.energy));
  return 0;
}

}  // namespace patinate::cli
