#include "libcommon/output/contact_strip.h"

#include <gtest/gtest.h>

namespace patinate {
namespace {

TEST(ContactStrip, LabelsOfAScaleHaveTheDecimalsThatItsStepsAsk) {
  using Texts = std::vector<std::string>;
  EXPECT_EQ(scale_labels(std::vector{0.0, 1.3325, 2.665, 3.9975, 5.33}), (Texts{"0", "1.3", "2.7", "4", "5.3"}));
  EXPECT_EQ(scale_labels(std::vector{0.0, 119.75, 239.5, 359.25, 479.0}), (Texts{"0", "120", "240", "359", "479"}));
  EXPECT_EQ(scale_labels(std::vector{-0.02, 0.0, 0.02}), (Texts{"-0.02", "0", "0.02"}));
  EXPECT_EQ(scale_labels(std::vector{1.6e9, 1.6e9 + 60.0}), (Texts{"1600000000", "1600000060"}));
  EXPECT_EQ(scale_labels(std::vector{2.5, 2.5}), (Texts{"2.5", "2.5"}));
}

}  // namespace
}  // namespace patinate
