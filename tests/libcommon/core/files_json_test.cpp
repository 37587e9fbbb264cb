#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "libcommon/core/files.h"
#include "libcommon/core/temporary_file.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::TempFolder;

template <class Function>
std::string message_of(Function&& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(Files, AreListedInNaturalOrder) {
  TempFolder folder;
  for (const char* name : {"10.png", "9.png", "a2.png", "a10.png", "x.txt", "09.png"})
    std::ofstream(folder / name) << "x";
  std::vector<std::string> names;
  for (const auto& p : list_files(folder.path(), "*.png")) names.push_back(p.filename());
  EXPECT_EQ(names, (std::vector<std::string>{"09.png", "9.png", "10.png", "a2.png", "a10.png"}));
}

TEST(Files, FractionsInNamesCompareAsNumbers) {
  const std::vector<std::vector<std::string>> kOrders{{"t=0.25h.png", "t=0.5h.png", "t=0.75h.png", "t=1.0h.png"},
                                                      {"0,5.png", "0,75.png", "10.png"},
                                                      {"v1.9.png", "v1.10.png", "v1.11.png"},
                                                      {"1.2.9.png", "1.2.10.png"}};
  for (const auto& order : kOrders) {
    TempFolder folder;
    for (const std::string& name : order) std::ofstream(folder / name) << "x";
    std::vector<std::string> names;
    for (const auto& p : list_files(folder.path(), "*.png")) names.push_back(p.filename());
    EXPECT_EQ(names, order);
  }
}

/// Works in a folder until the end of a test.
class WorkingFolder {
 public:
  explicit WorkingFolder(const std::filesystem::path& folder) : before_(std::filesystem::current_path()) {
    std::filesystem::current_path(folder);
  }
  ~WorkingFolder() { std::filesystem::current_path(before_); }
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;

 private:
  std::filesystem::path before_;
};

TEST(Files, OfAPatternWithoutAFolderLieInTheWorkingFolder) {
  TempFolder folder;
  for (const char* name : {"10.png", "9.png"}) std::ofstream(folder / name) << "x";
  const WorkingFolder here(folder.path());
  const std::filesystem::path pattern("*.png");
  EXPECT_EQ(list_files(pattern.parent_path(), pattern.filename().string()),
            (std::vector<std::filesystem::path>{"9.png", "10.png"}));
  EXPECT_EQ(list_files(".", "9.*"), (std::vector<std::filesystem::path>{"./9.png"}));
}

TEST(Files, AFileWithoutAFolderLiesInTheWorkingFolder) {
  EXPECT_EQ(folder_of("scene.json"), ".");
  EXPECT_EQ(folder_of("a/scene.json"), "a");
  EXPECT_EQ(folder_of("/scene.json"), "/");
}

TEST(Files, AManifestStandsForItsFolder) {
  EXPECT_EQ(manifest_folder("copper", "history.json"), "copper");
  EXPECT_EQ(manifest_folder("copper/history.json", "history.json"), "copper");
  EXPECT_EQ(manifest_folder("history.json", "history.json"), ".");
}

TEST(Files, AFailedWriteLeavesTheOldFile) {
  TempFolder folder;
  write_atomically(folder / "a.txt", "old");
  EXPECT_THROW(write_atomically(folder / "a.txt",
                                [](const std::filesystem::path& p) {
                                  std::ofstream(p) << "half";
                                  throw CannotComplete("disk full");
                                }),
               CannotComplete);
  EXPECT_EQ(read_file(folder / "a.txt"), "old");
  EXPECT_EQ(list_files(folder.path(), "*").size(), 1u);
}

// A process that ends at once while two threads write: neither the half-written file nor one that is finished too late
// is left.
TEST(Files, AbandonedFilesAreRemovedAndNoneIsFinishedAnyMore) {
  TempFolder folder;
  const auto end_while_writing = [&folder] {
    AtomicFile half(folder / "half.txt"), late(folder / "late.txt");
    std::ofstream(half.temporary()) << "half";
    std::ofstream(late.temporary()) << "whole";
    abandon_atomic_files();
    std::thread([&late] { late.finish(); }).detach();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ::_exit(7);
  };
  EXPECT_EXIT(end_while_writing(), testing::ExitedWithCode(7), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

// A writer has its name before it opens the file: what it opens after the removal would be left.
TEST(Files, NoneIsBegunAfterTheRemoval) {
  TempFolder folder;
  const auto end_before_writing = [&folder] {
    const AtomicFile file(folder / "late.txt");
    const TemporaryFolder work(folder.path(), "work");
    abandon_atomic_files();
    std::ofstream(file.temporary()) << "late";
    std::ofstream(work.path() / "late.txt") << "late";
    ::_exit(7);
  };
  EXPECT_EXIT(end_before_writing(), testing::ExitedWithCode(7), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

/// The name that this process would write `path` under, with another process id: MACHINE-PID-PROCESS-NUMBER.
std::filesystem::path left_by(const std::filesystem::path& path, const std::string& machine, const std::string& pid) {
  std::string name = AtomicFile(path).temporary().filename().string();
  const std::size_t at = name.find(".tmp") + 4, dash = name.find('-', at), second = name.find('-', dash + 1);
  return path.parent_path() / (name.substr(0, at) + (machine.empty() ? name.substr(at, dash - at) : machine) + "-" +
                               pid + "-00c0ffee" + name.substr(name.find('-', second + 1)));
}

constexpr const char* kNobody = "999999999";  // No process has that number: the kernel's limit is 2^22.

TEST(Files, WhatAKilledWriterLeftIsRemoved) {
  TempFolder folder;
  std::ofstream(left_by(folder / "a.txt", "", kNobody)) << "half";
  std::ofstream(left_by(folder / "a.txt", "", std::to_string(::getpid())))
      << "half by a process that had this id before";
  std::ofstream(left_by(folder / "marker", "", kNobody)) << "half";  // Without an extension.
  write_atomically(folder / "a.txt", "whole");
  write_atomically(folder / "marker", "whole");
  EXPECT_EQ(list_files(folder.path(), "*").size(), 2u);
}

TEST(Files, TwoWritersOfOneFileHaveFilesOfTheirOwn) {
  TempFolder folder;
  AtomicFile one(folder / "a.txt"), other(folder / "a.txt");
  EXPECT_NE(one.temporary(), other.temporary());
  std::ofstream(one.temporary()) << "one";
  std::ofstream(other.temporary()) << "other";
  one.finish();
  EXPECT_EQ(read_file(folder / "a.txt"), "one");
  other.finish();
  EXPECT_EQ(read_file(folder / "a.txt"), "other");
}

// A process id says nothing about another machine. Names of earlier versions, of which the machine is not known, count
// as such.
TEST(Files, WhatAnotherMachineWritesStaysUnlessItIsLongUnwritten) {
  TempFolder folder;
  const std::vector<std::filesystem::path> others{left_by(folder / "a.txt", "0badf00d", kNobody),
                                                  folder / (".a.tmp" + std::string(kNobody) + ".txt")};
  for (const auto& other : others) std::ofstream(other) << "half";
  write_atomically(folder / "a.txt", "whole");
  for (const auto& other : others) EXPECT_TRUE(std::filesystem::exists(other)) << other;
  for (const auto& other : others)
    std::filesystem::last_write_time(other, std::filesystem::file_time_type::clock::now() - std::chrono::hours(24 * 8));
  write_atomically(folder / "a.txt", "whole");
  EXPECT_EQ(list_files(folder.path(), "*").size(), 1u);
}

TEST(Files, LongNamesCanBeWritten) {
  TempFolder folder;
  const std::string name = std::string(230, 'n') + ".txt";
  write_atomically(folder / name, "whole");
  EXPECT_EQ(list_files(folder.path(), "*").size(), 1u);
}

TEST(Files, ATemporaryNameIsKnownAndNoOther) {
  TempFolder folder;
  EXPECT_TRUE(is_temporary(AtomicFile(folder / "a.b.txt").temporary()));
  EXPECT_TRUE(is_temporary(AtomicFile(folder / "a").temporary()));
  for (const char* name : {"a.txt", ".a.tmp.txt", ".a.tmpx.txt", "a.tmp12.txt", ".a.tmp-1.txt", ".a.tmp1e9.txt",
                           ".a.tmp00c0ffee-1-00c0ffee.txt"})
    EXPECT_FALSE(is_temporary(name)) << name;
}

TEST(Files, WhatKilledWritersOfSeveralFilesLeftIsRemoved) {
  TempFolder folder;
  const AtomicFile own(folder / "map-c.bin");
  const std::filesystem::path dead_a = left_by(folder / "map-a.bin", "", kNobody),
                              dead_b = left_by(folder / "map-b.bin", "", kNobody),
                              other = left_by(folder / "other.bin", "", kNobody);
  for (const std::filesystem::path& path :
       {dead_a, dead_b, other, own.temporary(), folder / ".map-d.tmpx.bin", folder / ".map-e.tmp-1.bin",
        folder / ".map-f.tmp1e99.bin", folder / "map-g.bin"}) {
    std::ofstream(path) << "half";
  }
  remove_abandoned(folder.path(), "map-");
  EXPECT_EQ(list_files(folder.path(), ".map-?.*").size(), 4u);
  EXPECT_FALSE(std::filesystem::exists(dead_a) || std::filesystem::exists(dead_b));
  EXPECT_TRUE(std::filesystem::exists(own.temporary()) && std::filesystem::exists(folder / "map-g.bin") &&
              std::filesystem::exists(other));
  remove_abandoned(folder / "missing", "map-");
}

TEST(Files, SpecialFilesAreNotReplaced) {
  EXPECT_THROW(write_atomically("/dev/null", "text"), CannotComplete);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(Json, CommentsAreAllowedAndSyntaxErrorsNameLineAndColumn) {
  TempFolder folder;
  write_atomically(folder / "a.json", "{ // why\n \"x\": 1 }");
  EXPECT_EQ(load_json(folder / "a.json")["x"], 1);
  write_atomically(folder / "b.json", "{\n  \"x\": ,\n}");
  EXPECT_EQ(message_of([&] { (void)load_json(folder / "b.json"); }),
            (folder / "b.json").string() + ": is no valid JSON at line 2, column 8");
  write_atomically(folder / "c.json", "");
  EXPECT_NE(message_of([&] { (void)load_json(folder / "c.json"); }).find("empty"), std::string::npos);
  write_atomically(folder / "deep.json", std::string(100'000, '['));
  EXPECT_THROW((void)load_json(folder / "deep.json"), IoError);
}

TEST(Json, ErrorsNamePointerFoundAndExpected) {
  const Json json = Json::parse(R"({"a": {"b": [1, "x"]}, "typo": 1})");
  JsonReader reader("f.json", json);
  EXPECT_EQ(message_of([&] { (void)reader.member("a").member("b").elements()[1].number(); }),
            "f.json: /a/b/1: found \"x\"; expected a number");
  EXPECT_EQ(message_of([&] { (void)reader.member("a").member("b").elements()[0].number(above(1)); }),
            "f.json: /a/b/0: found 1; expected a number > 1");
  EXPECT_EQ(message_of([&] { (void)reader.member("c"); }), "f.json: /: `c` is missing");
  EXPECT_EQ(message_of([&] { reader.finish(); }), "f.json: /typo: unknown key; there is a, c");
}

TEST(Json, UnknownKeysComeWithASuggestion) {
  const Json json = Json::parse(R"({"intervall": 1})");
  JsonReader reader("f.json", json);
  EXPECT_FALSE(reader.has("interval"));
  (void)message_of([&] { (void)reader.member("interval"); });
  EXPECT_EQ(message_of([&] { reader.finish(); }), "f.json: /intervall: unknown key; did you mean `interval`?");
}

}  // namespace
TEST(Json, ADocumentOfAnOlderVersionGetsTheWordsOfTheNext) {
  const Json before = Json::parse(
      R"({"format": "x", "version": 1, "behaviour": {"op": "behaviour", "list": ["behaviour", 1, "behaviours"]}})");
  const Json now = Json::parse(
      R"({"format": "x", "version": 2, "behavior": {"op": "behavior", "list": ["behavior", 1, "behaviours"]}})");
  Json document = before;
  update_spelling(document, 1, {{"behaviour", "behavior"}});
  EXPECT_EQ(document, now);
  update_spelling(document, 1, {{"behavior", "conduct"}});
  EXPECT_EQ(document, now);  // Another version stays as it is.
  Json list = Json::parse("[1]");
  update_spelling(list, 1, {{"a", "b"}});
  EXPECT_EQ(list, Json::parse("[1]"));
}

}  // namespace patinate
