#include "app/output/export_work.h"

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "app/output/aging_mesh.h"
#include "app/output/export_model.h"
#include "app/output/picture_series.h"
#include "app/request/output_file.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/atlas/sheet.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer_io.h"
#include "transfer/lookup/texture_files.h"

namespace patinate::app {

namespace {

constexpr std::array<std::string_view, 3> kFormatNames{"png", "exr", "tif"};

/// Source of a sequence.
struct SequenceSource {
  std::string key;
  std::vector<std::string> tile_names;
  HistoryManifest history;
  /// Writes the files of one time, one a tile. Thread-safe.
  std::function<void(double time, const std::vector<std::filesystem::path>& files, const RunControl& control)> write;
};

/// Names of a time's files in the folder, one a tile.
std::vector<std::filesystem::path> image_files(const SequenceSource& source, std::size_t index,
                                               const std::string& extension) {
  std::vector<std::filesystem::path> files;
  for (const std::string& tile : source.tile_names)
    files.push_back(tile_path(zero_padded(index, 5) + "." + extension, tile));
  return files;
}

Json export_json(double time, const std::vector<std::filesystem::path>& files, const SequenceSource& source) {
  if (files.size() == 1) return Json{{"time", time}, {"file", files[0].string()}};
  Json json{{"time", time}, {"files", Json::object()}};
  for (std::size_t k = 0; k < files.size(); ++k) json["files"][source.tile_names[k]] = files[k].string();
  return json;
}

/// A folder of one image per time (and tile), and `sequence.json`.
OutputWork sequence_work(const ExportTask& task, SequenceSource given, const RunControl& planning) {
  const auto source = std::make_shared<const SequenceSource>(std::move(given));
  std::vector<std::string> notes;
  const std::vector<double> times = task.times.resolve(source->history, 0, notes);
  const std::string extension(kFormatNames[static_cast<std::size_t>(task.format.kind)]);
  JobInputs inputs("export sequence", 2);
  inputs.add_content("source", "what is exported", source->key).add_value("--format", extension);
  for (double t : times) inputs.add_value("time " + number_text(t), "an image");
  JobPlan plan = inputs.plan(task.output, "sequence.json");
  Json files = Json::array();
  for (std::size_t i = 0; i < times.size(); ++i) {
    planning.throw_if_stopped();
    const std::vector<std::filesystem::path> outputs = image_files(*source, i, extension);
    files.push_back(export_json(times[i], outputs, *source));
    plan.items.push_back(
        {.name = zero_padded(i, 5),
         .outputs = outputs,
         .run =
             [source, t = times[i], outputs](const std::filesystem::path& folder, const RunControl& control) {
               const RunControl silent = control.silent();
               std::vector<std::filesystem::path> written;
               for (const auto& file : outputs) written.push_back(folder / file);
               source->write(t, written, silent);
             },
         .key = ContentHash().add("export image 2").add(source->key).add(extension).add(times[i]).hex()});
  }
  plan.join = [source, files, key = plan.key](const std::filesystem::path& folder, const RunControl&) {
    save_json(folder / "sequence.json",
              Json{{"time_unit", time_unit_text(source->history.time_unit)}, {"images", files}, {"key", key}});
  };
  OutputWork work{.output = task.output,
                  .label = "export",
                  .key = plan.key,
                  .existing_key = "",
                  .notes = std::move(notes),
                  .report = std::make_shared<const Json>(Json{{"images", times.size()}})};
  work.plan = std::move(plan);
  return work;
}

OutputWork pictures_work(const ExportTask& task, const HistoryManifest& history, PictureSeries series,
                         const RunControl& planning) {
  std::vector<std::string> notes;
  series.label = "export";
  series.times = task.times.resolve(history, kMoviePictures, notes);
  OutputWork work = series_work(task.output, series, task.movie, planning);
  work.notes = std::move(notes);
  return work;
}

/// Opened for the first texture that is not up to date.
class LateWriter {
 public:
  explicit LateWriter(std::shared_ptr<const transfer::TransferFolder> transfer) : transfer_(std::move(transfer)) {}
  const transfer::TextureWriter& open(const RunControl& control) {
    std::call_once(once_, [&] { writer_.emplace(*transfer_, transfer::CoordinateStripsOptions{}, control); });
    return *writer_;
  }

