// The kernels against their definition in integers of 64 bit, a texel at a time: what another device would have to
// repeat.
#include "simulation/composition/compose_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "libcommon/core/instruction_set.h"
#include "libcommon/core/random.h"
#include "simulation/composition/quantized_appearance.h"
#include "tests/simulation/composition/compose_scene.h"

namespace patinate::simulation::composition {
namespace {

using i64 = std::int64_t;

std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : {InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512}) {
    if (has_instruction_set(set)) sets.push_back(set);
  }
  return sets;
}

i64 varied(i64 variation, i64 xi) { return 32768 + ((variation * xi + 16384) >> 15); }

i64 scaled(i64 delta, i64 factor, i64 shift, i64 variation, i64 xi) {
  if (variation != 0) delta = (delta * (varied(variation, xi) >> 2) + 4096) >> 13;
  return std::clamp<i64>((delta * factor + (shift > 0 ? i64{1} << (shift - 1) : 0)) >> shift, -kMaxHeight, kMaxHeight);
}

/// A look's color of a channel where there is F = delta (1 + v xi).
i64 color_of(const QuantizedAppearance& look, i64 delta, i64 xi, std::size_t c) {
  const i64 f = std::min<i64>((std::max<i64>(delta, 0) * varied(look.variation, xi) + 16384) >> 15, 65535);
  i64 color = look.color[c], begin = color;
  for (std::size_t r = 0; r < static_cast<std::size_t>(look.num_ramps); ++r) {
    const i64 share =
        (std::clamp<i64>(f - look.ramp_start[r], 0, look.ramp_width[r]) * look.ramp_scale[r] + 32768) >> 16;
    color += ((look.ramp_color[3 * r + c] - begin) * share) >> 14;
    begin = look.ramp_color[3 * r + c];
  }
  return color;
}

struct Composed {
  std::uint32_t code = 0;
  i64 height = 0;
};

Composed compose_texel(const ComposeTask& task, std::uint32_t l) {
  i64 total = 0, specular = task.base->specular[l], height = task.height[l];
  std::vector<i64> weights;
  for (std::size_t k = 0; k < static_cast<std::size_t>(task.num_materials); ++k) {
    const QuantizedAppearance& look = *task.look[k];
    const i64 xi = noise(task.first_texel + l, look.noise_key);
    const i64 delta = i64{task.amount[k][l]} - task.original[k][l];
    i64 w = delta > look.limit ? i64{kMaxWeight} : (std::max<i64>(delta, 0) * look.strength + 8192) >> 14;
    w = std::min<i64>((w * varied(look.variation, xi) + 16384) >> 15, kMaxWeight);
    weights.push_back(w);
    const i64 at_one = delta > 0 ? std::min<i64>(look.strength, kMaxWeight) : 0;
    const i64 cover = std::min<i64>((at_one * varied(look.variation, xi) + 16384) >> 15, kMaxWeight);
    total += task.form == kPrintedForm ? cover : w;
    specular += scaled(delta, look.specular, 13, look.specular_variation, xi);
    height += scaled(delta, look.height, look.height_shift, look.height_variation, xi);
  }
  const i64 most = task.form == kPrintedForm ? kOne : total;  // Where weights are not divided by their sum.
  const i64 scale = total > kOne                   ? ((i64{1} << 30) + most / 2) / most
                    : task.form == kNormalizedForm ? 65536
                                                   : total * 4;
  Composed out{.code = static_cast<std::uint32_t>((std::clamp<i64>(specular, 0, kOne) * 255 + 8192) >> 14) << 24,
               .height = std::clamp<i64>(height, -kMaxHeight, kMaxHeight)};
  for (std::size_t c = 0; c < 3; ++c) {
    i64 sum = std::max<i64>(0, kOne - total) * task.base->linear[c][l] + 8192;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      const i64 delta = i64{task.amount[k][l]} - task.original[k][l];
      const i64 color = task.picture[k] != nullptr
                            ? task.picture[k][c * kTile + l]
                            : color_of(*task.look[k], delta, noise(task.first_texel + l, task.look[k]->noise_key), c);
      sum += ((weights[k] * scale + 32768) >> 16) * color;
    }
    out.code |= static_cast<std::uint32_t>(task.srgb[std::min<i64>(sum >> 14, 65535) >> kSrgbShift]) << (8 * c);
  }
  return out;
}

