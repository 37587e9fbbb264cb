// Report of a factorization: manifest, page, CSVs, and the manifest of the denoised history.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/compare/sections.h"
#include "analysis/factorization/factorization_document.h"
#include "analysis/factorization/factorization_work.h"
#include "analysis/factorization/map_pictures.h"
#include "analysis/factorization/place_fit.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/median.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/contact_strip.h"
#include "libcommon/output/map_legend.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr int kCurvePoints = 129;  ///< Points of the drawn curve.
constexpr std::array<const char*, 3> kColorNames{"red", "green", "blue"};

/// Everything the report is made of.
struct Said {
  const FactorizationWork& work;
  /// Number of values: channels that differ.
  [[nodiscard]] double num_channels() const { return work.is_color() ? 3.0 : 1.0; }
  [[nodiscard]] std::string unit() const { return work.task.of == FactorQuantity::Height ? "mm" : ""; }
  const FactorizationWork::Factored& f;
  const fs::path& folder;
  std::vector<FrameRecord> frames;
  std::array<double, kNumPlaceStatuses> counts = {};  ///< By PlaceStatus, of the first model, inside the mask.
  std::vector<double> rates, rate_stddevs;            ///< Rates and rate stddevs of fitted places, all models.
  std::vector<double> ends;                           ///< Until when the curve covers every place that changes.
  ImageU8 clock, changes;
};

Said gather(FactorizationWork& work, const fs::path& folder) {
  Said s{.work = work,
         .f = work.factored(folder),
         .folder = folder,
         .frames = {},
         .rates = {},
         .rate_stddevs = {},
         .ends = {},
         .clock = read_mask(folder / "maps/clock.png"),
         .changes = read_mask(folder / "maps/changes.png")};
  for (std::size_t i = 0; i < work.frames.size(); ++i)
    read_object(load_json(folder / work_file("frame." + std::to_string(i) + ".json")),
                described(s.frames.emplace_back()));
  for (std::int64_t i = 0; i < work.mask.num_pixels(); ++i) {
    if (work.mask.data()[i] == 0) continue;
    double end = 1e300;
    for (std::size_t m = 0; m < work.num_models(); ++m) {
      const PlaceFactors p = factors_at(s.f.image, i, m, work.num_models());
      if (m == 0) s.counts[static_cast<std::size_t>(p.status)] += 1.0;
      if (p.status == PlaceStatus::Fitted) s.rates.push_back(p.rate), s.rate_stddevs.push_back(p.rate_stddev);
      if (p.status == PlaceStatus::Fitted || p.status == PlaceStatus::Open)
        end = std::min(end, (s.f.models[m].curve.high + p.offset) / p.rate);
    }
    if (end < 1e300) s.ends.push_back(end);
  }
  return s;
}

/// Mean over those frames that were compared, weighted by their pixels.
std::optional<double> over_frames(const Said& s, double FrameError::*figure, bool is_squared) {
  double sum = 0.0, pixels = 0.0;
  for (const FrameRecord& f : s.frames) {
    if (!f.error) continue;
    const double v = (*f.error).*figure, n = static_cast<double>(f.error->num_pixels);
    sum += n * (is_squared ? v * v : v), pixels += n;
  }
  if (pixels == 0.0) return std::nullopt;
  return is_squared ? std::sqrt(sum / pixels) : sum / pixels;
}

