// What a finished output is worth to a later plan, and what a dry run says about it. Expected bytes are those of a plan
// run afresh.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/job/job_report.h"
#include "tests/libcommon/job/job_tree.h"
#include "tests/support/temp_folder.h"
#include "tests/support/threads.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;
using testing_support::TempFolder;
using testing_support::Tree;
using testing_support::tree_of;
using testing_support::with_threads;
using Photos = std::vector<std::pair<std::string, std::string>>;  ///< Name and content.

/// A frame for each photograph, and a summary of all: as ingest. Adds the names of the frames it makes to `runs`.
JobPlan album(const fs::path& output, const Photos& photos, const std::string& sigma = "20",
              std::vector<std::string>* runs = nullptr) {
  JobInputs inputs("album", 1);
  inputs.add_value("--sigma", sigma);
  JobPlan plan;
  std::string all;
  for (const auto& [name, content] : photos) {
    inputs.add_content("photograph", name, content);
    all += content;
    const std::string item = "frame" + std::to_string(plan.items.size());
    const fs::path file = "frames/" + item + ".txt";
    plan.items.push_back({.name = item,
                          .outputs = {file},
                          .run =
                              [=, text = content](const fs::path& folder, const RunControl&) {
                                write_atomically(folder / file, "frame of " + text);
                                if (runs) runs->push_back(item);
                              },
                          .key = "frame of " + content});
  }
  plan.output = output;
  plan.manifest = "album.json";
  plan.key = inputs.key();
  plan.depends_on = inputs.list();
  plan.may_grow = true;
  plan.join = [key = plan.key, all, sigma](const fs::path& folder, const RunControl&) {
    save_json(folder / "album.json", Json{{"all", all}, {"sigma", sigma}, {"key", key}});
  };
  return plan;
}

const Photos kThree{{"1.jpg", "a"}, {"2.jpg", "b"}, {"3.jpg", "c"}};
const Photos kFour{{"1.jpg", "a"}, {"2.jpg", "b"}, {"3.jpg", "c"}, {"4.jpg", "d"}};

TEST(JobReuse, AnAppendedPhotographCostsOneFrameAndNeedsNoForce) {
  TempFolder temp;
  (void)run_job(album(temp / "fresh", kFour), {}, {});
  (void)run_job(album(temp / "out", kThree), {}, {});
  std::vector<std::string> runs;
  EXPECT_EQ(run_job(album(temp / "out", kFour, "20", &runs), {}, with_threads(1)), JobStatus::Done);
  EXPECT_EQ(runs, std::vector<std::string>{"frame3"});
  EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "fresh"));
  EXPECT_FALSE(fs::exists(temp / "out.partial"));
}

TEST(JobReuse, AnotherOptionOrAnotherPhotographNeedsForceAndKeepsTheFramesThatAreTheSame) {
  TempFolder temp;
  const Photos changed{{"1.jpg", "a"}, {"2.jpg", "B"}, {"3.jpg", "c"}, {"4.jpg", "d"}};
  (void)run_job(album(temp / "fresh", changed, "30"), {}, {});
  (void)run_job(album(temp / "out", kThree), {}, {});
  const Tree before = tree_of(temp / "out");
  EXPECT_THROW((void)run_job(album(temp / "out", kFour, "30"), {}, {}), CannotComplete);
  EXPECT_THROW((void)run_job(album(temp / "out", changed), {}, {}), CannotComplete);
  EXPECT_THROW((void)run_job(album(temp / "out", {{"1.jpg", "a"}, {"2.jpg", "b"}}), {}, {}), CannotComplete);
  EXPECT_EQ(tree_of(temp / "out"), before);
  std::vector<std::string> runs;
  (void)run_job(album(temp / "out", changed, "30", &runs), {.force = true}, with_threads(1));
  EXPECT_EQ(runs, (std::vector<std::string>{"frame1", "frame3"}));
  EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "fresh"));
}

TEST(JobReuse, AFileThatWasChangedSinceIsMadeAgain) {
  TempFolder temp;
  (void)run_job(album(temp / "fresh", kFour), {}, {});
  for (const bool is_removed : {false, true}) {
    (void)run_job(album(temp / "out", kThree), {}, {});
    if (is_removed)
      fs::remove(temp / "out/frames/frame1.txt");
    else
      std::ofstream(temp / "out/frames/frame1.txt") << "scribble";
    std::vector<std::string> runs;
    (void)run_job(album(temp / "out", kFour, "20", &runs), {}, with_threads(1));
    EXPECT_EQ(runs, (std::vector<std::string>{"frame1", "frame3"}));
    EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "fresh"));
    fs::remove_all(temp / "out");
  }
}

