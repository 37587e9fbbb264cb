#include "transfer/synthesis/neighborhood_projection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <set>
#include <tuple>

#include "libcommon/core/instruction_set.h"
#include "libcommon/core/random.h"
#include "transfer/synthesis/pixel_blocks.h"

namespace patinate::transfer {
namespace {

using Appearance = std::function<int(int x, int y, int c)>;

SourceLevel source_of(int side, const Neighborhood& neighborhood, const Appearance& value) {
  AppearanceImage appearance(side, side, kAppearanceSize);
  ControlImage controls(side, side, 1);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      for (int c = 0; c < kAppearanceSize; ++c) appearance.at(x, y, c) = static_cast<std::int16_t>(value(x, y, c));
      controls.at(x, y) = static_cast<std::uint16_t>((x * 97 + y * 31) % (kControlSteps + 1));
    }
  }
  ImageU8 mask(side, side, 1, 255);
  mask.at(side / 2, side / 3) = 0;
  return make_source_level(std::move(appearance), std::move(controls), mask, 20000.0, neighborhood);
}

int noise(int x, int y, int c) {
  return static_cast<int>(RandomStream(4, static_cast<std::uint64_t>((y * 4096 + x) * 8 + c)).below(1023)) - 511;
}
int spikes(int x, int y, int c) {
  return (noise(x, y, 0) > 0 ? 1 : -1) * (c % 2 == 0 ? kAppearanceLimit : -kAppearanceLimit);
}
int waves(int x, int y, int c) { return (x * (13 + c) + y * (29 - 3 * c)) % (600 >> c) - (300 >> c); }
int flat(int, int, int) { return kAppearanceLimit; }

using Parts = NeighborhoodProjection::Parts;

/// Over the neighbors of some quarters.
std::int64_t squared_difference(std::span<const std::int16_t> a, std::span<const std::int16_t> b,
                                const Neighborhood& neighborhood, unsigned quarters) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::size_t k = i / kAppearanceSize;
    if ((quarters >> quarter_of(neighborhood.offsets[k]) & 1U) != 0)
      sum += std::int64_t{neighborhood.weights[k]} * (a[i] - b[i]) * (a[i] - b[i]);
  }
  return sum;
}

/// Over the values of some quarters.
std::int64_t squared_distance(const ProjectedNeighborhood& p, const ProjectedNeighborhood& q,
                              unsigned quarters = kAllQuarters) {
  std::int64_t sum = 0;
  for (std::size_t j = 0; j < p.size(); ++j)
    sum += (quarters >> (j / 4) & 1U) != 0 ? std::int64_t{p[j] - q[j]} * (p[j] - q[j]) : 0;
  return sum;
}

/// Two lists of appearances: anything, anything and nearly the same, or the limits.
void draw(RandomStream& random, std::uint32_t kind, std::vector<std::int16_t>& a, std::vector<std::int16_t>& b) {
  const auto any = [&] {
    return static_cast<std::int16_t>(static_cast<int>(random.below(2 * kAppearanceLimit + 1)) - kAppearanceLimit);
  };
  const auto limit = [&] {
    return static_cast<std::int16_t>(random.below(2) == 0 ? kAppearanceLimit : -kAppearanceLimit);
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i] = kind == 2 ? limit() : any();
    const int step = static_cast<int>(random.below(5)) - 2;
    b[i] = kind == 0   ? any()
           : kind == 1 ? static_cast<std::int16_t>(std::clamp(a[i] + step, -kAppearanceLimit, kAppearanceLimit))
           : kind == 2 ? static_cast<std::int16_t>(-a[i])
                       : limit();
  }
}

