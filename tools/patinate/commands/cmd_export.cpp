#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/output/glb.h"
#include "patinate/output/obj.h"
#include "patinate/output/usd.h"
#include "tools/patinate/command_line/output_file.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/times_argument.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/services/aging_glb.h"
#include "tools/patinate/services/aging_mesh.h"
#include "tools/patinate/services/picture_series.h"
#include "transfer/lookup/texture_files.h"

namespace patinate::cli {

namespace {

struct SequenceFormat {
  enum class Kind { Png, Exr, Tif } kind = Kind::Png;
};
constexpr std::array<std::string_view, 3> kFormatNames{"png", "exr", "tif"};
void describe(OptionVisitor& v, SequenceFormat& o) {
  v.visit_choice({"format", "Files of an image sequence"}, o.kind, kFormatNames);
}

std::string glb_key_of(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) ? read_glb_key(path) : "";
}

/// Files that lie beside a model under its name.
bool has_beside(const std::filesystem::path& path, const std::vector<std::string>& extensions) {
  std::error_code error;
  return std::all_of(extensions.begin(), extensions.end(), [&](const std::string& extension) {
    return std::filesystem::exists(std::filesystem::path(path).replace_extension(extension), error);
  });
}

/// Of a stage whose textures and materials are there.
std::string usd_key_of(const std::filesystem::path& path) {
  std::error_code error;
  const bool is_whole = path.extension() == ".usdz" || has_beside(path, {".textures", ".mtlx"});
  return is_whole && std::filesystem::is_regular_file(path, error) ? read_usd_key(path) : "";
}

std::string obj_key_of(const std::filesystem::path& path) {
  std::error_code error;
  const bool is_whole = has_beside(path, {".obj.textures", ".mtl", ".obj.mtlx"});
  return is_whole && std::filesystem::is_regular_file(path, error) ? read_obj_key(path) : "";
}

enum class ModelFormat { Glb, Usd, Obj };

/// What a model is, by its name.
std::optional<ModelFormat> model_format(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".glb") return ModelFormat::Glb;
  if (extension == ".usdz" || extension == ".usda") return ModelFormat::Usd;
  if (extension == ".obj") return ModelFormat::Obj;
  return std::nullopt;
}

std::string model_key_of(ModelFormat format, const std::filesystem::path& path) {
  if (format == ModelFormat::Glb) return glb_key_of(path);
  return format == ModelFormat::Usd ? usd_key_of(path) : obj_key_of(path);
}

void write_model(ModelFormat format, const AgingGlb& model, const std::filesystem::path& output,
                 const std::vector<double>& times, const std::string& key, const std::vector<std::string>& credits,
                 const RunControl& control) {
  std::vector<GlbAppearance> appearance =
      model.appearance(times, time_labels(times, model.history.time_unit), control.part(0.0, 0.1));
  const RunControl writing = control.part(0.1, 1.0);
  const std::string name = output.stem().string();
  if (format == ModelFormat::Glb) {
    const GlbOptions options{
        .name = name,
        .meters_per_unit = model.meters_per_unit,
        .key = key,
        .objects = model.objects,
        .credits = credits,
        .plants = model.plants ? model.plants(times, control.part(0.1, 0.4)) : std::vector<GlbPlant>{}};
    return write_glb(output, model.mesh, model.tiles, appearance, options, control.part(0.4, 1.0));
  }
  if (model.add_relief) model.add_relief(appearance, times, control);
  if (format == ModelFormat::Usd) {
    const UsdOptions options{.name = name,
                             .meters_per_unit = model.meters_per_unit,
                             .time_unit = time_unit_text(model.history.time_unit),
                             .key = key,
                             .objects = model.objects,
                             .credits = credits};
    return write_usd(output, model.mesh, model.tiles, appearance, times, options, writing);
  }
  const ObjOptions options{.name = name, .key = key, .objects = model.objects, .credits = credits};
  write_obj_model(output, model.mesh, model.tiles, appearance.front(), options, writing);
}

int export_model(CommandRun& run, ModelFormat format, const AgingGlb& model, const std::filesystem::path& output,
                 const std::vector<double>& times, const GlbPlantOptions& plants) {
  if (format == ModelFormat::Obj && times.size() > 1)
    throw UsageError("-o: an OBJ shows one time; give one --time, or .usda, .usdz or .glb");
  constexpr std::array<std::string_view, 3> kStages{"export glb 4", "export usd 3", "export obj 2"};
  ContentHash hash;
  hash.add(kStages[static_cast<std::size_t>(format)]).add(model.key);
  if (format == ModelFormat::Glb && model.plants) hash.add("plants 2").add(plants.plants);
  for (double t : times) hash.add(t);
  const std::vector<std::string> credits = run.credits();
  for (const std::string& credit : credits) hash.add(credit);
  const std::string key = hash.hex();
  const std::optional<JobStatus> status = run.check_file(output, model_key_of(format, output), key);
  if (!status) return 0;
  if (status == JobStatus::Done) write_model(format, model, output, times, key, credits, run.control("export"));
  run.report_output(*status, output, Json{{"times", times}});
  return 0;
}