Section figures_section(const Said& s) {
  Section section{.name = "figures", .title = "How much it explains, and how small it is"};
  const std::string unit = shown_time_unit(s.work.history.manifest().time_unit);
  const auto add = [&](const std::string& name, const std::string& title, const std::string& of,
                       std::optional<double> value, const std::string& why) {
    section.figures.push_back(
        {.name = name, .title = title, .unit = of, .value = value, .undefined = value ? "" : why});
  };
  const std::string unseen = "no frame shows a place that is known";
  add("rmse", "Reconstruction, root mean square", s.work.is_color() ? "linear" : s.unit(),
      over_frames(s, &FrameError::rmse, true), unseen);
  if (s.work.is_color())
    add("ciede2000_mean", "Reconstruction, mean difference of color", "CIEDE2000",
        over_frames(s, &FrameError::ciede2000_mean, false), unseen);
  double noise = 0.0;
  for (const TemporalModel& m : s.f.models) noise = std::max(noise, *std::max_element(m.noise.begin(), m.noise.end()));
  add("noise",
      std::string("Standard deviation of most residuals") + (s.work.is_color() ? ", the noisiest channel" : ""),
      s.work.is_color() ? "linear" : s.unit(), noise, "");
  const double all = std::accumulate(s.counts.begin(), s.counts.end(), 0.0);
  constexpr std::array<const char*, kNumPlaceStatuses> kNames{"unseen_share", "unchanged_share", "open_share",
                                                              "fitted_share", "otherwise_share"};
  constexpr std::array<const char*, kNumPlaceStatuses> kTitles{
      "Surface that too few frames show", "Surface of which nothing says that it changes: rate and offset undefined",
      "Surface that changes, its rate left open by the data", "Surface with known rate and offset",
      "Surface that changes, and not as the curve does"};
  for (const std::size_t k : {3u, 2u, 4u, 1u, 0u}) add(kNames[k], kTitles[k], "", s.counts[k] / all, "");
  const std::string nothing = "no place has a known rate";
  std::vector<double> rates = s.rates;
  std::sort(rates.begin(), rates.end());
  const auto at = [&](double share) {
    return rates.empty()
               ? std::nullopt
               : std::optional(rates[static_cast<std::size_t>(share * static_cast<double>(rates.size() - 1))]);
  };
  add("rate_p05", "Rate of the slowest 5 %", "of the median", at(0.05), nothing);
  add("rate_p95", "Rate of the fastest 5 %", "of the median", at(0.95), nothing);
  add("rate_stddev", "Median standard deviation of a rate by noise", "",
      s.rate_stddevs.empty() ? std::nullopt : std::optional(median(s.rate_stddevs)), nothing);
  add("covered_until", "Time until which the curve covers half of what changes", unit,
      s.ends.empty() ? std::nullopt : std::optional(median(s.ends)), "nothing changes");
  if (const std::optional<Forecast> forecast = read_forecast(s.work, s.folder)) {
    const std::string held = "Last " + std::to_string(forecast->num_held) + " frames, mean difference of color: ";
    const auto known = [&](double value) { return forecast->undefined.empty() ? std::optional(value) : std::nullopt; };
    add("forecast_ciede2000", held + "foretold by a curve that had not seen them", "CIEDE2000", known(forecast->curve),
        forecast->undefined);
    add("last_frame_ciede2000", held + "of that curve at the last frame before them, held", "CIEDE2000",
        known(forecast->last), forecast->undefined);
  }
  const double num_frames = s.work.history.num_frames();
  double numbers = (2.0 * s.num_channels() + 2.0 * static_cast<double>(s.work.num_models())) * all;
  for (const TemporalModel& m : s.f.models)
    numbers += 2.0 + std::min(s.num_channels(), 1.0 * m.curve.num_channels()) * (m.curve.num_intervals() + 3.0);
  const double of_history = s.num_channels() * num_frames * all;
  add("numbers_history", "Numbers of the history", "", of_history, "");
  add("numbers_factors", "Numbers of curve and maps", "", numbers, "");
  add("compactness", "Compression ratio", "", of_history / numbers, "");
  if (!s.work.is_color()) return section;
  double bytes_history = 0.0, bytes_maps = 0.0;
  for (const HistoryFrame& f : s.work.history.manifest().frames)
    bytes_history += static_cast<double>(fs::file_size(s.work.history.folder() / f.file));
  for (const char* name : {"maps/base.exr", "maps/gain.exr", "maps/rate.exr", "maps/offset.exr"})
    bytes_maps += static_cast<double>(fs::file_size(s.folder / name));
  add("bytes_history", "Files of the history's frames (half floats)", "bytes", bytes_history, "");
  add("bytes_factors", "Files of base, gain, rate and offset (floats)", "bytes", bytes_maps, "");
  return section;
}

