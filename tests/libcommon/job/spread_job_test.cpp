#include "libcommon/job/spread_job.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
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

constexpr std::size_t kParts = 6;

/// Six parts, a sum of what they wrote that is work only, and four files more that read it. `hook(i)` is called before
/// item i writes.
JobPlan staged_plan(const fs::path& output, const std::string& key, const std::function<void(std::size_t)>& hook = {}) {
  JobPlan plan{
      .output = output, .manifest = "sample.json", .key = key, .depends_on = {{"key", key}}, .items = {}, .join = {}};
  const fs::path sum = fs::path(kJobWorkFolder) / "sum.txt";
  const auto part = [](std::size_t i) { return fs::path("parts") / (std::to_string(i) + ".txt"); };
  for (std::size_t i = 0; i < kParts; ++i) {
    plan.items.push_back({.name = "part" + std::to_string(i),
                          .outputs = {part(i)},
                          .run = [=](const fs::path& folder, const RunControl&) {
                            if (hook) hook(i);
                            write_atomically(folder / part(i), key + std::to_string(i));
                          }});
  }
  plan.items.push_back({.name = "sum",
                        .outputs = {sum},
                        .run =
                            [=](const fs::path& folder, const RunControl&) {
                              if (hook) hook(kParts);
                              std::string all;
                              for (std::size_t i = 0; i < kParts; ++i) all += read_file(folder / part(i));
                              write_atomically(folder / sum, all);
                            },
                        .stage = 1});
  for (std::size_t i = 0; i < 4; ++i) {
    const fs::path file = "late" + std::to_string(i) + ".txt";
    plan.items.push_back({.name = "late" + std::to_string(i),
                          .outputs = {file},
                          .run =
                              [=](const fs::path& folder, const RunControl&) {
                                if (hook) hook(kParts + 1 + i);
                                write_atomically(folder / file, read_file(folder / sum) + std::to_string(i));
                              },
                          .stage = 2});
  }
  plan.join = [=](const fs::path& folder, const RunControl&) {
    save_json(folder / "sample.json", Json{{"sum", read_file(folder / sum)}, {"key", key}});
  };
  return plan;
}

std::vector<std::size_t> all_items(const JobPlan& plan) {
  std::vector<std::size_t> all(plan.items.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

std::size_t run_some(const JobPlan& plan, const std::vector<std::size_t>& items) {
  return run_spread_items(plan, items, {}, {});
}

TEST(SpreadJob, ItemsInAnyPortionsAndAnyOrderOfAStageGiveTheBytesOfOneRun) {
  TempFolder temp;
  (void)run_job(staged_plan(temp / "whole", "k"), {}, {});
  const Tree whole = tree_of(temp / "whole");
  const std::vector<std::vector<std::vector<std::size_t>>> ways{{{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}},
                                                                {{5}, {3, 1}, {0, 4, 2}, {6}, {10, 7}, {8, 9}},
                                                                {{4, 5}, {0, 1, 2, 3, 6}, {7, 8, 9, 10}}};
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const fs::path out = temp / ("out" + std::to_string(w));
    for (const auto& portion : ways[w]) {
      EXPECT_EQ(run_some(staged_plan(out, "k"), portion), portion.size());  // A plan of its own, as in a process.
      EXPECT_FALSE(fs::exists(out));
    }
    EXPECT_EQ(join_spread_items(staged_plan(out, "k"), {}, {}), JobStatus::Done);
    EXPECT_EQ(tree_of(out), whole);
    EXPECT_FALSE(fs::exists(out.string() + ".items"));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(temp.path()), fs::directory_iterator()), 4);  // No work left.
}

TEST(SpreadJob, AFinishedItemIsNeverRunAgain) {
  TempFolder temp;
  std::vector<std::size_t> runs;
  const JobPlan plan = staged_plan(temp / "out", "k", [&](std::size_t i) { runs.push_back(i); });
  EXPECT_EQ(run_some(plan, {2, 4}), 2u);
  EXPECT_EQ(run_spread_items(plan, all_items(plan), {}, with_threads(1)), plan.items.size() - 2);
  std::sort(runs.begin(), runs.end());
  EXPECT_EQ(runs, all_items(plan));
  (void)join_spread_items(plan, {}, {});
  EXPECT_EQ(run_some(plan, all_items(plan)), 0u);
  EXPECT_EQ(join_spread_items(plan, {}, {}), JobStatus::UpToDate);
  EXPECT_EQ(runs.size(), plan.items.size());
}

TEST(SpreadJob, SaysWhichItemsAreMissing) {
  TempFolder temp;
  const JobPlan plan = staged_plan(temp / "out", "k");
  (void)run_some(plan, {0, 3, 4});
  EXPECT_NE(error_of<Error>([&] { (void)run_some(plan, {6}); }).find("item 6 (sum) waits for items 1-2, 5"),
            std::string::npos);
  EXPECT_NE(
      error_of<Error>([&] { (void)join_spread_items(plan, {}, {}); }).find("8 of 11 items are not finished: 1-2, 5-10"),
      std::string::npos);
  EXPECT_FALSE(fs::exists(temp / "out"));
  const SpreadState state = spread_state(plan);
  EXPECT_FALSE(state.is_up_to_date);
  EXPECT_EQ(std::count(state.is_finished.begin(), state.is_finished.end(), true), 3);
}

