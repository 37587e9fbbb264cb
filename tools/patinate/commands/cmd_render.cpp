#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "libcommon/core/hash.h"
#include "libcommon/geometry/mesh_key.h"
#include "libcommon/output/contact_strip.h"
#include "patinate/atlas/atlas_mesh.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/output/render_surface.h"
#include "patinate/transfer/transfer_reader.h"
#include "tools/patinate/command_line/output_file.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/times_argument.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/services/aging_mesh.h"
#include "tools/patinate/services/mesh_source.h"
#include "tools/patinate/services/picture_series.h"
#include "tools/patinate/services/picture_views.h"
#include "tools/patinate/services/surface_files.h"

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

enum class ShownMaps { All, Color };
constexpr std::array<std::string_view, 2> kShownMapsNames{"all", "color"};

/// What of a surface is shown.
struct ShownOptions {
  ShownMaps maps = ShownMaps::All;
  double film = kWetFilm;
};
void describe(OptionVisitor& v, ShownOptions& o) {
  v.visit_choice({"maps", "What is shown of a surface: all that is known of it, or its color under one coat"}, o.maps,
                 kShownMapsNames);
  v.visit({"film", "Simulations: amount of water that wets a place through", "", above(0)}, o.film);
}

struct RenderCommand {
  std::filesystem::path subject;
  std::filesystem::path output;
  std::filesystem::path environment;
  std::string unit;
  SurfaceFiles files;
  TimesArgument times;
  RenderOptions options;
  MovieOptions movie;
  TurnOptions turn;
  ShownOptions shown;
  SurfaceOptions surface;
  ViewArguments views;

  [[nodiscard]] bool has_views() const { return !views.views.empty() || views.turntable; }
};

ContentHash begin_key(const RenderCommand& command, const std::vector<double>& times) {
  ContentHash hash;
  hash.add("render 3").add(command.output.extension().string());
  for (const auto& [name, value] : option_values(command.options)) hash.add(name).add(value);
  for (double t : times) hash.add(t);
  if (command.has_views()) {
    for (const PictureView& view : command.views.resolve(command.options))
      hash.add(view.name).add(view.azimuth_deg).add(view.elevation_deg);
  }
  for (const double x : command.views.target) hash.add("target").add(x);
  if (command.views.distance) hash.add("distance").add(*command.views.distance);
  return hash;
}

/// What is added where all maps of a surface are shown.
void add_surface(ContentHash& hash, const RenderCommand& command) {
  hash.add("surface 1").add(command.shown.film);
  for (const auto& [name, value] : option_values(command.surface)) hash.add(name).add(value);
  if (!command.environment.empty()) hash.add("environment").add_file(command.environment);
}

/// Asks for the picture only when the output is not up to date.
int finish(CommandRun& run, const RenderCommand& command, const std::string& key, const std::function<ImageF()>& make) {
  const std::optional<JobStatus> status = run.check_file(command.output, image_file_key(command.output), key);
  if (!status) return 0;
  if (status == JobStatus::Done) write_color(command.output, make(), key);
  run.report_output(*status, command.output);
  return 0;
}

/// One picture: when, and from where.
struct Shot {
  double time = 0.0;
  PictureView view;
};

/// An object that a camera goes around while it ages. What one picture needs is kept for the next.
class Studio {
 public:
  /// @param sample  Color at a time. @param maps  All that is known at a time, or nothing.
  Studio(const RenderCommand& command, const Mesh& mesh, std::function<ImageF(double, const RunControl&)> sample,
         std::function<SurfaceMaps(double, const RunControl&)> maps)
      : command_(command), mesh_(mesh), sample_(std::move(sample)), maps_(std::move(maps)) {
    if (!maps_ && !command.environment.empty()) {
      maps_ = [this](double time, const RunControl& control) { return SurfaceMaps{.color = sample_(time, control)}; };
    }
    if (!command.environment.empty()) environment_ = read_color(command.environment);
  }

