#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "libcommon/controls/image_control.h"
#include "libcommon/core/hash.h"
#include "libcommon/geometry/mesh_key.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/contact_strip.h"
#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/dilate.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/output/render.h"
#include "patinate/transfer/transfer_reader.h"
#include "tools/patinate/command_line/output_file.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/times_argument.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/services/aging_mesh.h"
#include "tools/patinate/services/picture_series.h"

namespace patinate::cli {

namespace {

/// A turntable.
struct TurnOptions {
  double turn_deg = 0.0;  ///< What the camera turns around the object from the first picture to the end.
};
void describe(OptionVisitor& v, TurnOptions& o) {
  v.visit({"turn", "Movies: the camera turns so far around the object, to its left; 360 closes the round", "deg",
           between(-36000, 36000)},
          o.turn_deg);
}

struct RenderCommand {
  std::filesystem::path subject;
  std::filesystem::path output;
  std::filesystem::path texture;
  TimesArgument times;
  RenderOptions options;
  MovieOptions movie;
  TurnOptions turn;
};

ContentHash begin_key(const RenderCommand& command, const std::vector<double>& times) {
  ContentHash hash;
  hash.add("render 3").add(command.output.extension().string());
  for (const auto& [name, value] : option_values(command.options)) hash.add(name).add(value);
  for (double t : times) hash.add(t);
  return hash;
}

/// Side by side with their times under them, or a single picture as it is.
ImageF strip_of(const std::vector<ImageF>& pictures, const std::vector<double>& times, TimeUnit unit) {
  if (pictures.size() == 1) return pictures.front();
  return contact_strip(pictures, time_labels(times, unit));
}

/// Asks for the picture only when the output is not up to date.
int finish(CommandRun& run, const RenderCommand& command, const std::string& key, const std::function<ImageF()>& make) {
  const std::optional<JobStatus> status = run.check_file(command.output, image_file_key(command.output), key);
  if (!status) return 0;
  if (status == JobStatus::Done) write_color(command.output, make(), key);
  run.report_output(*status, command.output);
  return 0;
}

SurfaceDetail detail_of(const AgingMesh& mesh, double time, const RunControl& control) {
  return mesh.detail ? mesh.detail(time, control) : SurfaceDetail{};
}

/// A movie, or numbered images, of the aging object; on a turntable when asked for.
int render_series(CommandRun& run, const RenderCommand& command, const AgingMesh& mesh) {
  const std::vector<double> times = command.times.resolve(run, mesh.history, kMoviePictures);
  std::unique_ptr<const RenderView> view;
  const auto picture = [&](double t, const RunControl& control) {
    const auto index = std::find(times.begin(), times.end(), t) - times.begin();
    if (!view || command.turn.turn_deg != 0.0 || mesh.detail) {
      RenderOptions options = command.options;
      options.azimuth_deg += command.turn.turn_deg * static_cast<double>(index) / static_cast<double>(times.size());
      view = std::make_unique<const RenderView>(mesh.mesh, options, detail_of(mesh, t, control), control);
    }
    return view->shade(mesh.sample(t, control), control);
  };
  ContentHash hash = begin_key(command, {});
  hash.add(mesh.key).add(command.turn.turn_deg).add(static_cast<std::int64_t>(times.size()));
  return make_series(run, command.output, {"render", hash.hex(), times, picture}, command.movie);
}

int render_aging_mesh(CommandRun& run, const RenderCommand& command) {
  const AgingMesh mesh = open_aging_mesh(command.subject);
  if (is_series(command.output)) return render_series(run, command, mesh);
  const std::vector<double> times = command.times.resolve(run, mesh.history, 5);
  const std::string key = begin_key(command, times).add(mesh.key).hex();
  return finish(run, command, key, [&] {
    const RunControl control = run.control("render");
    std::unique_ptr<const RenderView> view;
    std::vector<ImageF> pictures;
    for (double t : times) {
      const double done = static_cast<double>(pictures.size()) / static_cast<double>(times.size());
      RunControl quiet = control;
      quiet.on_progress = {};
      if (!view) {
        view = std::make_unique<const RenderView>(mesh.mesh, command.options, detail_of(mesh, t, quiet),
                                                  control.part(0.0, 0.6));
      } else if (mesh.detail) {
        view = std::make_unique<const RenderView>(mesh.mesh, command.options, detail_of(mesh, t, quiet), quiet);
      }
      pictures.push_back(view->shade(mesh.sample(t, quiet), quiet));
      control.report(0.6 + 0.4 * done);
    }
    return strip_of(pictures, times, mesh.history.time_unit);
  });
}

int render_history(CommandRun& run, const RenderCommand& command) {
  if (is_series(command.output))
    throw UsageError("-o: a history has no object; `patinate export` makes movies of histories");
  const HistoryReader history(command.subject);
  const std::vector<double> times = command.times.resolve(run, history.manifest(), 5);
  const std::string key = begin_key(command, times).add(transfer::history_content_key(history)).hex();
  return finish(run, command, key, [&] {
    std::vector<ImageF> pictures;
    for (double t : times) pictures.push_back(history.sample(t));
    return strip_of(pictures, times, history.manifest().time_unit);
  });
}

/// The textures of all tiles in one sheet, gutters filled: what lies beside the charts must not bleed into them.
ImageF sheet_texture(const AtlasMesh& atlas, const std::vector<std::filesystem::path>& files, Mesh& mesh_over_sheet) {
  std::vector<ImageF> textures;
  for (const auto& file : files) textures.push_back(read_color(file));
  if (atlas.tiles.size() == 1) {
    mesh_over_sheet = unit_square_mesh(atlas);
    dilate(textures.front(), TexelMap(mesh_over_sheet, textures.front().width(), textures.front().height()).coverage(),
           -1);
    return std::move(textures.front());
  }
  int side = 1;
  for (const ImageF& texture : textures) side = std::max({side, texture.width(), texture.height()});
  const Sheet sheet = make_sheet(atlas.tile_names(), side);
  mesh_over_sheet = sheet_mesh(atlas, sheet);
  const ImageU8 coverage = TexelMap(mesh_over_sheet, sheet).coverage();
  ImageF texture(sheet.width(), sheet.height(), 3);
  for (int i = 0; i < sheet.num_tiles(); ++i) {
    ImageF tile = resize_bilinear(textures[textures.size() == 1 ? 0 : static_cast<std::size_t>(i)], side, side);
    dilate(tile, cut_tile(coverage, sheet, i), -1);
    paste_tile(texture, sheet, i, tile);
  }
  return texture;
}

int render_mesh(CommandRun& run, const RenderCommand& command) {
  if (is_series(command.output)) throw UsageError("-o: a mesh with a texture does not age; give a transfer");
  if (command.texture.empty()) throw UsageError("--texture: is missing; a mesh is rendered with an image");
  const Mesh mesh = read_mesh(command.subject);
  UvLayout layout = find_uv_layout(mesh);
  if (layout.tiles.empty())
    throw IoError(command.subject.string(), layout.problem + "; a texture needs UVs in [0, 1] or in tiles");
  const AtlasMesh atlas = atlas_mesh_of(mesh, std::move(layout));
  const std::vector<std::filesystem::path> files = tile_map_files(command.texture, atlas.tile_names());
  ContentHash hash = begin_key(command, {});
  hash.add(mesh_content_key(mesh));
  for (const auto& file : files) hash.add_file(file);
  return finish(run, command, hash.hex(), [&] {
    Mesh over_sheet;
    const ImageF texture = sheet_texture(atlas, files, over_sheet);
    return render(over_sheet, texture, command.options, run.control("render"));
  });
}

}  // namespace

int cmd_render(CommandRun& run) {
  RenderCommand command;
  run.line.positional("SUBJECT", "A transfer, a simulation, a history, or a mesh with --texture", command.subject);
  run.line.output("PICTURE",
                  "Image to make: .png, .jpg, .tif or .exr; of a transfer or simulation also a movie (.mp4, .webm, "
                  ".gif) or images aged_%04d.png",
                  command.output);
  command.times.declare(run.line);
  run.line.option("texture", "IMAGE",
                  "Color of a mesh; with UDIM tiles or several materials one file each: tex.<UDIM>.png",
                  command.texture);
  run.line.options(command.options);
  run.line.options(command.movie);
  run.line.options(command.turn);
  run.line.example("render aged_bust --time 12 -o bust.png");
  run.line.example("render aged_bust --num-times 5 -o strip.png");
  run.line.example("render aged_bust --frames 150 --turn 360 -o bust.mp4");
  run.line.example("render bust.glb --texture albedo.png -o bust.png");
  if (!run.parse()) return 0;
  if (!is_series(command.output)) {
    std::vector<std::string> known = image_extensions();
    known.insert(known.end(), movie_extensions().begin(), movie_extensions().end());
    require_extension(command.output, known);
  }
  switch (kind_of(command.subject)) {
    case PathKind::Transfer:
    case PathKind::Simulation:
      return render_aging_mesh(run, command);
    case PathKind::History:
      return render_history(run, command);
    case PathKind::Mesh:
      return render_mesh(run, command);
    default:
      throw InvalidInput(command.subject.string() + ": is no transfer, simulation, history or mesh");
  }
}

}  // namespace patinate::cli
