#include "analysis/factorization/factorization_work.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/factorization/factorization_document.h"
#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "patinate/metrics/difference.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr double kBandBytes = 96e6;
constexpr int kLattice = 64;  ///< Pixels that the curve is sought in, a side.
constexpr std::int64_t kPixelsAtATime = 4096;
constexpr double kLargestHeight_mm = 65504.0;  ///< Largest finite half float.

/// Share of what changes that the curve covers at a time. @throws InvalidInput when that is nothing.
double covered_share(const FactorizationWork::Factored& f, const ImageU8& covered, double time) {
  double changing = 0.0, known = 0.0, last = -1e300;
  for (std::int64_t i = 0; i < covered.num_pixels(); ++i) {
    double end = 1e300;
    bool is_otherwise = false;
    for (std::size_t m = 0; m < f.models.size(); ++m) {
      const PlaceFactors p = factors_at(f.image, i, m, f.models.size());
      is_otherwise = is_otherwise || p.status == PlaceStatus::Otherwise;
      if (p.status == PlaceStatus::Fitted || p.status == PlaceStatus::Open)
        end = std::min(end, (f.models[m].curve.high + p.offset) / p.rate);
    }
    if (is_otherwise) changing += 1.0;
    if (end == 1e300 || is_otherwise) continue;
    changing += 1.0, known += covered.data()[i] != 0 ? 1.0 : 0.0, last = std::max(last, end);
  }
  if (known == 0.0)
    throw InvalidInput("times: " + number_text(time) +
                       " is beyond what any place tells of any other; the slowest place is covered until " +
                       short_number_text(rounded(last, 4)));
  return known / changing;
}

}  // namespace

fs::path work_file(const std::string& name) { return fs::path(kJobWorkFolder) / name; }

FactorizationWork::FactorizationWork(FactorizationTask asked)
    : task(std::move(asked)), history(task.history), mask(history.read_mask()) {
  check_ranges(task.options);
  if (!is_color()) {
    map.emplace(history, task.of);
    if (task.options.clock == FactorClock::Channels)
      throw InvalidInput("clock: a map of " + name_of(task.of) + " has one channel; expected shared");
    if (!task.times.empty())
      throw InvalidInput("times: a history of more times is made of its color only, not of its " + name_of(task.of));
  }
  const HistoryManifest& m = history.manifest();
  const int count = history.num_frames();
  if (count < kLeastFrames) {
    throw InvalidInput(task.history.string() + ": has " + (count == 1 ? "1 frame" : std::to_string(count) + " frames") +
                       "; a curve with rates and offsets needs at least " + std::to_string(kLeastFrames));
  }
  for (int i = 0; i < count; ++i) {
    const HistoryFrame& frame = m.frames[i];
    if (frame.is_extrapolated)
      throw InvalidInput(frame.file.string() + ": is extrapolated, not observed; factorize the original history");
    frames.push_back({.time = frame.time, .source = i});
  }
  for (const double t : task.times) {
    if (!std::isfinite(t)) throw InvalidInput("times: " + number_text(t) + " is no time");
    if (std::any_of(frames.begin(), frames.end(), [&](const FactoredFrame& f) { return f.time == t; })) continue;
    frames.push_back(
        {.time = t, .source = -1, .is_extrapolated = t < m.frames.front().time || t > m.frames.back().time});
  }
  std::sort(frames.begin(), frames.end(),
            [](const FactoredFrame& a, const FactoredFrame& b) { return a.time < b.time; });
  std::vector<double> times;
  for (const FactoredFrame& f : frames) times.push_back(f.time);
  if (const auto problem = find_time_problem(times))
    throw InvalidInput("times: beside its own frames the denoised history " + problem->text);
}

int FactorizationWork::rows_per_band() const {
  const double row = 3.0 * sizeof(float) * width() * history.num_frames();
  return std::clamp(static_cast<int>(kBandBytes / row), 1, height());
}

const FactorizationWork::Factored& FactorizationWork::factored(const fs::path& folder) {
  const std::scoped_lock lock(mutex_);
  if (!factored_) {
    factored_ = Factored{read_models(folder / work_file("models.json")),
                         read_channels(folder / work_file("factors.exr"), factor_channel_names(num_models()))};
  }
  return *factored_;
}

namespace {

/// Series of pixels on a lattice: those that the curve is sought in.
PlaceSeries lattice_series(FactorizationWork& work, const RunControl& control) {
  std::vector<std::uint32_t> pixels;
  const int step_x = std::max(1, work.width() / kLattice), step_y = std::max(1, work.height() / kLattice);
  for (int y = step_y / 2; y < work.height(); y += step_y) {
    for (int x = step_x / 2; x < work.width(); x += step_x) {
      if (work.mask.at(x, y) != 0)
        pixels.push_back(static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(work.width()) +
                         static_cast<std::uint32_t>(x));
    }
  }
  if (pixels.empty()) throw InvalidInput(work.task.history.string() + ": its mask leaves nothing to fit a curve to");
  return place_series(work.values(), pixels, control);
}

}  // namespace

