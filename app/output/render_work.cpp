#include "app/output/render_work.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "app/output/picture_series.h"
#include "app/request/output_file.h"
#include "app/request/path_kind.h"
#include "app/request/unit_argument.h"
#include "app/request/usage_error.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_key.h"
#include "libcommon/image/filters.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "libcommon/output/contact_strip.h"
#include "libcommon/output/key_light.h"
#include "patinate/atlas/atlas_mesh.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::app {

namespace {

/// One picture: when, and from where.
struct PictureShot {
  double time = 0.0;
  PictureView view;
};

/// Data of one picture that is kept for the next. One thread at a time.
class PictureStudio {
 public:
  using Sample = std::function<ImageF(double time, const RunControl& control)>;
  using Maps = std::function<SurfaceMaps(double time, const RunControl& control)>;
  /// @param sample  Color at a time. @param maps  All that is known at a time, or nothing. @throws IoError
  PictureStudio(std::shared_ptr<const RenderTask> task, std::shared_ptr<const Mesh> mesh, Sample sample, Maps maps);

  [[nodiscard]] ImageF picture(const PictureShot& shot, const RunControl& control);
  /// How many pictures what is kept takes as long as, about: colors in one light are cheap once rays have been traced.
  [[nodiscard]] double pictures_before() const { return maps_ ? 1.0 : 50.0; }

