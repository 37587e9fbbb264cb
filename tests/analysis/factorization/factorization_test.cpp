#include "patinate/analysis/factorization.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "analysis/factorization/factorization_document.h"
#include "analysis/factorization/forecast.h"
#include "analysis/factorization/temporal_curve.h"
#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "tests/analysis/factorization/factored_places.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

namespace fs = std::filesystem;
using testing_support::factor_errors;
using testing_support::factored_places;
using testing_support::FactoredOptions;
using testing_support::FactoredPlaces;
using testing_support::FactorErrors;
using testing_support::kQuickFactorization;
using testing_support::true_curve;

/// Root mean square error of values fitted with p parameters to n samples of noise sigma, when the curve is known:
/// sigma sqrt(p / n).
double bound_of_values(double sigma, double num_parameters, double num_samples) {
  return sigma * std::sqrt(num_parameters / num_samples);
}

TEST(TemporalCurve, ReproducesCubicsAndTheirSlopes) {
  std::vector<double> clocks, values;
  const auto cubic = [](double s) { return 0.3 + 0.2 * s - 0.05 * s * s + 0.01 * s * s * s; };
  for (int i = 0; i <= 40; ++i) clocks.push_back(-1.0 + 0.15 * i), values.push_back(cubic(clocks.back()));
  TemporalCurve curve{.low = -1.0, .high = 5.0, .coefficients = {fitted_curve(-1.0, 5.0, 6, clocks, values)}};
  // Cubics are splines; the resistance to bending moves them by less than this.
  constexpr double kBent = 2e-5;
  for (double s = -1.0; s <= 5.0; s += 0.37) {
    EXPECT_NEAR(curve.value(0, s), cubic(s), kBent);
    const CurveBasis b = curve_basis(curve, s);
    double slope = 0.0;
    for (std::size_t i = 0; i < 4; ++i) slope += b.slopes[i] * curve.coefficients[0][b.first + i];
    EXPECT_NEAR(slope, 0.2 - 0.1 * s + 0.03 * s * s, 10 * kBent);
  }
  EXPECT_EQ(curve.value(0, 9.0), curve.value(0, 5.0));  // Ends hold.
}

TEST(Factorization, OfFactoredPlacesReturnsTheirFactors) {
  const FactoredPlaces places = factored_places({.count = 300});
  const FactorErrors e = factor_errors(places, factorize(places.series, kQuickFactorization));
  // The curves are no splines of 24 pieces: what those cannot follow is the only error.
  EXPECT_EQ(e.fitted_share, 1.0);
  EXPECT_LT(e.value, 0.001);
  EXPECT_LT(e.rate, 0.005);
  EXPECT_LT(e.offset, 0.2);  // On a scale of 100.
  EXPECT_LT(e.gain, 0.002);
  EXPECT_LT(e.base, 0.002);
}

TEST(Factorization, UnderNoiseAndOutliersIsAsGoodAsAKnownCurveAllows) {
  constexpr double kNoise = 0.01, kCauchyLoss = 1.1,
                   kUnknownCurve = 1.1;  // 95 % efficiency, 2 % of the values lost; the curve has errors too.
  const FactoredPlaces places = factored_places({.count = 300, .noise = kNoise, .outliers = 0.02});
  const Factorization made = factorize(places.series, kQuickFactorization);
  const FactorErrors e = factor_errors(places, made);
  EXPECT_EQ(e.fitted_share, 1.0);
  EXPECT_LT(e.value, kCauchyLoss * kUnknownCurve * bound_of_values(kNoise, 8, 3.0 * 48));
  for (const double noise : made.models[0].noise) EXPECT_NEAR(noise, kNoise, 0.001);
  // Rates are off by as much as they say of themselves, but for the curve, whose own errors (of 96 places) all of them
  // share: nine tenths of them lie within 2 x 1.645 standard deviations times this.
  constexpr double kSharedCurve = 1.6;
  std::vector<PlaceFactors> truth = places.truth;
  apply_gauge(clock_gauge(truth), truth);
  std::vector<double> shares;
  for (std::size_t i = 0; i < truth.size(); ++i)
    shares.push_back((made.factors[0][i].rate - truth[i].rate) / made.factors[0][i].rate_stddev);
  std::sort(shares.begin(), shares.end());
  EXPECT_LT(shares[shares.size() * 95 / 100] - shares[shares.size() * 5 / 100], kSharedCurve * 2 * 1.645);
}

