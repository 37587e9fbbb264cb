#include "capture/timelapse/patch_step.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/timelapse/align_step.h"
#include "capture/timelapse/chart_step.h"
#include "capture/timelapse/frame_photo.h"
#include "capture/timelapse/ingest_warnings.h"
#include "capture/timelapse/repair.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kPatchVersion = 1;
constexpr int kCells = 3;                ///< A side, for what one factor does not explain.
constexpr double kMinPatchShown = 0.25;  ///< Share of the patch.
constexpr double kMaxSaturated = 0.1;    ///< Share of what is shown.
constexpr double kMaxResidual = 0.03;    ///< Relative: a just noticeable step of a gray card.
using Color = std::array<double, 3>;

/// Patch in a photograph.
struct PatchColor {
  Color mean{};
  std::array<std::optional<Color>, kCells* kCells> cells = {};
};

/// Mean of the values without the tenths at both ends.
double middle_mean(std::vector<float> values) {
  std::sort(values.begin(), values.end());
  const std::size_t cut = values.size() / 10;
  double sum = 0.0;
  for (std::size_t i = cut; i < values.size() - cut; ++i) sum += static_cast<double>(values[i]);
  return sum / static_cast<double>(values.size() - 2 * cut);
}

struct Samples {
  std::array<std::vector<float>, 3> values;

  void add(std::span<const float> rgb) {
    for (std::size_t c = 0; c < 3; ++c) values[c].push_back(rgb[c]);
  }
  [[nodiscard]] Color mean() const { return {middle_mean(values[0]), middle_mean(values[1]), middle_mean(values[2])}; }
};

std::optional<PatchColor> measure(const IngestWork& work, int index, const fs::path& folder) {
  const CaptureProject& project = work.project;
  const PixelRectangle& patch = *project.reference_patch;
  const CapturePhoto& photo = project.frames[index];
  const ImageF whole = read_whole_photo(project, photo);
  ImageU8 shown;
  const ImageF color = lay_in_rectangle(work, index, folder, whole, patch, shown);
  const SaturationPhoto by_sensor = saturation_photo(project, photo, whole);
  const ImageF sensor = lay_in_rectangle(work, index, folder, by_sensor.photo, patch, shown);
  Samples all;
  std::array<Samples, kCells * kCells> cells;
  int num_shown = 0, num_saturated = 0;
  for (int y = 0; y < patch.height; ++y) {
    for (int x = 0; x < patch.width; ++x) {
      if (shown.at(x, y) == 0) continue;
      ++num_shown;
      const auto rgb = color.pixel(x, y);
      const auto codes = sensor.pixel(x, y);
      if (*std::max_element(codes.begin(), codes.end()) >= by_sensor.level) {
        ++num_saturated;
        continue;
      }
      all.add(rgb);
      cells[y * kCells / patch.height * kCells + x * kCells / patch.width].add(rgb);
    }
  }
  const bool is_seen =
      num_shown > kMinPatchShown * patch.width * patch.height && num_saturated <= kMaxSaturated * num_shown;
  if (!is_seen) return std::nullopt;
  PatchColor result{.mean = all.mean()};
  if (!(*std::min_element(result.mean.begin(), result.mean.end()) > 0.0)) return std::nullopt;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (!cells[k].values[0].empty()) result.cells[k] = cells[k].mean();
  }
  return result;
}

