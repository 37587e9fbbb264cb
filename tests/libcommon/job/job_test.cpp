#include "libcommon/job/job.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "libcommon/core/files.h"
#include "patinate/core/json.h"
#include "tests/libcommon/job/job_tree.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"
#include "tests/support/threads.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;
using testing_support::error_of;
using testing_support::TempFolder;
using testing_support::Tree;
using testing_support::tree_of;
using testing_support::with_threads;

/// Eight items of one file each; `hook(i)` is called before item i writes.
JobPlan sample_plan(const fs::path& output, const std::string& key, const std::function<void(int)>& hook = {}) {
  JobPlan plan;
  plan.output = output;
  plan.manifest = "sample.json";
  plan.key = key;
  for (int i = 0; i < 8; ++i) {
    const fs::path file = "parts/" + std::to_string(i) + ".txt";
    plan.items.push_back({.name = "part" + std::to_string(i),
                          .outputs = {file},
                          .run = [i, file, key, hook](const fs::path& folder, const RunControl&) {
                            if (hook) hook(i);
                            write_atomically(folder / file, key + std::to_string(i));
                          }});
  }
  plan.join = [key](const fs::path& folder, const RunControl&) {
    save_json(folder / "sample.json", Json{{"key", key}});
  };
  return plan;
}

std::string refusal_of(const JobPlan& plan, const JobOptions& options = {}) {
  return error_of<CannotComplete>([&] { (void)run_job(plan, options, {}); });
}

TEST(Job, MakesOutputsAndManifestAndNothingElse) {
  TempFolder temp;
  for (int n : {1, 3}) {
    const fs::path out = temp / ("out" + std::to_string(n));
    EXPECT_EQ(run_job(sample_plan(out, "k"), {}, with_threads(n)), JobStatus::Done);
    const Tree tree = tree_of(out);
    EXPECT_EQ(tree.size(), 11u);  // 8 files, their folder, the manifest, job.json
    EXPECT_EQ(tree.at("parts/3.txt"), "k3");
    EXPECT_FALSE(fs::exists(out.string() + ".partial"));
  }
}

TEST(Job, AStageBeginsWhenTheEarlierOnesAreFinished) {
  TempFolder temp;
  JobPlan plan = sample_plan(temp / "out", "k");
  std::atomic<int> num_early{0}, num_too_soon{0};
  for (std::size_t i = 0; i < plan.items.size(); ++i) {
    plan.items[i].stage = i % 2 == 0 ? 1 : 0;  // Late ones first in the list.
    plan.items[i].run = [&, late = i % 2 == 0, file = plan.items[i].outputs[0]](const fs::path& folder,
                                                                                const RunControl&) {
      if (late && num_early != 4) ++num_too_soon;
      write_atomically(folder / file, "x");
      if (!late) ++num_early;
    };
  }
  EXPECT_EQ(run_job(plan, {}, with_threads(3)), JobStatus::Done);
  EXPECT_EQ(num_too_soon, 0);
}

TEST(Job, RunsNoItemWhenTheOutputIsUpToDate) {
  TempFolder temp;
  (void)run_job(sample_plan(temp / "out", "k"), {}, {});
  std::atomic<int> runs{0};
  EXPECT_EQ(run_job(sample_plan(temp / "out", "k", [&](int) { ++runs; }), {}, {}), JobStatus::UpToDate);
  EXPECT_EQ(run_job(sample_plan(temp / "out", "k", [&](int) { ++runs; }), {.force = true, .keeps_same = true}, {}),
            JobStatus::UpToDate);
  EXPECT_EQ(run_job(sample_plan(temp / "out/", "k", [&](int) { ++runs; }), {}, {}), JobStatus::UpToDate);
  EXPECT_EQ(runs, 0);
}

TEST(Job, LeavesADifferentOutputUntouchedUnlessForced) {
  TempFolder temp;
  (void)run_job(sample_plan(temp / "out", "old"), {}, {});
  const Tree before = tree_of(temp / "out");
  EXPECT_NE(refusal_of(sample_plan(temp / "out", "new")).find("--force"), std::string::npos);
  EXPECT_EQ(tree_of(temp / "out"), before);
  EXPECT_EQ(run_job(sample_plan(temp / "out", "new"), {.force = true}, {}), JobStatus::Done);
  EXPECT_EQ(tree_of(temp / "out").at("parts/0.txt"), "new0");
  EXPECT_FALSE(fs::exists(temp / "out.partial"));
}

