#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>

#include "libcommon/core/expression_program.h"
#include "libcommon/core/random.h"
#include "tests/support/errors.h"

namespace patinate {
namespace {

const std::vector<std::string> kNames{"water", "metal", "age"};
const ExpressionSyntax kSyntax{.subject = "driver", .name = "material", .names = kNames, .has_files = false};

using Block = std::array<float, kExpressionBlock>;

/// Values of an expression for inputs of each of kNames.
Block values_of(const std::string& text, const std::array<Block, 3>& inputs,
                InstructionSet set = InstructionSet::Baseline) {
  const Expression expression = parse_expression(text, kSyntax);
  const ExpressionProgram program = compile_expression(
      expression,
      [](const ExpressionName& name) {
        return static_cast<int>(std::find(kNames.begin(), kNames.end(), name.text) - kNames.begin());
      },
      3);
  std::vector<float> memory(static_cast<std::size_t>(program.num_slots + 1) * kExpressionBlock);
  void* start = memory.data();
  std::size_t room = memory.size() * sizeof(float);
  auto* slots = static_cast<float*>(std::align(64, memory.size() * sizeof(float) - 64, start, room));
  std::memcpy(slots, inputs.data(), sizeof inputs);
  for (const auto& constant : program.constants)
    std::fill_n(slots + constant.slot * kExpressionBlock, kExpressionBlock, constant.value);
  run_expression(program, slots, set);
  Block out;
  std::copy_n(slots + program.result * kExpressionBlock, kExpressionBlock, out.begin());
  return out;
}

/// Where water = 0.2, metal = 0.6 and age = -3.
float value_of(const std::string& text) {
  std::array<Block, 3> inputs;
  inputs[0].fill(0.2F);
  inputs[1].fill(0.6F);
  inputs[2].fill(-3.0F);
  const Block values = values_of(text, inputs);
  for (const float value : values) EXPECT_EQ(value, values[0]);
  return values[0];
}

TEST(ExpressionProgram, FollowsTheRulesOfArithmetic) {
  EXPECT_FLOAT_EQ(value_of("metal"), 0.6F);
  EXPECT_FLOAT_EQ(value_of("2.5"), 2.5F);
  EXPECT_FLOAT_EQ(value_of("0.7*water + 0.3*metal"), 0.32F);
  EXPECT_FLOAT_EQ(value_of("(water + metal)*(metal - water)/(0.5*(1 + 3))"), 0.16F);
  EXPECT_FLOAT_EQ(value_of("metal - (water - (0.1 - (age + 3)))"), 0.5F);
  EXPECT_FLOAT_EQ(value_of("min(metal, water*2, 1, !metal)"), 0.4F);
  EXPECT_FLOAT_EQ(value_of("max(min(metal, 0.5), -age*water, water)"), 0.6F);
  EXPECT_FLOAT_EQ(value_of("max(min(max(metal)))"), 0.6F);
  EXPECT_FLOAT_EQ(value_of("abs(age)*water"), 0.6F);
  EXPECT_FLOAT_EQ(value_of("pow(metal, 2) + pow(age, 0.5)"), 0.36F);
  EXPECT_FLOAT_EQ(value_of("clamp(age, 0.1, 0.7) + clamp(9, water, metal)"), 0.7F);
  EXPECT_FLOAT_EQ(value_of("smoothstep(0.2, 1, metal) + smoothstep(0.6, 0.6, water)"), 0.5F);
  EXPECT_FLOAT_EQ(value_of("-(-water - -metal)"), -0.4F);
}

TEST(ExpressionProgram, IsNeverNanOrInfinite) {
  EXPECT_EQ(value_of("metal/0"), 0.0F) << "by definition";
  EXPECT_EQ(value_of("-metal/(water - water)"), 0.0F);
  EXPECT_EQ(value_of("1e30*1e30*1e30*0"), 0.0F);
  EXPECT_EQ(value_of("1e30*1e30 - 1e30*1e30"), 0.0F);
  EXPECT_EQ(value_of("pow(0, -1)"), 0.0F);
  EXPECT_EQ(value_of("pow(1e30, 9)"), 1e30F);
  EXPECT_EQ(value_of("1e30/1e-30"), 1e30F);
  EXPECT_EQ(value_of("smoothstep(-1e30, 1e30, 1e30)"), 1.0F);
  for (const std::string text : {"water/metal", "pow(water, metal)", "smoothstep(water, metal, age)",
                                 "clamp(water, age, metal)", "water/(metal*metal*metal)"}) {
    RandomStream random(1, 0);
    std::array<Block, 3> inputs;
    for (int run = 0; run < 50; ++run) {
      for (Block& block : inputs) {
        for (float& value : block)
          value = static_cast<float>((random.uniform() - 0.5) * std::pow(10.0, 60.0 * random.uniform() - 30.0));
      }
      inputs[0][3] = inputs[1][3] = 0.0F;
      for (const float value : values_of(text, inputs)) ASSERT_TRUE(std::abs(value) <= 1e30F) << text;
    }
  }
}

TEST(ExpressionProgram, HasTheSameBitsForEveryInstructionSet) {
  for (const InstructionSet set : {InstructionSet::Avx2, InstructionSet::Avx512}) {
    if (!has_instruction_set(set))
      GTEST_SKIP() << "this machine lacks " << kInstructionSetNames[static_cast<std::size_t>(set)];
    RandomStream random(2, 0);
    for (int run = 0; run < 100; ++run) {
      std::array<Block, 3> inputs;
      for (Block& block : inputs) {
        for (float& value : block)
          value = random.below(9) == 0 ? 0.0F : static_cast<float>(4.0 * random.uniform() - 0.5);
      }
      for (const std::string text :
           {"min(water, metal)", "water*metal + age/water", "!pow(water, 1.7) - clamp(age, water, metal)",
            "smoothstep(water, metal, age)/abs(age - metal)", "max(-water, age, 0.3)*metal"}) {
        const Block expected = values_of(text, inputs), found = values_of(text, inputs, set);
        ASSERT_EQ(std::memcmp(expected.data(), found.data(), sizeof expected), 0) << text;
      }
    }
  }
}

TEST(ExpressionProgram, NamesTheMistakeAndWhatWasMeant) {
  const auto says = [](const std::string& text) {
    return testing_support::error_of<ParseError>([&] { (void)parse_expression(text, kSyntax); });
  };
  EXPECT_EQ(says("min(watr, metal)"),
            "driver `min(watr, metal)`: position 5: unknown material `watr`; there are `water`, `metal`, `age`; did "
            "you mean `water`?");
  EXPECT_EQ(says("water +"), "driver `water +`: position 8: found the end; expected a number, a material or `(`");
  EXPECT_EQ(says("\"wet.exr\""), "driver `\"wet.exr\"`: position 1: found `\"`; expected a number, a material or `(`");
  EXPECT_EQ(says("water/metal"), "") << "no path where there are no files";
}

}  // namespace
}  // namespace patinate