Section curve_section(const Said& s) {
  Section section{.name = "curve", .title = "The curve, and the error of every frame"};
  const std::string unit = shown_time_unit(s.work.history.manifest().time_unit);
  for (std::size_t m = 0; m < s.f.models.size(); ++m) {
    const TemporalCurve& c = s.f.models[m].curve;
    const std::string which = s.f.models.size() == 1 ? "" : std::string("_") + kColorNames[m];
    Curve curve{.name = "curve" + which,
                .title = "Temporal curve over the common clock",
                .x_name = "clock (" + unit + ")",
                .y_name = "share of the gain"};
    for (int i = 0; i < kCurvePoints; ++i)
      curve.x.push_back(rounded(c.low + (c.high - c.low) * i / (kCurvePoints - 1), 9));
    for (int k = 0; k < (s.work.is_color() ? c.num_channels() : 1); ++k) {
      CurveColumn column{.name = s.work.is_color()
                                     ? kColorNames[s.f.models.size() == 1 ? static_cast<std::size_t>(k) : m]
                                     : name_of(s.work.task.of)};
      for (const double v : c.samples(k, kCurvePoints)) column.values.push_back(v);
      curve.columns.push_back(std::move(column));
    }
    section.curves.push_back(std::move(curve));
  }
  Curve error{.name = "error",
              .title = "Reconstruction error of every frame",
              .x_name = "time (" + unit + ")",
              .y_name = "CIEDE2000"};
  CurveColumn mean{.name = "mean"}, p95{.name = "95th percentile"};
  Curve rms{.name = "rmse",
            .title = s.work.is_color() ? "Reconstruction error of every frame, linear" : error.title,
            .x_name = error.x_name,
            .y_name = "root mean square"};
  CurveColumn rmse{.name = s.work.is_color() ? "all channels" : name_of(s.work.task.of)};
  for (const FrameRecord& f : s.frames) {
    if (!f.error) continue;
    error.x.push_back(f.time);
    mean.values.push_back(f.error->ciede2000_mean);
    p95.values.push_back(f.error->ciede2000_p95);
    rmse.values.push_back(f.error->rmse);
  }
  rms.x = error.x;
  error.columns = {mean, p95}, rms.columns = {rmse};
  if (s.work.is_color()) section.curves.push_back(std::move(error));
  section.curves.push_back(std::move(rms));
  return section;
}

/// The history and what the factors make of it, at the same times.
Section look_section(const Said& s) {
  Section section{.name = "look", .title = "The history, and what curve and maps make of it"};
  if (!s.work.is_color()) {
    add_map_strips(s.work, s.folder, section);
    return section;
  }
  std::vector<std::size_t> seen, extrapolated;
  for (std::size_t i = 0; i < s.work.frames.size(); ++i) {
    if (s.work.frames[i].source >= 0) seen.push_back(i);
    if (s.work.frames[i].source < 0 && s.work.frames[i].is_extrapolated) extrapolated.push_back(i);
  }
  const std::string unit = shown_time_unit(s.work.history.manifest().time_unit);
  const auto strip = [&](const std::string& name, const std::string& caption, const std::vector<std::size_t>& of,
                         bool is_source) {
    std::vector<ImageF> images;
    std::vector<std::string> labels;
    for (const std::size_t k : spread_indices(of.size(), kPicturesInARow)) {
      const FactoredFrame& frame = s.work.frames[of[k]];
      images.push_back(
          shown(is_source ? s.work.history.read_frame(frame.source)
                          : read_color(s.folder / "history" / HistoryWriter::frame_file(static_cast<int>(of[k])))));
      labels.push_back(short_number_text(rounded(frame.time, 4)) + " " + unit);
    }
    section.pictures.push_back({name, caption, contact_strip(images, labels, {.label_px = 13})});
  };
  strip("history", "The history", seen, true);
  strip("factored", "Curve and maps", seen, false);
  if (!extrapolated.empty())
    strip("extrapolated",
          std::any_of(s.frames.begin(), s.frames.end(), [](const FrameRecord& f) { return f.is_held; })
              ? "EXTRAPOLATED, not observed: holds the last frame, because the curve does not predict better"
              : "EXTRAPOLATED, not observed: slower places continue along the curve of faster ones, and hold its end "
                "where no place has been later",
          extrapolated, false);
  return section;
}

