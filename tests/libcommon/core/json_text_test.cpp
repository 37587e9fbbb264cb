#include "libcommon/core/json_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "patinate/core/error.h"
#include "tests/support/errors.h"

namespace patinate {
namespace {

using testing_support::error_of;
using testing_support::has;

std::string json_error(const std::string& text, const JsonTextLimits& limits = {}) {
  return error_of<IoError>([&] { (void)parse_json("a.json", text, limits); });
}

// RFC 8259: "the names within an object SHOULD be unique"; which one counts is up to the reader, so two readers may
// differ.
TEST(JsonText, AKeyGivenTwiceIsRefusedWithItsPointer) {
  EXPECT_EQ(json_error(R"({"a": 1, "b": 2, "a": 3})"), "a.json: /a: is given twice; keep one of them");
  EXPECT_EQ(json_error(R"([0, {"x": [{"k": 1}, {"k": 1, "k": 1}]}])"),
            "a.json: /1/x/1/k: is given twice; keep one of them");
  EXPECT_EQ(json_error(R"({"a": {"a": 1}, "b": {"a": {}, "\u0061": []}})"),
            "a.json: /b/a: is given twice; keep one of them");
  EXPECT_EQ(json_error(R"([{"a": 1}, {"a": 1, "b": {"a": 2}}, {"A": 1, "a": 2}])"), "");
}

TEST(JsonText, LimitsKeepReadersFromRecursingAndSearchingForEver) {
  EXPECT_EQ(json_error(std::string(64, '[') + std::string(64, ']')), "");
  EXPECT_TRUE(has(json_error(std::string(66, '[') + std::string(66, ']')), "nested more than 64 levels"));
  EXPECT_TRUE(has(json_error(std::string(5'000'000, '[')), "nested more than 64 levels"));
  std::string deep;
  for (int i = 0; i < 50'000; ++i) deep += "{\"a\":";
  EXPECT_TRUE(has(json_error(deep), "nested more than 64 levels"));
  std::string wide = "{\"x\": {\"0\": 0";
  for (int i = 1; i < 200'000; ++i) wide += ",\"" + std::to_string(i) + "\":0";
  EXPECT_EQ(json_error(wide + "}}"), "a.json: /x: has more than 4096 members");
  EXPECT_TRUE(has(json_error("[1e400]"), "too large for a computer"));
  EXPECT_FALSE(has(json_error("[1e400]"), "json.exception"));
  EXPECT_TRUE(has(json_error("// no\n1", {.may_have_comments = false}), "no valid JSON at line 1"));
  EXPECT_EQ(json_error("// yes\n1"), "");
}

TEST(JsonText, SettingAMemberLeavesAllElseAsItIsWritten) {
  const std::string text =
      "// \"align\": 0\n{\n  \"name\": \"a \\\"align\\\": }\",  /* \"align\": 1 */\n  \"in\": {\"align\": [1, 2]},\n"
      "  \"al\\u0069gn\" : /* x, */ 1.50 , \"z\": 0.10 // last\n}\n";
  const std::string set = with_member(text, "align", "\"auto\"");
  EXPECT_EQ(set, std::string(text).replace(text.find("1.50"), 4, "\"auto\""));
  EXPECT_EQ(parse_json("a.json", set).at("align"), "auto");
  EXPECT_EQ(with_member(set, "align", "1.50"), text);
  EXPECT_EQ(with_member(text, "z", "[{}]"), std::string(text).replace(text.find("0.10"), 4, "[{}]"));
  EXPECT_EQ(with_member(text, "new", "2"), std::string(text).insert(text.find(" // last"), ",\n  \"new\": 2"));
  EXPECT_EQ(with_member("{\"a\": [\"]\", {\"b\": \"{\"}]}", "b", "1"), "{\"a\": [\"]\", {\"b\": \"{\"}], \"b\": 1}");
  EXPECT_EQ(with_member(" { } ", "a", "1"), " {\"a\": 1 } ");
  EXPECT_EQ(with_member("\xEF\xBB\xBF{\"a\":true}", "a", "1"), "\xEF\xBB\xBF{\"a\":1}");
  EXPECT_THROW((void)with_member("[1]", "a", "1"), InvalidInput);
}

TEST(JsonText, TakingAMemberOutLeavesAllElseAsItIsWritten) {
  const std::string text = "{ // first\n  \"a\": [1, {\"b\": 2}], /* of b */ \"b\" : \"},\", \"c\": 0.10 // last\n}\n";
  EXPECT_EQ(without_member(text, "b"), "{ // first\n  \"a\": [1, {\"b\": 2}], /* of b */ \"c\": 0.10 // last\n}\n");
  EXPECT_EQ(without_member(text, "c"), "{ // first\n  \"a\": [1, {\"b\": 2}], /* of b */ \"b\" : \"},\" // last\n}\n");
  EXPECT_EQ(without_member(text, "a"), "{ // first\n  /* of b */ \"b\" : \"},\", \"c\": 0.10 // last\n}\n");
  EXPECT_EQ(without_member(text, "d"), text);
  EXPECT_EQ(without_member("{\"a\": 1}", "a"), "{}");
  EXPECT_EQ(without_member("{\"a\": 1, // of a\n\"b\": 2}", "b"), "{\"a\": 1 // of a\n}");
  EXPECT_EQ(without_member(with_member(text, "new", "2"), "new"), text);
  EXPECT_THROW((void)without_member("[1]", "a"), InvalidInput);
}

}  // namespace
}  // namespace patinate