TEST(Job, NeverRemovesWhatItDidNotMake) {
  TempFolder temp;
  fs::create_directory(temp / "photos");
  write_atomically(temp / "photos" / "a.jpg", "precious");
  write_atomically(temp / "file", "precious");
  fs::create_directory(temp / "out.partial");
  write_atomically(temp / "out.partial" / "a.jpg", "precious");
  for (const char* name : {"photos", "file", "out"}) {
    EXPECT_NE(refusal_of(sample_plan(temp / name, "k"), {.force = true}), "") << name;
  }
  EXPECT_EQ(tree_of(temp.path()).size(), 5u);
}

TEST(Job, TakesAnEmptyFolderAsItsOutput) {
  TempFolder temp;
  fs::create_directory(temp / "out");
  EXPECT_EQ(run_job(sample_plan(temp / "out", "k"), {}, {}), JobStatus::Done);
}

TEST(Job, SaysWhichFolderIsMissing) {
  TempFolder temp;
  EXPECT_NE(refusal_of(sample_plan(temp / "no" / "out", "k")).find((temp / "no").string()), std::string::npos);
  write_atomically(temp / "file", "");
  EXPECT_NE(refusal_of(sample_plan(temp / "file" / "out", "k")), "");
}

TEST(Job, GoesOnWithFinishedItemsAfterCanceling) {
  TempFolder temp;
  (void)run_job(sample_plan(temp / "whole", "k"), {}, {});
  std::stop_source stop;
  RunControl control = with_threads(1);
  control.stop = stop.get_token();
  const auto stop_at_5 = [&](int i) {
    if (i == 5) stop.request_stop();
  };
  EXPECT_THROW((void)run_job(sample_plan(temp / "out", "k", stop_at_5), {}, control), Canceled);
  EXPECT_FALSE(fs::exists(temp / "out"));
  std::vector<int> runs;
  JobOptions options;
  std::size_t num_done = 0, num_items = 0;
  options.on_resume = [&](std::size_t done, std::size_t items, const std::string&) {
    num_done = done, num_items = items;
  };
  EXPECT_EQ(run_job(sample_plan(temp / "out", "k", [&](int i) { runs.push_back(i); }), options, with_threads(1)),
            JobStatus::Done);
  // Files written when the stop came are brought to the disk now, not made again.
  EXPECT_EQ(runs, (std::vector<int>{6, 7}));
  EXPECT_EQ(num_done, 6u);
  EXPECT_EQ(num_items, 8u);
  EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "whole"));
}

/// A run that is stopped when item 0 of `plan` is written and not yet marked. @returns where that is noted.
fs::path stopped_when_written(const fs::path& output) {
  std::stop_source stop;
  RunControl control = with_threads(1);
  control.stop = stop.get_token();
  const auto stop_at_0 = [&](int i) {
    if (i == 0) stop.request_stop();
  };
  EXPECT_THROW((void)run_job(sample_plan(output, "k", stop_at_0), {}, control), Canceled);
  const fs::path book = output.string() + ".partial/.job";
  EXPECT_FALSE(fs::exists(book / "done"));
  EXPECT_EQ(std::distance(fs::directory_iterator(book / "written"), {}), 1);
  return fs::directory_iterator(book / "written")->path();
}

std::vector<int> items_run(const fs::path& output) {
  std::vector<int> runs;
  EXPECT_EQ(run_job(sample_plan(output, "k", [&](int i) { runs.push_back(i); }), {}, with_threads(1)), JobStatus::Done);
  return runs;
}

TEST(Job, TheOnlyItemThatWasWrittenWhenItWasStoppedIsKept) {
  TempFolder temp;
  (void)stopped_when_written(temp / "out");
  EXPECT_EQ(items_run(temp / "out"), (std::vector<int>{1, 2, 3, 4, 5, 6, 7}));
}