Section maps_section(const Said& s) {
  Section section{.name = "maps", .title = "The maps"};
  const auto color = [&](const char* name, bool is_sum) {
    ImageF image = read_channels(s.folder / "maps/base.exr", {"R", "G", "B"});
    if (is_sum) {
      const ImageF gain = read_channels(s.folder / "maps/gain.exr", {"R", "G", "B"});
      for (std::int64_t i = 0; i < 3 * image.num_pixels(); ++i)
        image.data()[i] = std::max(0.0f, image.data()[i] + gain.data()[i]);
    }
    section.pictures.push_back(
        {name, is_sum ? "Base and gain: color where the curve is 1" : "Base D: color where the curve is 0",
         shown(std::move(image))});
  };
  if (s.work.is_color()) {
    color("base", false);
    color("base_and_gain", true);
  }
  const std::vector<std::string> channels =
      s.work.num_models() == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
  const auto ramp = [&](const char* name, const std::string& caption, const ImageU8& mask, bool has_sign,
                        const std::string& unit) {
    const bool is_value = std::string(name) == "base" || std::string(name) == "gain";  // Three equal channels of a map.
    const ImageF all = read_channels(s.folder / "maps" / (std::string(name) + ".exr"),
                                     is_value ? std::vector<std::string>{"R"} : channels);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      ImageF one(all.width(), all.height());
      for (std::int64_t i = 0; i < one.num_pixels(); ++i)
        one.data()[i] = all.data()[static_cast<std::size_t>(i) * channels.size() + c];
      if (std::none_of(mask.values().begin(), mask.values().end(), [](std::uint8_t v) { return v != 0; })) return;
      const Percentiles range = percentiles(one, mask, 0.02, 0.98);
      const double largest =
          std::max({std::abs(static_cast<double>(range.low)), std::abs(static_cast<double>(range.high)), 1e-6});
      const double low = has_sign ? -largest : static_cast<double>(range.low),
                   high = has_sign ? largest : std::max(static_cast<double>(range.high), low + 1e-6);
      const ColorRamp kind = has_sign ? ColorRamp::Diverging : ColorRamp::Sequential;
      const std::string which = channels.size() == 1 ? "" : std::string(", ") + kColorNames[c];
      section.pictures.push_back({name + (channels.size() == 1 ? "" : std::string("_") + kColorNames[c]),
                                  caption + which + ", " + short_number_text(rounded(low, 3)) + " (blue) to " +
                                      short_number_text(rounded(high, 3)) + (has_sign ? " (orange)" : " (yellow)"),
                                  with_legend(shown(ramp_picture(one, mask, low, high, kind)),
                                              {.ramp = kind, .low = low, .high = high, .unit = unit})});
    }
  };
  const std::string time_unit = shown_time_unit(s.work.history.manifest().time_unit);
  if (!s.work.is_color()) {
    ramp("base", "Base D: " + name_of(s.work.task.of) + " where the curve is 0", s.work.mask, false, s.unit());
    ramp("gain", "Gain A: what the curve adds where it is 1", s.changes, true, s.unit());
  }
  ramp("rate", "Rate R: gray where it is not known", s.clock, false, "");
  ramp("offset", "Offset O (" + time_unit + "): gray where it is not known", s.clock, true, time_unit);
  ramp("residual", "Root mean square over time of what is left over", s.work.mask, false, "");
  return section;
}

