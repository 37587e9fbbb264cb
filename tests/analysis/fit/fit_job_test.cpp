#include "analysis/fit/fit_job.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/random.h"
#include "tests/analysis/fit/fit_model.h"
#include "tests/analysis/fit/run_fit.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

namespace fs = std::filesystem;
using namespace testing_support;

/// A captured history of the truth.
fs::path captured(const TempFolder& folder) {
  write_surface(folder.path() / "captured", green_plate(kGreenTruth), "0123456789abcdef");
  return folder.path() / "captured";
}

/// Every file with its bytes, but for job.json, which names what was regenerated.
std::string tree_of(const fs::path& folder) {
  std::vector<std::string> lines;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && entry.path().filename() != "job.json")
      lines.push_back(fs::relative(entry.path(), folder).string() + " " + hash_file(entry.path()));
  }
  std::sort(lines.begin(), lines.end());
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(FitJob, FindsKnownValuesAgainAndSaysWhichOneDoesNothing) {
  const TempFolder folder;
  FitTask task = green_task(captured(folder));
  const Json report = run_fit(std::move(task), folder.path() / "fit");
  const Json& p = report.at("parameters");
  // Two significant digits: the search ends at a thousandth of the range, a factor of 1.005 in the rate, and frames are
  // half floats.
  EXPECT_NEAR(p[0].at("best").get<double>(), kGreenTruth[0], 0.02 * kGreenTruth[0]);
  EXPECT_NEAR(p[1].at("best").get<double>(), kGreenTruth[1], 0.02 * kGreenTruth[1]);
  EXPECT_EQ(p[0].at("determination"), "determined");
  EXPECT_EQ(p[1].at("determination"), "determined");
  EXPECT_EQ(p[2].at("determination"), "without_effect");
  EXPECT_LT(report.at("objective").at("after").get<double>(), 0.02 * report.at("objective").at("before").get<double>());
  for (const Json& f : report.at("figures")) {
    if (f.at("name") == "color_distribution") {
      EXPECT_LT(f.at("after").get<double>(), f.at("before").get<double>());
    }
  }
}

TEST(FitJob, IntervalsHoldAllOfTheTruthAsOftenAsTheySayWhenOtherSeedsDiffer) {
  const TempFolder folder;
  constexpr int kTruths = 24;
  constexpr double kChance = 0.05;
  int num_held = 0;
  for (int k = 0; k < kTruths; ++k) {
    RandomStream random(11, static_cast<std::uint64_t>(k));
    const double rate = 0.1 * std::pow(10.0, random.uniform()), strength = 0.3 + 0.5 * random.uniform();
    const double captured_rate = rate * (1.0 + kChance * random.normal());
    const fs::path history = folder.path() / ("captured" + std::to_string(k));
    write_surface(history, green_plate({captured_rate, strength, 0.0}), "0123456789abcdef");
    FitTask task = green_task(history, kChance);
    task.parameters.resize(2);
    task.captures[0].age = [inner = task.captures[0].age, k](const std::vector<double>& v, std::uint64_t shift,
                                                             const RunControl& c) -> ComposeWith {
      return [look = inner({v[0], v[1], 0.0}, shift + 1000 * static_cast<std::uint64_t>(k), c)](
                 const std::vector<double>& l, const RunControl& lc) {
        return look({l[0], l[1], 0.0}, lc);
      };
    };
    task.options.evaluations = 37;
    task.options.appearance_evaluations = 13;
    task.seed = static_cast<std::uint64_t>(k);
    const Json report = run_fit(std::move(task), folder.path() / ("fit" + std::to_string(k)));
    const auto holds = [&](std::size_t i, double truth) {
      const Json interval = report.at("parameters")[i].at("interval");
      return interval[0].get<double>() <= truth && truth <= interval[1].get<double>();
    };
    num_held += holds(0, rate) && holds(1, strength);
  }
  // Were coverage below nine tenths, fewer than 18 of 24 would be held in more than one of a hundred tests: binomial.
  EXPECT_GE(num_held, 18);
}

TEST(FitJob, AModelThatIsRightForetellsFramesThatItsSearchDidNotSeeAndOneThatStopsDoesNot) {
  const TempFolder folder;
  const fs::path history = captured(folder);
  const auto held_out = [&](bool stops, const std::string& name) {
    FitTask task = green_task(history);
    task.parameters.resize(2);
    task.captures[0].age = [inner = task.captures[0].age, stops](const std::vector<double>& v, std::uint64_t shift,
                                                                 const RunControl& c) -> ComposeWith {
      return [look = inner({v[0], v[1], 0.0}, shift, c), stops](const std::vector<double>& l, const RunControl& lc) {
        AgedSurface surface = look({l[0], l[1], 0.0}, lc);
        // Nothing more after the fourth day.
        for (std::size_t t = 5; stops && t < surface.colors.size(); ++t) surface.colors[t] = surface.colors[4];
        return surface;
      };
    };
    task.objective.until = 4.0;
    task.options.seeds = 2;
    task.options.scan = 0;
    return run_fit(std::move(task), folder.path() / name).at("held_out");
  };
  const Json right = held_out(false, "right"), wrong = held_out(true, "wrong");
  EXPECT_EQ(right.at("times"), 4);
  EXPECT_LT(right.at("after").get<double>(), 0.1 * right.at("last_frame").get<double>());
  EXPECT_EQ(right.at("last_frame"), wrong.at("last_frame"));
  // Both fit what they see; what has stopped is the last frame, held.
  EXPECT_NEAR(wrong.at("after").get<double>(), wrong.at("last_frame").get<double>(),
              0.2 * wrong.at("last_frame").get<double>());
  EXPECT_EQ(right.at("other_seeds").size(), 2u);
}