TEST(JobReuse, WithoutARecordEverythingIsMadeAgain) {
  TempFolder temp;
  (void)run_job(album(temp / "fresh", kFour), {}, {});
  for (const char* damage :
       {"", "{", "{\"format\": 3}", "[]", "{\"format\": \"patinate.job\", \"version\": 1, \"items\": 7}"}) {
    (void)run_job(album(temp / "out", kThree), {}, {});
    write_atomically(temp / "out/job.json", damage);
    EXPECT_THROW((void)run_job(album(temp / "out", kFour), {}, {}), CannotComplete) << damage;
    std::vector<std::string> runs;
    (void)run_job(album(temp / "out", kFour, "20", &runs), {.force = true}, with_threads(1));
    EXPECT_EQ(runs.size(), 4u);
    EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "fresh"));
    fs::remove_all(temp / "out");
  }
}

/// An append that fails after the frames that it keeps are in the partial folder.
JobPlan failing_append(const fs::path& output) {
  JobPlan plan = album(output, kFour);
  plan.items.back().run = [](const fs::path&, const RunControl&) { throw IoError("4.jpg", "is truncated"); };
  return plan;
}

TEST(JobReuse, AnInterruptedAppendLeavesTheOldOutputWholeAndGoesOn) {
  TempFolder temp;
  (void)run_job(album(temp / "fresh", kFour), {}, {});
  (void)run_job(album(temp / "out", kThree), {}, {});
  const Tree before = tree_of(temp / "out");
  EXPECT_THROW((void)run_job(failing_append(temp / "out"), {}, with_threads(1)), IoError);
  EXPECT_EQ(tree_of(temp / "out"), before);
  std::vector<std::string> runs;
  (void)run_job(album(temp / "out", kFour, "20", &runs), {}, with_threads(1));
  EXPECT_EQ(runs, std::vector<std::string>{"frame3"});
  EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "fresh"));
}

TEST(JobReuse, AFileEditedInPlaceBetweenTwoRunsOfAnAppendIsMadeAgain) {
  TempFolder temp;
  (void)run_job(album(temp / "fresh", kFour), {}, {});
  (void)run_job(album(temp / "out", kThree), {}, {});
  EXPECT_THROW((void)run_job(failing_append(temp / "out"), {}, with_threads(1)), IoError);
  std::ofstream(temp / "out/frames/frame1.txt") << "scribble";  // The partial folder holds a link to it.
  (void)run_job(album(temp / "out", kFour), {}, with_threads(1));
  EXPECT_EQ(tree_of(temp / "out"), tree_of(temp / "fresh"));
}

TEST(JobReuse, WorkFilesServeAResumedRunAndAreNotInTheOutput) {
  TempFolder temp;
  int num_early = 0;
  bool is_failing = true;
  JobPlan plan = album(temp / "out", kThree);
  const fs::path work = fs::path(kJobWorkFolder) / "half.bin";
  plan.items.push_back({.name = "early", .outputs = {work}, .run = [&](const fs::path& folder, const RunControl&) {
                          ++num_early;
                          write_atomically(folder / work, "half");
                        }});
  plan.items.push_back({.name = "late",
                        .outputs = {"late.txt"},
                        .run =
                            [&](const fs::path& folder, const RunControl&) {
                              if (is_failing) throw CannotComplete("disk full");
                              write_atomically(folder / "late.txt", read_file(folder / work) + " and half");
                            },
                        .stage = 1});
  EXPECT_THROW((void)run_job(plan, {}, with_threads(1)), CannotComplete);
  is_failing = false;
  (void)run_job(plan, {}, with_threads(1));
  EXPECT_EQ(num_early, 1);
  const Tree tree = tree_of(temp / "out");
  EXPECT_EQ(tree.at("late.txt"), "half and half");
  EXPECT_FALSE(tree.contains(".job"));
  EXPECT_EQ(tree.at("job.json").find("half.bin"), std::string::npos);
}

TEST(JobReport, SaysWhatIsMissingWhatChangedAndWhatWouldBeKept) {
  TempFolder temp;
  const auto explain = [&](const Photos& photos, const std::string& sigma, bool force = false) {
    return explain_job(album(temp / "out", photos, sigma), {.force = force});
  };
  EXPECT_EQ(explain(kThree, "20").need, OutputNeed::Missing);
  (void)run_job(album(temp / "out", kThree), {}, {});
  EXPECT_EQ(explain(kThree, "20").need, OutputNeed::UpToDate);
  EXPECT_TRUE(explain(kThree, "20").items.empty());

  const JobReport grown = explain(kFour, "20");
  EXPECT_EQ(grown.need, OutputNeed::Grown);
  EXPECT_FALSE(grown.needs_force());
  EXPECT_NE(grown.text().find("4.jpg is new"), std::string::npos) << grown.text();
  EXPECT_NE(grown.text().find("kept 3: frame0, frame1, frame2"), std::string::npos) << grown.text();
  EXPECT_NE(grown.text().find("to make 1: frame3"), std::string::npos) << grown.text();

  const JobReport stale = explain({{"1.jpg", "a"}, {"2.jpg", "B"}}, "30");
  EXPECT_EQ(stale.need, OutputNeed::Stale);
  EXPECT_TRUE(stale.needs_force());
  for (const char* expected :
       {"--sigma was `20`, is `30`", "2.jpg was `b`, is `B`", "3.jpg is gone", "--force", "to make 1: frame1"}) {
    EXPECT_NE(stale.text().find(expected), std::string::npos) << expected << "\n" << stale.text();
  }
  EXPECT_FALSE(explain({{"1.jpg", "a"}}, "30", true).needs_force());
  EXPECT_EQ(stale.json()["changes"].size(), 3u);
  EXPECT_EQ(stale.json()["items"][1]["need"], "run");
}

