#include "libcommon/document/document.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::TempFolder;

enum class Kind { Plain, Fancy };
constexpr std::array<std::string_view, 2> kKindNames{"plain", "fancy"};

struct Part {
  std::string name;
  std::optional<double> size;
};
void describe(DocumentVisitor& v, Part& p) {
  v.member({"name", "Of the part."}, p.name);
  v.member({.name = "size", .range = above(0), .is_nullable = true}, p.size);
}

struct Thing {
  int count = 1;
  double share = 0.5;
  bool is_new = false;
  Kind kind = Kind::Plain;
  std::filesystem::path file = {};
  std::array<double, 2> range{0, 1};
  std::vector<Part> parts = {};
  std::vector<std::optional<double>> values = {};
  std::vector<std::pair<double, double>> pairs = {};
  std::optional<Part> best = {};
  std::string note = {};
  Named<Part> named = {};
};
void describe(DocumentVisitor& v, Thing& t) {
  v.member({"count", "How many.", between(1, 9)}, t.count);
  v.member({"share", "", between(0, 1), Presence::Optional}, t.share);
  v.member({.name = "new", .presence = Presence::IfSet}, t.is_new);
  v.choice({"kind"}, t.kind, kKindNames);
  v.member({"file", "Where."}, t.file);
  v.member({"range"}, t.range);
  v.require("range", t.range[0] <= t.range[1], "[low, high]");
  v.member({.name = "parts", .presence = Presence::Optional, .max_size = 2}, t.parts);
  v.member({.name = "values", .presence = Presence::IfSet, .has_nulls = true}, t.values);
  v.member({.name = "pairs", .presence = Presence::IfSet}, t.pairs);
  v.member({.name = "best", .presence = Presence::IfSet}, t.best);
  v.object({.name = "more", .presence = Presence::IfSet}, !t.note.empty(), [&] { v.member({"note"}, t.note); });
  v.member({.name = "named", .presence = Presence::IfSet}, t.named);
}

constexpr DocumentKind kThing{.format = "patinate.thing", .version = 3, .title = "thing", .about = "A thing."};

Thing full_thing() {
  return {.count = 2,
          .share = 1.0,
          .is_new = true,
          .kind = Kind::Fancy,
          .file = "a/b.png",
          .range = {-1, 2.5},
          .parts = {{"a", 0.5}, {"b", std::nullopt}},
          .values = {1.5, std::nullopt},
          .pairs = {{0, 1}},
          .best = Part{"c", 2.0},
          .note = "seen",
          .named = {{"a/b", {"e", 1.0}}, {"a", {"f", std::nullopt}}}};
}

Json written(Thing thing) { return document_json(kThing, described(thing)); }

/// Error of reading `json`; "" when it is read.
std::string error_of(const Json& json) {
  const TempFolder folder;
  const std::filesystem::path file = folder / "thing.json";
  write_atomically(file, json.dump());
  try {
    Thing thing;
    read_document(kThing, file, described(thing));
    return "";
  } catch (const IoError& e) {
    return std::string(e.what()).substr(file.string().size());
  }
}

TEST(Document, IsWrittenInTheOrderOfItsDescription) {
  EXPECT_EQ(
      written(full_thing()).dump(),
      R"({"format":"patinate.thing","version":3,"count":2,"share":1.0,"new":true,"kind":"fancy","file":"a/b.png",)"
      R"("range":[-1.0,2.5],"parts":[{"name":"a","size":0.5},{"name":"b","size":null}],"values":[1.5,null],)"
      R"("pairs":[[0.0,1.0]],"best":{"name":"c","size":2.0},"more":{"note":"seen"},)"
      R"("named":{"a/b":{"name":"e","size":1.0},"a":{"name":"f","size":null}}})");
  EXPECT_EQ(written({.file = "x"}).dump(),
            R"({"format":"patinate.thing","version":3,"count":1,"share":0.5,"kind":"plain","file":"x",)"
            R"("range":[0.0,1.0],"parts":[]})");
}