TEST(Factorization, MaskedValuesDoNotMatterAndStillPlacesAreSaid) {
  const FactoredPlaces places = factored_places({.count = 300, .noise = 0.01, .unseen = 0.2, .unchanged = 0.3});
  const Factorization made = factorize(places.series, kQuickFactorization);
  EXPECT_LT(factor_errors(places, made).value, 1.2 * bound_of_values(0.01, 8, 0.8 * 3 * 48));
  for (std::size_t i = 0; i < places.truth.size(); ++i) {
    const PlaceFactors& f = made.factors[0][i];
    ASSERT_EQ(f.status, places.truth[i].status) << i;
    if (f.status != PlaceStatus::Unchanged) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(f.gain[c], 0.0);
      EXPECT_NEAR(f.base[c], places.truth[i].base[c], 5 * 0.01 / std::sqrt(30.0));
    }
  }
}

TEST(Factorization, WhatChangesInAnotherWayIsNotCalledUnchanged) {
  FactoredPlaces places = factored_places({.count = 300, .noise = 0.01, .unchanged = 0.2});
  const std::size_t num_times = places.series.times.size();
  // A third goes to and fro, several times as often as anything of the curve.
  for (std::size_t i = 0; i < places.truth.size(); i += 3) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t t = 0; t < num_times; ++t) {
        RandomStream random(11, i * 1000 + c * 100 + t);
        places.series.values[(i * 3 + c) * num_times + t] = static_cast<float>(
            0.5 + 0.1 * std::sin(places.series.times[t] * 2.0 * std::numbers::pi / 33.0) + 0.01 * random.normal());
      }
    }
  }
  const Factorization made = factorize(places.series, kQuickFactorization);
  for (std::size_t i = 0; i < places.truth.size(); ++i) {
    const PlaceFactors& f = made.factors[0][i];
    if (i % 3 == 0) {
      EXPECT_NE(f.status, PlaceStatus::Unchanged) << i;
      if (f.status != PlaceStatus::Otherwise) continue;
      EXPECT_FALSE(is_covered(made.models[0].curve, f, places.series.times.front())) << "nobody knows how it goes on";
    } else if (places.truth[i].status == PlaceStatus::Unchanged) {
      EXPECT_EQ(f.status, PlaceStatus::Unchanged) << i;
    }
  }
}

TEST(Forecast, KnowsACourseThatQuickPlacesHaveShownAndNotWhatNobodyDid) {
  // Slow places stand at the end where quick ones have been: the curve knows more than the last frame.
  const FactoredPlaces known = factored_places({.count = 300, .noise = 0.005, .spread = 0.4});
  const Forecast of_known = make_forecast(known.series, kQuickFactorization);
  EXPECT_EQ(of_known.undefined, "");
  EXPECT_EQ(of_known.num_held, 9);
  EXPECT_TRUE(of_known.has_skill());
  // In the last fifth everything stands still: nothing told that.
  FactoredPlaces still = factored_places({.count = 300, .noise = 0.005, .spread = 0.4});
  const std::size_t num_times = still.series.times.size();
  for (std::size_t i = 0; i < still.truth.size() * 3; ++i) {
    float* values = still.series.values.data() + i * num_times;
    for (std::size_t t = num_times - 9; t < num_times; ++t) values[t] = values[num_times - 10];
  }
  EXPECT_FALSE(make_forecast(still.series, kQuickFactorization).has_skill());
  const Forecast of_few =
      make_forecast({.times = {0, 1, 2, 3}, .values = std::vector<float>(12, 0.5f)}, kQuickFactorization);
  EXPECT_FALSE(of_few.has_skill());
  EXPECT_NE(of_few.undefined.find("too few frames"), std::string::npos);
}

TEST(Factorization, EveryChannelMayHaveAClockOfItsOwn) {
  FactoredPlaces places = factored_places({.count = 200});
  const Factorization made =
      factorize(places.series, {.clock = FactorClock::Channels, .num_intervals = 24, .num_training = 96});
  ASSERT_EQ(made.models.size(), 3u);
  double squares = 0.0;
  for (std::size_t i = 0; i < places.truth.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const auto k = static_cast<std::size_t>(c);
      for (const double t : places.series.times) {
        const double v = places.truth[i].base[k] +
                         places.truth[i].gain[k] * true_curve(c, places.truth[i].rate * t - places.truth[i].offset);
        squares += std::pow(factored_value(made.models[k].curve, made.factors[k][i], 0, t) - v, 2);
      }
    }
  }
  EXPECT_LT(std::sqrt(squares / (200.0 * 3 * 48)), 0.001);
}