void make_forecast_file(FactorizationWork& work, const fs::path& folder, const RunControl& control) {
  const PlaceSeries series = lattice_series(work, control.part(0.0, 0.02));
  fs::create_directories(folder / kJobWorkFolder);
  save_json(folder / work_file("forecast.json"),
            forecast_json(make_forecast(series, work.task.options, control.part(0.02, 1.0))));
}

std::optional<Forecast> read_forecast(const FactorizationWork& work, const fs::path& folder) {
  if (!work.looks_ahead()) return std::nullopt;
  return forecast_from_json(load_json(folder / work_file("forecast.json")));
}

void make_curve(FactorizationWork& work, const fs::path& folder, const RunControl& control) {
  const PlaceSeries series = lattice_series(work, control.part(0.0, 0.02));
  std::vector<TemporalModel> models;
  for (std::size_t m = 0; m < work.num_models(); ++m) {
    const RunControl part =
        control.part(0.02 + 0.98 * static_cast<double>(m) / static_cast<double>(work.num_models()),
                     0.02 + 0.98 * (static_cast<double>(m) + 1.0) / static_cast<double>(work.num_models()));
    models.push_back(
        train_curve(work.num_models() == 1 ? series : series.channel(static_cast<int>(m)), work.task.options, part));
  }
  fs::create_directories(folder / kJobWorkFolder);
  save_models(folder / work_file("curve.json"), models);
}

void make_rows(FactorizationWork& work, int band, const fs::path& folder, const RunControl& control) {
  const std::vector<TemporalModel> models = read_models(folder / work_file("curve.json"));
  const int first = band * work.rows_per_band(), rows = std::min(work.rows_per_band(), work.height() - first);
  std::vector<std::uint32_t> pixels, places;
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(rows) * static_cast<std::uint32_t>(work.width()); ++i) {
    const std::uint32_t pixel = static_cast<std::uint32_t>(first) * static_cast<std::uint32_t>(work.width()) + i;
    if (work.mask.data()[pixel] != 0) pixels.push_back(pixel), places.push_back(i);
  }
  std::vector<std::vector<PlaceFactors>> all(
      models.size(),
      std::vector<PlaceFactors>(static_cast<std::size_t>(rows) * static_cast<std::size_t>(work.width())));
  const PlaceSeries series = place_series(work.values(), pixels, control.part(0.0, 0.2));
  for (std::size_t m = 0; m < models.size(); ++m) {
    const double share = 0.8 / static_cast<double>(models.size()), begin = 0.2 + share * static_cast<double>(m);
    const std::vector<PlaceFactors> made = fit_places(models.size() == 1 ? series : series.channel(static_cast<int>(m)),
                                                      models[m], work.task.options, control.part(begin, begin + share));
    for (std::size_t i = 0; i < made.size(); ++i) all[m][places[i]] = made[i];
  }
  write_exr(folder / work_file("rows." + std::to_string(band) + ".exr"), factor_image(work.width(), rows, all),
            factor_channel_names(models.size()), ExrDepth::Float);
  control.report(1.0);
}

namespace {

/// A frame of the source with one of its maps as curve and maps make it, where that is known.
void write_frame_with_map(const FactorizationWork& work, int index, const ImageF& made, const ImageF& factors,
                          const fs::path& history) {
  const int source = work.frames[index].source;
  const FrameFacts& facts = work.history.facts().frames[source];
  write_exr(history / HistoryWriter::frame_file(index), work.history.read_frame(source), {"R", "G", "B"},
            ExrDepth::Half);
  if (facts.has_mask) {
    fs::create_directories((history / HistoryWriter::frame_mask_file(index)).parent_path());
    write_codes(history / HistoryWriter::frame_mask_file(index), work.history.read_frame_mask(source));
  }
  const QuantityPlace place = place_of(work.task.of);
  const bool is_share = work.task.of == FactorQuantity::Roughness || work.task.of == FactorQuantity::Metalness;
  for (const std::string& name : facts.extras) {
    ImageF image = *work.history.read_frame_extra(source, name);
    for (std::int64_t i = 0; i < image.num_pixels() && name == place.extra; ++i) {
      if (work.mask.data()[i] == 0 || factors_at(factors, i, 0, 1).status == PlaceStatus::Unseen) continue;
      image.data()[i * image.channels() + place.channel] =
          is_share ? std::min(1.0f, made.data()[3 * i]) : made.data()[3 * i];
    }
    HistoryWriter::write_frame_extra(history, index, name, image);
  }
}

}  // namespace

