// What every job guarantees, for each kind of plan that a command makes: its bytes depend neither on the number of
// threads, nor on being stopped and resumed, nor on being run in pieces that are joined. Real processes are killed and
// joined for four commands by tests/cli/kill_test.py and plan_test.py.
#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "tests/support/temp_folder.h"
#include "tools/patinate/command_line/planned_command.h"

namespace patinate::cli {
namespace {

namespace fs = std::filesystem;
using testing_support::TempFolder;
using Wanted = PlanRequest::Wanted;
using Outputs = std::map<std::string, std::string>;  // Relative path -> bytes.

std::vector<std::string> command_words(const std::string& text) {
  std::vector<std::string> words;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

/// Asks a command that works in `folder`.
PlanRequest ask(const fs::path& folder, const std::string& command, int num_threads, PlanRequest request,
                std::stop_token stop = {}) {
  fs::current_path(folder);
  std::vector<std::string> words = command_words(command);
  for (const std::string& word : {std::string("--quiet"), std::string("--threads"), std::to_string(num_threads)})
    words.push_back(word);
  bool is_json = false;
  if (ask_command(words, request, std::move(stop), is_json) != 0) throw std::runtime_error("failed: " + command);
  return request;
}

void make(const fs::path& folder, const std::string& command) {
  (void)ask(folder, command, 2, {.wanted = Wanted::Whole});
}

/// Inputs of the commands. Each works in a folder of its own, with links to these.
class JobPlans : public testing::TestWithParam<std::string> {
 protected:
  static void SetUpTestSuite() {
    inputs_ = new TempFolder;
    // Two squares, each with a UDIM tile of its own.
    fs::create_directory(*inputs_ / "squares");
    std::ofstream(*inputs_ / "squares/mesh.obj")
        << "v 0 0 0\nv 50 0 0\nv 50 50 9\nv 0 50 9\nv 100 0 0\nv 100 50 9\nvt 0.1 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 0.1 "
           "0.9\n"
           "vt 1.1 0.1\nvt 1.9 0.1\nvt 1.9 0.9\nvt 1.1 0.9\nf 1/1 2/2 3/3 4/4\nf 2/5 5/6 6/7 3/8\n";
    for (const char* command :
         {"synth crackle --width 48 --height 40 --num-frames 4 -o capture", "synth sculpture --resolution 24 -o urn",
          "synth ledge --cells 4 -o ledge",
          "synth mold --width 64 --height 48 --steps 2 --lights 3 --scan-spacing 3 -o mold",
          "ingest capture -o history", "transfer history urn/mesh.obj --control facing --resolution 64 -o aged",
          "simulate ledge/scene.json --resolution 64 --iterations 4 -o dirty"})
      make(inputs_->path(), command);
  }
  static void TearDownTestSuite() {
    fs::current_path(fs::temp_directory_path());
    delete inputs_;
  }

  /// A folder for one run of the command.
  fs::path place(const std::string& name) {
    const fs::path folder = work_ / name;
    fs::create_directory(folder);
    for (const auto& entry : fs::directory_iterator(inputs_->path()))
      fs::create_directory_symlink(entry.path(), folder / entry.path().filename());
    return folder;
  }

  /// All that a command has made: nothing else is called "out".
  static Outputs outputs_of(const fs::path& folder) {
    Outputs made;
    for (fs::recursive_directory_iterator entry(folder), end; entry != end; ++entry) {
      const std::string name = entry->path().lexically_relative(folder).string();
      if (entry->is_symlink() || !name.starts_with("out")) {
        if (entry->is_directory()) entry.disable_recursion_pending();
        continue;
      }
      const std::string file = entry->path().filename().string();
      if (file == ".cache" && entry->is_directory())
        entry.disable_recursion_pending();  // Cache of a history's analysis.
      if (entry->is_regular_file() && file != "run.json") made[name] = read_file(entry->path());
    }
    return made;
  }

  static std::vector<std::string> names_of(const Outputs& outputs) {
    std::vector<std::string> names;
    for (const auto& [name, bytes] : outputs) names.push_back(name);
    return names;
  }

  void expect_same(const Outputs& made, const std::string& how) {
    EXPECT_EQ(names_of(made), names_of(whole_)) << how;
    for (const auto& [name, bytes] : whole_)
      EXPECT_TRUE(!made.contains(name) || made.at(name) == bytes) << how << ": " << name;
  }

  void SetUp() override {
    const fs::path folder = place("whole");
    (void)ask(folder, GetParam(), 1, {.wanted = Wanted::Whole});
    whole_ = outputs_of(folder);
    ASSERT_FALSE(whole_.empty());
  }

  TempFolder work_;
  Outputs whole_;  // On one thread, at once.
  static inline TempFolder* inputs_ = nullptr;
};

TEST_P(JobPlans, GiveTheSameBytesOnThreeThreads) {
  const fs::path folder = place("threads");
  (void)ask(folder, GetParam(), 3, {.wanted = Wanted::Whole});
  expect_same(outputs_of(folder), "three threads");
}

TEST_P(JobPlans, GiveTheSameBytesWhenStoppedAndResumed) {
  const fs::path folder = place("stopped");
  // Stopped before it begins, and a little later each time; what is left by that is finished in the end.
  for (int milliseconds = 0; milliseconds < 40; milliseconds += 13) {
    std::stop_source source;
    if (milliseconds == 0) source.request_stop();
    std::jthread stopper([&](const std::stop_token& over) {
      std::mutex mutex;
      std::unique_lock lock(mutex);
      std::condition_variable_any().wait_for(lock, over, std::chrono::milliseconds(milliseconds), [] { return false; });
      source.request_stop();
    });
    try {
      (void)ask(folder, GetParam(), 2, {.wanted = Wanted::Whole}, source.get_token());
      break;
    } catch (const Canceled&) {
      const Outputs left = outputs_of(folder);
      for (const auto& [name, bytes] : whole_)
        EXPECT_TRUE(!left.contains(name) || left.at(name) == bytes) << "half-written: " << name;
    }
  }
  (void)ask(folder, GetParam(), 2, {.wanted = Wanted::Whole});
  expect_same(outputs_of(folder), "stopped and resumed");
}

TEST_P(JobPlans, GiveTheSameBytesInPiecesThatAreJoined) {
  const fs::path folder = place("spread");
  const PlannedWork work = *ask(folder, GetParam(), 1, {}).work;
  EXPECT_TRUE(outputs_of(folder).empty()) << "a plan makes nothing";
  for (std::size_t i = 0; i < work.items.size(); ++i) {
    for (const std::size_t before : work.items[i].waits_for) EXPECT_LT(before, i);
    (void)ask(folder, GetParam(), 1 + static_cast<int>(i % 2), {.wanted = Wanted::Items, .items = std::to_string(i)});
  }
  if (work.has_join) (void)ask(folder, GetParam(), 2, {.wanted = Wanted::Join});
  expect_same(outputs_of(folder), "pieces");
  EXPECT_TRUE(ask(folder, GetParam(), 1, {}).work->is_up_to_date);
}

INSTANTIATE_TEST_SUITE_P(
    OfCommands, JobPlans,
    testing::Values("synth crackle --width 48 --height 40 --num-frames 3 -o out", "ingest capture --progress -o out",
                    "ingest mold -o out", "register mold/step00/scan.ply mold/step01/scan.ply -o out",
                    "accessibility mold/step00/scan.ply --resolution 48 --share-rays 16 -o out",
                    "thickness capture/backlight.png -o out.exr",
                    "transfer history urn/mesh.obj --control facing --resolution 64 -o out",
                    "transfer history squares/mesh.obj --control height --resolution 64 --unit mm -o out",
                    "texture aged --num-times 4 -o out_%02d.png", "texture aged --time 3 -o out.exr",
                    "export aged --num-times 4 -o out", "export aged --num-times 3 -o out.glb",
                    "export aged --num-times 3 -o out.gif",
                    "render aged --num-times 3 --width 40 --samples 1 -o out_%02d.png",
                    "render aged --num-times 3 --width 40 --samples 1 -o out.png",
                    "render aged --turntable 3 --time 4 --width 40 --samples 1 -o out.gif",
                    "control urn/mesh.obj --kind facing --resolution 64 -o out.exr",
                    "control urn/mesh.obj --kind facing --kind height --resolution 64 -o out_<KIND>.exr",
                    "simulate ledge/scene.json --resolution 64 --iterations 6 --history-every 2 -o out",
                    "recompose dirty --set dirt.strength=3 -o out", "combine history history -o out",
                    "trim history --every 2 -o out", "appearance history --metalness 1 -o out",
                    "compare history history --num-resamples 10 -o out", "evaluate aged --samples 500 -o out",
                    "factorize history --num-intervals 8 --num-training 24 -o out"),
    [](const testing::TestParamInfo<std::string>& command) {
      return std::to_string(command.index) + "_" + command.param.substr(0, command.param.find(" "));
    });

}  // namespace
}  // namespace patinate::cli