TEST(ComposeKernel, GivesWhatItsDefinitionInIntegersGives) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    RandomStream random(seed, 1);
    std::vector<MaterialAppearance> appearance =
        testing_support::any_appearance(static_cast<int>(1 + random.below(8)), seed);
    if (seed % 10 == 0) appearance[0].strength = 1000.0;
    std::vector<QuantizedAppearance> quantized;
    for (std::size_t k = 0; k < appearance.size(); ++k)
      quantized.push_back(quantize(appearance[k], 300.0, noise_key(static_cast<int>(k))));
    std::vector<std::uint16_t> amounts(8 * kTile), originals(8 * kTile), picture(3 * kTile);
    for (std::uint16_t& v : amounts) v = static_cast<std::uint16_t>(random.below(seed % 3 == 0 ? 65536 : 9000));
    for (std::uint16_t& v : originals) v = static_cast<std::uint16_t>(random.below(seed % 4 == 0 ? 65536 : 2000));
    for (std::uint16_t& v : picture) v = static_cast<std::uint16_t>(random.below(65536));
    BaseTile base;
    std::array<std::int32_t, kTile> heights{};
    for (std::size_t l = 0; l < kTile; ++l) {
      for (auto& plane : base.linear) plane[l] = static_cast<std::uint16_t>(random.below(65536));
      base.specular[l] = static_cast<std::int32_t>(random.below(kOne + 1));
      base.code[l] = 0;
      heights[l] = static_cast<std::int32_t>(random.below(1u << 28)) - kMaxHeight;
    }
    ComposeTask task;
    task.num_materials = static_cast<int>(appearance.size());
    for (std::size_t k = 0; k < appearance.size(); ++k) {
      task.look[k] = &quantized[k];
      task.amount[k] = &amounts[k * kTile];
      task.original[k] = &originals[k * kTile];
    }
    if (seed % 2 == 0) task.picture[0] = picture.data();
    task.base = &base;
    task.height = heights.data();
    task.srgb = srgb8_of_linear16().data();
    task.first_texel = random.next_u32() & ~63u;
    task.form = static_cast<i32>(seed % 5 % 3);
    for (const InstructionSet set : instruction_sets()) {
      alignas(64) std::array<std::uint32_t, kTile> code{};
      alignas(64) std::array<std::int32_t, kTile> height{};
      kernels(set).compose(task, code.data(), height.data());
      for (std::uint32_t l = 0; l < kTile; ++l) {
        const Composed expected = compose_texel(task, l);
        ASSERT_EQ(code[l], expected.code) << seed << " " << l;
        ASSERT_EQ(height[l], expected.height) << seed << " " << l;
      }
    }
  }
}

TEST(ComposeKernel, NormalizesWeightsByAnExactQuotient) {
  // One material, white, over nothing: the share of each total weight above 1, up to that of eight materials.
  QuantizedAppearance look;
  look.strength = kOne;
  look.color = {65535, 65535, 65535};
  BaseTile base{};
  const std::array<std::uint16_t, kTile> none{};
  const std::array<std::int32_t, kTile> flat{};
  for (std::uint32_t first = kOne; first < 65536 * 2; first += kTile) {
    // Two materials, the second constant, so that totals pass 65535.
    std::array<std::uint16_t, kTile> a{}, b{};
    for (std::uint32_t l = 0; l < kTile; ++l) {
      const std::uint32_t total = std::min(first + l, 2 * kMaxWeight);
      a[l] = static_cast<std::uint16_t>(std::min(total, kMaxWeight));
      b[l] = static_cast<std::uint16_t>(total - a[l]);
    }
    ComposeTask task;
    task.num_materials = 2;
    task.look = {&look, &look};
    task.amount = {a.data(), b.data()};
    task.original = {none.data(), none.data()};
    task.base = &base;
    task.height = flat.data();
    task.srgb = srgb8_of_linear16().data();
    for (const InstructionSet set : instruction_sets()) {
      alignas(64) std::array<std::uint32_t, kTile> code{};
      alignas(64) std::array<std::int32_t, kTile> height{};
      kernels(set).compose(task, code.data(), height.data());
      for (std::uint32_t l = 0; l < kTile; ++l) {
        ASSERT_EQ(code[l] & 0xFFFFFF, 0xFFFFFFu);  // both white: white, whatever the total
        ASSERT_EQ(code[l], compose_texel(task, l).code);
      }
    }
  }
}

TEST(ComposeKernel, NormalsAreIntegerRootsAndQuotients) {
  RandomStream random(1, 1);
  for (int round = 0; round < 2000; ++round) {
    SlopeTile slopes;
    for (std::size_t l = 0; l < kTile; ++l) {
      const std::uint32_t range = 1u << (1 + random.below(15));
      slopes.along_t[l] = static_cast<std::int32_t>(random.below(2 * range + 1)) - static_cast<std::int32_t>(range);
      slopes.along_b[l] = static_cast<std::int32_t>(random.below(2 * range + 1)) - static_cast<std::int32_t>(range);
      slopes.along_t[l] = std::clamp(slopes.along_t[l], -kMaxSlope, kMaxSlope);
      slopes.along_b[l] = std::clamp(slopes.along_b[l], -kMaxSlope, kMaxSlope);
    }
    for (const InstructionSet set : instruction_sets()) {
      alignas(64) std::array<std::uint8_t, 3 * kTile> normal{};
      kernels(set).encode(slopes, normal.data());
      for (std::size_t l = 0; l < kTile; ++l) {
        const i64 x = -slopes.along_t[l], y = -slopes.along_b[l], z = kSlopeOne;
        i64 length = 0;
        for (i64 bit = 1 << 14; bit > 0; bit >>= 1) {
          if ((length + bit) * (length + bit) <= x * x + y * y + z * z) length += bit;
        }
        ASSERT_EQ(normal[l], (255 * (length + x) + length) / (2 * length));
        ASSERT_EQ(normal[kTile + l], (255 * (length + y) + length) / (2 * length));
        ASSERT_EQ(normal[2 * kTile + l], (255 * (length + z) + length) / (2 * length));
      }
    }
  }
}

}  // namespace
}  // namespace patinate::simulation::composition
