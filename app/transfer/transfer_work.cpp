#include "app/transfer/transfer_work.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "app/controls/control_store.h"
#include "app/controls/scene_controls.h"
#include "app/device/checked_devices.h"
#include "app/request/history_library.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "app/transfer/destination.h"
#include "libcommon/controls/distance_io.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::app {

namespace {

/// A file that is no manifest stands where the history belongs: most often the mesh. @throws IoError
void require_history_place(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error) || lower_extension(path) == ".json") return;
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

/// Text about what was found in the source, and what was done about it.
std::string structure_text(const transfer::StructureFacts& s, transfer::TransferQuality quality) {
  const bool has_lines = s.kind != transfer::StructureKind::Regions;
  std::string text = !has_lines ? "found regions of two materials; the rarer covers "
                     : s.kind == transfer::StructureKind::DarkLines ? "found dark lines, which cover "
                                                                    : "found bright lines, which cover ";
  text += percent_text(s.share, 2) + " of the source; copied pieces were ";
  text += quality == transfer::TransferQuality::Draft ? "not cut (--quality draft)"
          : has_lines                                 ? "cut so that lines continue"
                                                      : "cut so that borders continue";
  return text + "; turn this off with --structure 0";
}

/// Whether they could turn as was asked.
std::string turning_text(transfer::PieceTurning asked, transfer::PieceTurning made) {
  if (made == transfer::PieceTurning::Free)
    return "copied pieces turn with the direction of --flow; turn this off with --turning never";
  if (asked != transfer::PieceTurning::Free) return "";
  return "--turning free: copied pieces follow --flow; only those of a history with lines turn, "
         "with --method fast, and not with --flow uv";
}

/// Says what the values of a library's control mean, and that it would help. Candidates are drawn by the first two
/// controls: it becomes one of them.
void note_library(const std::vector<LibraryPart>& library, std::vector<transfer::TransferControl>& controls,
                  const Words& say) {
  if (library.empty()) return;
  const auto found = std::find_if(controls.begin(), controls.end(),
                                  [](const transfer::TransferControl& c) { return c.source == kLibraryControl; });
  std::string list;
  for (std::size_t p = 0; p < library.size(); ++p)
    list += (p == 0 ? "" : ", ") + std::to_string(p) + " " + library[p].name;
  if (found == controls.end()) {
    say.note("a library (" + list + "): no control says which history applies where; give --control " +
             std::string(kLibraryControl) + "=MAP");
    return;
  }
  say.note(std::string(kLibraryControl) + ": " + list);
  if (found - controls.begin() > 1) std::rotate(controls.begin() + 1, found, found + 1);
}

/// A map of few values is not matched by rank, as others are.
void note_mapping(const transfer::TransferControl& control, const ImageU8& coverage, const Words& say) {
  if (control.mapping != transfer::ControlMapping::Linear) return;
  const double tied = transfer::suited_mapping(control.values, coverage).tied_share;
  say.note("control `" + control.source + "`: `" + control.destination + "` has few values on " +
           percent_text(tied, 2) + " of the mesh: its least and greatest become the history's (linear); write " +
           control.destination + ":" + number_text(control.weight) + ":rank to match how often values occur");
}

}  // namespace

std::vector<transfer::TransferControl> noted_controls(const History& history,
                                                      std::span<const transfer::ControlSpec> specs, const TexelMap& map,
                                                      const MakeControl& make, const Words& say) {
  std::vector<std::pair<float, float>> ranges;
  std::vector<transfer::TransferControl> controls = transfer::make_transfer_controls(
      history, specs, map.coverage(), [&](std::size_t i, const transfer::ControlSpec& spec) {
        ControlMap made = make(i, spec);
        for (const std::string& note : made.notes) say.note(note);
        ranges.push_back(covered_range(made.values, map));
        return made;
      });
  for (std::size_t i = 0; i < controls.size(); ++i) {
    if (!specs[i].mapping) note_mapping(controls[i], map.coverage(), say);
    if (!(ranges[i].first < ranges[i].second) && controls[i].mapping != transfer::ControlMapping::Physical) {
      say.note("control `" + controls[i].source + "`: `" + specs[i].destination +
               "` has the same value everywhere on the mesh, so this control has no effect");
    }
  }
  note_library(history.facts().parts, controls, say);
  return controls;
}

namespace {

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
  throw UsageError("--flow: found `" + flow + "`; expected gravity, curvature, uv, or a file of curves" +
                   did_you_mean(flow, kinds));
}