std::vector<fs::path> files_beside(const FactorizationWork& work, int index) {
  const FactoredFrame& frame = work.frames[index];
  std::vector<fs::path> files;
  const FrameFacts* facts = work.is_color() ? nullptr : &work.history.facts().frames[frame.source];
  if (frame.is_extrapolated || (facts != nullptr && facts->has_mask))
    files.push_back(HistoryWriter::frame_mask_file(index));
  if (facts != nullptr) {
    for (const std::string& name : facts->extras) files.push_back(HistoryWriter::frame_extra_file(index, name));
  }
  return files;
}

void make_frame(FactorizationWork& work, int index, const fs::path& folder, const RunControl& control) {
  const FactorizationWork::Factored& f = work.factored(folder);
  const FactoredFrame& asked = work.frames[index];
  // A curve without skill predicts the future worse than what was seen last.
  const double last = work.history.manifest().frames.back().time;
  const std::optional<Forecast> forecast = asked.time > last ? read_forecast(work, folder) : std::nullopt;
  const bool is_held = forecast && !forecast->has_skill();
  const double time = is_held ? last : asked.time;
  const int width = work.width(), height = work.height();
  const double lowest = work.task.of == FactorQuantity::Height ? -kLargestHeight_mm : 0.0;
  ImageF made(width, height, 3), source;
  ImageU8 covered(width, height), seen;
  if (asked.source >= 0)
    source = work.values().read_frame(asked.source), seen = work.values().read_frame_mask(asked.source);
  std::vector<float> differences(static_cast<std::size_t>(made.num_pixels()), -1.0f);  // CIEDE2000; -1 = not compared.
  parallel_for(made.num_pixels(), kPixelsAtATime, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const auto p = static_cast<std::size_t>(i);
      if (work.mask.data()[i] == 0) continue;
      const std::array<float, 3> v = factored_color(f.models, f.image, i, time, lowest);
      std::copy(v.begin(), v.end(), made.data() + 3 * i);
      covered.data()[i] = is_covered(f.models, f.image, i, asked.time) ? 255 : 0;
      const bool is_known = factors_at(f.image, i, 0, f.models.size()).status != PlaceStatus::Unseen;
      if (source.empty() || seen.data()[i] == 0 || !is_known) continue;
      const float* s = source.data() + 3 * i;
      const auto lab = [](float r, float g, float b) {
        return lab_from_linear(static_cast<double>(r), static_cast<double>(g), static_cast<double>(b));
      };
      differences[p] =
          work.is_color() ? static_cast<float>(ciede2000(lab(v[0], v[1], v[2]), lab(s[0], s[1], s[2]))) : 0.0f;
    }
  });
  fs::create_directories(folder / "history/frames");
  if (!work.is_color()) write_frame_with_map(work, index, made, f.image, folder / "history");
  if (work.is_color())
    write_exr(folder / "history" / HistoryWriter::frame_file(index), made, {"R", "G", "B"}, ExrDepth::Half);
  FrameRecord record{.time = asked.time, .covered_share = {}, .is_held = false, .error = {}};
  if (asked.is_extrapolated) {
    fs::create_directories(folder / "history/masks");
    write_codes(folder / "history" / HistoryWriter::frame_mask_file(index), covered);
    record.covered_share = rounded(covered_share(f, covered, asked.time), 6);
    record.is_held = is_held;
  }
  std::vector<float> list;
  double squares = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < differences.size(); ++i) {
    if (differences[i] < 0.0f) continue;
    list.push_back(differences[i]);
    sum += static_cast<double>(differences[i]);
    for (std::size_t c = 0; c < 3; ++c)
      squares += std::pow(static_cast<double>(made.data()[3 * i + c] - source.data()[3 * i + c]), 2);
  }
  if (!list.empty()) {
    const auto rank = static_cast<std::size_t>(0.95 * static_cast<double>(list.size() - 1));
    const auto n = static_cast<double>(list.size());
    record.error = FrameError{.num_pixels = static_cast<std::int64_t>(list.size()),
                              .rmse = rounded(std::sqrt(squares / (3.0 * n)), 6),
                              .ciede2000_mean = rounded(sum / n, 6),
                              .ciede2000_p95 = rounded(static_cast<double>(value_at_rank(list, rank)), 6),
                              .is_color = work.is_color()};
  }
  save_json(folder / work_file("frame." + std::to_string(index) + ".json"), object_json(described(record)));
  control.report(1.0);
}

}  // namespace patinate::analysis