  [[nodiscard]] ImageF picture(const Shot& shot, const RunControl& control) {
    const RunControl begin = control.part(0.0, 0.6), end = control.part(0.6, 1.0);
    if (maps_) {
      if (!surface_ || time_ != shot.time)
        surface_.emplace(mesh_, maps_(shot.time, begin), command_.options, command_.surface, environment_, begin);
      time_ = shot.time;
      return surface_->picture(shot.view.azimuth_deg, shot.view.elevation_deg, end);
    }
    RenderOptions options = command_.options;
    options.azimuth_deg = shot.view.azimuth_deg;
    options.elevation_deg = shot.view.elevation_deg;
    if (!color_ || seen_ != std::pair(options.azimuth_deg, options.elevation_deg))
      color_.emplace(mesh_, options, begin);
    seen_ = {options.azimuth_deg, options.elevation_deg};
    return color_->shade(sample_(shot.time, end), end);
  }

 private:
  const RenderCommand& command_;
  const Mesh& mesh_;
  std::function<ImageF(double, const RunControl&)> sample_;
  std::function<SurfaceMaps(double, const RunControl&)> maps_;
  ImageF environment_;
  std::optional<SurfaceView> surface_;
  double time_ = 0.0;  ///< Of surface_.
  std::optional<RenderView> color_;
  std::pair<double, double> seen_;  ///< Azimuth and elevation of color_.
};

/// All shots in one picture, side by side with labels under them; a single picture as it is.
ImageF strip_of(CommandRun& run, Studio& studio, const std::vector<Shot>& shots,
                const std::vector<std::string>& labels) {
  const RunControl control = run.control("render");
  std::vector<ImageF> pictures;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const auto n = static_cast<double>(shots.size());
    pictures.push_back(
        studio.picture(shots[i], control.part(static_cast<double>(i) / n, (static_cast<double>(i) + 1.0) / n)));
  }
  return shots.size() == 1 ? pictures.front() : contact_strip(pictures, labels);
}

/// One picture a shot, as a movie or as numbered images; `numbers` tell them apart.
int make_shots(CommandRun& run, const RenderCommand& command, Studio& studio, const std::string& key,
               const std::vector<Shot>& shots, const std::vector<double>& numbers, const std::string& measure) {
  const auto picture = [&](double number, const RunControl& control) {
    const auto index = std::find(numbers.begin(), numbers.end(), number) - numbers.begin();
    return studio.picture(shots[static_cast<std::size_t>(index)], control);
  };
  return make_series(run, command.output,
                     {.label = "render", .key = key, .times = numbers, .picture = picture, .measure = measure},
                     command.movie);
}

/// Every view at one time. Numbered by view, from 0.
int make_views(CommandRun& run, const RenderCommand& command, Studio& studio, const std::string& key, double time) {
  std::vector<Shot> shots;
  std::vector<std::string> labels;
  std::vector<double> numbers;
  for (const PictureView& view : command.views.resolve(command.options)) {
    numbers.push_back(static_cast<double>(shots.size()));
    shots.push_back({time, view});
    labels.push_back(view.name);
  }
  if (is_series(command.output)) return make_shots(run, command, studio, key, shots, numbers, "view");
  return finish(run, command, key, [&] { return strip_of(run, studio, shots, labels); });
}

/// The object at several times, seen from one place, or turning in a movie.
int make_times(CommandRun& run, const RenderCommand& command, Studio& studio, const std::string& key,
               const std::vector<double>& times, TimeUnit unit) {
  std::vector<Shot> shots;
  for (const double t : times) {
    const double turned = is_series(command.output) ? command.turn.turn_deg * static_cast<double>(shots.size()) /
                                                          static_cast<double>(times.size())
                                                    : 0.0;
    shots.push_back({t, {"", command.options.azimuth_deg + turned, command.options.elevation_deg}});
  }
  if (is_series(command.output)) return make_shots(run, command, studio, key, shots, times, "time");
  return finish(run, command, key, [&] { return strip_of(run, studio, shots, time_labels(times, unit)); });
}

/// What was asked for. Of a simulation its end when nothing was: what a run has come to.
std::vector<double> times_of(CommandRun& run, const RenderCommand& command, const AgingMesh& mesh) {
  const bool is_end = mesh.history.origin == "simulated" && command.shown.maps == ShownMaps::All &&
                      !is_series(command.output) && kind_of(command.subject) == PathKind::Simulation;
  if (!command.times.is_given() && (is_end || command.has_views())) return {mesh.history.frames.back().time};
  return command.times.resolve(run, mesh.history, is_series(command.output) ? kMoviePictures : 5);
}