TEST(JobReport, TellsThePredictedItemsAndTouchesNothing) {
  TempFolder temp;
  (void)run_job(album(temp / "out", kThree), {}, {});
  EXPECT_THROW((void)run_job(failing_append(temp / "out"), {}, with_threads(1)), IoError);
  const auto times = [&] {
    std::map<std::string, fs::file_time_type> result{{".", fs::last_write_time(temp.path())}};
    for (const auto& e : fs::recursive_directory_iterator(temp.path()))
      result[e.path().string()] = fs::last_write_time(e.path());
    return result;
  };
  const auto before = times();
  const Tree tree = tree_of(temp.path());
  const JobReport report = explain_job(album(temp / "out", kFour), {});
  for (const JobReport::Item& item : report.items) {
    EXPECT_EQ(item.need, item.name == "frame3" ? ItemNeed::Run : ItemNeed::Resume) << item.name;
  }
  (void)explain_job(album(temp / "other", kFour), {});
  EXPECT_EQ(times(), before);
  EXPECT_EQ(tree_of(temp.path()), tree);
}

TEST(JobReport, FailsWhereTheJobWouldFail) {
  TempFolder temp;
  fs::create_directory(temp / "photos");
  write_atomically(temp / "photos/a.jpg", "precious");
  EXPECT_THROW((void)explain_job(album(temp / "photos", kThree), {.force = true}), CannotComplete);
  EXPECT_THROW((void)explain_job(album(temp / "no/out", kThree), {}), CannotComplete);
}

TEST(JobReport, OfASingleFileIsDecidedByItsKey) {
  TempFolder temp;
  const auto explain = [&](const char* existing_key, const JobOptions& options) {
    return explain_output_files({{.path = temp / "a.png", .existing_key = existing_key}}, "k", options);
  };
  EXPECT_EQ(explain("", {}).need, OutputNeed::Missing);
  write_atomically(temp / "a.png", "x");
  EXPECT_EQ(explain("k", {}).need, OutputNeed::UpToDate);
  EXPECT_TRUE(explain("other", {}).needs_force());
  EXPECT_FALSE(explain("other", {.force = true}).needs_force());
}

TEST(JobInputs, FilesCountByContentAndRoleAndValuesByNameAndText) {
  TempFolder temp;
  write_atomically(temp / "a.jpg", "same");
  write_atomically(temp / "b.jpg", "same");
  const auto key = [&](const char* role, const char* file, const char* name, const char* value) {
    return JobInputs("stage", 1).add_file(role, temp / file).add_value(name, value).key();
  };
  const std::string first = key("photo", "a.jpg", "x", "1");
  EXPECT_EQ(key("photo", "b.jpg", "x", "1"), first);
  EXPECT_NE(key("mask", "a.jpg", "x", "1"), first);
  EXPECT_NE(key("photo", "a.jpg", "y", "1"), first);
  EXPECT_NE(key("photo", "a.jpg", "x", "2"), first);
  EXPECT_NE(JobInputs("stage", 2).key(), JobInputs("stage", 1).key());
}

TEST(JobInputs, WithoutNamesTextsAndKeysCountAlone) {
  const auto key = [](const char* name, const char* text, const char* role) {
    return JobInputs::counted_without_names("stage").add_value(name, text).add_content(role, "photo", "k").key();
  };
  EXPECT_EQ(key("--a", "1", "photo"), key("--b", "1", "mask"));
  EXPECT_NE(key("--a", "1", "photo"), key("--a", "2", "photo"));
  EXPECT_EQ(key("--a", "1", "photo"), ContentHash().add("stage").add("1").add("k").hex());
  EXPECT_EQ(JobInputs::counted_without_names("stage").add_value("--a", "1").list().front().name, "--a");
}

TEST(JobInputs, NamesAreUniqueAndReadFromTheProject) {
  TempFolder temp;
  fs::create_directory(temp / "photos");
  write_atomically(temp / "photos/a.jpg", "x");
  JobInputs inputs("stage", 1);
  inputs.add_file("photo", temp / "photos/a.jpg", temp.path()).add_file("photo", temp / "photos/a.jpg", temp.path());
  inputs.add_options({{"spatial_sigma", "3"}});
  ASSERT_EQ(inputs.list().size(), 4u);
  EXPECT_EQ(inputs.list()[1].name, "photos/a.jpg");
  EXPECT_EQ(inputs.list()[2].name, "photos/a.jpg (2)");
  EXPECT_EQ(inputs.list()[3].name, "--spatial-sigma");
}

}  // namespace
}  // namespace patinate
