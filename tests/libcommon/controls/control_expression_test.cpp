#include "libcommon/controls/control_expression.h"

#include <gtest/gtest.h>

#include <cmath>

#include "patinate/core/error.h"

namespace patinate {
namespace {

const std::vector<std::string> kNames{"accessibility", "facing", "spray"};

/// Value of an expression where accessibility = 0.2, facing = 0.6, spray = 0.5 and every file 0.9.
float value_of(const std::string& text) {
  const ControlExpression expression(text, kNames);
  const ControlMap map = expression.evaluate(ImageU8(1, 1, 1, std::uint8_t{255}), [](const ControlName& name) {
    const float value = name.is_file ? 0.9F : name.text == "accessibility" ? 0.2F : name.text == "facing" ? 0.6F : 0.5F;
    return ControlMap{ImageF(1, 1, 1, value), -3.0, 5.0, "1/mm"};
  });
  return map.values.at(0, 0);
}

std::string expression_error(const std::string& text) {
  try {
    const ControlExpression expression(text, kNames);
  } catch (const ParseError& e) {
    const std::string message = e.what();
    return message.substr(message.find("position"));
  }
  return "";
}

TEST(ControlExpression, FollowsTheRulesOfArithmetic) {
  EXPECT_FLOAT_EQ(value_of("0.7*accessibility + 0.3*facing"), 0.32F);
  EXPECT_FLOAT_EQ(value_of("facing - accessibility - 0.1"), 0.3F);
  EXPECT_FLOAT_EQ(value_of("facing-(accessibility-.1)"), 0.5F);
  EXPECT_FLOAT_EQ(value_of("0.6/2/3"), 0.1F);
  EXPECT_FLOAT_EQ(value_of("1 - 2*accessibility"), 0.6F);
  EXPECT_FLOAT_EQ(value_of("-accessibility + 1"), 0.8F);
  EXPECT_FLOAT_EQ(value_of("!spray*facing"), 0.3F);
  EXPECT_FLOAT_EQ(value_of("!(spray*facing)"), 0.7F);
  EXPECT_FLOAT_EQ(value_of("!!facing"), 0.6F);
  EXPECT_FLOAT_EQ(value_of("min(facing, accessibility, 0.3)"), 0.2F);
  EXPECT_FLOAT_EQ(value_of("max(min(facing,spray),accessibility)"), 0.5F);
  EXPECT_FLOAT_EQ(value_of("2e-1"), 0.2F);
  EXPECT_FLOAT_EQ(value_of("facing/accessibility*0.1"), 0.3F);
}

TEST(ControlExpression, IsClampedAndNeverNan) {
  EXPECT_EQ(value_of("facing + facing"), 1.0F);
  EXPECT_EQ(value_of("-facing"), 0.0F);
  EXPECT_EQ(value_of("facing / 0"), 1.0F);
  EXPECT_EQ(value_of("-facing / 0"), 0.0F);
  EXPECT_EQ(value_of("0 / 0"), 0.0F);
  EXPECT_EQ(value_of("1/0 - 1/0"), 0.0F);
  EXPECT_EQ(value_of("1e30*1e30*1e30*0"), 0.0F);
}

TEST(ControlExpression, HasTheFunctionsOfShaping) {
  EXPECT_FLOAT_EQ(value_of("abs(accessibility - facing)"), 0.4F);
  EXPECT_FLOAT_EQ(value_of("pow(spray, 2)"), 0.25F);
  EXPECT_FLOAT_EQ(value_of("pow(0 - spray, 0.5)"), 0.0F);  // of max(0, x)
  EXPECT_FLOAT_EQ(value_of("pow(0*spray, -1)"), 1.0F);     // huge, then cut
  EXPECT_FLOAT_EQ(value_of("clamp(2*facing, 0.1, 0.7)"), 0.7F);
  EXPECT_FLOAT_EQ(value_of("clamp(facing - 1, 0.1, 0.7)"), 0.1F);
  EXPECT_FLOAT_EQ(value_of("smoothstep(0.4, 0.8, facing)"), 0.5F);
  EXPECT_FLOAT_EQ(value_of("smoothstep(0, 1, accessibility)"), 0.104F);  // 3 * 0.04 - 2 * 0.008
  EXPECT_FLOAT_EQ(value_of("smoothstep(0.8, 0, accessibility)"), 0.84375F);
  EXPECT_FLOAT_EQ(value_of("smoothstep(0.6, 0.6, spray)"), 0.0F);
  EXPECT_EQ(expression_error("pow(facing)"), "position 11: found `)`; expected `,`");
  EXPECT_EQ(expression_error("abs(facing, 2)"), "position 11: found `,`; expected `)`");
}

TEST(ControlExpression, KindsHaveArguments) {
  const auto names_of = [](const std::string& text) { return ControlExpression(text, kNames).names(); };
  EXPECT_EQ(names_of("accessibility(scale=3) - accessibility( scale = 10 , low-percent=2)"),
            (std::vector<ControlName>{{"accessibility", false, {{"scale", "3"}}},
                                      {"accessibility", false, {{"scale", "10"}, {"low_percent", "2"}}}}));
  EXPECT_EQ(names_of("spray(path=\"a, b).csv\", shadows=false)*facing(direction=0,1,0)"),
            (std::vector<ControlName>{{"spray", false, {{"spray_path", "a, b).csv"}, {"spray_shadows", "false"}}},
                                      {"facing", false, {{"direction", "0,1,0"}}}}));
  EXPECT_EQ(ControlExpression("facing(direction=z)", kNames).alone()->text, "facing");
  EXPECT_EQ(ControlExpression("!facing", kNames).alone(), nullptr);
  EXPECT_EQ(expression_error("facing(scale=3)"), "position 8: `facing` has no argument `scale`; it has direction");
  EXPECT_EQ(expression_error("facing(direction)"), "position 8: found `d`; expected an argument, such as scale=3");
}

TEST(ControlExpression, TellsFilesFromNames) {
  const auto names_of = [](const std::string& text) { return ControlExpression(text, kNames).names(); };
  EXPECT_EQ(names_of("maps/wet.exr"), (std::vector<ControlName>{{"maps/wet.exr", true}}));
  EXPECT_EQ(names_of("../wet-2.png*facing"), (std::vector<ControlName>{{"../wet-2.png", true}, {"facing", false}}));
  EXPECT_EQ(names_of("0.5*2024-05_map.exr"), (std::vector<ControlName>{{"2024-05_map.exr", true}}));
  EXPECT_EQ(names_of("\"my maps/a + b.exr\" + facing/2"),
            (std::vector<ControlName>{{"my maps/a + b.exr", true}, {"facing", false}}));
  EXPECT_EQ(names_of("facing + spray*facing"), (std::vector<ControlName>{{"facing", false}, {"spray", false}}));
  EXPECT_FLOAT_EQ(value_of("wet.exr * facing"), 0.54F);
}

TEST(ControlExpression, ErrorsNameThePositionAndWhatWasMeant) {
  EXPECT_EQ(
      expression_error("0.5*acessibility"),
      "position 5: unknown control `acessibility`; there are `accessibility`, `facing`, `spray`, and files such as "
      "`map.exr`; did you mean `accessibility`?");
  EXPECT_EQ(expression_error("facing +"), "position 9: found the end; expected a number, a control or `(`");
  EXPECT_EQ(expression_error("(facing"), "position 8: found the end; expected `)`");
  EXPECT_EQ(expression_error("facing spray"), "position 8: found `s`; expected an operator or the end");
  EXPECT_EQ(expression_error("min facing"), "position 5: found `f`; expected `(`");
  EXPECT_EQ(expression_error("facing % 2"), "position 8: found `%`; expected an operator or the end");
  EXPECT_EQ(expression_error("\"wet.exr"), "position 1: found `\"`; expected a file name between two `\"`");
  EXPECT_NE(expression_error(""), "");
  EXPECT_NE(expression_error(std::string(5000, '(')).find("levels of nesting"), std::string::npos);
  EXPECT_NE(expression_error(std::string(20'000, ' ')), "");
}

TEST(ControlExpression, KeepsTheRangeOfAMapAlone) {
  const auto evaluate = [](const std::string& text) {
    return ControlExpression(text, kNames).evaluate(ImageU8(2, 1, 1, std::uint8_t{255}), [](const ControlName&) {
      return ControlMap{ImageF(2, 1, 1, 0.25F), -3.0, 5.0, "1/mm"};
    });
  };
  const ControlMap same = evaluate("(facing)"), inverted = evaluate("!facing"), mixed = evaluate("2*facing");
  EXPECT_EQ(same.low, -3.0);
  EXPECT_EQ(same.high, 5.0);
  EXPECT_EQ(same.unit, "1/mm");
  EXPECT_EQ(inverted.low, 5.0);
  EXPECT_EQ(inverted.high, -3.0);
  EXPECT_EQ(mixed.unit, "relative");
  EXPECT_EQ(mixed.high, 1.0);
}

TEST(ControlExpression, IsZeroOutsideTheChartsAndChecksSizes) {
  const ControlExpression expression("!facing", kNames);
  ImageU8 coverage(2, 1, 1, std::uint8_t{255});
  coverage.at(1, 0) = 0;
  const auto map_of = [](int width) { return ControlMap{ImageF(width, 1), 0.0, 1.0, ""}; };
  const ControlMap out = expression.evaluate(coverage, [&](const ControlName&) { return map_of(2); });
  EXPECT_EQ(out.values.at(0, 0), 1.0F);
  EXPECT_EQ(out.values.at(1, 0), 0.0F);
  EXPECT_THROW((void)expression.evaluate(coverage, [&](const ControlName&) { return map_of(3); }), InvalidInput);
}

}  // namespace
}  // namespace patinate