 private:
  std::shared_ptr<const RenderTask> task_;
  std::shared_ptr<const Mesh> mesh_;
  Sample sample_;
  Maps maps_;
  ImageF environment_;
  std::optional<SurfaceView> surface_;
  double time_ = 0.0;  ///< Time of surface_.
  std::optional<RenderView> color_;
  std::pair<double, double> seen_;  ///< Azimuth and elevation of color_.
};

PictureStudio::PictureStudio(std::shared_ptr<const RenderTask> task, std::shared_ptr<const Mesh> mesh, Sample sample,
                             Maps maps)
    : task_(std::move(task)), mesh_(std::move(mesh)), sample_(std::move(sample)), maps_(std::move(maps)) {
  if (task_->environment.empty()) return;
  environment_ = read_color(task_->environment);
  if (!maps_) {
    maps_ = [color = sample_](double time, const RunControl& control) {
      return SurfaceMaps{.color = color(time, control)};
    };
  }
}

ImageF PictureStudio::picture(const PictureShot& shot, const RunControl& control) {
  const bool is_first = !surface_ && !color_;
  const double share = is_first ? pictures_before() / (1.0 + pictures_before()) : 0.0;
  const RunControl begin = control.part(0.0, share), end = control.part(share, 1.0);
  if (maps_) {
    if (!surface_) {
      surface_.emplace(*mesh_, maps_(shot.time, begin), task_->options, task_->surface, environment_, begin);
    } else if (time_ != shot.time) {
      surface_->show(maps_(shot.time, begin), begin);
    }
    time_ = shot.time;
    return surface_->picture(shot.view.azimuth_deg, shot.view.elevation_deg, end);
  }
  RenderOptions options = task_->options;
  options.azimuth_deg = shot.view.azimuth_deg;
  options.elevation_deg = shot.view.elevation_deg;
  if (!color_ || seen_ != std::pair(options.azimuth_deg, options.elevation_deg)) color_.emplace(*mesh_, options, begin);
  seen_ = {options.azimuth_deg, options.elevation_deg};
  return color_->shade(sample_(shot.time, end), end);
}

constexpr std::array<std::string_view, 2> kShownMapsNames{"all", "color"};
constexpr int kStripPictures = 5;

using SharedTask = std::shared_ptr<const RenderTask>;

ContentHash begin_key(const RenderTask& task, const std::vector<double>& times) {
  ContentHash hash;
  hash.add("render 4").add(task.output.extension().string());
  for (const auto& [name, value] : option_values(task.options)) hash.add(name).add(value);
  for (double t : times) hash.add(t);
  if (task.has_views()) {
    for (const PictureView& view : task.views.resolve(task.options))
      hash.add(view.name).add(view.azimuth_deg).add(view.elevation_deg);
  }
  for (const double x : task.views.target) hash.add("target").add(x);
  if (task.views.distance) hash.add("distance").add(*task.views.distance);
  return hash;
}

/// Adds what decides where all maps of a surface are shown.
void add_surface(ContentHash& hash, const RenderTask& task) {
  hash.add("surface 3").add(task.shown.film);
  for (const auto& [name, value] : option_values(task.surface)) hash.add(name).add(value);
  if (!task.environment.empty()) hash.add("environment").add_file(task.environment);
}

/// Under the pictures of a strip; none where there is one picture, or a movie.
std::vector<std::string> strip_labels(const RenderTask& task, const std::vector<double>& times, TimeUnit unit) {
  if (times.size() < 2 || is_series(task.output)) return {};
  return time_labels(times, unit);
}

/// One picture, as a file or not.
OutputWork picture_work(const RenderTask& task, const std::string& key,
                        std::function<ImageF(const RunControl& control)> picture) {
  OutputWork work{.output = task.output, .label = "render", .key = key, .existing_key = "", .report = nullptr};
  work.picture = std::move(picture);
  if (task.output.empty()) return work;
  work.existing_key = image_file_key(task.output);
  work.make = [output = task.output, key, picture = work.picture](const RunControl& control) {
    write_color(output, picture(control), key);
  };
  return work;
}

/// All shots in one picture, side by side with labels under them; a single picture as it is.
OutputWork strip_work(const RenderTask& task, const std::string& key, const std::shared_ptr<PictureStudio>& studio,
                      const std::vector<PictureShot>& shots, const std::vector<std::string>& labels) {
  OutputWork work = picture_work(task, key, [studio, shots, labels](const RunControl& control) {
    std::vector<ImageF> pictures;
    const double before = studio->pictures_before(), all = before + static_cast<double>(shots.size());
    for (std::size_t i = 0; i < shots.size(); ++i) {
      const double done = i == 0 ? 0.0 : (before + static_cast<double>(i)) / all;
      const double next = (before + static_cast<double>(i) + 1.0) / all;
      pictures.push_back(studio->picture(shots[i], control.part(done, next)));
    }
    return shots.size() == 1 ? pictures.front() : contact_strip(pictures, labels);
  });
  return work;
}

/// One picture a shot, as a movie or as numbered images; `numbers` tell them apart.
OutputWork shots_work(const RenderTask& task, const std::string& key, const std::shared_ptr<PictureStudio>& studio,
                      const std::vector<PictureShot>& shots, const std::vector<double>& numbers,
                      const std::string& measure) {
  const auto picture = [studio, shots, numbers](double number, const RunControl& control) {
    const auto index = std::find(numbers.begin(), numbers.end(), number) - numbers.begin();
    return studio->picture(shots[index], control);
  };
  return series_work(task.output,
                     {.label = "render", .key = key, .times = numbers, .picture = picture, .measure = measure},
                     task.movie);
}

/// Every view at one time. Numbered by view, from 0.
OutputWork views_work(const RenderTask& task, const std::string& key, const std::shared_ptr<PictureStudio>& studio,
                      double time) {
  std::vector<PictureShot> shots;
  std::vector<std::string> labels;
  std::vector<double> numbers;
  for (const PictureView& view : task.views.resolve(task.options)) {
    numbers.push_back(static_cast<double>(shots.size()));
    shots.push_back({time, view});
    labels.push_back(view.name);
  }
  if (is_series(task.output)) return shots_work(task, key, studio, shots, numbers, "view");
  return strip_work(task, key, studio, shots, labels);
}

/// The object at several times, seen from one place, or turning in a movie.
OutputWork times_work(const RenderTask& task, const std::string& key, const std::shared_ptr<PictureStudio>& studio,
                      const std::vector<double>& times, const std::vector<std::string>& labels) {
  std::vector<PictureShot> shots;
  for (const double t : times) {
    const double turned = is_series(task.output) ? task.turn.turn_deg * static_cast<double>(shots.size()) /
                                                       static_cast<double>(times.size())
                                                 : 0.0;
    shots.push_back({t, {"", task.options.azimuth_deg + turned, task.options.elevation_deg}});
  }
  if (is_series(task.output)) return shots_work(task, key, studio, shots, times, "time");
  return strip_work(task, key, studio, shots, labels);
}

/// Times that were asked for. Of a simulation its end when nothing was: what a run has come to.
std::vector<double> times_of(const RenderTask& task, const AgingMesh& mesh, std::vector<std::string>& notes) {
  const bool is_end = mesh.history.origin == "simulated" && task.shown.maps == ShownMaps::All &&
                      !is_series(task.output) && !task.mesh && kind_of(task.subject) == PathKind::Simulation;
  if (!task.times.is_given() && (is_end || task.has_views())) return {mesh.history.frames.back().time};
  return task.times.resolve(mesh.history, is_series(task.output) ? kMoviePictures : kStripPictures, notes);
}

/// Says where a near light may reach little of what it is to light, and how large that is: its unit is easily missed.
void note_near_light(const RenderOptions& options, const Mesh& mesh, std::vector<std::string>& notes) {
  const Box box = bounding_box(mesh);
  const Vec3 place =
      options.target.value_or(box.center()) + options.light_distance * KeyLight(options, box.center()).direction();
  const bool is_within = (place - box.low).minCoeff() >= 0.0 && (box.high - place).minCoeff() >= 0.0;
  if (!(options.light_distance > 0.0) || !is_within) return;
  const Vec3 size = box.high - box.low;
  notes.push_back("--light-distance: the light stands within the mesh's bounding box (" + short_number_text(size.x()) +
                  " x " + short_number_text(size.y()) + " x " + short_number_text(size.z()) +
                  " in its unit); what it cannot reach stays dark");
}

/// Factor of heights below flakes; nothing where no flakes stand off the surface.
std::optional<double> flake_relief(const RenderTask& task) {
  const bool has_flakes = task.shown.flakes.flakes && task.surface.relief > 0.0;
  return has_flakes ? std::optional<double>(task.surface.relief) : std::nullopt;
}

OutputWork aging_mesh_pictures(const SharedTask& task) {
  const auto mesh = task->mesh ? task->mesh
                               : std::make_shared<const AgingMesh>(open_aging_mesh(
                                     task->subject, task->devices, task->shown.film, flake_relief(*task)));
  std::vector<std::string> notes;
  if (mesh->is_reduced)
    notes.push_back(task->subject.string() +
                    ": has more texels than are held at once; pictures show its color, reduced");
  note_near_light(task->options, mesh->mesh, notes);
  const std::vector<double> times = times_of(*task, *mesh, notes);
  if (task->has_views() && times.size() != 1)
    throw UsageError("--views, --turntable: show one time; give it with --time");
  auto maps = task->shown.maps == ShownMaps::All ? mesh->maps : nullptr;
  if (maps && *std::min_element(times.begin(), times.end()) < mesh->maps_from) {
    notes.push_back("relief, gloss and water are known only at the end; pictures of other times show color");
    maps = nullptr;
  }
  ContentHash hash = begin_key(*task, is_series(task->output) ? std::vector<double>{} : times);
  hash.add(mesh->key);
  if (is_series(task->output)) hash.add(task->turn.turn_deg).add(static_cast<std::int64_t>(times.size()));
  if (maps || !task->environment.empty()) add_surface(hash, *task);
  if (maps && mesh->may_have_flakes) hash.add("flakes 1");
  const std::vector<std::string> labels = strip_labels(*task, times, mesh->history.time_unit);
  for (const std::string& label : labels) hash.add(label);
  const auto studio =
      std::make_shared<PictureStudio>(task, std::shared_ptr<const Mesh>(mesh, &mesh->mesh), mesh->sample, maps);
  OutputWork work = task->has_views() ? views_work(*task, hash.hex(), studio, times.front())
                                      : times_work(*task, hash.hex(), studio, times, labels);
  work.notes = std::move(notes);
  return work;
}

/// The size of a picture of a history, which keeps its proportions.
std::pair<int, int> history_size(const RenderTask& task, const HistoryManifest& history) {
  double scale = 1.0;
  if (task.is_width_given || task.is_height_given) scale = std::numeric_limits<double>::infinity();
  if (task.is_width_given) scale = std::min(scale, static_cast<double>(task.options.width) / history.width);
  if (task.is_height_given) scale = std::min(scale, static_cast<double>(task.options.height) / history.height);
  const auto scaled = [&](int side) { return std::max(1, static_cast<int>(std::lround(scale * side))); };
  return {scaled(history.width), scaled(history.height)};
}

OutputWork history_pictures(const SharedTask& task) {
  if (is_series(task->output))
    throw UsageError("-o: a history has no object; `patinate export` makes movies of histories");
  const auto history = std::make_shared<const HistoryReader>(task->subject);
  std::vector<std::string> notes;
  const std::vector<double> times = task->times.resolve(history->manifest(), kStripPictures, notes);
  const std::vector<std::string> labels = strip_labels(*task, times, history->manifest().time_unit);
  ContentHash hash = begin_key(*task, times);
  hash.add(transfer::history_content_key(*history));
  for (const std::string& label : labels) hash.add(label);
  const std::pair<int, int> size = history_size(*task, history->manifest());
  const bool is_scaled = size != std::pair(history->manifest().width, history->manifest().height);
  if (is_scaled) hash.add("scaled").add(std::int64_t{size.first}).add(std::int64_t{size.second});
  OutputWork work =
      picture_work(*task, hash.hex(), [history, times, labels, size, is_scaled](const RunControl& control) {
        std::vector<ImageF> pictures;
        for (double t : times) {
          control.throw_if_stopped();
          ImageF picture = history->sample(t);
          if (is_scaled)
            picture = size.first < picture.width() ? downscale_area(picture, size.first, size.second)
                                                   : resize_bilinear(picture, size.first, size.second);
          pictures.push_back(std::move(picture));
        }
        return pictures.size() == 1 ? pictures.front() : contact_strip(pictures, labels);
      });
  work.notes = std::move(notes);
  return work;
}

/// @throws UsageError
double picture_unit(const RenderTask& task) {
  return mm_per_unit(!task.unit.empty() ? task.unit : is_gltf_file(task.subject) ? "m" : "mm");
}

OutputWork mesh_work(const SharedTask& task) {
  if (is_series(task->output) && !task->has_views())
    throw UsageError("-o: a mesh with a texture does not age; give a transfer, or --turntable");
  if (task->files.color.empty()) throw UsageError("--texture: is missing; a mesh is rendered with an image");
  const Mesh mesh = read_mesh(task->subject);
  UvLayout layout = find_uv_layout(mesh);
  if (layout.tiles.empty())
    throw IoError(task->subject.string(), layout.problem + "; a texture needs UVs in [0, 1] or in tiles");
  const AtlasMesh atlas = atlas_mesh_of(mesh, std::move(layout));
  const double unit_mm = picture_unit(*task);
  ContentHash hash = begin_key(*task, {});
  hash.add(mesh_content_key(mesh));
  task->files.add_to(hash, atlas);
  const bool is_surface = task->files.has_more() || !task->environment.empty();
  if (is_surface) {
    add_surface(hash, *task);
    hash.add(unit_mm);
  }
  const auto over_sheet = std::make_shared<Mesh>();
  const auto maps = std::make_shared<const SurfaceMaps>(
      is_surface ? read_surface_maps(atlas, task->files, unit_mm, *over_sheet)
                 : SurfaceMaps{.color = read_color_map(atlas, task->files, *over_sheet)});
  std::function<SurfaceMaps(double, const RunControl&)> all;
  if (is_surface) all = [maps](double, const RunControl&) { return *maps; };
  const auto studio = std::make_shared<PictureStudio>(
      task, over_sheet, [maps](double, const RunControl&) { return maps->color; }, all);
  OutputWork work = views_work(*task, hash.hex(), studio, 0.0);
  note_near_light(task->options, mesh, work.notes);
  return work;
}

}  // namespace