TEST(SpreadJob, AnItemOfOtherInputIsNoneOfThePlan) {
  TempFolder temp;
  (void)run_some(staged_plan(temp / "out", "old"), {0, 1, 2, 3, 4, 5});
  EXPECT_EQ(run_some(staged_plan(temp / "out", "new"), {0, 1, 2, 3, 4, 5}), 6u);
}

pid_t in_another_process(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  int code = 0;
  try {
    work();
  } catch (...) {
    code = 1;
  }
  ::_exit(code);
}

int code_of(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(SpreadJob, ProcessesThatDoTheSameAtOnceAllEndWell) {
  TempFolder temp;
  (void)run_job(staged_plan(temp / "whole", "k"), {}, {});
  for (int round = 0; round < 8; ++round) {
    const fs::path out = temp / ("out" + std::to_string(round));
    std::vector<pid_t> children;
    for (int c = 0; c < 4; ++c) {
      children.push_back(in_another_process([&] {
        const JobPlan plan = staged_plan(out, "k");
        (void)run_spread_items(plan, all_items(plan), {}, with_threads(1));
        (void)join_spread_items(plan, {}, with_threads(1));
      }));
    }
    for (const pid_t child : children) EXPECT_EQ(code_of(child), 0);
    EXPECT_EQ(tree_of(out), tree_of(temp / "whole"));
    EXPECT_FALSE(fs::exists(out.string() + ".items"));
  }
}

TEST(SpreadJob, KilledAnywhereItLeavesNoHalfItemAndTheOthersGoOn) {
  TempFolder temp;
  (void)run_job(staged_plan(temp / "whole", "k"), {}, {});
  for (const std::size_t kill_at : {0u, 3u, 6u, 8u}) {
    const fs::path out = temp / ("out" + std::to_string(kill_at));
    const pid_t child = in_another_process([&] {
      const JobPlan plan = staged_plan(out, "k", [&](std::size_t i) {
        if (i == kill_at) ::raise(SIGKILL);
      });
      (void)run_spread_items(plan, all_items(plan), {}, with_threads(1));
    });
    EXPECT_EQ(code_of(child), -1);
    std::atomic<std::size_t> runs{0};
    const JobPlan plan = staged_plan(out, "k", [&](std::size_t) { ++runs; });
    (void)run_spread_items(plan, all_items(plan), {}, {});
    EXPECT_EQ(runs, plan.items.size() - kill_at);
    EXPECT_EQ(join_spread_items(plan, {}, {}), JobStatus::Done);
    EXPECT_EQ(tree_of(out), tree_of(temp / "whole"));
    EXPECT_FALSE(fs::exists(out.string() + ".items")) << "what the killed process was writing is removed";
  }
}

TEST(SpreadJob, NeedsNoLock) {
  TempFolder temp;
  const JobPlan plan = staged_plan(temp / "out", "k");
  fs::create_directory(temp / "out.items");
  fs::create_directory(temp / "out.partial");
  for (const char* locked : {"out.items", "out.partial", "."}) {
    const int fd = ::open((temp / locked).c_str(), O_RDONLY | O_DIRECTORY);
    ASSERT_EQ(::flock(fd, LOCK_EX | LOCK_NB), 0);  // Closed by the end of the process.
  }
  (void)run_some(plan, all_items(plan));
  EXPECT_EQ(join_spread_items(plan, {}, {}), JobStatus::Done);
}

TEST(SpreadJob, ADifferentOutputIsReplacedOnlyWhenForced) {
  TempFolder temp;
  (void)run_job(staged_plan(temp / "out", "old"), {}, {});
  const JobPlan plan = staged_plan(temp / "out", "new");
  EXPECT_NE(error_of<Error>([&] { (void)run_some(plan, {0}); }).find("--force"), std::string::npos);
  (void)run_spread_items(plan, all_items(plan), {.force = true}, {});
  EXPECT_EQ(tree_of(temp / "out").at("parts/0.txt"), "old0");
  EXPECT_EQ(join_spread_items(plan, {.force = true}, {}), JobStatus::Done);
  (void)run_job(staged_plan(temp / "fresh", "new"), {}, {});
  EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "fresh"));
  EXPECT_EQ(std::distance(fs::directory_iterator(temp.path()), fs::directory_iterator()), 2);
}