/// What a sequence is made of.
struct SequenceSource {
  std::string key;
  std::vector<std::string> tile_names;
  /// Writes the files of one time, one a tile. Thread-safe.
  std::function<void(double time, const std::vector<std::filesystem::path>& files, const RunControl& control)> write;
};

/// A folder of one image per time (and tile), and `sequence.json`.
int export_sequence(CommandRun& run, const SequenceSource& source, const HistoryManifest& history,
                    const std::filesystem::path& output, const std::vector<double>& times,
                    const SequenceFormat& format) {
  const std::string extension(kFormatNames[static_cast<std::size_t>(format.kind)]);
  JobInputs inputs("export sequence", 2);
  inputs.add_content("source", "what is exported", source.key).add_value("--format", extension);
  for (double t : times) inputs.add_value("time " + number_text(t), "an image");
  JobPlan plan = inputs.plan(output, "sequence.json");
  Json files = Json::array();
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::string number = zero_padded(i, 5);
    std::vector<std::filesystem::path> outputs;
    for (const std::string& tile : source.tile_names) outputs.push_back(tile_path(number + "." + extension, tile));
    if (outputs.size() == 1) {
      files.push_back(Json{{"time", times[i]}, {"file", outputs[0].string()}});
    } else {
      files.push_back(Json{{"time", times[i]}, {"files", Json::object()}});
      for (std::size_t k = 0; k < outputs.size(); ++k)
        files.back()["files"][source.tile_names[k]] = outputs[k].string();
    }
    plan.items.push_back(
        {.name = number,
         .outputs = outputs,
         .run =
             [&source, t = times[i], outputs](const std::filesystem::path& folder, const RunControl& control) {
               RunControl silent = control;
               silent.on_progress = {};
               std::vector<std::filesystem::path> written;
               for (const auto& file : outputs) written.push_back(folder / file);
               source.write(t, written, silent);
             },
         .key = ContentHash().add("export image 2").add(source.key).add(extension).add(times[i]).hex()});
  }
  plan.join = [&, key = plan.key](const std::filesystem::path& folder, const RunControl&) {
    save_json(folder / "sequence.json",
              Json{{"time_unit", time_unit_text(history.time_unit)}, {"images", files}, {"key", key}});
  };
  const std::optional<JobStatus> status = run.make_folder(plan, "export");
  if (status) run.report_output(*status, output, Json{{"images", times.size()}});
  return 0;
}

/// A movie or numbered images of a transfer's texture, strip by strip; nothing where its tiles make one sheet.
std::optional<PictureSeries> texture_series(CommandRun& run, const std::filesystem::path& subject,
                                            const TimesArgument& times) {
  const auto transfer = std::make_shared<const transfer::TransferFolder>(subject);
  if (transfer->sheet().num_tiles() > 1) return std::nullopt;
  const auto writer = std::make_shared<std::optional<const transfer::TextureWriter>>();  // Opened for the first texture
                                                                                         // that is not up to date.
  const auto open = [transfer, writer](const RunControl& control) -> const transfer::TextureWriter& {
    return *writer ? **writer : writer->emplace(*transfer, transfer::CoordinateStripsOptions{}, control);
  };
  PictureSeries series{
      "export", transfer->manifest().key, times.resolve(run, transfer->history().manifest(), kMoviePictures), {}};
  series.write = [transfer, open](double t, const std::filesystem::path& file, const std::string& key,
                                  const RunControl& control) {
    const std::vector<transfer::TextureFile> texture{{{file}, transfer->history().sample(t), key}};
    open(control).write(texture, control);
  };
  series.codes = [transfer, open](double t, const RunControl& control) {
    ImageU8 picture(transfer->manifest().width, transfer->manifest().height, 3);
    std::size_t done = 0;
    open(control).gather_rows(
        0, srgb8_from_linear(transfer->history().sample(t)),
        [&](std::span<const std::uint8_t> rows) {
          std::copy(rows.begin(), rows.end(), picture.values().subspan(done).begin());
          done += rows.size();
        },
        control);
    return picture;
  };
  return series;
}

/// Textures of a transfer: strip by strip, however large the atlas.
int export_textures(CommandRun& run, const std::filesystem::path& subject, const std::filesystem::path& output,
                    const TimesArgument& times, const SequenceFormat& format) {
  const transfer::TransferFolder transfer(subject);
  std::once_flag once;
  std::unique_ptr<const transfer::TextureWriter> writer;  // Opened for the first texture that is not up to date.
  const auto write = [&](double t, const std::vector<std::filesystem::path>& files, const RunControl& control) {
    std::call_once(once, [&] {
      writer = std::make_unique<const transfer::TextureWriter>(transfer, transfer::CoordinateStripsOptions{}, control);
    });
    const std::vector<transfer::TextureFile> texture{{files, transfer.history().sample(t)}};
    writer->write(texture, control);
  };
  const HistoryManifest& history = transfer.history().manifest();
  return export_sequence(run, {transfer.manifest().key, transfer.sheet().names, write}, history, output,
                         times.resolve(run, history, 0), format);
}