TEST(Document, ReadsWhatItWrites) {
  const TempFolder folder;
  for (const Thing& thing : {full_thing(), Thing{.file = "x"}}) {
    save_json(folder / "thing.json", written(thing));
    Thing back;
    read_document(kThing, folder / "thing.json", described(back));
    EXPECT_EQ(written(back), written(thing));
  }
}

TEST(Document, ErrorsNameTheMemberAndWhatWasExpected) {
  const auto error_with = [](const char* pointer, const Json& value) {
    Json json = written(full_thing());
    json[Json::json_pointer(pointer)] = value;
    return error_of(json);
  };
  EXPECT_EQ(error_of(written(full_thing())), "");
  EXPECT_EQ(error_with("/count", 10), ": /count: found 10; expected an integer [1, 9]");
  EXPECT_EQ(error_with("/kind", "fance"),
            ": /kind: found \"fance\"; expected one of \"plain\", \"fancy\"; did you mean `fancy`?");
  EXPECT_EQ(error_with("/parts/1/size", -1), ": /parts/1/size: found -1; expected a number > 0");
  EXPECT_EQ(error_with("/range", Json{3, 2}), ": /range: found an array of 2; expected [low, high]");
  EXPECT_NE(error_with("/parts/2", Json{{"name", "d"}, {"size", 1}}).find("/parts"), std::string::npos);
  EXPECT_NE(error_with("/parts/0/nam", 1).find("/parts/0"), std::string::npos);
  EXPECT_NE(error_with("/more/note", 1).find("/more/note"), std::string::npos);
  EXPECT_EQ(error_with("/named/a/size", 0), ": /named/a/size: found 0; expected a number > 0");
  EXPECT_NE(error_with("/surplus", 1).find("surplus"), std::string::npos);
  EXPECT_NE(error_with("/version", 4).find("/version"), std::string::npos);
}

TEST(Document, SchemaSaysWhatTheReaderChecks) {
  Thing any;
  const Json schema = document_schema(kThing, described(any));
  EXPECT_EQ(schema["properties"]["format"].dump(), R"({"const":"patinate.thing"})");
  EXPECT_EQ(schema["required"].dump(), R"(["format","version","count","kind","file","range"])");
  EXPECT_EQ(schema["additionalProperties"], false);
  const Json& members = schema["properties"];
  EXPECT_EQ(members["count"].dump(), R"({"description":"How many.","type":"integer","minimum":1,"maximum":9})");
  EXPECT_EQ(members["kind"].dump(), R"({"enum":["plain","fancy"]})");
  EXPECT_EQ(members["file"].dump(), R"({"description":"Where. Relative to this file.","type":"string","minLength":1})");
  EXPECT_EQ(members["parts"]["maxItems"], 2);
  EXPECT_EQ(members["parts"]["items"]["required"].dump(), R"(["name","size"])");
  EXPECT_EQ(members["parts"]["items"]["properties"]["size"].dump(),
            R"({"type":["number","null"],"exclusiveMinimum":0})");
  EXPECT_EQ(members["values"]["items"]["type"].dump(), R"(["number","null"])");
  EXPECT_EQ(members["best"]["type"], "object");
  EXPECT_EQ(members["more"]["properties"]["note"].dump(), R"({"type":"string"})");
  EXPECT_EQ(members["named"]["additionalProperties"], members["best"]) << members["named"].dump();
}

TEST(Document, MissingMembersAreErrorsUnlessTheyAreOptional) {
  for (const char* member : {"count", "kind", "file", "range"}) {
    Json json = written(full_thing());
    json.erase(member);
    EXPECT_NE(error_of(json).find(member), std::string::npos) << member;
  }
  for (const char* member : {"share", "new", "parts", "values", "best", "more"}) {
    Json json = written(full_thing());
    json.erase(member);
    EXPECT_EQ(error_of(json), "") << member;
  }
}

}  // namespace
}  // namespace patinate