TEST(Job, WhatWasWrittenBeforeTheMachineStartedAnewIsMadeAgain) {
  // After a power cut a file that nothing forced to the disk may hold anything.
  TempFolder temp;
  const fs::path note = stopped_when_written(temp / "out");
  std::string text = read_file(note);
  ASSERT_GT(text.size(), 2u);
  text[text.size() - 2] = text[text.size() - 2] == '0' ? '1' : '0';  // Its last line is this start of the machine.
  std::ofstream(note) << text;
  write_atomically(temp / "out.partial/parts/0.txt", "");
  EXPECT_EQ(items_run(temp / "out").front(), 0);
  (void)run_job(sample_plan(temp / "whole", "k"), {}, {});
  EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "whole"));
}

TEST(Job, WhatWasWrittenIsMadeAgainWhereAFileIsGone) {
  TempFolder temp;
  (void)stopped_when_written(temp / "out");
  fs::remove(temp / "out.partial/parts/0.txt");
  EXPECT_EQ(items_run(temp / "out").front(), 0);
}

TEST(Job, WhatWasWrittenDoesNotVouchForWhatAnotherPlanMadeOfIt) {
  TempFolder temp;
  (void)stopped_when_written(temp / "out");
  const auto fail_at_1 = [](int i) {
    if (i == 1) throw CannotComplete("disk full");
  };
  EXPECT_THROW((void)run_job(sample_plan(temp / "out", "other", fail_at_1), {}, with_threads(1)), CannotComplete);
  EXPECT_EQ(items_run(temp / "out").front(), 0);
  EXPECT_EQ(read_file(temp / "out/parts/0.txt"), "k0");
}

TEST(Job, DiscardsAPartialResultOfAnotherKey) {
  TempFolder temp;
  const auto fail_at_4 = [](int i) {
    if (i == 4) throw CannotComplete("disk full");
  };
  EXPECT_THROW((void)run_job(sample_plan(temp / "out", "old", fail_at_4), {}, with_threads(1)), CannotComplete);
  EXPECT_TRUE(fs::exists(temp / "out.partial"));
  EXPECT_EQ(run_job(sample_plan(temp / "out", "new"), {}, {}), JobStatus::Done);
  EXPECT_EQ(tree_of(temp / "out").at("parts/0.txt"), "new0");
}

TEST(Job, LeavesNothingBehindWhenNothingIsFinished) {
  TempFolder temp;
  const auto bad_photo = [](int) { throw IoError("a.jpg", "is truncated"); };
  EXPECT_THROW((void)run_job(sample_plan(temp / "out", "k", bad_photo), {}, with_threads(1)), IoError);
  EXPECT_TRUE(fs::is_empty(temp.path()));
}

TEST(Job, GoesOnWithFinishedItemsAfterWrongInput) {
  TempFolder temp;
  (void)run_job(sample_plan(temp / "whole", "k"), {}, {});
  const auto bad_photo = [](int i) {
    if (i == 4) throw IoError("a.jpg", "is truncated");
  };
  EXPECT_THROW((void)run_job(sample_plan(temp / "out", "k", bad_photo), {}, with_threads(1)), IoError);
  EXPECT_FALSE(fs::exists(temp / "out"));
  std::vector<int> runs;
  (void)run_job(sample_plan(temp / "out", "k", [&](int i) { runs.push_back(i); }), {}, with_threads(1));
  EXPECT_EQ(runs, (std::vector<int>{4, 5, 6, 7}));
  EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "whole"));
}

/// Plan like sample_plan(), but every item has a key of its own, which is what it writes; `hook(i)` is called after
/// that.
JobPlan keyed_plan(const fs::path& output, const std::vector<std::string>& keys,
                   const std::function<void(int)>& hook = {}) {
  std::string plan_key;
  for (const std::string& key : keys) plan_key += key;
  JobPlan plan = sample_plan(output, plan_key);
  plan.items.resize(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    plan.items[i].key = keys[i];
    plan.items[i].run = [i, key = keys[i], file = plan.items[i].outputs[0], hook](const fs::path& folder,
                                                                                  const RunControl&) {
      write_atomically(folder / file, key);
      if (hook) hook(static_cast<int>(i));
    };
  }
  return plan;
}

