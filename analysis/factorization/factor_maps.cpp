// Bands of factors brought together, and written as maps and as what the denoised history has beside its frames.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/factorization/factorization_document.h"
#include "analysis/factorization/factorization_work.h"
#include "libcommon/image/filters.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr double kControlTail = 0.005;  ///< Share of rates beyond each end of the control's range.
const fs::path kHistory = "history";

bool changes(const PlaceFactors& f) {
  return f.status == PlaceStatus::Fitted || f.status == PlaceStatus::Open || f.status == PlaceStatus::Otherwise;
}

/// Every file of the source that the denoised history takes over.
std::vector<fs::path> taken_over(const HistoryManifest& m) {
  std::vector<fs::path> files;
  for (const ControlParameter& c : m.controls) files.push_back(c.file);
  for (const HistoryMap& map : m.maps) files.push_back(map.file);
  return files;
}

/// Image of a model's factors, by channel.
ImageF map_of(const ImageF& factors, std::size_t num_models, double (*value)(const PlaceFactors&)) {
  ImageF out(factors.width(), factors.height(), static_cast<int>(num_models));
  for (std::int64_t i = 0; i < out.num_pixels(); ++i) {
    for (std::size_t m = 0; m < num_models; ++m)
      out.data()[static_cast<std::size_t>(i) * num_models + m] =
          static_cast<float>(value(factors_at(factors, i, m, num_models)));
  }
  return out;
}

/// Three channels of the factor image from `first` on.
ImageF colors_of(const ImageF& factors, int first) {
  ImageF out(factors.width(), factors.height(), 3);
  for (std::int64_t i = 0; i < out.num_pixels(); ++i)
    std::copy_n(factors.data() + i * factors.channels() + first, 3, out.data() + 3 * i);
  return out;
}

/// The mean rate of a place's clocks, and where all of them are known.
void write_rate_control(const FactorizationWork& work, const ImageF& factors, HistoryWriter& writer) {
  ImageF rate(factors.width(), factors.height());
  ImageU8 known(factors.width(), factors.height()), unchanged = known;
  bool is_any = false;
  for (std::int64_t i = 0; i < rate.num_pixels(); ++i) {
    double sum = 0.0;
    bool is_known = true, is_still = true;
    for (std::size_t m = 0; m < work.num_models(); ++m) {
      const PlaceFactors f = factors_at(factors, i, m, work.num_models());
      sum += f.rate, is_known = is_known && f.status == PlaceStatus::Fitted, is_still = is_still && !changes(f);
    }
    rate.data()[i] = static_cast<float>(sum / static_cast<double>(work.num_models()));
    known.data()[i] = is_known ? 255 : 0, unchanged.data()[i] = is_still ? 255 : 0;
    is_any = is_any || is_known;
  }
  if (!is_any) return;
  const Percentiles range = percentiles(rate, known, kControlTail, 1.0 - kControlTail);
  for (std::int64_t i = 0; i < rate.num_pixels(); ++i) {
    if (unchanged.data()[i] != 0) rate.data()[i] = range.low;  // It does not age: the low end.
  }
  writer.write_control(rate_control_name(work.history.manifest()), rate, static_cast<double>(range.low),
                       static_cast<double>(range.high), "relative");
}

}  // namespace

std::vector<std::pair<std::string, fs::path>> factor_maps() {
  std::vector<std::pair<std::string, fs::path>> maps;
  for (const char* name : {"base", "gain", "rate", "offset", "rate_stddev", "residual"})
    maps.emplace_back(name, fs::path("maps") / (std::string(name) + ".exr"));
  for (const char* name : {"changes", "clock"})
    maps.emplace_back(name, fs::path("maps") / (std::string(name) + ".png"));
  return maps;
}

std::string rate_control_name(const HistoryManifest& history) {
  const auto is_taken = [&](const std::string& name) {
    return std::any_of(history.controls.begin(), history.controls.end(),
                       [&](const ControlParameter& c) { return c.name == name; });
  };
  std::string name = "rate";
  while (is_taken(name)) name = "factored_" + name;
  return name;
}

std::vector<fs::path> map_outputs(const FactorizationWork& work) {
  std::vector<fs::path> files{work_file("models.json"), work_file("factors.exr"), work_file("controls.json"),
                              kHistory / HistoryWriter::mask_file()};
  for (const auto& [name, file] : factor_maps()) files.push_back(file);
  for (const fs::path& file : taken_over(work.history.manifest())) files.push_back(kHistory / file);
  return files;
}

