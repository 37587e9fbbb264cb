#include "libcommon/history/appearance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "libcommon/history/appearance_json.h"
#include "libcommon/history/footprint.h"
#include "libcommon/history/stated_history.h"
#include "patinate/history/history_sampling.h"
#include "patinate/history/memory_history.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::TempFolder;

constexpr float kHalf = 5e-4f;  // Rounding of a half float in [0.5, 1].

Appearance read_text(const TempFolder& folder, const std::string& members) {
  const std::filesystem::path file = folder / "stated.json";
  std::ofstream(file) << R"({"format": "patinate.appearance", "version": 1, )" << members << "}";
  return read_appearance_file(file);
}

ImageF plain(const std::array<float, 3>& linear) {
  ImageF image(1, 1, 3);
  for (int c = 0; c < 3; ++c) image.at(0, 0, c) = linear[c];
  return image;
}

StatedMaterial material(double code, double metalness, double roughness) {
  const auto linear = static_cast<double>(linear_from_srgb(static_cast<float>(code)));
  return {.color = {linear, linear, linear}, .metalness = metalness, .roughness = roughness, .tint = {}};
}

ImageF gray(double code) {
  const float linear = linear_from_srgb(static_cast<float>(code));
  return plain({linear, linear, linear});
}

TEST(ValueCurve, IsLinearBetweenItsPointsAndConstantBeyond) {
  const ValueCurve curve{{{1.0, 0.2}, {3.0, 0.6}, {4.0, 0.0}}};
  EXPECT_EQ(curve.at(-5.0), 0.2);
  EXPECT_EQ(curve.at(3.0), 0.6);
  EXPECT_DOUBLE_EQ(curve.at(2.0), 0.4);
  EXPECT_DOUBLE_EQ(curve.at(3.5), 0.3);
  EXPECT_EQ(curve.at(9.0), 0.0);
}

// The shares are known: all of one at its color, equal ones halfway, and 1 : 16 at distances of 2 : 1.
TEST(Appearance, APixelIsTheMaterialWhoseColorItHasAndAMixtureBetweenColors) {
  Appearance a;
  a.materials = {material(0.2, 1.0, 0.3), material(0.8, 0.0, 0.9)};
  const auto metalness_at = [&](double code) { return appearance_maps(a, {}, 0.0, gray(code)).metalness.at(0, 0); };
  // Half a code of 8 bits counts as no distance: 1e-5 of the other material at 0.6 of the range.
  EXPECT_NEAR(metalness_at(0.2), 1.0f, 1e-5f);
  EXPECT_NEAR(metalness_at(0.8), 0.0f, 1e-5f);
  EXPECT_NEAR(metalness_at(0.5), 0.5f, 1e-4f);
  EXPECT_NEAR(metalness_at(0.4), 16.0f / 17.0f, 1e-3f);
  EXPECT_NEAR(appearance_maps(a, {}, 0.0, gray(0.5)).specular.at(0, 0, 1), 0.6f, 1e-4f);
  // A third material elsewhere changes nothing where a pixel has the first one's color.
  a.materials.push_back(material(0.25, 0.0, 0.1));
  EXPECT_NEAR(metalness_at(0.2), 1.0f, 1e-3f);
}

TEST(Appearance, TintOfMetalFollowsLightAndDarkAndNeverLeavesTheUnitRange) {
  Appearance a;
  a.materials = {material(0.5, 1.0, 0.3)};
  a.materials[0].tint = {0.9, 0.45, 0.3};
  const auto tint_at = [&](double code) { return appearance_maps(a, {}, 0.0, gray(code)).tint; };
  const float darker = linear_from_srgb(0.4f) / linear_from_srgb(0.5f);
  EXPECT_NEAR(tint_at(0.5).at(0, 0, 0), 0.9f, 1e-5f);
  EXPECT_NEAR(tint_at(0.4).at(0, 0, 1), 0.45f * darker, 1e-5f);
  EXPECT_EQ(tint_at(1.0).at(0, 0, 0), 1.0f);
  EXPECT_NEAR(tint_at(1.0).at(0, 0, 2), 1.0f / 3.0f, 1e-5f);  // The hue stays.
}

