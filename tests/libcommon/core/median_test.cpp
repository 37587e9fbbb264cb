#include "libcommon/core/median.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "libcommon/core/random.h"

namespace patinate {
namespace {

TEST(Median, IsTheMiddleOrTheUpperOfTheMiddleTwo) {
  EXPECT_EQ(median(std::vector<double>{3, 1, 2}), 2);
  EXPECT_EQ(median(std::vector<float>{4, 1, 3, 2}), 3);
  EXPECT_EQ(median(std::vector<int>{7}), 7);
  EXPECT_EQ(median(std::vector<double>{}), 0);
}

// Expected values: those of the sorted list.
TEST(Median, ValuesByRankAreThoseOfTheSortedList) {
  RandomStream random(1, 2, 3);
  std::vector<double> values(101);
  for (double& v : values) v = random.uniform();
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t rank = 0; rank < values.size(); ++rank) EXPECT_EQ(value_at_rank(values, rank), sorted[rank]);
}

}  // namespace
}  // namespace patinate
