#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/controls/control_expression.h"
#include "libcommon/controls/control_kinds.h"
#include "libcommon/core/error.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_key.h"
#include "libcommon/image/image_io.h"
#include "tools/patinate/commands.h"
#include "tools/patinate/mesh_source.h"
#include "tools/patinate/output_file.h"

namespace patinate {

namespace {

struct ControlCommandOptions {
  AtlasOptions atlas;
  ControlKindOptions kinds;
};
void describe(OptionVisitor& v, ControlCommandOptions& o) {
  describe(v, o.atlas);
  describe(v, o.kinds);
}

bool is_kind(const std::string& kind) {
  const std::vector<std::string>& kinds = control_kind_names();
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

/// Everything that the map depends on.
std::string control_key(const std::string& kind, const Mesh& mesh_mm, const ControlCommandOptions& options) {
  ContentHash hash;
  hash.add("control 1").add(kind).add(mesh_content_key(mesh_mm));
  for (const auto& [name, value] : option_values(options)) hash.add(name).add(value);
  if (is_kind(kind)) {
    for (const auto& file : control_input_files(kind, options.kinds)) hash.add_file(file);
  } else {
    const ControlExpression expression(kind, control_kind_names());
    for (const ControlName& name : expression.names()) {
      if (name.is_file) hash.add_file(name.text);
      if (name.is_file) continue;
      for (const auto& file : control_input_files(name.text, options.kinds)) hash.add_file(file);
    }
  }
  return hash.hex();
}

/// glTF is in metres by its standard; other files are taken as mm unless --unit says otherwise.
double mm_per_mesh_unit(const MeshSource& source) {
  return mm_per_unit(source.unit_or_none().value_or("mm"));
}

}  // namespace

int cmd_control(CommandRun& run) {
  MeshSource mesh_source;
  std::filesystem::path output;
  std::string kind;
  ControlCommandOptions options;
  declare_mesh(run.line, mesh_source);
  run.line.option("kind", "KIND", "A kind (see below), or an expression of kinds and of map files", kind);
  run.line.required();
  run.line.suggestions(control_kind_names());
  run.line.output("MAP.exr", "The control map to make, float, channel Y, [0, 1]", output);
  run.line.options(options);
  std::vector<std::pair<std::string, std::string>> kinds;
  for (const ControlKind& k : control_kinds()) kinds.emplace_back(k.name, k.brief);
  run.line.list("Kinds: the map is high at", kinds);
  run.line.example("control bust.glb --kind accessibility -o crevices.exr");
  run.line.example("control bust.glb --kind facing --direction 0,1,0 -o dust.exr");
  run.line.example("control bust.glb --kind \"0.7*accessibility + 0.3*facing\" -o mix.exr");
  if (!run.parse()) return 0;
  require_extension(output, {".exr"});
  (void)ControlExpression(kind, control_kind_names());  // A typo is said before work starts.

  Mesh mesh = load_mesh(mesh_source);
  scale_mesh(mesh, mm_per_mesh_unit(mesh_source));
  const std::string key = control_key(kind, mesh, options);
  const std::optional<JobStatus> status = run.check_file(output, image_file_key(output), key);
  if (!status) return 0;
  if (status == JobStatus::UpToDate) {
    run.report_output(*status, output);
    return 0;
  }
  const RunControl control = run.control("control");
  const TexelMap map = make_texel_map(mesh_source.path, mesh, options.atlas, control.part(0.0, 0.2));
  const ControlMap result = is_kind(kind) ? make_control(kind, map, options.kinds, control.part(0.2, 1.0))
                                          : make_control_expression(kind, map, options.kinds, control.part(0.2, 1.0));
  write_exr(output, result.values, {"Y"}, ExrDepth::Float, key);
  if (map.num_overlapping() > 0) {
    run.note(mesh_source.path.string() + ": the UVs of " + std::to_string(map.num_overlapping()) +
             " texels overlap; choose a surface with --node or --material");
  }
  for (const std::string& note : result.notes) run.note(note);
  run.detail("0 stands for " + number_text(result.low) + ", 1 for " + number_text(result.high) + " " + result.unit);
  run.report_output(*status, output,
                    Json{{"range", {result.low, result.high}}, {"unit", result.unit}, {"covered", map.num_covered()}});
  return 0;
}

}  // namespace patinate