TEST(FitJob, ASingleNumberHasTheBudgetOfTwo) {
  EXPECT_EQ(fit_budget({}, 1, 0).evaluations, 201);
  EXPECT_EQ(fit_budget({}, 2, 5).evaluations, 201);
  EXPECT_EQ(fit_budget({}, 3, 0).evaluations, 301);
  EXPECT_EQ(fit_budget({}, 0, 1).evaluations, 201);
  EXPECT_EQ(fit_budget({.evaluations = 50}, 1, 0).evaluations, 50);
}

// One place has no half on each side: the scan of appearance was empty, and its first one read all the same.
TEST(FitJob, AScanOfOnePlaceIsAScan) {
  const TempFolder folder;
  const fs::path history = captured(folder);
  for (const int scan : {1, 3}) {
    FitTask task = green_task(history);
    task.options.evaluations = 25;
    task.options.appearance_evaluations = 5;
    task.options.scan = scan;
    task.options.seeds = 1;
    const Json report = run_fit(std::move(task), folder.path() / ("fit" + std::to_string(scan)));
    for (const Json& p : report.at("parameters")) EXPECT_NE(p.at("determination"), "not_examined") << p.at("pointer");
    EXPECT_EQ(report.at("parameters")[2].at("determination"), "without_effect");
  }
}

// The least step of the search for a look is 0.05: the range between that and a first step of 0.02 is empty, which
// std::clamp must not be asked for (`dev` and `asan` check it).
TEST(FitJob, AFirstStepBelowTheLeastOfALookIsUsed) {
  const TempFolder folder;
  FitTask task = green_task(captured(folder));
  task.options.evaluations = 13;
  task.options.appearance_evaluations = 5;
  task.options.scan = 0;
  task.options.seeds = 0;
  task.options.step = 0.02;
  ASSERT_TRUE(std::any_of(task.parameters.begin(), task.parameters.end(),
                          [](const FitParameter& p) { return p.is_appearance; }));
  const Json report = run_fit(std::move(task), folder.path() / "fit");
  EXPECT_LE(report.at("objective").at("after").get<double>(), report.at("objective").at("before").get<double>());
}

TEST(FitJob, HasTheSameBytesForAnyNumberOfThreads) {
  const TempFolder folder;
  const fs::path history = captured(folder);
  std::string first;
  for (const int threads : {1, 3}) {
    FitTask task = green_task(history, 0.02);
    task.options.evaluations = 13;
    task.options.scan = 2;
    task.options.seeds = 1;
    (void)run_fit(std::move(task), folder.path() / std::to_string(threads), threads);
    const std::string tree = tree_of(folder.path() / std::to_string(threads));
    if (first.empty()) first = tree;
    EXPECT_EQ(tree, first) << threads << " threads";
  }
}

TEST(FitJob, StoppedAnywhereItGoesOnAndEndsInTheSameBytes) {
  const TempFolder folder;
  const fs::path history = captured(folder);
  const auto task_of = [&](int* count) {
    FitTask task = green_task(history, 0.02, count);
    task.options.evaluations = 13;
    task.options.scan = 2;
    task.options.seeds = 1;
    return task;
  };
  int num_whole = 0, num_pieces = 0;
  (void)run_fit(task_of(&num_whole), folder.path() / "whole", 1);
  for (const int after : {3, 16}) {
    std::stop_source stop;
    FitTask task = task_of(&num_pieces);
    int calls = 0;
    task.captures[0].age = [inner = task.captures[0].age, &calls, after, &stop](
                               const std::vector<double>& v, std::uint64_t shift, const RunControl& c) {
      if (++calls == after) stop.request_stop();
      return inner(v, shift, c);
    };
    EXPECT_THROW(run_fit(std::move(task), folder.path() / "pieces", 1, stop.get_token()), Canceled);
  }
  (void)run_fit(task_of(&num_pieces), folder.path() / "pieces", 1);
  EXPECT_EQ(tree_of(folder.path() / "pieces"), tree_of(folder.path() / "whole"));
  EXPECT_LE(num_pieces, num_whole + 2 * 2);  // A stop loses at most what was under way.
}

