// What items declare against what they write. Expected: a run that resumes after an interruption ends with the files of
// one that was not interrupted, so a plan for which that cannot hold is refused.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/job/job.h"
#include "libcommon/job/job_report.h"
#include "tests/libcommon/job/job_tree.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"
#include "tests/support/threads.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;
using testing_support::error_of;
using testing_support::TempFolder;
using testing_support::tree_of;
using testing_support::with_threads;

JobItem writer_of(const std::string& name, const std::vector<fs::path>& written, int stage = 0) {
  return {.name = name,
          .outputs = {},
          .run =
              [written](const fs::path& folder, const RunControl&) {
                for (const fs::path& file : written) {
                  fs::create_directories((folder / file).parent_path());
                  write_atomically(folder / file, file.string());
                }
              },
          .key = name,
          .stage = stage};
}

JobPlan plan_of(const fs::path& output, std::vector<JobItem> items, const std::string& key = "k") {
  JobPlan plan;
  plan.output = output;
  plan.manifest = "sample.json";
  plan.key = key;
  plan.items = std::move(items);
  plan.join = [key](const fs::path& folder, const RunControl&) {
    save_json(folder / "sample.json", Json{{"key", key}});
  };
  return plan;
}

JobItem failing(int stage) {
  return {.name = "failing",
          .outputs = {},
          .run = [](const fs::path&, const RunControl&) { throw CannotComplete("disk full"); },
          .key = "failing",
          .stage = stage};
}

TEST(JobOutputs, AnItemThatWritesWhatItDidNotDeclareIsRefused) {
  for (const int num_items : {1, 2, 3, 7}) {
    for (int wrong = 0; wrong < num_items; ++wrong) {
      const TempFolder temp;
      std::vector<JobItem> items;
      for (int i = 0; i < num_items; ++i) {
        const fs::path file = "parts/" + std::to_string(i);
        JobItem item =
            writer_of("part" + std::to_string(i),
                      i == wrong ? std::vector<fs::path>{file, "controls/rate.exr"} : std::vector<fs::path>{file});
        item.outputs = {file};
        items.push_back(std::move(item));
      }
      for (const int n : {1, 3}) {
        const std::string said =
            error_of<CannotComplete>([&] { (void)run_job(plan_of(temp / "out", items), {}, with_threads(n)); });
        EXPECT_NE(said.find("controls/rate.exr: was written by a step that does not declare it"), std::string::npos)
            << said;
        EXPECT_TRUE(fs::is_empty(temp.path())) << "what is left would vouch for too little";
      }
    }
  }
}

TEST(JobOutputs, UndeclaredWorkIsRefusedToo) {
  const TempFolder temp;
  const fs::path work = fs::path(kJobWorkFolder) / "checkpoint";
  EXPECT_NE(error_of<CannotComplete>([&] {
              (void)run_job(plan_of(temp / "out", {writer_of("a", {work})}), {}, {});
            }).find("does not declare"),
            std::string::npos);
  JobPlan plan = plan_of(temp / "out", {writer_of("a", {work})});
  plan.shared_work = {work};
  EXPECT_EQ(run_job(plan, {}, {}), JobStatus::Done);
  EXPECT_FALSE(fs::exists(temp / "out" / ".job"));
  plan.shared_work = {"checkpoint"};
  EXPECT_THROW(check_plan(plan), InvalidInput);
}

TEST(JobOutputs, AnItemThatLacksWhatItDeclaredIsRefused) {
  const TempFolder temp;
  JobItem item = writer_of("maps", {"base.exr"});
  item.outputs = {"base.exr", "rate.exr"};
  const std::string said = error_of<CannotComplete>([&] { (void)run_job(plan_of(temp / "out", {item}), {}, {}); });
  EXPECT_NE(said.find("rate.exr: was not made by its step `maps`"), std::string::npos) << said;
  EXPECT_FALSE(fs::exists(temp / "out"));
}

