#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/transfer/control_matching.h"

namespace patinate::transfer {
namespace {

TEST(ControlSpec, ReadsEveryPartOfTheGrammar) {
  const ControlSpec plain = parse_control_spec("accessibility");
  EXPECT_EQ(plain.source, "");
  EXPECT_EQ(plain.destination, "accessibility");
  EXPECT_EQ(plain.weight, 1.0);
  EXPECT_EQ(plain.mapping, std::nullopt);
  EXPECT_EQ(parse_control_spec("accessibility:1:auto").mapping, std::nullopt);
  const ControlSpec full = parse_control_spec("progress=0.7*accessibility + 0.3*facing:2.5:linear");
  EXPECT_EQ(full.source, "progress");
  EXPECT_EQ(full.destination, "0.7*accessibility + 0.3*facing");
  EXPECT_EQ(full.weight, 2.5);
  EXPECT_EQ(full.mapping, ControlMapping::Linear);
  EXPECT_EQ(parse_control_spec("thickness=!spray").destination, "!spray");
  const ControlSpec argued = parse_control_spec("image(file=\"a=b:c.exr\") + height(axis=z):2");
  EXPECT_EQ(argued.source, "");
  EXPECT_EQ(argued.destination, "image(file=\"a=b:c.exr\") + height(axis=z)");
  EXPECT_EQ(argued.weight, 2.0);
  EXPECT_EQ(parse_control_spec("wet=distance(from=creases)").source, "wet");
}

TEST(ControlSpec, SaysWhatIsWrong) {
  const auto message = [](const char* text) -> std::string {
    try {
      (void)parse_control_spec(text);
    } catch (const ParseError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(message("a=b:heavy").find("weight `heavy`"), std::string::npos);
  EXPECT_NE(message("a=b:1:liner").find("did you mean `linear`"), std::string::npos);
  EXPECT_NE(message("a=").find("destination is missing"), std::string::npos);
  EXPECT_NE(message("a=b:-1").find("weight"), std::string::npos);
  EXPECT_NE(message("a=b:nan").find("weight"), std::string::npos);
}

ImageF random_image(int size, std::uint64_t item, double power) {
  RandomStream random(9, item);
  ImageF image(size, size);
  for (float& v : image.values()) {
    const double u = random.uniform();
    v = static_cast<float>(power == 1.0 ? u : u * u);
  }
  return image;
}

TEST(MatchControl, RankGivesTheDestinationTheSourcesDistribution) {
  const ImageF destination = random_image(60, 1, 2.0), source = random_image(50, 2, 1.0);
  const ImageF matched = match_control(destination, {}, {}, source, {}, {}, ControlMapping::Rank);
  std::vector<float> a(matched.values().begin(), matched.values().end()),
      b(source.values().begin(), source.values().end());
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  for (double q : {0.05, 0.25, 0.5, 0.75, 0.95}) {
    EXPECT_NEAR(a[static_cast<std::size_t>(q * static_cast<double>(a.size()))],
                b[static_cast<std::size_t>(q * static_cast<double>(b.size()))], 2e-3)
        << q;
  }
  // Order is kept.
  for (std::size_t i = 1; i < destination.values().size(); ++i) {
    if (destination.values()[i - 1] < destination.values()[i]) {
      EXPECT_LE(matched.values()[i - 1], matched.values()[i]);
    }
  }
}

TEST(MatchControl, OntoItselfIsTheIdentity) {
  const ImageF image = random_image(40, 3, 1.0);
  const ControlRange range{0.0, 1.0, "mm"};
  for (ControlMapping mapping : {ControlMapping::Rank, ControlMapping::Linear, ControlMapping::Physical}) {
    const ImageF matched = match_control(image, {}, range, image, {}, range, mapping);
    for (std::size_t i = 0; i < image.values().size(); ++i) EXPECT_NEAR(matched.values()[i], image.values()[i], 1e-6);
  }
}

/// `share` of the texels are 0, the others anything.
ImageF painted(double share) {
  ImageF image = random_image(64, 4, 1.0);
  const auto num_bare = static_cast<std::int64_t>(share * static_cast<double>(image.num_pixels()));
  std::fill_n(image.data(), num_bare, 0.0f);
  return image;
}

TEST(SuitedMapping, IsLinearForPaintedAndBinaryMapsAndRankForContinuousOnes) {
  EXPECT_EQ(suited_mapping(random_image(64, 4, 1.0), {}).mapping, ControlMapping::Rank);
  EXPECT_EQ(suited_mapping(painted(0.1), {}).mapping, ControlMapping::Rank);
  const SuitedMapping bare = suited_mapping(painted(0.72), {});
  EXPECT_EQ(bare.mapping, ControlMapping::Linear);
  EXPECT_NEAR(bare.tied_share, 0.72, 0.01);
  ImageF binary = painted(0.6);
  for (float& v : binary.values()) v = v > 0.0f ? 1.0f : 0.0f;
  EXPECT_EQ(suited_mapping(binary, {}).mapping, ControlMapping::Linear);
  EXPECT_EQ(suited_mapping(ImageF(64, 64, 1, 0.3f), {}).mapping, ControlMapping::Rank) << "it decides nothing";
  // Gray values of eight bits are continuous enough.
  ImageF gray = random_image(64, 4, 1.0);
  for (float& v : gray.values()) v = std::floor(v * 255.0f) / 255.0f;
  EXPECT_EQ(suited_mapping(gray, {}).mapping, ControlMapping::Rank);
}

TEST(SuitedMapping, TheUnpaintedPartThenAgesLikeTheSourcesLeast) {
  const ImageF destination = painted(0.72), source = random_image(64, 5, 1.0);
  const auto bare = [&](ControlMapping mapping) {
    return match_control(destination, {}, {}, source, {}, {}, mapping).data()[0];
  };
  EXPECT_NEAR(bare(ControlMapping::Rank), 0.36, 0.02) << "the middle of the ranks";
  EXPECT_NEAR(bare(suited_mapping(destination, {}).mapping), 0.0, 0.01);
}

TEST(SuitedMapping, CountsWhatIsInsideTheMask) {
  ImageU8 mask(64, 64, 1, 255);
  std::fill_n(mask.data(), 64 * 32, std::uint8_t{0});
  EXPECT_EQ(suited_mapping(painted(0.5), mask).mapping, ControlMapping::Rank);
}

TEST(MatchControl, PhysicalConvertsBetweenRangesAndRefusesOtherUnits) {
  const ImageF destination(1, 1, 1, 0.5f), source(1, 1, 1, 0.0f);
  // 0.5 of [0, 2] mm is 1 mm, which is 0.25 of [0, 4] mm.
  const ImageF matched =
      match_control(destination, {}, {0.0, 2.0, "mm"}, source, {}, {0.0, 4.0, "mm"}, ControlMapping::Physical);
  EXPECT_FLOAT_EQ(matched.at(0, 0), 0.25f);
  EXPECT_THROW(
      (void)match_control(destination, {}, {0.0, 2.0, "mm"}, source, {}, {0.0, 4.0, "1/mm"}, ControlMapping::Physical),
      InvalidInput);
  EXPECT_THROW((void)match_control(destination, {}, {0.0, 1.0, "cosine"}, source, {}, {0.0, 1.0, "relative"},
                                   ControlMapping::Physical),
               InvalidInput);
  EXPECT_FLOAT_EQ(
      match_control(destination, {}, {0.0, 2.0, ""}, source, {}, {0.0, 4.0, "mm"}, ControlMapping::Physical).at(0, 0),
      0.25f);
}

}  // namespace
}  // namespace patinate::transfer