TEST(Factorization, IsTheSameForAnyNumberOfThreads) {
  const FactoredPlaces places = factored_places({.count = 120, .noise = 0.01});
  const auto made = [&](int threads) {
    RunControl control;
    control.num_threads = threads;
    return factorize(places.series, {.num_intervals = 16, .num_training = 64}, control);
  };
  const Factorization one = made(1);
  for (const int threads : {2, 5}) {
    const Factorization other = made(threads);
    EXPECT_EQ(one.models[0].curve.coefficients, other.models[0].curve.coefficients);
    for (std::size_t i = 0; i < one.factors[0].size(); ++i) {
      EXPECT_EQ(one.factors[0][i].rate, other.factors[0][i].rate);
      EXPECT_EQ(one.factors[0][i].gain, other.factors[0][i].gain);
    }
  }
}

TEST(Factorization, GoesOnForSlowPlacesWhereFastOnesHaveBeen) {
  // Frames until 70 of 100: the curve still rises. Places at the quick end have seen what the slow ones will.
  FactoredOptions options{.count = 300, .times = {}};
  for (int t = 0; t <= 40; ++t) options.times.push_back(1.75 * t);
  const FactoredPlaces places = factored_places(options);
  const Factorization made = factorize(places.series, kQuickFactorization);
  double worst = 0.0;
  int covered = 0, open = 0;
  for (std::size_t i = 0; i < places.truth.size(); ++i) {
    const PlaceFactors& p = places.truth[i];
    if (!is_covered(made.models[0].curve, made.factors[0][i], 85.0)) {
      ++open;
      continue;
    }
    ++covered;
    for (int c = 0; c < 3; ++c) {
      const double truth = p.base[c] + p.gain[c] * true_curve(c, p.rate * 85.0 - p.offset);
      worst = std::max(worst, std::abs(factored_value(made.models[0].curve, made.factors[0][i], c, 85.0) - truth));
    }
  }
  EXPECT_GT(covered, 100);
  EXPECT_GT(open, 20);  // And some come from where nobody has been.
  EXPECT_LT(worst, 0.02);
}

TEST(Factorization, SaysWhatItCannotTakeApart) {
  FactoredPlaces places = factored_places({.count = 20});
  PlaceSeries same = places.series;
  std::fill(same.values.begin(), same.values.end(), 0.4f);
  EXPECT_THROW((void)factorize(same), InvalidInput);
  PlaceSeries two{.times = {0.0, 1.0}, .values = std::vector<float>(60, 0.1f)};
  EXPECT_THROW((void)factorize(two), InvalidInput);
  PlaceSeries back = places.series;
  back.times[3] = back.times[2];
  EXPECT_THROW((void)factorize(back), InvalidInput);
  PlaceSeries hidden = places.series;
  hidden.is_seen.assign(20 * 48, 0);
  EXPECT_THROW((void)factorize(hidden), InvalidInput);
  EXPECT_THROW((void)factorize(places.series, {.max_rate = 1.0}), InvalidInput);
}

/// A history whose pixels are factored places, a masked column, a pixel without change, and frames with masks of their
/// own.
fs::path write_history(const fs::path& folder, const FactoredPlaces& places, int width, int height) {
  fs::create_directories(folder);
  HistoryManifest manifest;
  manifest.name = manifest.key = "made", manifest.origin = "synthetic";
  manifest.width = width, manifest.height = height, manifest.time_unit = TimeUnit::Days;
  HistoryWriter writer(folder, manifest);
  const std::size_t num_times = places.series.times.size();
  for (std::size_t t = 0; t < num_times; ++t) {
    ImageF frame(width, height, 3);
    for (std::size_t i = 0; i < places.truth.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) frame.data()[3 * i + c] = places.series.values[(3 * i + c) * num_times + t];
    }
    writer.write_frame(static_cast<int>(t), places.series.times[t], frame);
  }
  ImageU8 mask(width, height, 1, 255);
  for (int y = 0; y < height; ++y) mask.at(0, y) = 0;
  writer.write_mask(mask);
  writer.finish();
  return folder;
}