 private:
  std::shared_ptr<const transfer::TransferFolder> transfer_;
  std::once_flag once_;
  std::optional<transfer::TextureWriter> writer_;
};

/// A movie or numbered images of a transfer's texture, strip by strip.
PictureSeries texture_series(const std::shared_ptr<const transfer::TransferFolder>& transfer) {
  const auto writer = std::make_shared<LateWriter>(transfer);
  PictureSeries series{.label = "export", .key = transfer->manifest().key, .times = {}, .picture = {}};
  series.write = [transfer, writer](double t, const std::filesystem::path& file, const std::string& key,
                                    const RunControl& control) {
    const std::vector<transfer::TextureFile> texture{{{file}, transfer->history().sample(t), key}};
    writer->open(control).write(texture, control);
  };
  series.codes = [transfer, writer](double t, const RunControl& control) {
    ImageU8 picture(transfer->manifest().width, transfer->manifest().height, 3);
    std::size_t done = 0;
    writer->open(control).gather_rows(
        0, transfer->history().sample(t), transfer::color_codes,
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
OutputWork textures_work(const ExportTask& task, const RunControl& planning) {
  const auto transfer = std::make_shared<const transfer::TransferFolder>(task.subject);
  const auto writer = std::make_shared<LateWriter>(transfer);
  const auto write = [transfer, writer](double t, const std::vector<std::filesystem::path>& files,
                                        const RunControl& control) {
    const std::vector<transfer::TextureFile> texture{{files, transfer->history().sample(t)}};
    writer->open(control).write(texture, control);
  };
  return sequence_work(task, {transfer->manifest().key, transfer->sheet().names, transfer->history().manifest(), write},
                       planning);
}

/// Images or a movie of a surface over the sheet of all its tiles.
OutputWork aging_mesh_export(const ExportTask& task, const RunControl& planning) {
  const auto mesh = std::make_shared<const AgingMesh>(open_aging_mesh(task.subject, task.devices));
  const auto noted = [&](OutputWork work) {
    if (mesh->is_reduced)
      work.notes.insert(work.notes.begin(),
                        task.subject.string() + ": has more texels than are held at once; they are shown reduced");
    return work;
  };
  if (is_series(task.output)) {
    return noted(pictures_work(task, mesh->history,
                               {.label = "export", .key = mesh->key, .times = {}, .picture = mesh->sample}, planning));
  }
  const auto write = [mesh](double t, const std::vector<std::filesystem::path>& files, const RunControl& control) {
    write_color(files.front(), mesh->sample(t, control));
  };
  return noted(sequence_work(task, {mesh->key, mesh->tile_names, mesh->history, write}, planning));
}

/// Frames of a history as they are, over its own pixels.
OutputWork history_export(const ExportTask& task, const RunControl& planning) {
  const auto history = std::make_shared<const HistoryReader>(task.subject);
  const std::string key = transfer::history_content_key(*history);
  if (is_series(task.output)) {
    return pictures_work(task, history->manifest(),
                         {.label = "export",
                          .key = key,
                          .times = {},
                          .picture = [history](double t, const RunControl&) { return history->sample(t); }},
                         planning);
  }
  const auto write = [history](double t, const std::vector<std::filesystem::path>& files, const RunControl&) {
    write_color(files.front(), history->sample(t));
  };
  return sequence_work(task, {key, {""}, history->manifest(), write}, planning);
}

}  // namespace

void describe(OptionVisitor& v, SequenceFormat& o) {
  v.visit_choice({"format", "Files of an image sequence"}, o.kind, kFormatNames);
}

void describe(OptionVisitor& v, ModelAxis& o) {
  v.visit_choice({"up", "Models: axis of the mesh that points up; in GLB and USD it is +Y"}, o.up, kUpAxisNames);
}

void check_output(const ExportTask& task) {
  const std::optional<ModelFormat> model = model_format(task.output);
  const bool is_pictures = is_series(task.output);
  if (is_pictures && !is_movie(task.output)) require_extension(task.output, image_extensions());
  if (!model && !is_pictures)
    require_folder_name(task.output,
                        "MODEL.glb, .usdz, .usda or .obj, MOVIE.mp4, .webm or .gif, images as aged_%04d.png, or the "
                        "name of a folder (with / "
                        "at its end where it has a dot)");
}

OutputWork export_work(const ExportTask& task, const RunControl& planning) {
  check_output(task);
  const std::optional<ModelFormat> model = model_format(task.output);
  const bool is_pictures = is_series(task.output);
  const PathKind kind = kind_of(task.subject);
  if (task.axis.up != UpAxis::Y && !model) throw UsageError("--up: is of models; pictures of a mesh are `render`'s");
  if (kind == PathKind::History) {
    if (model) throw UsageError("-o: a history has no mesh; give a transfer, or a folder for images");
    return history_export(task, planning);
  }
  if (kind != PathKind::Transfer && kind != PathKind::Simulation)
    throw InvalidInput(task.subject.string() + ": is no transfer, simulation or history");
  if (model) return model_work(task, *model);
  if (kind == PathKind::Simulation) return aging_mesh_export(task, planning);
  if (!is_pictures) return textures_work(task, planning);
  const auto transfer = std::make_shared<const transfer::TransferFolder>(task.subject);
  if (transfer->sheet().num_tiles() > 1) return aging_mesh_export(task, planning);  // Its tiles make one sheet.
  return pictures_work(task, transfer->history().manifest(), texture_series(transfer), planning);
}

}  // namespace patinate::app