HistoryManifest denoised_history(const Said& s) {
  HistoryManifest m = s.work.history.manifest();
  m.parts.clear();  // Curve and maps do not make what a library was made from.
  m.name += " (factorized)";
  m.frames.clear();
  for (std::size_t i = 0; i < s.work.frames.size(); ++i) {
    const int index = static_cast<int>(i);
    HistoryFrame frame{.time = s.work.frames[i].time,
                       .file = HistoryWriter::frame_file(index),
                       .mask = {},
                       .extras = {},
                       .is_extrapolated = s.work.frames[i].is_extrapolated};
    if (frame.is_extrapolated) frame.mask = HistoryWriter::frame_mask_file(index);
    if (!s.work.is_color()) {
      const FrameFacts& source = s.work.history.facts().frames[s.work.frames[i].source];
      if (source.has_mask) frame.mask = HistoryWriter::frame_mask_file(index);
      for (const std::string& name : source.extras)
        frame.extras.push_back({name, HistoryWriter::frame_extra_file(index, name)});
    }
    m.frames.push_back(std::move(frame));
  }
  for (const Json& c : load_json(s.folder / work_file("controls.json"))) {
    m.controls.push_back({.name = c.at("name"),
                          .file = c.at("file").get<std::string>(),
                          .low = c.at("range").at(0),
                          .high = c.at("range").at(1),
                          .unit = c.at("unit")});
  }
  m.mask = HistoryWriter::mask_file();
  m.key = s.work.key;
  return m;
}

}  // namespace

void write_factorization(FactorizationWork& work, const fs::path& folder, const RunControl& control) {
  const Said s = gather(work, folder);
  const HistoryManifest& source = work.history.manifest();
  write_history_manifest(folder / "history" / kHistoryManifestFile, denoised_history(s));
  control.report(0.3);
  HtmlPage page(source.name + ", factorized");
  std::string what = work.is_color() ? "color" : name_of(work.task.of);
  what[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(what[0])));
  page.paragraph(
      what +
      " of every place over time as A phi(R t - O) + D: one temporal curve phi for all places, and for each place "
      "a gain A, a base D, a rate R and an offset O. "
      "The median place has R = 1 and O = 0; phi goes from 0 to 1.");
  fs::create_directories(folder / "curves");
  std::array<Section, 4> sections{figures_section(s), look_section(s), curve_section(s), maps_section(s)};
  for (Section& section : sections) {
    embed_pictures(section.pictures, folder / kJobWorkFolder / "picture.png");
    add_section(page, section, folder, "");
  }
  if (!source.warnings.empty()) {
    page.heading("Warnings of the history");
    for (const HistoryWarning& warning : source.warnings) page.paragraph(warning_text(warning));
  }
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(work.task.command);
  page.link(kFactorizationManifestFile, "Curve and figures as JSON");
  page.link("history/history.json", "The denoised history");
  page.save(folder / kFactorizationPageFile);
  const Named<std::string> options = option_values(work.task.options);
  const auto clock = std::find_if(options.begin(), options.end(), [](const auto& o) { return o.first == "clock"; });
  save_factorization(folder, {.name = source.name,
                              .origin = source.origin,
                              .width = source.width,
                              .height = source.height,
                              .time_unit = source.time_unit,
                              .clock = clock->second,
                              .models = s.f.models,
                              .maps = {},
                              .history = "history",
                              .frames = s.frames,
                              .figures = listed_figures(sections),
                              .curves = listed_curves(sections),
                              .origin_of_report = {options, work.task.command, work.key},
                              .of = work.is_color() ? std::nullopt : std::optional(work.task.of)});
  control.report(1.0);
}

}  // namespace patinate::analysis