TEST(FitJob, ALargerBudgetGoesOnFromASmallerOne) {
  const TempFolder folder;
  const fs::path history = captured(folder);
  const auto task_of = [&](int evaluations, int* count) {
    FitTask task = green_task(history, 0.0, count);
    task.options.evaluations = evaluations;
    task.options.scan = 2;
    task.options.seeds = 1;
    return task;
  };
  int num_agings = 0;
  (void)run_fit(task_of(13, nullptr), folder.path() / "fit");
  (void)run_fit(task_of(19, &num_agings), folder.path() / "fit");
  // One more generation of six, then as after any search: a seed and what it is compared with, scans of two parameters
  // (each again along the valley, and with another seed, at most), one of the look, before and after.
  EXPECT_GE(num_agings, 6 + 2 + 2 * 2 + 1 + 2);
  EXPECT_LE(num_agings, 6 + 2 + 2 * 2 * (1 + 1 + 2) + 1 + 2);
  (void)run_fit(task_of(19, nullptr), folder.path() / "at_once");
  EXPECT_EQ(tree_of(folder.path() / "fit"), tree_of(folder.path() / "at_once"));
}

TEST(FitJob, LooksAloneNeedOneAging) {
  const TempFolder folder;
  int num_agings = 0;
  FitTask task = green_task(captured(folder), 0.0, &num_agings);
  task.parameters[0].start = kGreenTruth[0];
  task.parameters = {task.parameters[1]};
  task.captures[0].age = [inner = task.captures[0].age](const std::vector<double>& v, std::uint64_t shift,
                                                        const RunControl& c) -> ComposeWith {
    return [look = inner({kGreenTruth[0], v[0], 0.0}, shift, c)](const std::vector<double>& l, const RunControl& lc) {
      return look({kGreenTruth[0], l[0], 0.0}, lc);
    };
  };
  task.options.seeds = 0;
  const Json report = run_fit(std::move(task), folder.path() / "fit");
  EXPECT_NEAR(report.at("parameters")[0].at("best").get<double>(), kGreenTruth[1], 0.01);
  EXPECT_EQ(num_agings, 1 + 1 + 2);  // the search; the scan; before and after
  EXPECT_GT(report.at("evaluations").at("appearance_evaluations").get<int>(), 20);
}

TEST(FitJob, ValuesThatTheModelRefusesAreRankedLastAndNamed) {
  const TempFolder folder;
  FitTask task = green_task(captured(folder));
  task.captures[0].age = [inner = task.captures[0].age](const std::vector<double>& v, std::uint64_t shift,
                                                        const RunControl& c) -> ComposeWith {
    if (v[0] > 1.0) throw InvalidInput("the rate and the strength do not go together");
    return inner(v, shift, c);
  };
  task.options.evaluations = 37;
  const Json report = run_fit(std::move(task), folder.path() / "fit");
  EXPECT_NEAR(report.at("parameters")[0].at("best").get<double>(), kGreenTruth[0], 0.1 * kGreenTruth[0]);
  EXPECT_TRUE(has(read_file(folder.path() / "fit/evaluations.csv"), "do not go together"));
}

TEST(FitJob, SaysBeforeAnyWorkWhatCannotBeFitted) {
  const TempFolder folder;
  const fs::path history = captured(folder);
  const auto message = [&](const std::function<void(FitTask&)>& change) {
    FitTask task = green_task(history);
    change(task);
    return error_of([&] { (void)plan_fit(std::move(task), folder.path() / "fit"); });
  };
  EXPECT_TRUE(has(message([](FitTask& t) { t.options.evaluations = 5; }), "too small"));
  EXPECT_TRUE(has(message([](FitTask& t) { t.parameters[0].start = 3.0; }), "/rate: starts at 3"));
  EXPECT_TRUE(has(message([](FitTask& t) { t.captures[0].outline.times = {100, 101}; }), "no time in common"));
  EXPECT_TRUE(has(message([](FitTask& t) { t.captures[0].outline.times = {8, 9}; }), "only one time in common"));
  EXPECT_TRUE(has(message([](FitTask& t) {
                    t.terms = {{.figure = FitFigure::ColorByControl}};
                    t.captures[0].outline.control_names = {"hits", "y"};
                  }),
                  "no control in common"));
  EXPECT_TRUE(has(message([](FitTask& t) {
                    t.terms = {{.figure = FitFigure::Ciede2000}};
                    t.captures[0].outline.width = 64;
                  }),
                  "place by place"));
  EXPECT_TRUE(has(message([](FitTask& t) {
                    t.terms = {{.figure = FitFigure::Covered}};
                    t.objective.visible_delta_e = 500;
                  }),
                  "does not age visibly"));
  AgedSurface one = green_plate(kGreenTruth);
  one.times.resize(1);
  one.colors.resize(1);
  write_surface(folder.path() / "one", one, "0123456789abcdef");
  EXPECT_TRUE(has(message([&](FitTask& t) { t.captures[0].history = folder.path() / "one"; }), "has one frame"));
}

}  // namespace
}  // namespace patinate::analysis