/// Frames of a history as they are, over its own pixels.
int export_frames(CommandRun& run, const HistoryReader& history, const std::string& key,
                  const std::filesystem::path& output, const TimesArgument& times, const SequenceFormat& format) {
  const auto write = [&](double t, const std::vector<std::filesystem::path>& files, const RunControl&) {
    write_color(files.front(), history.sample(t));
  };
  return export_sequence(run, {key, {""}, write}, history.manifest(), output, times.resolve(run, history.manifest(), 0),
                         format);
}

}  // namespace

int cmd_export(CommandRun& run) {
  std::filesystem::path subject, output;
  TimesArgument times;
  SequenceFormat format;
  MovieOptions movie;
  GlbPlantOptions plants;
  run.line.positional("SUBJECT", "A transfer or simulation, or for pictures a history", subject);
  run.line.output(
      "OUTPUT",
      "MODEL.glb with one variant a time; MODEL.usdz or .usda with textures over time; MODEL.obj with MTL at one "
      "time; .usda and .obj with MaterialX; MOVIE.mp4, .webm or .gif; images aged_%04d.png; or a folder of images",
      output);
  times.declare(run.line);
  run.line.options(format);
  run.line.options(movie);
  run.line.options(plants);
  run.line.example("export aged_bust -o bust.glb --times 0,6,12");
  run.line.example("export aged_bust -o bust.usdz --num-times 20");
  run.line.example("export aged_bust -o bust.obj --time 12");
  run.line.example("export aged_bust -o textures --format png");
  run.line.example("export copper -o copper.mp4 --frames 200 --fps 25");
  if (!run.parse()) return 0;
  const std::optional<ModelFormat> format_of_model = model_format(output);
  const bool is_model = format_of_model.has_value();
  const bool is_pictures = is_series(output);
  if (!is_model && !is_pictures)
    require_folder_name(output,
                        "MODEL.glb, .usdz, .usda or .obj, MOVIE.mp4, .webm or .gif, images as aged_%04d.png, or the "
                        "name of a folder (with / "
                        "at its end where it has a dot)");
  const PathKind kind = kind_of(subject);
  if (kind == PathKind::Transfer && is_pictures) {
    if (const std::optional<PictureSeries> series = texture_series(run, subject, times))
      return make_series(run, output, *series, movie);
  }
  if (kind == PathKind::Transfer && !is_model && !is_pictures)
    return export_textures(run, subject, output, times, format);
  const bool may_show_plants = kind == PathKind::Simulation && format_of_model == ModelFormat::Glb;
  if (plants.plants != GlbPlantOptions{}.plants && !may_show_plants)
    throw UsageError("--plants: are shown in a GLB of a simulation alone");
  if (kind == PathKind::Transfer || kind == PathKind::Simulation) {
    if (is_model) {
      const AgingGlb model = open_aging_glb(subject, plants);
      const int default_count = *format_of_model == ModelFormat::Obj ? 1 : 5;
      return export_model(run, *format_of_model, model, output, times.resolve(run, model.history, default_count),
                          plants);
    }
    const AgingMesh mesh = open_aging_mesh(subject);
    if (mesh.is_reduced) run.note(subject.string() + ": has more texels than are held at once; they are shown reduced");
    if (is_pictures) {
      return make_series(run, output,
                         {"export", mesh.key, times.resolve(run, mesh.history, kMoviePictures), mesh.sample}, movie);
    }
    const auto write = [&](double t, const std::vector<std::filesystem::path>& files, const RunControl& control) {
      write_color(files.front(), mesh.sample(t, control));
    };
    return export_sequence(run, {mesh.key, mesh.tile_names, write}, mesh.history, output,
                           times.resolve(run, mesh.history, 0), format);
  }
  if (kind != PathKind::History) throw InvalidInput(subject.string() + ": is no transfer, simulation or history");
  const HistoryReader history(subject);
  if (is_model) throw UsageError("-o: a history has no mesh; give a transfer, or a folder for images");
  if (is_pictures) {
    const PictureSeries series{"export", transfer::history_content_key(history),
                               times.resolve(run, history.manifest(), kMoviePictures),
                               [&](double t, const RunControl&) { return history.sample(t); }};
    return make_series(run, output, series, movie);
  }
  return export_frames(run, history, transfer::history_content_key(history), output, times, format);
}

}  // namespace patinate::cli
