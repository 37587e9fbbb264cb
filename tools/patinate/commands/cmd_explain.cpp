#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/explanation/explanation_job.h"
#include "app/controls/control_store.h"
#include "app/controls/scene_controls.h"
#include "app/request/path_kind.h"
#include "app/request/repeating_command.h"
#include "libcommon/controls/control_arguments.h"
#include "libcommon/controls/control_cache.h"
#include "libcommon/controls/image_control.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_key.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/commands/declared_options.h"
#include "tools/patinate/commands/surface_reference.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

struct ExplainCommand {
  fs::path reference, output;
  app::MeshSource mesh;
  app::AtlasOptions atlas;
  std::vector<std::string> kinds, also;
  ReferenceOptions options;
  analysis::ExplanationOptions explanation;
  ControlKindOptions controls;
  app::ControlStoreOptions store;
};

/// Every kind that has what it needs. Distance is from creases unless something else was said.
std::vector<std::string> default_kinds(const ControlKindOptions& options) {
  std::vector<std::string> kinds = control_kind_names();
  if (options.image.empty()) std::erase(kinds, "image");
  return kinds;
}

/// Content key of the map of an expression.
std::string expression_key(const std::string& text, const TexelMap& map, const ControlKindOptions& options) {
  ContentHash hash;
  hash.add("expression").add(text).add(mesh_content_key(map.mesh()));
  hash.add(std::int64_t{map.width()}).add(std::int64_t{map.height()});
  const ControlExpression parsed(text, control_kind_names());
  for (const ControlName& name : parsed.names()) {
    if (!name.is_file) hash.add(control_content_key(name.text, map, named_options(name, options)));
    if (!name.is_file) continue;
    for (const fs::path& file : tile_map_files(name.text, map.sheet().names)) hash.add_file(file);
  }
  return hash.hex();
}

/// Options that commands need beside the expression: those of its kinds that are not the default.
std::vector<std::string> needed_options(const std::string& text, const ControlKindOptions& options) {
  std::vector<std::string> needed;
  const auto defaults = option_values(ControlKindOptions{});
  const ControlExpression parsed(text, control_kind_names());
  for (const ControlName& name : parsed.names()) {
    if (name.is_file) continue;
    const auto values = option_values(used_options(name.text, options));
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool is_said = std::any_of(name.arguments.begin(), name.arguments.end(),
                                       [&](const auto& argument) { return argument.first == values[i].first; });
      if (!is_said && values[i] != defaults[i]) needed.push_back(app::changed_options({values[i]}, {defaults[i]}));
    }
  }
  return needed;
}

std::vector<analysis::ExplainingControl> explained_controls(const ExplainCommand& command,
                                                            const std::shared_ptr<const TexelMap>& map) {
  const ControlCache cache = app::user_control_cache(command.store.cache);
  std::vector<analysis::ExplainingControl> controls;
  const bool is_default = command.kinds.empty();
  for (const std::string& text : is_default ? default_kinds(command.controls) : command.kinds) {
    const ControlName kind = single_kind(text).value();
    const ControlKindOptions options = named_options(kind, command.controls);
    controls.push_back({.name = text,
                        .key = control_content_key(kind.text, *map, options),
                        .make = [kind, map, options, cache](
                                    const RunControl& c) { return cached_control(kind.text, *map, options, cache, c); },
                        .options = needed_options(text, command.controls),
                        .may_fail = is_default});
  }
  const ControlKindOptions& options = command.controls;
  for (const std::string& text : command.also) {
    controls.push_back({.name = text,
                        .key = expression_key(text, *map, options),
                        .make =
                            [text, map, options, cache](const RunControl& c) {
                              return make_control_expression(text, *map, options, c, control_source(cache));
                            },
                        .options = needed_options(text, options)});
  }
  return controls;
}

/// Command that repeats it: options that are not the default, and nothing that changes no byte.
std::string explain_command(const ExplainCommand& command, std::int64_t seed) {
  std::string text =
      "patinate control explain " + app::input_word(command.reference) + " " + app::input_word(command.mesh.path);
  const auto add = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) text += " --" + name + " " + app::shell_word(value);
  };
  add("unit", command.mesh.unit);
  add("node", command.mesh.node);
  add("material", command.mesh.material);
  for (const std::string& kind : command.kinds) add("kind", kind);
  for (const std::string& expression : command.also) add("also", expression);
  text += app::changed_options(option_values(command.atlas), option_values(app::AtlasOptions{}));
  ReferenceOptions named = command.options;
  for (std::string* path : {&named.before, &named.mask, &named.camera}) {
    if (!path->empty()) *path = app::input_word(*path);
  }
  text += app::changed_options(option_values(named), option_values(ReferenceOptions{}));
  text += app::changed_options(option_values(command.explanation), option_values(analysis::ExplanationOptions{}));
  text += app::changed_options(option_values(command.controls), option_values(ControlKindOptions{}));
  if (seed != CommonOptions{}.seed) text += " --seed " + std::to_string(seed);
  return text + app::kAnyOutput;
}