TEST(NeighborhoodProjection, IsNeverFartherApartThanTheNeighborhoodsAre) {
  std::int64_t wrong = 0;
  double nearest_to_reach = 0.0;
  for (const Appearance& value : {Appearance(noise), Appearance(spikes), Appearance(waves), Appearance(flat)}) {
    for (const int radius : {1, 3, 5}) {
      const Neighborhood neighborhood = Neighborhood::square(radius);
      const SourceLevel source = source_of(40, neighborhood, value);
      for (const Parts parts : {Parts::Whole, Parts::Quarters}) {
        const NeighborhoodProjection projection(source, neighborhood, parts);
        std::vector<std::int16_t> a(neighborhood.offsets.size() * kAppearanceSize), b(a.size());
        for (std::uint64_t i = 0; i < 400; ++i) {
          RandomStream random(6, i);
          draw(random, static_cast<std::uint32_t>(i % 4), a, b);
          const unsigned quarters = parts == Parts::Whole ? kAllQuarters : 1 + random.below(kAllQuarters);
          const std::int64_t reach = NeighborhoodProjection::reach(squared_difference(a, b, neighborhood, quarters)),
                             distance = squared_distance(projection.of(a), projection.of(b), quarters);
          wrong += distance > reach ? 1 : 0;
          nearest_to_reach = std::max(nearest_to_reach, static_cast<double>(distance) / static_cast<double>(reach));
        }
      }
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(nearest_to_reach, 0.5) << "a bound that says little";
}

TEST(NeighborhoodProjection, OfAPixelIsThatOfItsNeighbors) {
  const Neighborhood neighborhood = Neighborhood::square(2);
  const SourceLevel source = source_of(24, neighborhood, noise);
  std::vector<std::int16_t> around;
  for (const Offset& o : neighborhood.offsets) {
    for (int c = 0; c < kAppearanceSize; ++c) around.push_back(source.appearance.at(10 + o.x, 15 + o.y, c));
  }
  for (const Parts parts : {Parts::Whole, Parts::Quarters}) {
    const NeighborhoodProjection projection(source, neighborhood, parts);
    EXPECT_EQ(projection.of_pixel(15 * 24 + 10), projection.of(around));
  }
}

// What looks alike is near in the projection: smooth sources are told apart by a few axes.
TEST(NeighborhoodProjection, KeepsMostOfTheDistanceInASmoothSource) {
  const Neighborhood neighborhood = Neighborhood::square(3);
  const SourceLevel source = source_of(64, neighborhood, [](int x, int y, int c) {
    return (x * (c + 1) + 2 * y) % 256 < 128 ? 3 * x - c * y : c * x - 2 * y;
  });
  for (const Parts parts : {Parts::Whole, Parts::Quarters}) {
    const NeighborhoodProjection projection(source, neighborhood, parts);
    double kept = 0.0, total = 0.0;
    std::array<std::vector<std::int16_t>, 2> around;
    for (std::uint64_t i = 0; i < 500; ++i) {
      RandomStream random(3, i);
      for (std::vector<std::int16_t>& a : around) {
        const std::int32_t p = source.usable[random.below(static_cast<std::uint32_t>(source.usable.size()))];
        a.clear();
        for (const Offset& o : neighborhood.offsets) {
          for (int c = 0; c < kAppearanceSize; ++c)
            a.push_back(source.appearance.at(p % source.width() + o.x, p / source.width() + o.y, c));
        }
      }
      kept += 16.0 * static_cast<double>(squared_distance(projection.of(around[0]), projection.of(around[1])));
      total += static_cast<double>(squared_difference(around[0], around[1], neighborhood, kAllQuarters));
    }
    EXPECT_GT(kept / total, 0.9);
  }
}

TEST(NeighborhoodProjection, QuartersAreOfEqualSizeAndTwoOfThemComeFirst) {
  for (int radius = 1; radius <= 5; ++radius) {
    std::array<std::size_t, kNumQuarters> sizes{};
    for (const Offset& o : Neighborhood::square(radius).offsets) {
      ++sizes[quarter_of(o)];
      EXPECT_EQ(o.y < 0 || (o.y == 0 && o.x < 0), quarter_of(o) == 0 || quarter_of(o) == 3);
    }
    for (std::size_t size : sizes) EXPECT_EQ(size, static_cast<std::size_t>(radius * (radius + 1)));
  }
}

TEST(PixelBlocks, HoldEveryUsablePixelOnceWithWhatTheySayOfIt) {
  const Neighborhood neighborhood = Neighborhood::square(1);
  const SourceLevel source = source_of(70, neighborhood, waves);
  const NeighborhoodProjection projection(source, neighborhood, Parts::Whole);
  constexpr std::size_t kGroups = PixelBlock::kSize / kGroupSize;
  for (const auto tiles : {PixelBlocks::Tiles::Squares, PixelBlocks::Tiles::Anywhere}) {
    const PixelBlocks all = PixelBlocks::make(source, projection, tiles);
    const auto holds = [](const SearchWindow& extent, int x, int y) {
      return x >= extent.x0 && x < extent.x1 && y >= extent.y0 && y < extent.y1;
    };
    std::set<std::int32_t> seen;
    std::int32_t next_block = 0;
    for (std::size_t t = 0; t < all.tiles.size(); ++t) {
      const PixelTile& tile = all.tiles[t];
      EXPECT_EQ(tile.first_block, next_block);
      EXPECT_LE(tile.last_block, next_block + kGroupSize);
      next_block = tile.last_block;
      for (auto b = static_cast<std::size_t>(tile.first_block); b < static_cast<std::size_t>(tile.last_block); ++b) {
        const PixelBlock& block = all.blocks[b];
        const std::size_t in_tile = b - static_cast<std::size_t>(tile.first_block);
        EXPECT_TRUE(block.end > block.begin && block.end - block.begin <= PixelBlock::kSize);
        for (auto i = static_cast<std::size_t>(block.begin); i < static_cast<std::size_t>(block.end); ++i) {
          const std::int32_t pixel = all.pixels[i];
          const int x = pixel % source.width(), y = pixel / source.width();
          const ProjectedNeighborhood p = projection.of_pixel(pixel);
          const std::size_t at = i - static_cast<std::size_t>(block.begin);
          EXPECT_TRUE(seen.insert(pixel).second);
          EXPECT_TRUE(holds(block.extent, x, y) && holds(tile.extent, x, y));
          EXPECT_TRUE(block.low_control <= all.controls[i] && all.controls[i] <= block.high_control);
          EXPECT_TRUE(all.controls[i] == source.controls.at(x, y) &&
                      (at == 0 || all.controls[i - 1] <= all.controls[i]));
          for (std::size_t j = 0; j < p.size(); ++j) {
            EXPECT_EQ(all.groups[b * kGroups + at / kGroupSize].values[j / 2][at % kGroupSize][j % 2], p[j]);
            EXPECT_TRUE(all.boxes[t].low.values[j / 2][in_tile][j % 2] <= p[j] &&
                        p[j] <= all.boxes[t].high.values[j / 2][in_tile][j % 2]);
          }
        }
      }
    }
    EXPECT_EQ(static_cast<std::size_t>(next_block), all.blocks.size());
    EXPECT_EQ(seen.size(), source.usable.size());
  }
}

TEST(ReachKernel, SaysTheSameAsTheFormulaForEveryInstructionSet) {
  constexpr std::size_t kNumGroups = 9;
  std::array<ProjectedGroup, kNumGroups> groups{};
  ProjectedBoxes boxes{};
  RandomStream random(9, 0);
  const auto any = [&] {
    return static_cast<std::int16_t>(static_cast<int>(random.below(5600)) - 2800);
  };  // 16 of them are at most 11,200 long.
  for (int i = 0; i < kGroupSize; ++i) {
    for (int j = 0; j < 16; ++j) {
      for (ProjectedGroup& group : groups) group.values[j / 2][i][j % 2] = any();
      std::tie(boxes.low.values[j / 2][i][j % 2], boxes.high.values[j / 2][i][j % 2]) = std::minmax({any(), any()});
    }
  }
  ProjectedNeighborhood query{};
  for (std::int16_t& q : query) q = any();
  const std::array<ReachKernel, 3> kernels{reach_baseline::kKernel, reach_avx2::kKernel, reach_avx512::kKernel};
  for (const unsigned quarters : {kAllQuarters, 1U, 10U}) {
    ProjectedNeighborhood counts{};
    for (std::size_t j = 0; j < counts.size(); ++j) counts[j] = (quarters >> (j / 4) & 1U) != 0 ? -1 : 0;
    const auto squared = [&](const ProjectedGroup& low, const ProjectedGroup& high, std::size_t i) {
      std::int32_t sum = 0;
      for (std::size_t j = 0; j < query.size(); ++j) {
        const int d = std::max({0, low.values[j / 2][i][j % 2] - query[j], query[j] - high.values[j / 2][i][j % 2]});
        sum += counts[j] != 0 ? d * d : 0;
      }
      return sum;
    };
    for (const std::int32_t limit : {-1, 0, 8'000'000, 20'000'000, 60'000'000, 90'000'000, 1'000'000'000}) {
      for (std::size_t k = 0; k < kernels.size(); ++k) {
        if (!has_instruction_set(static_cast<InstructionSet>(k))) continue;  // Baseline is always there.
        alignas(64) std::array<std::int32_t, kNumGroups * kGroupSize> distances{};
        std::array<std::uint16_t, kNumGroups> masks{};
        const auto check = [&](bool is_within, std::int32_t distance, std::int32_t expected) {
          EXPECT_EQ(is_within, expected <= limit) << kInstructionSetNames[k];
          EXPECT_TRUE(!is_within || distance == expected) << kInstructionSetNames[k];
        };
        kernels[k].points(groups.data(), static_cast<int>(groups.size()), query.data(), counts.data(), limit,
                          distances.data(), masks.data());
        for (std::size_t i = 0; i < distances.size(); ++i)
          check((masks[i / kGroupSize] >> (i % kGroupSize) & 1U) != 0, distances[i],
                squared(groups[i / kGroupSize], groups[i / kGroupSize], i % kGroupSize));
        const unsigned mask = kernels[k].boxes(&boxes, query.data(), counts.data(), limit, distances.data());
        for (std::size_t i = 0; i < kGroupSize; ++i)
          check((mask >> i & 1U) != 0, distances[i], squared(boxes.low, boxes.high, i));
      }
    }
  }
}

}  // namespace
}  // namespace patinate::transfer
