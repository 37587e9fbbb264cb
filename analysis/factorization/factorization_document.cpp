#include "analysis/factorization/factorization_document.h"

#include <array>
#include <nlohmann/json.hpp>

#include "analysis/factorization/factorization_work.h"
#include "analysis/report/analysis_documents.h"
#include "libcommon/core/files.h"
#include "libcommon/history/history_documents.h"

namespace patinate::analysis {

namespace {

constexpr double kMaxSide = 65536;
constexpr std::size_t kMaxCoefficients = 1000;

constexpr DocumentKind kFactorizationDocument{
    .format = "patinate.factorization",
    .title = "patinate factorization",
    .about = "factorization.json of `patinate history factorize`: color = gain x curve(rate x time - offset) + base."};

void describe_model(DocumentVisitor& v, TemporalModel& m, std::vector<std::string> channels) {
  v.member({.name = "channels", .help = "Of R, G and B.", .min_size = 1, .max_size = 3}, channels);
  v.member({"low", "Where the curve begins, on the common clock; before, its value there holds."}, m.curve.low);
  v.member({"high", "Where it ends."}, m.curve.high);
  v.require("high", m.curve.high > m.curve.low, "more than low");
  std::vector<std::vector<double>>& lists = m.curve.coefficients;
  v.member({.name = "coefficients",
            .help = "For every channel those of a uniform cubic B-spline of as many pieces as there are coefficients, "
                    "less 3.",
            .max_size = kMaxCoefficients},
           lists);
  v.require("coefficients", lists.size() == channels.size(), "a list for every channel");
  for (const std::vector<double>& list : lists)
    v.require("coefficients", list.size() >= 4 && list.size() == lists.front().size(),
              "at least 4 coefficients, as many for every channel");
  v.member({"noise", "Standard deviation of most residuals of every channel, linear.", above(0)}, m.noise);
  v.require("noise", m.noise.size() == channels.size(), "a number for every channel");
  v.member({"correlation", "Of residuals from frame to frame.", between(0, 0.99)}, m.correlation);
}

/// One for all channels, or one for each.
void describe_models(DocumentVisitor& v, std::vector<TemporalModel>& models) {
  std::size_t next = 0;
  v.list({.name = "curves", .help = "One for all channels, or one for each.", .min_size = 1, .max_size = 3}, models,
         [&](TemporalModel& m) {
           const std::vector<std::string> names{"R", "G", "B"};
           describe_model(v, m, models.size() == 1 ? names : std::vector{names[next++]});
         });
  v.require("curves", models.size() == 1 || models.size() == 3, "one curve for all channels, or three");
  v.require("curves", models.front().curve.num_channels() == (models.size() == 1 ? 3 : 1), "three channels in all");
}

}  // namespace

void describe(DocumentVisitor& v, FrameRecord& f) {
  bool is_extrapolated = f.covered_share.has_value();
  std::optional<std::int64_t> pixels;
  std::optional<double> rmse, mean, p95;
  if (f.error) pixels = f.error->num_pixels, rmse = f.error->rmse;
  if (f.error && f.error->is_color) mean = f.error->ciede2000_mean, p95 = f.error->ciede2000_p95;
  v.member({"time"}, f.time);
  v.member(if_set("extrapolated", "Nobody saw it."), is_extrapolated);
  v.member(if_set("covered_share", "Of what changes: where the curve is known that far.", between(0, 1)),
           f.covered_share);
  v.member(if_set("held",
                  "As it is at the last frame: a curve that had not seen the last fifth of the frames foretold them no "
                  "better, or that could not be tried."),
           f.is_held);
  v.member(if_set("pixels", "Compared with the history's frame.", at_least(1)), pixels);
  v.member(if_set("rmse", "Linear.", at_least(0)), rmse);
  v.member(if_set("ciede2000_mean", "", at_least(0)), mean);
  v.member(if_set("ciede2000_p95", "", at_least(0)), p95);
  if (rmse) f.error = FrameError{pixels.value_or(1), *rmse, mean.value_or(0.0), p95.value_or(0.0), mean.has_value()};
}

void describe(DocumentVisitor& v, FactorizationManifest& m) {
  v.member({"name", "Of the history."}, m.name);
  v.member({"origin", "Of the history: captured, simulated or synthetic."}, m.origin);
  v.member({"width", "Pixels of every map.", between(1, kMaxSide)}, m.width);
  v.member({"height", "Pixels of every map.", between(1, kMaxSide)}, m.height);
  v.choice({"time_unit", "Of times, clocks and offsets."}, m.time_unit, kTimeUnitNames);
  v.member({"clock", "shared: one rate and offset of a place; channels: one for each channel."}, m.clock);
  describe_models(v, m.models);
  constexpr std::array<std::string_view, 8> kHelps{"D, R G B.",
                                                   "A, R G B.",
                                                   "R, 1 where it is not defined.",
                                                   "O, in time_unit, 0 where it is not defined.",
                                                   "Standard deviation of the rate as noise leaves it.",
                                                   "Root mean square over time.",
                                                   "0 = does not change.",
                                                   "0 = rate and offset are not known."};
  m.maps = factor_maps();
  v.object({"maps", "EXR, float; changes and clock 8 bit."}, true, [&] {
    for (std::size_t i = 0; i < m.maps.size(); ++i) v.member({m.maps[i].first, kHelps[i]}, m.maps[i].second);
  });
  v.member({"history", "The denoised history."}, m.history);
  v.member({"frames", "Of the denoised history, by time."}, m.frames);
  v.member({.name = "figures", .max_size = 1000}, m.figures);
  v.member({"csv", "What is drawn on the page."}, m.curves);
  describe_origin(v, m.origin_of_report);
  v.choice(if_set("of",
                  "The map of the frames that was taken apart; absent: their color. Its curves and maps have "
                  "three equal channels, and its frames no differences of color."),
           m.of, kFactorQuantityNames);
}

void save_factorization(const std::filesystem::path& folder, FactorizationManifest m) {
  save_json(folder / kFactorizationManifestFile, document_json(kFactorizationDocument, described(m)));
}

FactorizationManifest read_factorization(const std::filesystem::path& path) {
  const std::filesystem::path folder = manifest_folder(path, kFactorizationManifestFile);
  FactorizationManifest m;
  read_document(kFactorizationDocument, folder / kFactorizationManifestFile, described(m));
  for (auto& [name, file] : m.maps) file = folder / file;
  m.history = folder / m.history;
  return m;
}

Json factorization_schema() { return document_schema(kFactorizationDocument, described<FactorizationManifest>()); }

void save_models(const std::filesystem::path& file, std::vector<TemporalModel> models) {
  save_json(file, object_json([&](DocumentVisitor& v) { describe_models(v, models); })["curves"]);
}

std::vector<TemporalModel> read_models(const std::filesystem::path& file) {
  std::vector<TemporalModel> models;
  read_object({{"curves", load_json(file)}}, [&](DocumentVisitor& v) { describe_models(v, models); });
  return models;
}

}  // namespace patinate::analysis
