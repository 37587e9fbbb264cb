#include "tests/capture/gloss/plate_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "capture/gloss/gloss_rig.h"
#include "capture/timelapse/ingest.h"
#include "datasets_synthetic/plate_io.h"
#include "datasets_synthetic/project_io.h"
#include "libcommon/core/median.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"

namespace patinate::testing_support {

namespace {

struct Sum {
  double off = 0.0, truth = 0.0, count = 0.0;
  [[nodiscard]] double share() const { return count > 0.0 ? off / std::max(truth, 0.05 * count) : 0.0; }
};

double angle_of(const datasets::GlossyPlate& plate, int frame, int x, int y) {
  const Vec3 p = plate.position(x, y), half = direction_to(plate.lamp(frame), p) + (plate.camera() - p).normalized();
  return std::atan2(std::hypot(half.x(), half.y()), half.z());
}

PlateErrors errors_of(const datasets::GlossyPlate& plate, const HistoryReader& history, const ImageF& photo,
                      int frame) {
  const int size = plate.options().size;
  const ImageF found = history.read_frame(frame);
  const std::optional<ImageF> specular = history.read_frame_extra(frame, "specular"),
                              metalness = history.read_frame_extra(frame, "metalness"),
                              tint = history.read_frame_extra(frame, "tint");
  const ImageU8 mask = history.read_mask();
  std::vector<double> angles;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) angles.push_back(angle_of(plate, frame, x, y));
  std::vector<double> sorted = angles;
  const double near = value_at_rank(sorted, sorted.size() / 10);
  Sum all, all_lambert, close, close_lambert;
  std::vector<double> roughness, f0;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      if (!is_inside(mask, x, y)) continue;
      const datasets::PlateLook look = plate.look(x, y, frame);
      const Vec3 p = plate.position(x, y);
      const Light lamp = plate.lamp(frame);
      const double metal = metalness ? static_cast<double>(metalness->at(x, y)) : 0.0;
      for (int c = 0; c < 3; ++c) {
        const double color = static_cast<double>(found.at(x, y, c)),
                     mirror = tint ? static_cast<double>(tint->at(x, y, c)) : 1.0;
        const double base = (1.0 - metal) * color + metal * (mirror > 0.0 ? mirror : 1.0),
                     albedo = (1.0 - metal) * base;
        const double matt = light_at(lamp, p)[c] * direction_to(lamp, p).z() / M_PI,
                     seen = static_cast<double>(photo.at(x, y, c)) / matt;
        const bool is_close = angles[y * size + x] < near;
        for (const auto& [sum, value] :
             {std::pair{&all, albedo}, std::pair{&all_lambert, seen}, std::pair{is_close ? &close : nullptr, albedo},
              std::pair{is_close ? &close_lambert : nullptr, seen}}) {
          if (sum == nullptr) continue;
          sum->off += std::abs(value - look.albedo[c]);
          sum->truth += look.albedo[c];
          sum->count += 1.0;
        }
      }
      if (!specular || look.patina > 0.05) continue;
      roughness.push_back(static_cast<double>(specular->at(x, y, 1)) - look.polish_roughness);
      double mirror = (1.0 - metal) * static_cast<double>(specular->at(x, y, 0));
      for (int c = 0; c < 3 && metal > 0.0; ++c) mirror += metal * static_cast<double>(tint->at(x, y, c)) / 3.0;
      f0.push_back(mirror / look.polish_f0.mean() - 1.0);
    }
  }
  PlateErrors errors{.albedo = all.share(),
                     .lambert = all_lambert.share(),
                     .albedo_near = close.share(),
                     .lambert_near = close_lambert.share()};
  if (!roughness.empty()) errors.roughness = median(std::move(roughness));
  if (!f0.empty()) errors.f0 = median(std::move(f0));
  return errors;
}

}  // namespace

PlateRun ingested_plate(const datasets::PlateOptions& options, const std::filesystem::path& folder,
                        const std::function<void(Json&)>& change) {
  run_job(datasets::plan_plate(options, folder / "plate"), {}, {});
  const std::filesystem::path file = folder / "plate/capture.json";
  if (change) {
    Json json = load_json(file);
    change(json);
    save_json(file, json);
  }
  run_job(capture::plan_ingest(capture::read_capture_project(file), {}, folder / "history"), {}, {});
  const HistoryReader history(folder / "history");
  PlateRun run{.history = load_json(folder / "history/history.json")};
  if (std::filesystem::exists(folder / "history/gloss.json")) run.gloss = load_json(folder / "history/gloss.json");
  const datasets::GlossyPlate plate(options);
  for (int i = 0; i < options.num_frames; ++i)
    run.errors.push_back(errors_of(plate, history, read_color(folder / "plate" / datasets::photo_file(i)), i));
  return run;
}

void print_errors(const std::string& name, const PlateRun& run) {
  std::printf("%s\n", name.c_str());
  for (std::size_t i = 0; i < run.errors.size(); ++i) {
    const PlateErrors& e = run.errors[i];
    std::printf(
        "  %2zu: roughness %+.3f, F0 %+5.1f %%, albedo %4.1f (Lambert %4.1f), near the mirror %4.1f (%5.1f) %%\n", i,
        e.roughness, 100.0 * e.f0, 100.0 * e.albedo, 100.0 * e.lambert, 100.0 * e.albedo_near, 100.0 * e.lambert_near);
  }
  if (!run.gloss.contains("materials")) return;
  for (const Json& m : run.gloss.at("materials")) {
    std::printf("  share %.2f, saved %.0f", m.at("share").get<double>(), m.at("saved").get<double>());
    if (m.contains("at")) {
      for (const std::size_t i : {std::size_t{0}, m.at("at").size() / 2, m.at("at").size() - 1}) {
        const Json& at = m.at("at").at(i);
        std::printf("; r %.3f +- %.3f, F0 %.3f +- %.3f", at.at("roughness").get<double>(),
                    at.at("roughness_deviation").get<double>(), at.at("f0").get<double>(),
                    at.at("f0_deviation").get<double>());
      }
    }
    std::printf("\n");
  }
}

}  // namespace patinate::testing_support