TEST(Job, AnotherPlanKeepsFinishedItemsWhoseOwnKeyIsTheSame) {
  TempFolder temp;
  const std::vector<std::string> changed{"a", "b", "C", "d", "E", "f"};
  (void)run_job(keyed_plan(temp / "whole", changed), {}, {});
  const auto fail_at_4 = [](int i) {
    if (i == 4) throw IoError("e.jpg", "is truncated");
  };
  EXPECT_THROW((void)run_job(keyed_plan(temp / "out", {"a", "b", "c", "d", "e"}, fail_at_4), {}, with_threads(1)),
               IoError);
  std::vector<int> runs;
  (void)run_job(keyed_plan(temp / "out", changed, [&](int i) { runs.push_back(i); }), {}, with_threads(1));
  EXPECT_EQ(runs, (std::vector<int>{2, 4, 5}));
  EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "whole"));
}

TEST(Job, AMarkerDoesNotVouchForWhatAnotherPlanWroteOverItsFile) {
  TempFolder temp;
  const auto fail_at = [](int k) {
    return [k](int i) {
      if (i == k) throw CannotComplete("disk full");
    };
  };
  const std::vector<std::string> keys{"a", "b", "c"};
  EXPECT_THROW((void)run_job(keyed_plan(temp / "out", keys, fail_at(2)), {}, with_threads(1)), CannotComplete);
  EXPECT_THROW((void)run_job(keyed_plan(temp / "out", {"a", "B", "c"}, fail_at(1)), {}, with_threads(1)),
               CannotComplete);
  (void)run_job(keyed_plan(temp / "out", keys), {}, with_threads(1));
  EXPECT_EQ(tree_of(temp / "out").at("parts/1.txt"), "b");
}

TEST(Job, ReportsRisingFractionsThatEndAtOne) {
  TempFolder temp;
  std::vector<double> fractions;
  RunControl control = with_threads(2);
  control.on_progress = [&](double f) { fractions.push_back(f); };
  (void)run_job(sample_plan(temp / "out", "k"), {}, control);
  ASSERT_GE(fractions.size(), 9u);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
  EXPECT_EQ(std::count(fractions.begin(), fractions.end(), 1.0), 1);
}

// Two items, one of which takes eight times as long as the other and as the join: of all ten parts, one is done after
// the first and nine after the second.
TEST(Job, ItemsCountByTheirWeights) {
  TempFolder temp;
  std::vector<double> fractions;
  RunControl control = with_threads(1);
  control.on_progress = [&](double f) { fractions.push_back(f); };
  JobPlan plan = sample_plan(temp / "out", "k");
  plan.items.resize(2);
  plan.items[0].weight = 1.0;
  plan.items[1].weight = 8.0;
  plan.items[1].stage = 1;
  plan.join_weight = 1.0;
  (void)run_job(plan, {}, control);
  EXPECT_NE(std::find(fractions.begin(), fractions.end(), 1.0 / 10.0), fractions.end());
  EXPECT_NE(std::find(fractions.begin(), fractions.end(), 9.0 / 10.0), fractions.end());
  plan.items[1].weight = 0.0;
  EXPECT_THROW((void)run_job(plan, {}, control), InvalidInput);
}

TEST(Job, RefusesItemNamesThatAreNoFileNames) {
  TempFolder temp;
  JobPlan plan = sample_plan(temp / "out", "k");
  plan.items[1].name = plan.items[0].name;
  EXPECT_THROW((void)run_job(plan, {}, {}), InvalidInput);
  plan.items[1].name = "../escape";
  EXPECT_THROW((void)run_job(plan, {}, {}), InvalidInput);
  plan = sample_plan(temp / "out", "k");
  plan.items[0].outputs = {"../escape.txt"};
  EXPECT_THROW((void)run_job(plan, {}, {}), InvalidInput);
}