TEST(JobOutputs, AnOptionalOutputIsKeptWhereItWasMadeAndMissedWhereItWasNot) {
  for (const bool is_made : {true, false}) {
    const TempFolder temp;
    JobItem item = writer_of(
        "maps", is_made ? std::vector<fs::path>{"base.exr", "controls/rate.exr"} : std::vector<fs::path>{"base.exr"});
    item.outputs = {"base.exr"};
    item.optional_outputs = {"controls/rate.exr"};
    (void)run_job(plan_of(temp / "whole", {item}), {}, {});
    EXPECT_EQ(fs::exists(temp / "whole/controls/rate.exr"), is_made);
    EXPECT_EQ(fs::exists(temp / "whole/controls"), is_made);

    EXPECT_THROW((void)run_job(plan_of(temp / "out", {item, failing(1)}), {}, {}), CannotComplete);
    int num_runs = 0;
    JobItem counted = item;
    counted.run = [&, run = item.run](const fs::path& folder, const RunControl& control) {
      ++num_runs, run(folder, control);
    };
    EXPECT_EQ(explain_job(plan_of(temp / "out", {counted}), {}).items.at(0).need, ItemNeed::Resume);
    EXPECT_EQ(run_job(plan_of(temp / "out", {counted}), {}, {}), JobStatus::Done);
    EXPECT_EQ(num_runs, 0);
    EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "whole"));

    EXPECT_EQ(explain_job(plan_of(temp / "out", {counted}, "other"), {.force = true}).items.at(0).need,
              ItemNeed::Reuse);
    EXPECT_EQ(run_job(plan_of(temp / "out", {counted}, "other"), {.force = true}, {}), JobStatus::Done);
    EXPECT_EQ(num_runs, 0) << "taken over from the finished output";
    EXPECT_EQ(fs::exists(temp / "out/controls/rate.exr"), is_made);
  }
}

TEST(JobOutputs, AnOptionalOutputThatIsGoneIsMadeAgain) {
  const TempFolder temp;
  JobItem item = writer_of("maps", {"base.exr", "rate.exr"});
  item.outputs = {"base.exr"};
  item.optional_outputs = {"rate.exr"};
  EXPECT_THROW((void)run_job(plan_of(temp / "out", {item, failing(1)}), {}, {}), CannotComplete);
  fs::remove(temp / "out.partial/rate.exr");
  EXPECT_EQ(run_job(plan_of(temp / "out", {item}), {}, {}), JobStatus::Done);
  EXPECT_TRUE(fs::exists(temp / "out/rate.exr"));
}

TEST(JobOutputs, AnItemThatDeclaresMoreThanItWasFinishedWithRunsAgain) {
  const TempFolder temp;
  JobItem item = writer_of("maps", {"base.exr"});
  item.outputs = {"base.exr"};
  EXPECT_THROW((void)run_job(plan_of(temp / "out", {item, failing(1)}), {}, {}), CannotComplete);
  item = writer_of("maps", {"base.exr", "rate.exr"});
  item.outputs = {"base.exr", "rate.exr"};
  EXPECT_EQ(run_job(plan_of(temp / "out", {item}), {}, {}), JobStatus::Done);
  EXPECT_TRUE(fs::exists(temp / "out/rate.exr"));
}

TEST(JobOutputs, SharedWorkIsThereForAResumedRunOfTheSamePlanOnly) {
  const TempFolder temp;
  const fs::path work = fs::path(kJobWorkFolder) / "checkpoint";
  const auto plan = [&](const std::string& key, bool fails, bool& was_there) {
    JobItem second{.name = "second",
                   .outputs = {},
                   .run =
                       [&was_there, work, fails](const fs::path& folder, const RunControl&) {
                         was_there = fs::exists(folder / work);
                         if (fails) throw CannotComplete("disk full");
                       },
                   .key = "second",
                   .stage = 1};
    JobPlan made = plan_of(temp / "out", {writer_of("first", {work}), second}, key);
    made.shared_work = {work};
    return made;
  };
  bool was_there = false;
  EXPECT_THROW((void)run_job(plan("k", true, was_there), {}, {}), CannotComplete);
  EXPECT_TRUE(was_there);
  was_there = false;
  EXPECT_THROW((void)run_job(plan("k", true, was_there), {}, {}), CannotComplete);
  EXPECT_TRUE(was_there) << "the first item is finished, and what it left is gone";
  (void)run_job(plan("other", false, was_there), {}, {});
  EXPECT_FALSE(was_there) << "left by another plan";
}

// On a network file system a lock of a folder is this machine's own; one of a file is everybody's.
TEST(JobOutputs, AnotherMachineThatHoldsTheLockFileIsRespected) {
  const TempFolder temp;
  EXPECT_THROW((void)run_job(plan_of(temp / "out", {writer_of("first", {}), failing(1)}), {}, {}), CannotComplete);
  const fs::path lock = temp / "out.partial/.job/lock";
  const int fd = ::open(lock.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_GE(fd, 0);
  ASSERT_EQ(::flock(fd, LOCK_EX | LOCK_NB), 0);
  const JobPlan plan = plan_of(temp / "out", {writer_of("first", {})});
  EXPECT_NE(
      error_of<CannotComplete>([&] { (void)run_job(plan, {}, {}); }).find("another process is making this output"),
      std::string::npos);
  EXPECT_TRUE(fs::exists(lock));
  ::close(fd);
  EXPECT_EQ(run_job(plan, {}, {}), JobStatus::Done);
  EXPECT_FALSE(fs::exists(temp / "out/.job"));
}

}  // namespace
}  // namespace patinate