/// Root mean square relative difference that is left between the cells of two patches.
double residual_of(const PatchColor& color, const Color& gain, const PatchColor& reference) {
  double sum = 0.0, count = 0.0;
  for (std::size_t k = 0; k < color.cells.size(); ++k) {
    if (!color.cells[k] || !reference.cells[k]) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const double there = (*reference.cells[k])[c];
      if (!(there > 0.0)) continue;
      const double d = gain[c] * (*color.cells[k])[c] / there - 1.0;
      sum += d * d;
      count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

void measure_all(const IngestWork& work, const fs::path& folder, const RunControl& control) {
  const CaptureProject& project = work.project;
  const std::vector<std::string> names = photo_names(project.frames);
  std::vector<std::optional<PatchColor>> colors(project.frames.size());
  parallel_for(static_cast<std::int64_t>(colors.size()), 1, control, [&](std::int64_t begin, std::int64_t) {
    colors[begin] = measure(work, static_cast<int>(begin), folder);
  });
  const auto& reference = colors[project.reference];
  if (!reference)
    throw IoError(
        project.file.string(),
        "`reference_patch` is saturated, black or not shown in the reference photograph, " + names[project.reference]);
  Json photos = Json::array();
  for (std::size_t i = 0; i < colors.size(); ++i) {
    Json entry{{"photo", names[i]}, {"number", project.frames[i].number}, {"is_seen", colors[i].has_value()}};
    if (colors[i]) {
      Color gain{};
      for (std::size_t c = 0; c < 3; ++c) gain[c] = reference->mean[c] / colors[i]->mean[c];
      entry["factors"] = gain;
      entry["residual"] = residual_of(*colors[i], gain, *reference);
    }
    photos.push_back(std::move(entry));
  }
  save_json(folder / kPatchFile, Json{{"photos", photos}});
}

std::string patch_key(const IngestWork& work) {
  const PixelRectangle& p = *work.project.reference_patch;
  ContentHash hash;
  hash.add("reference patch").add(kPatchVersion).add(work.project.response.text());
  for (int v : {p.x, p.y, p.width, p.height, work.project.reference}) hash.add(std::int64_t{v});
  for (std::size_t i = 0; i < work.photo_keys.size(); ++i) hash.add(work.photo_keys[i]).add(place_key(work, i));
  return hash.hex();
}

/// 1 without exposures in both photographs.
double exif_gain(const IngestWork& work, int index) {
  const CaptureProject& project = work.project;
  if (project.chart || (!project.is_handheld() && !project.reference_patch)) return 1.0;
  const CapturePhoto& photo = project.frames[index];
  const bool is_linear = !photo.has_codes || project.response.kind == Response::Kind::Linear;
  const double here = photo.exposure.amount();
  const double there = project.frames[project.reference].exposure.amount();
  return is_linear && here > 0.0 && there > 0.0 ? there / here : 1.0;
}

std::optional<Color> patch_gain(const IngestWork& work, int index, const fs::path& folder) {
  if (!work.project.reference_patch) return std::nullopt;
  GainTable& table = *work.gains;
  const std::lock_guard lock(table.mutex);
  if (!table.is_loaded) {
    const Json json = load_json(folder / kPatchFile);
    for (const Json& photo : json.at("photos")) {
      if (photo.contains("factors")) table.gains[photo.at("number").get<int>()] = photo.at("factors").get<Color>();
    }
    table.is_loaded = true;
  }
  const auto found = table.gains.find(work.project.frames[index].number);
  return found == table.gains.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

bool divides_exif_exposure(const IngestWork& work) {
  for (std::size_t i = 0; i < work.project.frames.size(); ++i) {
    if (exif_gain(work, static_cast<int>(i)) != 1.0) return true;
  }
  return false;
}

void add_patch_item(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work) {
  if (!work->project.reference_patch) return;
  items.push_back({.name = "reference-patch",
                   .outputs = {kPatchFile},
                   .run =
                       [work](const fs::path& folder, const RunControl& control) {
                         measure_all(*work, folder, control);
                         control.report(1.0);
                       },
                   .key = patch_key(*work),
                   .stage = needs_alignment(*work) ? 1 : 0,
                   .weight = 0.03 + 7e-8 * num_photo_pixels(work->project)});  // core seconds
}

std::string gain_key(const IngestWork& work, std::size_t index) {
  ContentHash hash;
  const double exif = exif_gain(work, static_cast<int>(index));
  if (work.project.reference_patch) hash.add(patch_key(work));
  if (exif != 1.0) hash.add("exposure by EXIF").add(exif);
  if (work.project.chart) hash.add(chart_key(work));
  return work.project.reference_patch || work.project.chart || exif != 1.0 ? hash.hex() : "";
}

void add_patch_inputs(JobInputs& inputs, const IngestWork& work) {
  if (work.project.reference_patch) inputs.add_value("reference_patch", patch_key(work));
}

Color light_gain(const IngestWork& work, int index, const fs::path& folder) {
  if (const auto gain = patch_gain(work, index, folder)) return *gain;
  const double exif = exif_gain(work, index);
  return {exif, exif, exif};
}

std::vector<HistoryWarning> report_patch(const IngestWork& work, const fs::path& folder) {
  std::vector<HistoryWarning> warnings;
  if (!work.project.reference_patch) return warnings;
  const Json photos = load_json(folder / kPatchFile).at("photos");
  if (fs::exists(folder / kSurveyFile)) {
    Json survey = load_json(folder / kSurveyFile);
    survey["reference_patch"] = photos;
    save_json(folder / kSurveyFile, survey);
  }
  std::vector<std::string> unseen, uneven;
  double worst = 0.0;
  std::string worst_name;
  for (const Json& photo : photos) {
    const std::string name = photo.at("photo").get<std::string>();
    if (!photo.contains("factors")) {
      unseen.push_back(name);
      continue;
    }
    const double residual = photo.at("residual").get<double>();
    if (!(residual > kMaxResidual)) continue;
    uneven.push_back(name);
    if (residual <= worst) continue;
    worst = residual;
    worst_name = name;
  }
  const double count = static_cast<double>(photos.size());
  if (!unseen.empty())
    warnings.push_back({.about = WarningSubject::Light,
                        .text = "the `reference_patch` is saturated or not shown in " + std::to_string(unseen.size()) +
                                " of " + std::to_string(photos.size()) + " photographs (" + photo_list(unseen) +
                                "): their light is left as it is, but for the exposure by EXIF where codes are linear",
                        .cure = "a patch that all photographs show, or leave them out (`exclude`)",
                        .share = static_cast<double>(unseen.size()) / count,
                        .photos = unseen});
  if (!uneven.empty())
    warnings.push_back({.about = WarningSubject::Light,
                        .text = "no one factor brings the `reference_patch` back in " + std::to_string(uneven.size()) +
                                " of " + std::to_string(photos.size()) + " photographs (" + photo_list(uneven) +
                                "): in " + worst_name + " its parts differ by " + fixed_percent_text(worst) +
                                " after it, by uneven light or because it lies elsewhere",
                        .cure = "a smaller patch, flatter light, or a patch that lies beside what ages",
                        .share = 0.5 * static_cast<double>(uneven.size()) / count,
                        .photos = uneven});
  return warnings;
}

}  // namespace patinate::capture
