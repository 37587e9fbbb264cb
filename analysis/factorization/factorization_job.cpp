#include "analysis/factorization/factorization_job.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "analysis/factorization/factorization_work.h"
#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/analysis/texture_series.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

bool has_extra(const FrameFacts& frame, const std::string& name) {
  return std::find(frame.extras.begin(), frame.extras.end(), name) != frame.extras.end();
}

/// Names of the quantities that every frame has.
std::string quantities_of(const HistoryFacts& facts) {
  std::string list = "color";
  for (const FactorQuantity q :
       {FactorQuantity::Roughness, FactorQuantity::Specular, FactorQuantity::Metalness, FactorQuantity::Height}) {
    if (std::all_of(facts.frames.begin(), facts.frames.end(),
                    [&](const FrameFacts& f) { return has_extra(f, place_of(q).extra); }))
      list += ", " + name_of(q);
  }
  return list;
}

constexpr std::int64_t kStageVersion = 4;  ///< Raised when the same input gives other figures.
// For progress, in what the factors of one pixel take, as measured on 400 x 300 pixels at 40 times: the curve is sought
// at a fixed number of places.
constexpr double kCurveWeight = 1.5e6, kMapsWeight = 0.1, kFrameWeight = 0.1, kJoinWeight = 0.5;

/// Inputs of curve and maps: not the times that are asked for.
JobInputs model_inputs(const FactorizationTask& task) {
  JobInputs inputs("factorize", kStageVersion);
  inputs.add_content("history", "the history", open_series(task.history).key());
  inputs.add_options(option_values(task.options));
  if (task.of != FactorQuantity::Color) inputs.add_value("--of", name_of(task.of));
  return inputs;
}

std::string frame_key(const std::string& model_key, int index, const FactoredFrame& frame) {
  ContentHash hash;
  return hash.add(model_key).add(std::int64_t{index}).add(frame.time).hex();
}

}  // namespace

std::string name_of(FactorQuantity quantity) {
  return std::string(kFactorQuantityNames[static_cast<std::size_t>(quantity)]);
}

FactorQuantity parse_factor_quantity(const std::string& name) {
  const auto found = std::find(kFactorQuantityNames.begin(), kFactorQuantityNames.end(), name);
  if (found == kFactorQuantityNames.end())
    throw InvalidInput("of: found `" + name + "`; expected color, roughness, specular, metalness or height");
  return static_cast<FactorQuantity>(found - kFactorQuantityNames.begin());
}

QuantityPlace place_of(FactorQuantity quantity) {
  if (quantity == FactorQuantity::Specular) return {"specular", 0};
  if (quantity == FactorQuantity::Roughness) return {"specular", 1};
  return {name_of(quantity), 0};
}

QuantityHistory::QuantityHistory(const HistoryReader& source, FactorQuantity quantity)
    : source_(source), quantity_(quantity), facts_(source.facts()) {
  for (FrameFacts& frame : facts_.frames) {
    if (!has_extra(frame, place_of(quantity).extra))
      throw InvalidInput(source.label() + ": not every frame has a map of " + name_of(quantity) +
                         "; all of them have " + quantities_of(source.facts()));
    frame.extras.clear();
    frame.has_mask = frame.has_mask || quantity == FactorQuantity::Roughness;
  }
}

ImageF QuantityHistory::load_frame(std::size_t frame) const {
  const QuantityPlace place = place_of(quantity_);
  const ImageF map = *source_.read_frame_extra(static_cast<int>(frame), place.extra);
  ImageF out(map.width(), map.height(), 3);
  for (std::int64_t i = 0; i < map.num_pixels(); ++i)
    std::fill_n(out.data() + 3 * i, 3, map.data()[i * map.channels() + place.channel]);
  return out;
}

ImageF QuantityHistory::load_frame_extra(std::size_t frame, std::size_t extra) const {
  return *source_.read_frame_extra(static_cast<int>(frame), facts_.frames[frame].extras[extra]);
}

ImageU8 QuantityHistory::load_frame_mask(std::size_t frame) const {
  ImageU8 mask = source_.read_frame_mask(static_cast<int>(frame));
  if (quantity_ != FactorQuantity::Roughness) return mask;
  const ImageF roughness = load_frame(frame);
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (!(roughness.data()[3 * i] > 0.0f)) mask.data()[i] = 0;
  }
  return mask;
}

JobPlan plan_factorization(FactorizationTask task, const fs::path& output) {
  JobInputs inputs = model_inputs(task);
  const std::string model_key = inputs.key();
  const auto work = std::make_shared<FactorizationWork>(std::move(task));
  for (const FactoredFrame& f : work->frames) {
    if (f.source < 0) inputs.add_value("--times " + number_text(f.time), number_text(f.time));
  }
  JobPlan plan = inputs.plan(output, kFactorizationManifestFile);
  work->key = plan.key;
  plan.parallel_items = false;
  const double pixels = static_cast<double>(work->width()) * work->height(),
               models = static_cast<double>(work->num_models());
  plan.items.push_back(
      {.name = "curve",
       .outputs = {work_file("curve.json")},
       .run = [work](const fs::path& folder, const RunControl& control) { make_curve(*work, folder, control); },
       .key = model_key,
       .weight = kCurveWeight * models});
  if (work->looks_ahead()) {
    plan.items.push_back({.name = "forecast",
                          .outputs = {work_file("forecast.json")},
                          .run = [work](const fs::path& folder,
                                        const RunControl& control) { make_forecast_file(*work, folder, control); },
                          .key = model_key,
                          .weight = kCurveWeight * models});
  }
  for (int band = 0; band < work->num_bands(); ++band) {
    const std::string name = "rows." + std::to_string(band);
    plan.items.push_back({.name = name,
                          .outputs = {work_file(name + ".exr")},
                          .run = [work, band](const fs::path& folder,
                                              const RunControl& control) { make_rows(*work, band, folder, control); },
                          .key = model_key,
                          .stage = 1,
                          .weight = models * pixels / work->num_bands()});
  }
  plan.items.push_back({.name = "maps",
                        .outputs = map_outputs(*work),
                        .run = [work](const fs::path& folder, const RunControl&) { make_maps(*work, folder); },
                        .key = model_key,
                        .stage = 2,
                        .weight = kMapsWeight * pixels,
                        .optional_outputs = {rate_control_file(*work)}});
  for (int i = 0; i < static_cast<int>(work->frames.size()); ++i) {
    const FactoredFrame& frame = work->frames[i];
    const std::string name = "frame." + std::to_string(i);
    std::vector<fs::path> outputs{work_file(name + ".json"), "history" / HistoryWriter::frame_file(i)};
    for (const fs::path& file : files_beside(*work, i)) outputs.push_back("history" / file);
    plan.items.push_back(
        {.name = name,
         .outputs = std::move(outputs),
         .run = [work, i](const fs::path& folder, const RunControl& control) { make_frame(*work, i, folder, control); },
         .key = frame_key(model_key, i, frame),
         .stage = 3,
         .weight = kFrameWeight * pixels});
  }
  plan.join_weight = kJoinWeight * pixels;
  plan.join = [work](const fs::path& folder, const RunControl& control) {
    write_factorization(*work, folder, control);
  };
  return plan;
}

}  // namespace patinate::analysis