/// Runs the job in a child process, which is killed once `ready` items are finished.
void kill_after_items(const JobPlan& plan, int ready) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    try {
      (void)run_job(plan, {}, with_threads(1));
    } catch (...) {
    }
    ::_exit(0);
  }
  const fs::path done = plan.output.string() + ".partial/.job/done";
  const auto num_done = [&] {
    std::error_code error;
    const fs::directory_iterator markers(done, error);
    return std::count_if(begin(markers), end(markers),
                         [](const auto& e) { return e.path().stem().string()[0] != '.'; });
  };
  for (int i = 0; i < 2000 && num_done() < ready; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ::kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status)) << "the job ended before it was killed";
}

TEST(Job, KilledAnywhereItFinishesWithTheSameBytes) {
  TempFolder temp;
  (void)run_job(sample_plan(temp / "whole", "k"), {}, {});
  for (int kill_at : {0, 1, 4, 7}) {
    const fs::path out = temp / ("out" + std::to_string(kill_at));
    const auto hang = [&](int i) {
      if (i < kill_at) return;
      // Leftover of a kill in the middle of writing.
      std::ofstream(out.string() + ".partial/parts/." + std::to_string(i) + ".tmp99.txt") << "half";
      std::this_thread::sleep_for(std::chrono::seconds(30));
    };
    kill_after_items(sample_plan(out, "k", hang), kill_at);
    std::vector<int> runs;
    EXPECT_EQ(run_job(sample_plan(out, "k", [&](int i) { runs.push_back(i); }), {}, with_threads(1)), JobStatus::Done);
    EXPECT_EQ(static_cast<int>(runs.size()), 8 - kill_at);
    EXPECT_EQ(tree_of(out), tree_of(temp / "whole"));
  }
}

TEST(Job, FinishesWhenKilledBetweenTheJoinAndTheRename) {
  TempFolder temp;
  (void)run_job(sample_plan(temp / "out", "k"), {}, {});
  fs::rename(temp / "out", temp / "out.partial");
  std::atomic<int> runs{0};
  EXPECT_EQ(run_job(sample_plan(temp / "out", "k", [&](int) { ++runs; }), {}, {}), JobStatus::Done);
  EXPECT_EQ(runs, 0);
  EXPECT_EQ(tree_of(temp / "out").size(), 11u);
}

TEST(Job, TwoProcessesDoNotMakeTheSameOutput) {
  TempFolder temp;
  const JobPlan plan =
      sample_plan(temp / "out", "k", [](int) { std::this_thread::sleep_for(std::chrono::seconds(30)); });
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    (void)run_job(plan, {}, with_threads(1));
    ::_exit(0);
  }
  while (!fs::exists(temp / "out.partial" / ".job" / "key")) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_NE(refusal_of(sample_plan(temp / "out", "k")).find("another process"), std::string::npos);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(refusal_of(sample_plan(temp / "out", "k")), "");
}

TEST(OutputFile, IsReplacedOnlyWithForceOrWhenAbsent) {
  TempFolder temp;
  EXPECT_EQ(check_output_file(temp / "a.png", "", "k", {}), JobStatus::Done);
  write_atomically(temp / "a.png", "x");
  EXPECT_EQ(check_output_file(temp / "a.png", "k", "k", {}), JobStatus::UpToDate);
  EXPECT_THROW((void)check_output_file(temp / "a.png", "other", "k", {}), CannotComplete);
  EXPECT_THROW((void)check_output_file(temp / "a.png", "", "k", {}), CannotComplete);
  EXPECT_EQ(check_output_file(temp / "a.png", "other", "k", {.force = true}), JobStatus::Done);
  EXPECT_THROW((void)check_output_file(temp.path(), "", "k", {.force = true}), CannotComplete);
}

TEST(RunRecord, StandsBesideTheManifest) {
  TempFolder temp;
  write_run_record(temp.path(), {"patinate", "ingest", "a.json"}, 1.5,
                   {{"threads", {{"value", 2}, {"from", "default"}}}});
  const Json record = load_json(temp / "run.json");
  EXPECT_EQ(record["command"][1], "ingest");
  EXPECT_EQ(record["seconds"], 1.5);
  EXPECT_EQ(record["options"]["threads"]["value"], 2);
}

}  // namespace
}  // namespace patinate
