// Replicates of one process against replicates of another, from histories on disk to the report.
#include "analysis/compare/replicates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/compare/compare_job.h"
#include "analysis/compare/replicates_job.h"
#include "libcommon/core/files.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/analysis/compare/report_figure.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

namespace fs = std::filesystem;
using testing_support::report_figure;
using testing_support::TempFolder;
using testing_support::write_history;

/// Smooth blotches from a seed that darken by `change`: one process, other seeds.
void write_replicate(const fs::path& folder, std::uint64_t seed, float change, int side = 32) {
  write_history(folder, side, side, 3, [=](int x, int y, int frame, int channel) {
    double sum = 0.0;
    for (std::uint64_t wave = 0; wave < 6; ++wave) {
      RandomStream random(seed, wave);
      const double u = random.normal(), v = random.normal(), phase = 6.28 * random.uniform();
      sum += std::sin(6.28 * (u * x + v * y) / side + phase);
    }
    const auto pattern = static_cast<float>(0.05 * sum);
    return 0.6f + 0.02f * static_cast<float>(channel) + 0.5f * pattern -
           (change + pattern) * static_cast<float>(frame) / 4.0f;
  });
  Json manifest = load_json(folder / "history.json");
  manifest["key"] = std::to_string(1'000'000'000'000'000 + seed);  // Every history has a key of its own.
  save_json(folder / "history.json", manifest);
}

class Replicates : public testing::Test {
 protected:
  ReplicatesTask task(int size_a, int size_b, std::uint64_t seed, float change_b, int side = 32) const {
    ReplicatesTask t{.a = {}, .b = {}, .names = {}, .options = {}, .command = "patinate history compare"};
    for (int k = 0; k < size_a + size_b; ++k) {
      const bool is_a = k < size_a;
      const std::string name = std::to_string(seed) + (is_a ? "a" : "b") + std::to_string(k);
      write_replicate(folder_ / name, 1000 * seed + static_cast<std::uint64_t>(k), is_a ? 0.5f : change_b, side);
      (is_a ? t.a : t.b).push_back(folder_ / name);
      t.names.push_back(name);
    }
    return t;
  }
  Json compared(const ReplicatesTask& t, const std::string& name, int num_threads = 0) const {
    RunControl control;
    control.num_threads = num_threads;
    EXPECT_EQ(run_job(plan_replicates(t, folder_ / name), {}, control), JobStatus::Done);
    return load_json(folder_ / name / kCompareReportFile);
  }
  std::string refusal(const ReplicatesTask& t) const {
    try {
      (void)plan_replicates(t, folder_ / "bad");
    } catch (const InvalidInput& e) {
      return e.what();
    }
    return "";
  }
  TempFolder folder_;
};

TEST_F(Replicates, ARealDifferenceIsFoundWithTheSmallestPThatThereIs) {
  const Json report = compared(task(4, 4, 1, 0.3f), "r");
  const Json& f = report_figure(report, "color_distribution");
  EXPECT_NEAR(f.at("p").get<double>(), 2.0 / 70.0, 1e-8);  // C(8, 4) = 70 and the mirror image.
  EXPECT_NEAR(report.at("overall_p").get<double>(), 2.0 / 70.0, 1e-8);
  EXPECT_GT(f.at("effect").get<double>(), 2.0);
  EXPECT_GT(f.at("between").get<double>(), f.at("within_a").get<double>());
}

TEST_F(Replicates, OfOneProcessAreCalledDifferentAsOftenAsItSays) {
  // 3 against 3: p is 0.1, 0.2, ..., so that 0.2 is reached in at most a fifth of 20 sets; of 20, 11 or more are
  // called different in one of 3000 such tests [binomial law, 0.2].
  int alarms = 0;
  for (std::uint64_t set = 0; set < 20; ++set) {
    ReplicatesTask t = task(3, 3, 50 + set, 0.5f, 24);
    const Json report = compared(t, "null" + std::to_string(set));
    EXPECT_GE(report.at("overall_p").get<double>(), 0.1 - 1e-9);
    alarms += report.at("overall_p").get<double>() <= 0.2 + 1e-9 ? 1 : 0;
  }
  EXPECT_LE(alarms, 10);
}

TEST_F(Replicates, ExchangingTheSidesExchangesTheColumnsAndNothingElse) {
  const ReplicatesTask t = task(2, 3, 2, 0.4f);
  ReplicatesTask swapped = t;
  std::swap(swapped.a, swapped.b);
  std::rotate(swapped.names.begin(), swapped.names.begin() + 2, swapped.names.end());
  const Json one = compared(t, "one"), other = compared(swapped, "other");
  for (const Json& f : one.at("figures")) {
    const Json& g = report_figure(other, f.at("name"));
    ASSERT_EQ(f.contains("p"), g.contains("p")) << f.dump();
    if (!f.contains("p")) continue;
    EXPECT_EQ(f.at("between"), g.at("between"));
    EXPECT_EQ(f.at("within_a"), g.at("within_b"));
    EXPECT_EQ(f.at("p"), g.at("p")) << f.dump();
  }
}

TEST_F(Replicates, SayWhatTheirNumberCannotShow) {
  const Json report = compared(task(2, 2, 3, 0.3f), "r");
  EXPECT_NEAR(report.at("smallest_p").get<double>(), 1.0 / 3.0, 1e-8);
  EXPECT_NE(report.at("verdict").dump().find("one figure alone cannot be below"), std::string::npos);
  const auto enough = report.at("enough_a_side").get<std::size_t>();
  std::size_t defined = 0;
  for (const Json& f : report.at("figures")) defined += f.contains("p") ? 1 : 0;
  EXPECT_LE(static_cast<double>(defined) * smallest_permutation_p(enough, enough), 0.05);
  EXPECT_GT(static_cast<double>(defined) * smallest_permutation_p(enough - 1, enough - 1), 0.05);
}

TEST_F(Replicates, WriteTheSameBytesOnAnyNumberOfThreads) {
  const ReplicatesTask t = task(2, 2, 4, 0.4f);
  (void)compared(t, "one", 1);
  (void)compared(t, "three", 3);
  for (const char* file : {"report.html", "report.json", "figures.csv", "distances.csv"})
    EXPECT_EQ(read_file(folder_ / "one" / file, 1 << 24), read_file(folder_ / "three" / file, 1 << 24)) << file;
}

TEST_F(Replicates, AnInterruptedRunKeepsItsPairs) {
  const ReplicatesTask t = task(2, 2, 5, 0.4f);
  JobPlan broken = plan_replicates(t, folder_ / "r");
  ASSERT_EQ(broken.items.size(), 7u);  // Six pairs and the pictures.
  broken.items[4].run = [](const fs::path&, const RunControl&) { throw CannotComplete("interrupted"); };
  EXPECT_THROW((void)run_job(broken, {}, {}), CannotComplete);
  JobPlan again = plan_replicates(t, folder_ / "r");
  int num_run = 0;
  for (JobItem& item : again.items)
    item.run = [&num_run, run = item.run](const fs::path& folder, const RunControl& control) {
      ++num_run;
      run(folder, control);
    };
  EXPECT_EQ(run_job(again, {}, {}), JobStatus::Done);
  EXPECT_EQ(num_run, 3);
  (void)compared(t, "whole");
  EXPECT_EQ(read_file(folder_ / "r/report.json", 1 << 24), read_file(folder_ / "whole/report.json", 1 << 24));
}

TEST_F(Replicates, AreRefusedInOneSentence) {
  ReplicatesTask t = task(2, 2, 6, 0.4f);
  ReplicatesTask alone = t;
  alone.b.pop_back();
  EXPECT_NE(refusal(alone).find("B has one replicate"), std::string::npos) << refusal(alone);
  ReplicatesTask twice = t;
  twice.b[1] = t.a[0];
  EXPECT_NE(refusal(twice).find("are the same history"), std::string::npos) << refusal(twice);
  ReplicatesTask mixed = t;
  write_replicate(folder_ / "small", 9, 0.5f, 16);
  mixed.b[1] = folder_ / "small";
  EXPECT_NE(refusal(mixed).find("have one size"), std::string::npos) << refusal(mixed);
}

}  // namespace
}  // namespace patinate::analysis
