#include "app/output/export_model.h"

#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/request/output_file.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/input_watch.h"
#include "libcommon/history/history_card.h"
#include "libcommon/output/model_textures.h"
#include "patinate/output/glb.h"
#include "patinate/output/obj.h"
#include "patinate/output/usd.h"

namespace patinate::app {

namespace {

constexpr int kModelTimes = 5;

/// Textures, all of which a MaterialX document beside them names.
OutputFile textures_beside(const std::filesystem::path& folder, const std::filesystem::path& materials) {
  require_own_textures(folder);
  OutputFile textures = output_folder(folder);
  std::error_code error;
  if (!std::filesystem::is_regular_file(materials, error)) return textures;
  const UnwatchedReads of_output;
  const std::string text = read_file(materials), before = "\"" + folder.filename().string() + "/";
  for (std::size_t at = text.find(before); at != std::string::npos; at = text.find(before, at + 1)) {
    const std::size_t begin = at + before.size();
    const std::string name = text.substr(begin, text.find('"', begin) - begin);
    if (!std::filesystem::exists(folder / name, error)) textures.lacks_files = true;
  }
  return textures;
}

/// Files beside a model under its name.
std::vector<OutputFile> files_beside(ModelFormat format, const std::filesystem::path& path) {
  const auto named = [&](const char* extension) { return std::filesystem::path(path).replace_extension(extension); };
  if (format == ModelFormat::Obj)
    return {textures_beside(named(".obj.textures"), named(".obj.mtlx")), output_file(named(".mtl")),
            output_file(named(".obj.mtlx"))};
  if (lower_extension(path) == ".usda")
    return {textures_beside(named(".textures"), named(".mtlx")), output_file(named(".mtlx"))};
  return {};
}

/// z up to y up: a quarter turn about x, which moves no digit.
Vec3 standing(const Vec3& v) { return {v.x(), v.z(), -v.y()}; }

void stand_up(Mesh& mesh) {
  for (Vec3& position : mesh.positions) position = standing(position);
  for (Vec3& normal : mesh.normals) normal = standing(normal);
}

/// An OBJ has no unit: it fits over the file that was aged.
Mesh in_own_unit(Mesh mesh, const AgingGlb& model) {
  scale_mesh(mesh, model.own_per_mm);
  return mesh;
}

GlbAppearance in_own_unit(GlbAppearance look, const AgingGlb& model) {
  for (auto& heights : look.heights) {
    heights = [heights, factor = static_cast<float>(model.own_per_mm)] {
      ImageF scaled = heights();
      for (float& height : scaled.values()) height *= factor;
      return scaled;
    };
  }
  return look;
}

/// Model that is written, and what it says of itself.
struct ModelToWrite {
  ModelFormat format;
  AgingGlb model;
  std::filesystem::path output;
  std::vector<double> times;
  std::string key;
  std::vector<std::string> credits;
  UpAxis up = UpAxis::Y;
};

/// What its file is made of, flakes included.
ModelParts parts_of(const ModelToWrite& what, const RunControl& control) {
  const AgingGlb& model = what.model;
  const std::vector<std::string> labels = time_labels(what.times, model.history.time_unit);
  ModelParts parts{.mesh = model.mesh,
                   .tiles = model.tiles,
                   .objects = model.objects,
                   .appearance = model.appearance(what.times, labels, control.part(0.0, 0.5))};
  const bool is_glb = what.format == ModelFormat::Glb;
  if (!is_glb && model.add_relief) model.add_relief(parts.appearance, what.times, control.silent());
  // In a stage, what is visible at a time is an object.
  const bool are_objects = what.format == ModelFormat::Usd;
  if (model.add_flakes) model.add_flakes(parts, what.times, labels, are_objects, control.part(0.5, 1.0));
  if (what.up == UpAxis::Z) stand_up(parts.mesh);
  return parts;
}

void write_model(const ModelToWrite& what, const RunControl& control) {
  const AgingGlb& model = what.model;
  ModelParts parts = parts_of(what, control.part(0.0, model.add_flakes ? 0.5 : 0.1));
  const RunControl writing = control.part(model.add_flakes ? 0.5 : 0.1, 1.0);
  const std::string name = what.output.stem().string();
  if (what.format == ModelFormat::Glb) {
    const GlbOptions options{.name = name, .key = what.key, .objects = parts.objects, .credits = what.credits};
    return write_glb(what.output, parts.mesh, parts.tiles, parts.appearance, options, writing);
  }
  if (what.format == ModelFormat::Usd) {
    const UsdOptions options{.name = name,
                             .time_unit = time_unit_text(model.history.time_unit),
                             .key = what.key,
                             .objects = parts.objects,
                             .credits = what.credits};
    return write_usd(what.output, parts.mesh, parts.tiles, parts.appearance, what.times, options, writing);
  }
  const ObjOptions options{.name = name, .key = what.key, .objects = parts.objects, .credits = what.credits};
  write_obj_model(what.output, in_own_unit(std::move(parts.mesh), model), parts.tiles,
                  in_own_unit(std::move(parts.appearance.front()), model), options, writing);
}

}  // namespace

std::optional<ModelFormat> model_format(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".glb") return ModelFormat::Glb;
  if (extension == ".usdz" || extension == ".usda") return ModelFormat::Usd;
  if (extension == ".obj") return ModelFormat::Obj;
  return std::nullopt;
}

OutputWork model_work(const ExportTask& task, ModelFormat format) {
  const auto what = std::make_shared<ModelToWrite>(
      ModelToWrite{.format = format,
                   .model = open_aging_glb(task.subject, task.devices, task.flakes.flakes),
                   .output = task.output,
                   .times = {},
                   .key = "",
                   .credits = credits_of(task.subject),
                   .up = task.axis.up});
  std::vector<std::string> notes;
  if (format != ModelFormat::Obj) notes = what->model.notes;
  what->times = task.times.resolve(what->model.history, format == ModelFormat::Obj ? 1 : kModelTimes, notes);
  if (format == ModelFormat::Obj && what->times.size() > 1)
    throw UsageError("-o: an OBJ shows one time; give one --time, or .usda, .usdz or .glb");
  constexpr std::array<std::string_view, 3> kStages{"export glb 6", "export usd 6", "export obj 4"};
  ContentHash hash;
  hash.add(kStages[static_cast<std::size_t>(format)]).add(what->model.key);
  if (what->up == UpAxis::Z) hash.add("up z");
  if (what->model.add_flakes) hash.add("flakes 1");
  for (double t : what->times) hash.add(t);
  for (const std::string& credit : what->credits) hash.add(credit);
  what->key = hash.hex();
  OutputWork work{.output = task.output,
                  .label = "export",
                  .key = what->key,
                  .existing_key = written_key(task.output),
                  .beside = files_beside(format, task.output),
                  .notes = std::move(notes),
                  .report = std::make_shared<const Json>(Json{{"times", what->times}})};
  work.make = [what](const RunControl& control) { write_model(*what, control); };
  return work;
}

}  // namespace patinate::app
