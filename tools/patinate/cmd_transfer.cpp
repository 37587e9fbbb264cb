#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/controls/control_expression.h"
#include "libcommon/controls/control_kinds.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_io.h"
#include "libcommon/history/history.h"
#include "tools/patinate/commands.h"
#include "tools/patinate/mesh_source.h"
#include "transfer/transfer_job.h"

namespace patinate {

namespace {

/// The destination in mm and the surface length of one history pixel.
struct Scale {
  double mm_per_mesh_unit = 1.0;
  double texel_size_mm = 1.0;
  std::string note;  ///< What the command says when the sizes were chosen, not known.
};

/// @param texel_size_in_mesh_units  Median over the atlas.
Scale choose_scale(const std::optional<std::string>& unit, std::optional<double> pixel_mm, double texel_size_in_mesh_units) {
  if (unit) {
    const double mm = mm_per_unit(*unit);
    if (pixel_mm) return {mm, *pixel_mm, ""};
    return {mm, texel_size_in_mesh_units * mm,
            "the history has no texel size: one pixel of it covers one texel (" + number_text(texel_size_in_mesh_units * mm) +
                " mm); --texel-size sets it"};
  }
  const double size = pixel_mm.value_or(1.0);
  return {size / texel_size_in_mesh_units, size, "the mesh has no unit: it is scaled so that one texel equals one pixel of the history; --unit sets it"};
}

/// The history's control that a spec names, or its only one.
std::string source_control(const HistoryReader& history, const ControlSpec& spec) {
  if (!spec.source.empty()) return history.control(spec.source).name;
  const auto& controls = history.manifest().controls;
  if (controls.size() == 1) return controls[0].name;
  std::string names;
  for (const ControlParameter& c : controls) names += (names.empty() ? "" : ", ") + c.name;
  throw UsageError("--control " + spec.destination + ": " + history.folder().string() +
                   (controls.empty() ? " has no controls; ingest with one" : " has several controls (" + names + "); write SOURCE=" + spec.destination));
}

/// Texels along each side of the atlas: as asked for, or, when both sizes are known, so many that a texel equals a pixel.
int choose_resolution(const AtlasOptions& asked, bool is_asked, double texel_mm, std::optional<double> pixel_mm) {
  if (is_asked || !pixel_mm) return asked.resolution;
  constexpr double kLeast = 256.0, kMost = 4096.0;
  return static_cast<int>(std::clamp(std::round(asked.resolution * texel_mm / *pixel_mm), kLeast, kMost));
}

std::vector<TransferControl> make_controls(const std::vector<std::string>& texts, const HistoryReader& history, const TexelMap& map,
                                           const ControlKindOptions& kinds, CommandRun& run) {
  std::vector<TransferControl> controls;
  for (const std::string& text : texts) {
    const ControlSpec spec = parse_control_spec(text);
    const std::string source = source_control(history, spec);
    for (const TransferControl& other : controls) {
      if (other.source == source) throw UsageError("--control: `" + source + "` is given twice; combine them in one expression");
    }
    ControlMap made = make_control_expression(spec.destination, map, kinds, run.control("control " + source));
    for (const std::string& note : made.notes) run.note(note);
    controls.push_back({source, spec.destination, std::move(made.values), {made.low, made.high, made.unit}, spec.weight, spec.mapping});
  }
  return controls;
}

/// Says when texels and the history's pixels differ so much that texture is left out or magnified.
void note_ratio(double pixels_per_texel, int resolution, CommandRun& run) {
  if (pixels_per_texel > 0.66 && pixels_per_texel < 1.5) return;
  run.note("one texel covers " + short_number_text(pixels_per_texel) + " pixels of the history; --resolution " +
           std::to_string(static_cast<int>(std::round(resolution * pixels_per_texel))) + " would make them equal");
}

Json energy_json(const TransferManifest& m) {
  return {{"energy", m.energy.energy}, {"control_error_mean", m.energy.control_error_mean}, {"coherent_share", m.energy.coherent_share}};
}

}  // namespace

int cmd_transfer(CommandRun& run) {
  std::filesystem::path history_path, output;
  std::vector<std::string> control_texts;
  MeshSource mesh_source;
  AtlasOptions atlas;
  std::optional<double> texel_size_mm;
  TransferOptions options;
  ControlKindOptions kinds;
  run.line.positional("HISTORY", "A material history", history_path);
  declare_mesh(run.line, mesh_source);
  run.line.output("TRANSFER", "Folder to make", output);
  run.line.repeated("control", "SPEC", "[SOURCE=]DESTINATION[:weight[:mapping]]: a control of the history, and where on the mesh it is high: a kind "
                    "(accessibility, facing, spray), a map file or an expression; mapping: rank, linear, physical", control_texts);
  run.line.required();
  run.line.options(atlas);
  run.line.option("texel_size", "MM", "Surface length of one pixel of the history; default: what the history says", texel_size_mm);
  run.line.options(options);
  run.line.options(kinds);
  run.line.example("transfer copper hydrant.gltf --material fire_hydrant --control progress=accessibility -o copper_hydrant");
  run.line.example("transfer crackle vase.obj --unit mm --control 'thickness=0.7*facing + 0.3*!accessibility' -o crackle_vase");
  if (!run.parse()) return 0;
  if (texel_size_mm && !(*texel_size_mm > 0.0)) throw UsageError("--texel-size: found `" + number_text(*texel_size_mm) + "`; expected a number > 0");
  for (const std::string& text : control_texts) {  // A typo is said before work starts.
    (void)ControlExpression(parse_control_spec(text).destination, control_kind_names());
  }

  TransferTask task;
  task.history = history_path;
  task.mesh_name = mesh_source.path.filename().string();
  task.options = options;
  task.options.seed = run.line.common().seed;
  const HistoryReader history(history_path);
  Mesh mesh = load_mesh(mesh_source);
  task.unit = mesh_source.unit_or_none();
  const TexelMap unscaled = make_texel_map(mesh_source.path, mesh, atlas, run.control("atlas"));
  if (unscaled.num_covered() == 0) throw IoError(mesh_source.path.string(), "its UVs cover no texel; use a larger --resolution, or lay the charts out larger");
  const std::optional<double> pixel_mm = texel_size_mm ? texel_size_mm : history.manifest().texel_size_mm;
  const Scale scale = choose_scale(task.unit, pixel_mm, unscaled.median_texel_size_mm());
  if (!scale.note.empty()) run.note(scale.note);
  if (1000 * unscaled.num_overlapping() > unscaled.num_covered()) {
    run.note(mesh_source.path.string() + ": " + std::to_string(unscaled.num_overlapping()) +
             " texels belong to more than one triangle; they age alike (choose surfaces with --node or --material)");
  }
  scale_mesh(mesh, scale.mm_per_mesh_unit);
  task.mm_per_mesh_unit = scale.mm_per_mesh_unit;
  task.texel_size_mm = scale.texel_size_mm;
  const double texel_mm = unscaled.median_texel_size_mm() * scale.mm_per_mesh_unit;
  const int resolution = choose_resolution(atlas, run.line.is_given("resolution"), texel_mm, task.unit ? pixel_mm : std::nullopt);
  task.map = std::make_shared<TexelMap>(std::move(mesh), resolution, resolution, run.control("atlas"));
  note_ratio(task.map->median_texel_size_mm() / scale.texel_size_mm, resolution, run);
  task.controls = make_controls(control_texts, history, *task.map, kinds, run);
  const std::optional<JobStatus> status = run.make_folder(plan_transfer(std::move(task), output), "transfer");
  if (!status) return 0;
  run.report_output(*status, output, energy_json(read_transfer_manifest(output)));
  return 0;
}

}  // namespace patinate