fs::path rate_control_file(const FactorizationWork& work) {
  return kHistory / HistoryWriter::control_file(rate_control_name(work.history.manifest()));
}

void make_maps(FactorizationWork& work, const fs::path& folder) {
  const std::size_t num_models = work.num_models();
  const std::vector<std::string> names = factor_channel_names(num_models);
  std::vector<TemporalModel> models = read_models(folder / work_file("curve.json"));
  std::vector<std::vector<PlaceFactors>> factors(num_models);
  for (int band = 0; band < work.num_bands(); ++band) {
    const ImageF rows = read_channels(folder / work_file("rows." + std::to_string(band) + ".exr"), names);
    for (std::int64_t i = 0; i < rows.num_pixels(); ++i) {
      for (std::size_t m = 0; m < num_models; ++m) factors[m].push_back(factors_at(rows, i, m, num_models));
    }
  }
  for (std::size_t m = 0; m < num_models; ++m) {
    const ClockGauge gauge = clock_gauge(factors[m]);
    apply_gauge(gauge, models[m].curve);
    apply_gauge(gauge, factors[m]);
  }
  const ImageF image = factor_image(work.width(), work.height(), factors);
  write_exr(folder / work_file("factors.exr"), image, names, ExrDepth::Float);
  save_models(folder / work_file("models.json"), models);

  fs::create_directories(folder / "maps");
  const std::vector<std::string> rgb{"R", "G", "B"}, of_clock = num_models == 1 ? std::vector<std::string>{"Y"} : rgb;
  const int after_models = image.channels() - 6;
  write_exr(folder / "maps/gain.exr", colors_of(image, after_models), rgb, ExrDepth::Float);
  write_exr(folder / "maps/base.exr", colors_of(image, after_models + 3), rgb, ExrDepth::Float);
  write_exr(folder / "maps/rate.exr", map_of(image, num_models, [](const PlaceFactors& f) { return f.rate; }), of_clock,
            ExrDepth::Float);
  write_exr(folder / "maps/offset.exr", map_of(image, num_models, [](const PlaceFactors& f) { return f.offset; }),
            of_clock, ExrDepth::Float);
  write_exr(folder / "maps/rate_stddev.exr",
            map_of(image, num_models, [](const PlaceFactors& f) { return f.rate_stddev; }), of_clock, ExrDepth::Float);
  write_exr(folder / "maps/residual.exr", map_of(image, num_models, [](const PlaceFactors& f) { return f.residual; }),
            of_clock, ExrDepth::Float);
  ImageU8 changed(work.width(), work.height()), clock = changed, known = changed;
  for (std::int64_t i = 0; i < changed.num_pixels(); ++i) {
    bool is_changing = false, is_fitted = true, is_known = work.mask.data()[i] != 0;
    for (std::size_t m = 0; m < num_models; ++m) {
      const PlaceFactors& f = factors[m][i];
      is_changing = is_changing || changes(f), is_fitted = is_fitted && f.status == PlaceStatus::Fitted,
      is_known = is_known && f.status != PlaceStatus::Unseen;
    }
    changed.data()[i] = is_changing ? 255 : 0, clock.data()[i] = is_fitted ? 255 : 0,
    known.data()[i] = is_known ? 255 : 0;
  }
  write_codes(folder / "maps/changes.png", changed);
  write_codes(folder / "maps/clock.png", clock);

  const HistoryManifest& source = work.history.manifest();
  fs::create_directories(folder / kHistory);
  for (const fs::path& file : taken_over(source)) {
    fs::create_directories((folder / kHistory / file).parent_path());
    fs::copy_file(work.history.folder() / file, folder / kHistory / file, fs::copy_options::overwrite_existing);
  }
  HistoryWriter writer(folder / kHistory, {.name = source.name,
                                           .origin = source.origin,
                                           .width = source.width,
                                           .height = source.height,
                                           .texel_size_mm = {},
                                           .time_unit = source.time_unit,
                                           .frames = {},
                                           .controls = {},
                                           .mask = {},
                                           .maps = {},
                                           .key = {}});
  writer.write_mask(known);
  write_rate_control(work, image, writer);
  Json controls = Json::array();
  for (const ControlParameter& c : writer.manifest().controls)
    controls.push_back(
        {{"name", c.name}, {"file", c.file.generic_string()}, {"range", {c.low, c.high}}, {"unit", c.unit}});
  save_json(folder / work_file("controls.json"), controls);
}

}  // namespace patinate::analysis