int render_aging_mesh(CommandRun& run, const RenderCommand& command) {
  const AgingMesh mesh = open_aging_mesh(command.subject, command.shown.film);
  if (mesh.is_reduced)
    run.note(command.subject.string() + ": has more texels than are held at once; pictures show its color, reduced");
  const std::vector<double> times = times_of(run, command, mesh);
  if (command.has_views() && times.size() != 1)
    throw UsageError("--views, --turntable: show one time; give it with --time");
  auto maps = command.shown.maps == ShownMaps::All ? mesh.maps : nullptr;
  if (maps && *std::min_element(times.begin(), times.end()) < mesh.maps_from) {
    run.note("relief, gloss and water are known of the end only; pictures of other times show color");
    maps = nullptr;
  }
  ContentHash hash = begin_key(command, is_series(command.output) ? std::vector<double>{} : times);
  hash.add(mesh.key);
  if (is_series(command.output)) hash.add(command.turn.turn_deg).add(static_cast<std::int64_t>(times.size()));
  if (maps || !command.environment.empty()) add_surface(hash, command);
  Studio studio(command, mesh.mesh, mesh.sample, maps);
  if (command.has_views()) return make_views(run, command, studio, hash.hex(), times.front());
  return make_times(run, command, studio, hash.hex(), times, mesh.history.time_unit);
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
    if (pictures.size() == 1) return pictures.front();
    return contact_strip(pictures, time_labels(times, history.manifest().time_unit));
  });
}

int render_mesh(CommandRun& run, const RenderCommand& command) {
  if (is_series(command.output) && !command.has_views())
    throw UsageError("-o: a mesh with a texture does not age; give a transfer, or --turntable");
  if (command.files.color.empty()) throw UsageError("--texture: is missing; a mesh is rendered with an image");
  const Mesh mesh = read_mesh(command.subject);
  UvLayout layout = find_uv_layout(mesh);
  if (layout.tiles.empty())
    throw IoError(command.subject.string(), layout.problem + "; a texture needs UVs in [0, 1] or in tiles");
  const AtlasMesh atlas = atlas_mesh_of(mesh, std::move(layout));
  const std::string extension = lower_extension(command.subject);
  const bool is_gltf = extension == ".gltf" || extension == ".glb";
  const double unit_mm = mm_per_unit(!command.unit.empty() ? command.unit : is_gltf ? "m" : "mm");
  ContentHash hash = begin_key(command, {});
  hash.add(mesh_content_key(mesh));
  command.files.add_to(hash, atlas);
  const bool is_surface = command.files.has_more() || !command.environment.empty();
  if (is_surface) {
    add_surface(hash, command);
    hash.add(unit_mm);
  }
  Mesh over_sheet;
  const SurfaceMaps maps = is_surface ? read_surface_maps(atlas, command.files, unit_mm, over_sheet)
                                      : SurfaceMaps{.color = read_color_map(atlas, command.files, over_sheet)};
  std::function<SurfaceMaps(double, const RunControl&)> all;
  if (is_surface) all = [&maps](double, const RunControl&) { return maps; };
  Studio studio(
      command, over_sheet, [&maps](double, const RunControl&) { return maps.color; }, all);
  return make_views(run, command, studio, hash.hex(), 0.0);
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
  command.files.declare(run.line);
  run.line.option("unit", "um|mm|cm|m", "Unit of a mesh whose --height-map is given; default: m for glTF, else mm",
                  command.unit);
  run.line.option("environment", "IMAGE",
                  "Surroundings that light the object: a picture of 360 x 180 degrees, HDR or EXR",
                  command.environment);
  command.views.declare(run.line);
  run.line.options(command.shown);
  run.line.options(command.surface);
  run.line.options(command.options);
  run.line.options(command.movie);
  run.line.options(command.turn);
  run.line.example("render rain -o rain.png");
  run.line.example("render rain --views front,left,40:20 --environment sky.hdr -o rain.png");
  run.line.example("render rain --turntable 90 -o rain.mp4");
  run.line.example("render aged_bust --time 12 -o bust.png");
  run.line.example("render aged_bust --num-times 5 -o strip.png");
  run.line.example("render aged_bust --frames 150 --turn 360 -o bust.mp4");
  run.line.example("render bust.glb --texture albedo.png -o bust.png");
  if (!run.parse()) return 0;
  command.views.apply_to(command.options);
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