void declare(CommandRun& run, ExplainCommand& command) {
  run.line.positional("REFERENCE",
                      "How it aged: an image on the mesh's UVs, a photograph (--camera), a history with positions, a "
                      "transfer or simulation",
                      command.reference);
  declare_mesh(run.line, command.mesh);
  run.line.output("REPORT", "Folder to make: report.html, explanation.json, figures.csv", command.output);
  run.line.repeated(
      "kind", "KIND",
      "Only this kind of control, with its arguments (`patinate control --help-all`); default: every kind",
      command.kinds);
  run.line.suggestions(control_kind_names());
  run.line.repeated("also", "EXPRESSION", "A map file or an expression of controls that may explain it, too",
                    command.also);
  run.line.options(command.options);
  run.line.options(command.atlas);
  run.line.options(command.explanation);
  run.line.options(command.store);
  declare_kind_options(run.line, command.controls);
  run.line.usual({"unit", "kind", "also", "before", "mask", "resolution"});
  run.line.example("control explain aged.jpg hydrant.gltf --before clean.jpg --mask paint.png -o why");
  run.line.example("control explain bust_simulated bust.glb --channel luminance --aged low -o why");
  run.line.example(
      "control explain photo.jpg statue.ply --unit mm --camera camera.yml --kind height --kind exposure -o why");
}

void check_kinds(const ExplainCommand& command) {
  for (const std::string& kind : command.kinds) {
    if (!single_kind(kind))  // A typo is said before work starts.
      throw ParseError("--kind: found `" + kind + "`; expected a kind; --also takes expressions and files");
  }
  for (const std::string& text : command.also) app::refuse_scene_maps(text, command.mesh.path);
}

void report_findings(CommandRun& run, const Json& report) {
  for (const Json& note : report.at("notes")) run.note(note.get<std::string>());
  for (const Json& skipped : report.at("skipped"))
    run.note(skipped.at("name").get<std::string>() + ": skipped, " + skipped.at("reason").get<std::string>());
  const auto two = [](const Json& v) { return short_number_text(std::round(100.0 * v.get<double>()) / 100.0 + 0.0); };
  for (const Json& c : report.at("candidates")) {
    const std::string name = c.at("name").get<std::string>();
    if (c.at("even").get<bool>()) run.note("  " + name + ": the same everywhere on this surface");
    if (c.at("even").get<bool>()) continue;
    std::string line = "  " + name + ": " + two(c.at("correlation"));
    if (!c.at("low").is_null()) line += " [" + two(c.at("low")) + ", " + two(c.at("high")) + "]";
    line += ", corrected p " + short_number_text(rounded(c.at("corrected_p").get<double>(), 2));
    if (!c.at("explains").get<bool>()) line += ": explains nothing that chance would not";
    run.note(line);
  }
  run.note(report.at("verdict").get<std::string>());
  const Json& mix = report.at("mix");
  if (!mix.is_null() && mix.at("explains").get<bool>())
    run.note("for transfer: " + mix.at("argument").get<std::string>());
}

}  // namespace

int cmd_explain(CommandRun& run) {
  ExplainCommand command;
  declare(run, command);
  if (!run.parse()) return 0;
  check_kinds(command);
  app::require_exists(command.reference);
  const std::int64_t seed = run.line.common().seed;
  analysis::ExplanationTask task;
  task.seed = static_cast<std::uint64_t>(seed);
  task.command = explain_command(command, seed);
  if (command.controls.distance_from.empty()) command.controls.distance_from = "creases";
  const bool needs_uvs = lies_on_uvs(command.reference, command.options);
  if (needs_uvs && command.atlas.method == AtlasMethod::Auto) command.atlas.method = AtlasMethod::Uv;
  Mesh mesh = app::load_mesh(command.mesh, words_of(run));
  AtlasMesh atlas = app::make_atlas(command.mesh, std::move(mesh), command.atlas, run.control("atlas"));
  app::note_atlas(command.mesh, atlas, words_of(run));
  if (!command.mesh.unit_or_none()) run.note(command.mesh.path.string() + ": taken as mm; --unit says otherwise");
  const double mm = app::mm_per_unit(command.mesh.unit_or_none().value_or("mm"));
  scale_mesh(atlas.mesh, mm);
  const auto map = std::make_shared<const TexelMap>(
      app::make_texel_map(command.mesh, atlas, command.atlas.resolution, run.control("atlas")));
  task.map = map;
  task.mesh_name = command.mesh.path.filename().string();
  task.mesh_key = mesh_content_key(map->mesh());
  task.reference = read_surface_reference(command.reference, command.options, *map, mm, run.control("reference"));
  task.controls = explained_controls(command, map);
  task.options = command.explanation;
  const std::array<double, 3>& up = command.controls.up;
  task.is_z_up = std::abs(up[2]) > std::abs(up[1]);
  const std::optional<JobStatus> status =
      run.make_folder(analysis::plan_explanation(std::move(task), command.output), "explain");
  if (!status) return 0;
  const Json report = load_json(command.output / analysis::kExplanationFile);
  report_findings(run, report);
  run.report_output(*status, command.output,
                    Json{{"verdict", report.at("verdict")},
                         {"candidates", report.at("candidates")},
                         {"mix", report.at("mix")},
                         {"notes", report.at("notes")}});
  return 0;
}

}  // namespace patinate::cli
