#include "libcommon/atlas/texel_set.h"

#include <gtest/gtest.h>

#include <vector>

#include "libcommon/core/random.h"

namespace patinate {
namespace {

// Oracle: a list. Sizes around words of 64; from almost nothing to everything.
TEST(TexelSet, SaysWhatAListOfItsMembersSays) {
  for (const std::int64_t num_texels : {0, 1, 63, 64, 65, 127, 1000, 4096}) {
    for (const std::uint32_t of_100 : {0u, 1u, 50u, 100u}) {
      const auto is_member_of_set = [&](TexelId t) {
        return RandomStream(7, static_cast<std::uint64_t>(t)).below(100) < of_100;
      };
      std::vector<TexelId> list;
      for (TexelId t = 0; t < num_texels; ++t) {
        if (is_member_of_set(t)) list.push_back(t);
      }
      const TexelSet set(num_texels, is_member_of_set, {});
      ASSERT_EQ(set.size(), list.size()) << num_texels << " " << of_100;
      EXPECT_EQ(std::vector<TexelId>(set.begin(), set.end()), list);
      std::size_t before = 0;
      for (TexelId t = 0; t < num_texels; ++t) {
        const bool is_member = before < list.size() && list[before] == t;
        ASSERT_EQ(set.contains(t), is_member) << t;
        ASSERT_EQ(set.index_of(t), before) << t;
        before += is_member;
      }
      for (std::size_t i = 0; i < list.size(); ++i) {
        ASSERT_EQ(set[i], list[i]) << i;
        ASSERT_EQ(std::vector<TexelId>(set.from(i), set.end()).size(), list.size() - i) << i;
      }
      EXPECT_EQ(set.from(list.size()), set.end());
    }
  }
}

TEST(TexelSet, OfNothingIsEmpty) {
  const TexelSet set;
  EXPECT_EQ(set.size(), 0u);
  EXPECT_EQ(set.begin(), set.end());
}

}  // namespace
}  // namespace patinate