void describe(OptionVisitor& v, TurnOptions& o) {
  v.visit({"turn", "Movies: angle by which the camera orbits the object, to its left; 360 is a full turn", "deg",
           between(-36000, 36000)},
          o.turn_deg);
}

void describe(OptionVisitor& v, ShownOptions& o) {
  v.visit_choice({"maps", "Maps to show: all of them, or only color under one coat"}, o.maps, kShownMapsNames);
  v.visit({"film", "Simulations: amount of water at which a place is fully wet", "", above(0)}, o.film);
  describe(v, o.flakes);
}

void check_task(const RenderTask& task) {
  RenderOptions options = task.options;
  task.views.apply_to(options);
  if (task.has_views()) (void)task.views.resolve(options);
  if (task.output.empty() || is_movie(task.output)) return;
  std::vector<std::string> known = image_extensions();
  if (!is_series(task.output)) known.insert(known.end(), movie_extensions().begin(), movie_extensions().end());
  require_extension(task.output, known);
}

OutputWork render_work(RenderTask given) {
  check_task(given);
  given.views.apply_to(given.options);
  const auto task = std::make_shared<const RenderTask>(std::move(given));
  if (task->mesh) return aging_mesh_pictures(task);
  switch (kind_of(task->subject)) {
    case PathKind::Transfer:
    case PathKind::Simulation:
      return aging_mesh_pictures(task);
    case PathKind::History:
      return history_pictures(task);
    case PathKind::Mesh:
      return mesh_work(task);
    default:
      throw InvalidInput(task->subject.string() + ": is no transfer, simulation, history or mesh");
  }
}

}  // namespace patinate::app