// A capture under lamps has measured the mirror; what is metal is stated beside it.
TEST(Appearance, MaterialsWithoutRoughnessLeaveTheMirrorThatWasMeasured) {
  const TempFolder folder;
  const auto maps = [&](const std::string& rest) {
    return read_text(folder, R"("materials": [{"color": "#808080", "metalness": 1)" + rest + "}]").map_names();
  };
  EXPECT_EQ(maps(""), (std::vector<std::string>{"metalness"}));
  EXPECT_EQ(maps(R"(, "tint": "#f0ae8c")"), (std::vector<std::string>{"metalness", "tint"}));
  EXPECT_EQ(maps(R"(, "specular": 0.1)"), (std::vector<std::string>{"specular", "metalness"}));
  EXPECT_EQ(maps(R"(, "roughness": 0.1)"), (std::vector<std::string>{"specular", "metalness"}));
  Appearance a;
  a.materials = {{.color = {0.5, 0.5, 0.5}, .metalness = 0.25}};
  const AppearanceMaps made = appearance_maps(a, {}, 0.0, gray(0.5));
  EXPECT_EQ(made.metalness.at(0, 0), 0.25f);
  EXPECT_TRUE(made.specular.empty());
}

TEST(Appearance, SaysWhatIsWrongInAFile) {
  const TempFolder folder;
  const auto said = [&](const std::string& members) { return error_of([&] { (void)read_text(folder, members); }); };
  EXPECT_TRUE(has(said(R"("metalness": 1.2)"), "/metalness: found 1.2"));
  EXPECT_TRUE(has(said(R"("metalness": [[0, 1], [0, 0.5]])"), "/metalness/1"));
  EXPECT_TRUE(has(said(R"("roughness": [[0, 1], [2, -0.5]])"), "in [0, 1]"));
  EXPECT_TRUE(has(said(R"("roughness": [])"), "one pair or more"));
  EXPECT_TRUE(has(said(R"("roughness": {"controls": "x"})"), "control"));
  EXPECT_TRUE(has(said(R"("tint": "copper")"), "#rrggbb"));
  EXPECT_TRUE(has(said(R"("metalnes": 1)"), "metalness"));
  EXPECT_TRUE(has(said(R"("materials": [{"color": "#000000"}])"), "`metalness` is missing"));
  EXPECT_TRUE(has(said(R"("materials": [{"color": "#000000", "metalness": 1, "roughness": 0.2}, )"
                       R"({"color": "#ffffff", "metalness": 0}])"),
                  "`roughness` of all materials, or of none"));
  EXPECT_TRUE(has(said(R"("materials": [{"color": "#000000", "metalness": 1, "roughness": 0.2}], "metalness": 1)"),
                  "`materials` say it already"));
}

TEST(AppearanceKey, FollowsWhatIsSaidAndTheContentOfMasks) {
  const TempFolder folder;
  const auto key = [&](const std::string& members) { return appearance_key(read_text(folder, members)); };
  write_codes(folder / "a.png", ImageU8(4, 4, 1, 255));
  write_codes(folder / "b.png", ImageU8(4, 4, 1, 255));
  EXPECT_EQ(key(R"("metalness": {"mask": "a.png"})"), key(R"("metalness": {"mask": "b.png"})"));
  EXPECT_NE(key(R"("metalness": 1)"), key(R"("roughness": 1)"));
  const auto material_key = [&](const std::string& rest) {
    return key(R"("materials": [{"color": "#808080", "metalness": 1)" + rest + "}]");
  };
  EXPECT_NE(material_key(""), material_key(R"(, "specular": 0.04)"));
  EXPECT_NE(material_key(R"(, "specular": 0.04)"), material_key(R"(, "roughness": 0.04)"));
  EXPECT_NE(key(R"("metalness": [[0, 1], [1, 0]])"), key(R"("metalness": [[0, 1], [2, 0]])"));
}

/// Four frames at 0, 1, 2, 3 whose control "x" is the column.
class StatedHistory : public testing::Test {
 protected:
  static constexpr int kSide = 5;
  void SetUp() override {
    testing_support::write_history(history_, kSide, kSide, 4, [](int x, int, int frame, int c) {
      return 0.1f + 0.1f * static_cast<float>(x) + 0.05f * static_cast<float>(frame) + 0.01f * static_cast<float>(c);
    });
  }
  void state(const std::string& members) const {
    state_appearance(history_, read_text(folder_, members), mask_reader(HistoryReader(history_).facts()));
  }
  [[nodiscard]] ImageF at(MaterialMap map, double time) const {
    return sample_material_map(HistoryReader(history_), map, time, Between::Blend);
  }

  TempFolder folder_;
  std::filesystem::path history_ = folder_ / "history";
};

TEST_F(StatedHistory, ConstantMapsAreWrittenOnce) {
  state(R"("metalness": 1, "roughness": 0.25)");
  const HistoryReader history(history_);
  EXPECT_EQ(history.facts().maps, (std::vector<std::string>{"specular", "metalness"}));
  EXPECT_TRUE(history.facts().frames[2].extras.empty());
  EXPECT_EQ(at(MaterialMap::Metalness, 1.7).at(3, 3), 1.0f);
  EXPECT_EQ(at(MaterialMap::Roughness, 9.0).at(0, 4), 0.25f);
  EXPECT_NEAR(at(MaterialMap::Specular, 0.0).at(0, 0), kUnknownSpecular, 1e-4f);
  EXPECT_TRUE(has(error_of([&] { state(R"("metalness": 0)"); }), "has `metalness` already"));
}

TEST_F(StatedHistory, OverTimeByControlAndByMask) {
  ImageU8 mask(kSide, kSide);
  mask.at(1, 2) = 255;
  write_codes(folder_ / "mask.png", mask);
  state(R"("metalness": [[0, 1], [2, 0]], "roughness": {"control": "x", "values": [[0, 0.5], [4, 0.75]]},
           "specular": {"mask": "mask.png", "values": [[0, 0.125], [1, 0.0625]]})");
  EXPECT_NEAR(at(MaterialMap::Metalness, 1.0).at(0, 0), 0.5f, kHalf);
  EXPECT_NEAR(at(MaterialMap::Metalness, 0.5).at(0, 0), 0.75f, kHalf);  // Between frames their blend.
  EXPECT_EQ(at(MaterialMap::Metalness, 3.0).at(0, 0), 0.0f);
  for (int x = 0; x < kSide; ++x)
    EXPECT_NEAR(at(MaterialMap::Roughness, 2.0).at(x, 1), 0.5f + 0.0625f * static_cast<float>(x), kHalf);
  EXPECT_EQ(at(MaterialMap::Specular, 2.0).at(1, 2), 0.0625f);
  EXPECT_EQ(at(MaterialMap::Specular, 2.0).at(2, 2), 0.125f);
}

TEST_F(StatedHistory, SaysWhichControlIsMissingAndWhichMaskDoesNotFit) {
  EXPECT_TRUE(has(error_of([&] { state(R"("metalness": {"control": "xx", "values": [[0, 1]]})"); }),
                  "has no control `xx`; there is: x, y"));
  write_codes(folder_ / "small.png", ImageU8(2, 3, 1, 255));
  EXPECT_TRUE(has(error_of([&] { state(R"("metalness": {"mask": "small.png"})"); }), "is 2 x 3 pixels"));
  EXPECT_TRUE(material_maps(HistoryReader(history_).facts()).empty());
}

TEST_F(StatedHistory, WhatSomeFramesHaveAndOthersNotIsRefused) {
  state(R"("metalness": [[0, 1], [2, 0]])");
  HistoryManifest manifest = read_history_manifest(history_);
  manifest.frames[2].extras.clear();
  EXPECT_TRUE(has(error_of([&] { write_history_manifest(history_ / "history.json", manifest); }),
                  "`metalness`: frame 2 has none, frame 0 has"));
  manifest = read_history_manifest(history_);
  manifest.maps = {{"metalness", "metalness/0000.exr"}};
  EXPECT_TRUE(has(error_of([&] { write_history_manifest(history_ / "history.json", manifest); }), "leave one"));
}

TEST_F(StatedHistory, MetalnessOutsideTheUnitRangeIsRefusedNamingTheFile) {
  state(R"("metalness": [[0, 1], [2, 0]])");
  write_exr(history_ / "metalness/0001.exr", ImageF(kSide, kSide, 1, 1.25f), {"Y"}, ExrDepth::Float);
  const HistoryReader history(history_);
  EXPECT_NO_THROW((void)history.read_frame_extra(0, "metalness"));
  const std::string said = error_of([&] { (void)history.read_frame_extra(1, "metalness"); });
  EXPECT_TRUE(has(said, "0001.exr") && has(said, "holds 1.25")) << said;
}

TEST_F(StatedHistory, BaseColorIsTheColorUntilThereIsATintThatMetalTakes) {
  const HistoryReader before(history_);
  EXPECT_TRUE(sample_reflectance(before, 1.5, Between::Blend).empty());
  EXPECT_TRUE(has(error_of([&] { (void)sample_orm(before, 1.0, Between::Blend); }), "neither roughness nor metalness"));
  state(R"("metalness": {"control": "x", "values": [[0, 0], [4, 1]]}, "specular": 0.5, "tint": [0.75, 0.5, 0.25])");
  const HistoryReader history(history_);
  const ImageF color = history.sample(1.5), base = sample_base_color(history, 1.5, Between::Blend);
  const ImageF orm = sample_orm(history, 1.5, Between::Blend);
  const ImageF f0 = sample_reflectance(history, 1.5, Between::Blend);
  const float tint[] = {0.75f, 0.5f, 0.25f};
  for (int x = 0; x < kSide; ++x) {
    const float m = 0.25f * static_cast<float>(x);
    EXPECT_EQ(orm.at(x, 0, 0), 1.0f);
    EXPECT_EQ(orm.at(x, 0, 2), m);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(base.at(x, 2, c), (1.0f - m) * color.at(x, 2, c) + m * tint[c], 1e-6f);
      EXPECT_EQ(f0.at(x, 2, c), 0.5f * tint[c]);
    }
  }
  EXPECT_EQ(base.at(0, 0), color.at(0, 0));
}

TEST_F(StatedHistory, WithoutTintTheBaseColorIsTheColorToTheBit) {
  state(R"("metalness": 1)");
  const HistoryReader history(history_);
  const ImageF color = history.sample(1.25), base = sample_base_color(history, 1.25, Between::Blend);
  EXPECT_TRUE(std::equal(color.values().begin(), color.values().end(), base.values().begin()));
}

// In a texel that covers several pixels, no metal counts as 0 and is not left out as unknown.
TEST(Footprint, MetalnessOfAChessboardIsItsMean) {
  ImageF board(32, 32);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) board.at(x, y) = (x + y) % 2 == 0 ? 1.0f : 0.0f;
  }
  const ImageF mean = mean_extra_over_footprint("metalness", board, 8.0);
  for (int i = 10; i < 22; ++i) EXPECT_NEAR(mean.at(i, 16), 0.5f, 1e-3f);
}

TEST(MemoryHistory, RefusesGlossOutsideItsRangeAndNormalsThatAreNoDirections) {
  const auto said = [](const std::string& name, const std::vector<float>& first, const std::vector<float>& rest) {
    MemoryHistoryImages images = testing_support::half_images(4, 3, 1, [](int, int, int, int) { return 0.5f; });
    ImageF map(4, 3, static_cast<int>(first.size()));
    for (int i = 0; i < 12; ++i) std::ranges::copy(i == 0 ? first : rest, map.pixel(i % 4, i / 4).begin());
    images.frames[0].extras.push_back({name, map});
    return error_of([&] { (void)MemoryHistory(images); });
  };
  EXPECT_TRUE(has(said("specular", {0.04f, 1.5f}, {0.04f, 0.5f}), "holds 1.5; a roughness is within [0, 1]"));
  EXPECT_TRUE(has(said("specular", {-0.5f, 0.5f}, {0.04f, 0.5f}), "holds -0.5; a strength"));
  EXPECT_EQ(said("specular", {2.0f, 1.0f}, {0.0f, 0.0f}), "");
  EXPECT_TRUE(has(said("normal", {0, 0, 3}, {0, 0, 1}), "holds a normal of length 3"));
  EXPECT_TRUE(has(said("normal", {0, 0.25f, 0}, {0, 0, 1}), "holds a normal of length 0.25"));
  EXPECT_TRUE(has(said("normal", {0, 0, 0}, {0, 0, 0}), "all normals have length 0"));
  EXPECT_EQ(said("normal", {0, 0, 0}, {0, 0, 1}), "") << "not known in one place";
  EXPECT_EQ(said("normal", {0, 0.6f, 0.6f}, {0, 0, 1}), "") << "a mean of two";
}

TEST(MemoryHistory, RefusesATintOutsideTheUnitRange) {
  MemoryHistoryImages images = testing_support::half_images(4, 3, 1, [](int, int, int, int) { return 0.5f; });
  images.maps.push_back({"tint", ImageF(4, 3, 3, 1.5f)});
  EXPECT_TRUE(has(error_of([&] { (void)MemoryHistory(images); }), "a tint is within [0, 1]"));
}

}  // namespace
}  // namespace patinate
