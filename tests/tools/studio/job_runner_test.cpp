#include "tools/studio/job_runner.h"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "tests/support/temp_folder.h"

namespace patinate::studio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// A program of the shell in place of patinate; `out` is the output.
class JobRunnerTest : public ::testing::Test {
 protected:
  JobRunnerTest() { fs::create_directories(temp_ / "served"); }

  JobProgram program(const std::string& text, JobLimits limits = {}) {
    const fs::path file = temp_ / "program";
    { std::ofstream(file) << "#!/bin/sh\n" << text << "\n"; }
    fs::permissions(file, fs::perms::owner_all);
    return {.file = file, .environment = {"PATH=/usr/bin:/bin", "NAME=value"}, .limits = limits};
  }
  static JobRequest request(const std::string& output = "out") {
    return {.command = "x", .words = {"x", "a b", "$HOME"}, .output = output};
  }
  static JobStatusReport ended(const JobRunner& runner, int id) {
    for (int i = 0; i < 2000; ++i) {
      const JobStatusReport job = runner.find(id).value();
      if (job.state > JobState::Running) return job;
      std::this_thread::sleep_for(10ms);
    }
    ADD_FAILURE() << "the job has not ended";
    return {};
  }
  JobStatusReport ran(const std::string& text, JobLimits limits = {}) {
    JobRunner runner(temp_ / "served", program(text, limits));
    return ended(runner, runner.start(request()));
  }

  testing_support::TempFolder temp_;
};

TEST_F(JobRunnerTest, WordsReachTheProgramAsTheyAre) {
  const JobStatusReport job = ran("echo \"$#:$1:$2:$3:$NAME\" >&2; basename \"$PWD\" >&2; touch out");
  EXPECT_EQ(job.state, JobState::Done);
  EXPECT_EQ(job.messages, (std::vector<std::string>{"3:x:a b:$HOME:value", "served"}));
}

TEST_F(JobRunnerTest, ProgressIsNoMessage) {
  const JobStatusReport job = ran("printf 'grow: 12 %%\\ngrow: 37 %%, 0:12 left\\ncovers 7 %% of it\\nlast' >&2");
  EXPECT_EQ(job.state, JobState::Failed);
  EXPECT_EQ(job.stage, "grow");
  EXPECT_EQ(job.share, 0.37);
  EXPECT_EQ(job.left, "0:12");
  EXPECT_EQ(job.messages, (std::vector<std::string>{"covers 7 % of it", "last"}));
}

TEST_F(JobRunnerTest, OnlyTheLastMessagesAreKeptAndNoneIsEndless) {
  const JobStatusReport job =
      ran("i=0; while [ $i -lt 500 ]; do echo line $i >&2; i=$((i+1)); done; "
          "head -c 3000000 /dev/zero | tr '\\0' x >&2");
  EXPECT_EQ(job.messages.size(), 40u);
  EXPECT_LE(job.messages.back().size(), 2000u);
}

TEST_F(JobRunnerTest, WhatIsMadeDecidesAndNotTheCodeAlone) {
  EXPECT_EQ(ran("exit 0").state, JobState::Failed);
  const JobStatusReport job = ran("touch out; exit 1");  // A grading that says "not passed".
  EXPECT_EQ(job.state, JobState::Done);
  EXPECT_EQ(job.exit_code, 1);
}

TEST_F(JobRunnerTest, ACrashIsSaid) {
  const JobStatusReport job = ran("kill -SEGV $$");
  EXPECT_EQ(job.state, JobState::Failed);
  ASSERT_FALSE(job.messages.empty());
  EXPECT_NE(job.messages.back().find("crashed"), std::string::npos);
}

TEST_F(JobRunnerTest, WhoMakesTooMuchIsEnded) {
  const JobStatusReport job =
      ran("mkdir out.partial; for f in a b c; do head -c 2000000 /dev/zero > out.partial/$f; done; exec sleep 60",
          {.max_bytes = 3'000'000});
  EXPECT_EQ(job.state, JobState::Failed);
  ASSERT_FALSE(job.messages.empty());
  EXPECT_NE(job.messages.front().find("a job may make"), std::string::npos);
}

TEST_F(JobRunnerTest, NoFileGrowsBeyondThat) {
  (void)ran("sleep 0.3; trap '' XFSZ; exec head -c 5000000 /dev/zero > big", {.max_bytes = 3'000'000});
  EXPECT_LE(fs::file_size(temp_ / "served/big"), 3'000'000u);
}

TEST_F(JobRunnerTest, ADiskThatIsNearlyFullStartsNothing) {
  const JobStatusReport job = ran("touch out", {.least_free = std::uint64_t{1} << 60});
  EXPECT_EQ(job.state, JobState::Failed);
  EXPECT_FALSE(fs::exists(temp_ / "served/out"));
}

TEST_F(JobRunnerTest, WhoTakesTooLongIsEnded) {
  const JobStatusReport job = ran("sleep 60", {.max_time = 1s, .patience = 100ms});
  EXPECT_EQ(job.state, JobState::Failed);
  ASSERT_FALSE(job.messages.empty());
  EXPECT_NE(job.messages.front().find("a job may take"), std::string::npos);
}

TEST_F(JobRunnerTest, WhoDoesNotListenIsEndedAllTheSame) {
  JobRunner runner(temp_ / "served", program("trap '' INT; sleep 60 & sleep 60", {.patience = 200ms}));
  const int id = runner.start(request());
  while (runner.find(id)->state != JobState::Running) std::this_thread::sleep_for(10ms);
  EXPECT_TRUE(runner.cancel(id));
  EXPECT_EQ(ended(runner, id).state, JobState::Canceled);
}

TEST_F(JobRunnerTest, SomeRunSomeWaitAndNoMoreComeIn) {
  JobRunner runner(temp_ / "served", program("sleep 60", {.num_running = 1, .num_waiting = 2, .patience = 100ms}));
  const int first = runner.start(request("a"));
  while (runner.find(first)->state != JobState::Running) std::this_thread::sleep_for(10ms);
  const int second = runner.start(request("b"));
  EXPECT_THROW((void)runner.start(request("./b")), WrongArgument);
  (void)runner.start(request("c"));
  EXPECT_THROW((void)runner.start(request("d")), InvalidInput);
  EXPECT_TRUE(runner.cancel(second));
  EXPECT_EQ(runner.find(second)->state, JobState::Canceled);
  EXPECT_FALSE(runner.cancel(99));
  EXPECT_TRUE(runner.cancel(first));
  (void)ended(runner, first);
  EXPECT_EQ(runner.list().front().request.output, "c");
}  // The one that runs ends with the runner.

TEST_F(JobRunnerTest, OldOnesAreForgotten) {
  JobRunner runner(temp_ / "served", program("touch $1", {.num_ended = 3}));
  int id = 0;
  for (int i = 0; i < 8; ++i) {
    id = runner.start({.command = "x", .words = {"o" + std::to_string(i)}, .output = "o" + std::to_string(i)});
    (void)ended(runner, id);
  }
  (void)ended(runner, runner.start({.command = "x", .words = {"last"}, .output = "last"}));
  EXPECT_LE(runner.list().size(), 5u);
}

TEST_F(JobRunnerTest, WithoutAProgramNothingRuns) {
  JobRunner runner(temp_ / "served", {});
  EXPECT_THROW((void)runner.start(request()), InvalidInput);
}

}  // namespace
}  // namespace patinate::studio