TEST(SpreadJob, WhatAnOutputHoldsOfItemsIsTakenOver) {
  TempFolder temp;
  const auto plan_of = [&](const std::string& key, std::size_t num, std::vector<std::string>& runs) {
    JobPlan plan{.output = temp / "out", .manifest = "m.json", .key = key, .depends_on = {}, .items = {}, .join = {}};
    plan.may_grow = true;
    for (std::size_t i = 0; i < num; ++i) {
      const std::string name = "frame" + std::to_string(i);
      plan.depends_on.push_back({name, name});
      plan.items.push_back({.name = name,
                            .outputs = {name},
                            .run =
                                [&runs, name](const fs::path& folder, const RunControl&) {
                                  runs.push_back(name);
                                  write_atomically(folder / name, name);
                                },
                            .key = "of-" + name});
    }
    plan.join = [key](const fs::path& folder, const RunControl&) { save_json(folder / "m.json", Json{{"key", key}}); };
    return plan;
  };
  std::vector<std::string> first, then;
  (void)run_job(plan_of("three", 3, first), {}, with_threads(1));
  const JobPlan longer = plan_of("four", 4, then);
  (void)run_spread_items(longer, all_items(longer), {}, with_threads(1));
  (void)join_spread_items(longer, {}, {});
  EXPECT_EQ(then, std::vector<std::string>{"frame3"});
  EXPECT_EQ(tree_of(temp / "out").size(), 6u);  // 4 frames, the manifest, job.json
}

/// Items that hand a checkpoint on, as a simulation's do.
JobPlan chain_plan(const fs::path& output, int length, std::vector<int>& begun_anew) {
  const fs::path checkpoint = fs::path(kJobWorkFolder) / "state.txt";
  JobPlan plan{.output = output, .manifest = "m.json", .key = "k", .depends_on = {}, .items = {}, .join = {}};
  plan.shared_work = {checkpoint};
  for (int i = 0; i < length; ++i) {
    const fs::path file = "step" + std::to_string(i);
    plan.items.push_back({.name = file.string(),
                          .outputs = {file},
                          .run =
                              [=, &begun_anew](const fs::path& folder, const RunControl&) {
                                std::string state = std::string(static_cast<std::size_t>(i), 'x');
                                if (fs::exists(folder / checkpoint))
                                  state = read_file(folder / checkpoint);
                                else
                                  begun_anew.push_back(i);
                                EXPECT_EQ(state.size(), static_cast<std::size_t>(i));
                                write_atomically(folder / file, state);
                                fs::create_directories(folder / kJobWorkFolder);
                                write_atomically(folder / checkpoint, state + "x");
                              },
                          .stage = i});
  }
  plan.join = [](const fs::path& folder, const RunControl&) { save_json(folder / "m.json", Json{{"key", "k"}}); };
  return plan;
}

TEST(SpreadJob, ACheckpointGoesFromProcessToProcessAndOnlyTheLastIsKept) {
  TempFolder temp;
  std::vector<int> begun_anew;
  constexpr int kLength = 5;
  for (std::size_t i = 0; i < kLength; ++i) {
    EXPECT_EQ(run_some(chain_plan(temp / "out", kLength, begun_anew), {i}), 1u);
    int num_checkpoints = 0;
    for (const auto& entry : fs::recursive_directory_iterator(temp / "out.items"))
      num_checkpoints += entry.path().filename() == "state.txt" ? 1 : 0;
    EXPECT_EQ(num_checkpoints, 1);
  }
  EXPECT_EQ(begun_anew, std::vector<int>{0});
  EXPECT_EQ(join_spread_items(chain_plan(temp / "out", kLength, begun_anew), {}, {}), JobStatus::Done);
  std::vector<int> whole;
  (void)run_job(chain_plan(temp / "whole", kLength, whole), {}, {});
  EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "whole"));
}

TEST(SpreadJob, FoldersOfOthersAreLeftAlone) {
  TempFolder temp;
  fs::create_directory(temp / "out.items");
  write_atomically(temp / "out.items" / "photo.jpg", "precious");
  EXPECT_NE(error_of<Error>([&] { (void)run_some(staged_plan(temp / "out", "k"), {0}); }).find("did not write"),
            std::string::npos);
  EXPECT_EQ(tree_of(temp / "out.items").size(), 1u);
}

TEST(ItemRanges, AreReadAsTheyAreWritten) {
  for (const std::vector<std::size_t>& items :
       {std::vector<std::size_t>{0}, {0, 1, 2}, {1, 3, 5}, {0, 2, 3, 4, 9}, {7, 8}}) {
    EXPECT_EQ(parse_item_ranges(item_ranges_text(items), 10), items);
  }
  EXPECT_EQ(item_ranges_text(std::vector<std::size_t>{0, 2, 3, 4, 9}), "0, 2-4, 9");
  EXPECT_EQ(parse_item_ranges("3,1-2,2", 10), (std::vector<std::size_t>{1, 2, 3}));
}

TEST(ItemRanges, WhatIsNoRangeOfThePlanIsRefused) {
  for (const char* text : {"", "-", "1-", "-1", "3-1", "a", "1,,2", "10", "0-10", "99999999999999999999", "1.5", "+1"})
    EXPECT_THROW((void)parse_item_ranges(text, 10), ParseError) << text;
  EXPECT_THROW((void)parse_item_ranges("0", 0), ParseError);
}

}  // namespace
}  // namespace patinate