/// A kind, or a file of curves. @returns nothing for UVs.
std::shared_ptr<const FlowFrames> make_flow(const std::string& flow, const TexelMap& map,
                                            const std::array<double, 3>& up, const Words& say) {
  const RunControl control = say.phase("flow");
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

}  // namespace

void check_request(const TransferRequest& request) {
  const std::optional<double>& size = request.texel_size_mm;
  if (size && !(*size >= kMinTexel_mm && *size <= kLargestTexel_mm))
    throw UsageError("--texel-size: found `" + number_text(*size) + "`; expected a number [1e-9, 1e9]");
  const std::string& device = request.device.device;
  if (device != "auto" && device != "cpu" && request.transfer.method != transfer::TransferMethod::Fast)
    throw UsageError("--device: --method reference runs on the CPU; leave --device out");
  if (request.edits.empty()) return;
  if (request.transfer.method != transfer::TransferMethod::Fast || request.transfer.neighborhood_radius_px == 1)
    throw UsageError("--edits: needs --method fast, and a --neighborhood of 2 or more");
}

transfer::TransferEdits requested_edits(const TransferRequest& request) {
  return request.edits.empty() ? transfer::TransferEdits{} : transfer::read_transfer_edits(request.edits);
}

transfer::TransferTask transfer_task(const TransferRequest& request, const Words& say) {
  check_flow(request.flow);  // Typos are said before the mesh is unwrapped.
  std::vector<transfer::ControlSpec> specs = transfer::parse_controls(request.controls);
  transfer::TransferTask task;
  if (request.transfer.method == transfer::TransferMethod::Fast)
    task.input.device = open_search_device(request.device, say);
  task.mesh_name = request.mesh.path.filename().string();
  task.options = request.transfer;
  require_history_place(request.history);
  const std::filesystem::path folder = history_place(request.history);
  const auto reader = std::make_shared<const HistoryReader>(folder);
  const HistoryReader& history = *reader;
  task.history = reader;
  task.is_history_installed = library_name(folder).has_value();
  specs = transfer::with_sources(history, std::move(specs));
  if (!request.source_mask.empty()) {
    task.input.source_mask = read_source_mask(request.source_mask, history);
    task.source_mask_name = request.source_mask.filename().string();
  }
  const std::optional<double> pixel_mm = request.texel_size_mm ? request.texel_size_mm : history.facts().texel_size_mm;
  const Destination destination =
      make_destination(request.mesh, request.atlas, request.is_resolution_given, pixel_mm, say);
  task.atlas = destination.atlas;
  task.input.map = destination.map;
  task.unit = destination.unit;
  task.mm_per_mesh_unit = destination.mm_per_mesh_unit;
  task.input.texel_size_mm = destination.texel_size_mm;
  for (const transfer::ControlSpec& spec : specs) refuse_scene_maps(spec.destination, request.mesh.path);
  const ControlSource made_by = control_source(user_control_cache(request.cache.cache));
  task.input.controls = noted_controls(
      history, specs, *task.input.map,
      [&](std::size_t, const transfer::ControlSpec& spec) {
        return make_control_expression(spec.destination, *task.input.map, request.kinds,
                                       say.phase("control " + spec.source), made_by);
      },
      say);
  task.input.frames = make_flow(request.flow, *task.input.map, request.kinds.up, say);
  task.flow = task.input.frames ? std::filesystem::path(request.flow).filename().string() : "uv";
  task.input.appearance = transfer::appearance_source(history, request.cache);
  task.input.history = task.history;
  return task;
}

std::vector<std::string> transfer_notes(const transfer::TransferManifest& made,
                                        const transfer::TransferOptions& asked) {
  return transfer_notes(
      {.structure = made.structure, .refused_line_share = made.refused_line_share, .used = made.measured_with}, asked);
}

std::vector<std::string> transfer_notes(const FoundStructure& found, const transfer::TransferOptions& asked) {
  std::vector<std::string> notes;
  if (found.structure) notes.push_back(structure_text(*found.structure, asked.quality));
  if (found.refused_line_share > 0.0) {
    notes.push_back(
        "found no lines, because what looks like lines would cover " + percent_text(found.refused_line_share, 2) +
        " of the source; to keep them whole, mark them in a control of the history and give --structure-map NAME");
  }
  if (std::string turning = turning_text(asked.turning, found.used.turning); !turning.empty())
    notes.push_back(std::move(turning));
  return notes;
}

}  // namespace patinate::app