void make(const JobPlan& plan, int threads) {
  RunControl control;
  control.num_threads = threads;
  (void)run_job(plan, {}, control);
}

TEST(FactorizationJob, WritesTheSameHistoryWithoutNoiseAndMarksWhatNobodySaw) {
  const testing_support::TempFolder folder;
  FactoredOptions options{.count = 24 * 16, .noise = 0.01, .unchanged = 0.1};
  for (int t = 0; t < 30; ++t) options.times.push_back(2.5 * t);
  const FactoredPlaces places = factored_places(options);
  const fs::path history = write_history(folder / "history", places, 24, 16);
  const FactorizationTask task{
      .history = history, .options = {.num_intervals = 20, .num_training = 64}, .times = {36.0, 90.0}};
  make(plan_factorization(task, folder / "one"), 1);
  make(plan_factorization(task, folder / "five"), 5);
  for (const char* name :
       {"factorization.json", "report.html", "maps/rate.exr", "maps/base.exr", "history/history.json",
        "history/frames/0031.exr", "history/masks/0031.png", "history/controls/rate.exr"}) {
    EXPECT_EQ(read_file(folder / "one" / name), read_file(folder / "five" / name)) << name;
  }
  const HistoryReader made(folder / "one/history");
  ASSERT_EQ(made.num_frames(), 32);
  EXPECT_EQ(made.manifest().frames.back().time, 90.0);
  EXPECT_TRUE(made.manifest().frames.back().is_extrapolated);
  EXPECT_FALSE(made.manifest().frames[15].is_extrapolated);  // 36 lies between frames.
  const ImageF rate = made.read_control("rate");
  const ImageU8 clock = read_mask(folder / "one/maps/clock.png"), changes = read_mask(folder / "one/maps/changes.png");
  double before = 0.0, after = 0.0;
  const ImageF noisy = HistoryReader(history).read_frame(12), clean = made.read_frame(12);
  for (std::size_t i = 0; i < places.truth.size(); ++i) {
    const bool is_inside = i % 24 != 0, is_changing = places.truth[i].status == PlaceStatus::Fitted;
    EXPECT_EQ(changes.data()[i] != 0, is_inside && is_changing) << i;
    if (is_inside && !is_changing) {
      EXPECT_EQ(rate.data()[i], 0.0f);
      EXPECT_EQ(clock.data()[i], 0);
    }
    for (std::size_t c = 0; c < 3 && is_inside; ++c) {
      const double v =
          places.truth[i].base[c] +
          places.truth[i].gain[c] *
              true_curve(static_cast<int>(c), places.truth[i].rate * options.times[12] - places.truth[i].offset);
      before += std::pow(static_cast<double>(noisy.data()[3 * i + c]) - v, 2),
          after += std::pow(static_cast<double>(clean.data()[3 * i + c]) - v, 2);
    }
  }
  EXPECT_LT(
      after,
      0.2 * before);  // Noise of 3 x 30 values, 8 numbers: a tenth of the squares; and frame 12 is no average one.
  const FactorizationManifest m = read_factorization(folder / "one");
  EXPECT_EQ(m.num_extrapolated(), 1);
  EXPECT_EQ(m.models.size(), 1u);
}

TEST(FactorizationJob, BadInputIsOneLine) {
  const testing_support::TempFolder folder;
  FactoredOptions options{.count = 64, .times = {0, 1, 2}};
  const fs::path three = write_history(folder / "three", factored_places(options), 8, 8);
  EXPECT_THROW((void)plan_factorization({.history = three}, folder / "out"), InvalidInput);
  options = {.count = 64, .times = {0, 20, 40, 60, 80, 100}};
  const fs::path six = write_history(folder / "six", factored_places(options), 8, 8);
  EXPECT_THROW((void)plan_factorization({.history = six, .times = {std::nan("")}}, folder / "out"), InvalidInput);
  // So far ahead that no place has been there.
  EXPECT_THROW(
      make(plan_factorization({.history = six, .options = {.num_training = 16}, .times = {1e6}}, folder / "out"), 1),
      InvalidInput);
}

}  // namespace
}  // namespace patinate::analysis
