#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "patinate/history/history.h"
#include "patinate/history/history_sampling.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

constexpr int kReliefWidth = 6, kReliefHeight = 5;

/// Relief that differs at every pixel, in tangent space.
Eigen::Vector3f relief(int x, int y) {
  return Eigen::Vector3f(0.1f * static_cast<float>(x) - 0.3f, 0.35f - 0.12f * static_cast<float>(y), 1.0f).normalized();
}

void put(ImageF& image, int x, int y, const Eigen::Vector3f& v) {
  for (int c = 0; c < 3; ++c) image.at(x, y, c) = v[c];
}

// Rounding of a few float products.
constexpr float kRounding = 2e-6f;

// Truth by construction: a plane seen aslant, its pixels' positions sheared, and world normals that are the relief in
// its frame.
TEST(TangentSpaceNormals, OfATiltedPlaneAreTheReliefThatWasPutOnIt) {
  const Eigen::Matrix3f world_from_plane =
      Eigen::AngleAxisf(0.9f, Eigen::Vector3f(0.3f, -0.7f, 0.5f).normalized()).toRotationMatrix();
  ImageF normals(kReliefWidth, kReliefHeight, 3), position(kReliefWidth, kReliefHeight, 3),
      surface(kReliefWidth, kReliefHeight, 3);
  for (int y = 0; y < kReliefHeight; ++y) {
    for (int x = 0; x < kReliefWidth; ++x) {
      put(normals, x, y, 2.5f * (world_from_plane * relief(x, y)));
      put(position, x, y,
          world_from_plane * Eigen::Vector3f(0.2f * static_cast<float>(x), -0.3f * static_cast<float>(y), 0.0f) +
              Eigen::Vector3f(100.0f, 7.0f, 3.0f));
      put(surface, x, y, world_from_plane.col(2));
    }
  }
  put(surface, 3, 2, Eigen::Vector3f::Zero());  // A hole in the scan: its neighbors continue with one side.
  put(normals, 5, 4, Eigen::Vector3f::Zero());  // Nobody knows.
  const ImageF found = tangent_space_normals(normals, position, surface);
  for (int y = 0; y < kReliefHeight; ++y) {
    for (int x = 0; x < kReliefWidth; ++x) {
      const bool is_known = !(x == 3 && y == 2) && !(x == 5 && y == 4);
      const Eigen::Vector3f expected = is_known ? relief(x, y) : Eigen::Vector3f(0.0f, 0.0f, 1.0f);
      // Positions lie 100 mm away: steps of 0.2 mm carry their rounding.
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(found.at(x, y, c), expected[c], 2e-4f) << x << ' ' << y;
    }
  }
}

TEST(TangentSpaceNormals, WithoutPositionsTheImageIsTheSurface) {
  ImageF normals(kReliefWidth, kReliefHeight, 3);
  for (int y = 0; y < kReliefHeight; ++y) {
    for (int x = 0; x < kReliefWidth; ++x) put(normals, x, y, 3.0f * relief(x, y));
  }
  const ImageF found = tangent_space_normals(normals, {}, {});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found.at(2, 3, c), relief(2, 3)[c], kRounding);
  EXPECT_THROW((void)tangent_space_normals(normals, ImageF(kReliefWidth, kReliefHeight, 3), {}), InvalidInput);
  EXPECT_THROW((void)tangent_space_normals(ImageF(kReliefWidth, kReliefHeight, 1), {}, {}), InvalidInput);
}

/// Four frames at 0, 1, 4, 5; the second has nothing beside color, the last no height.
class MaterialMaps : public testing::Test {
 protected:
  void SetUp() override {
    HistoryManifest manifest;
    manifest.name = "relief";
    manifest.origin = "synthetic";
    manifest.width = kReliefWidth;
    manifest.height = kReliefHeight;
    HistoryWriter writer(folder_.path(), manifest);
    const double times[] = {0.0, 1.0, 4.0, 5.0};
    for (int f = 0; f < 4; ++f) {
      writer.write_frame(f, times[f], ImageF(kReliefWidth, kReliefHeight, 3, 0.5f));
      if (f == 1) continue;
      HistoryWriter::write_frame_extra(folder_.path(), f, "normal", normals(f));
      writer.add_written_frame_extra(f, "normal");
      ImageF specular(kReliefWidth, kReliefHeight, 2);
      for (int y = 0; y < kReliefHeight; ++y) {
        for (int x = 0; x < kReliefWidth; ++x) {
          if ((x == 0 && f == 0) || x == 1) continue;  // Not known in the first frame; never known.
          specular.at(x, y, 0) = 0.1f * static_cast<float>(f + 1);
          specular.at(x, y, 1) = 0.2f + 0.1f * static_cast<float>(f);
        }
      }
      HistoryWriter::write_frame_extra(folder_.path(), f, "specular", specular);
      writer.add_written_frame_extra(f, "specular");
      if (f == 3) continue;
      HistoryWriter::write_frame_extra(folder_.path(), f, "height",
                                       ImageF(kReliefWidth, kReliefHeight, 1, static_cast<float>(f)));
      writer.add_written_frame_extra(f, "height");
    }
    writer.finish();
  }
  static ImageF normals(int frame) {
    ImageF image(kReliefWidth, kReliefHeight, 3);
    for (int y = 0; y < kReliefHeight; ++y) {
      for (int x = 0; x < kReliefWidth; ++x)
        put(image, x, y, Eigen::AngleAxisf(0.4f * static_cast<float>(frame), Eigen::Vector3f::UnitZ()) * relief(x, y));
    }
    return image;
  }
  testing_support::TempFolder folder_;
};

TEST_F(MaterialMaps, AtAFramesTimeAreThatFrame) {
  const HistoryReader history(folder_.path());
  EXPECT_EQ(material_maps(history.facts()).size(), 4u);
  const ImageF found = sample_material_map(history, MaterialMap::Normal, 4.0, Between::Blend), expected = normals(2);
  for (std::size_t i = 0; i < found.values().size(); ++i) EXPECT_NEAR(found.data()[i], expected.data()[i], kRounding);
  EXPECT_EQ(sample_material_map(history, MaterialMap::Roughness, 4.0, Between::Blend).at(3, 3), 0.4f);
  EXPECT_EQ(sample_material_map(history, MaterialMap::Specular, 4.0, Between::Blend).at(3, 3), 0.3f);
}

TEST_F(MaterialMaps, BetweenFramesThatHaveThemTheyAreABlend) {
  const HistoryReader history(folder_.path());
  EXPECT_FLOAT_EQ(sample_material_map(history, MaterialMap::Height, 1.0, Between::Blend).at(2, 2),
                  0.5f);  // A quarter of the way from 0 to 4.
  EXPECT_FLOAT_EQ(sample_material_map(history, MaterialMap::Height, 9.0, Between::Blend).at(2, 2),
                  2.0f);  // The last that is known.
  EXPECT_FLOAT_EQ(sample_material_map(history, MaterialMap::Height, 3.9, Between::Hold).at(2, 2), 0.0f);
  const ImageF found = sample_material_map(history, MaterialMap::Normal, 2.0, Between::Blend), a = normals(0),
               b = normals(2);
  const auto at = [](const ImageF& n) { return Eigen::Vector3f(n.at(4, 1, 0), n.at(4, 1, 1), n.at(4, 1, 2)); };
  EXPECT_LT((at(found) - (0.5f * at(a) + 0.5f * at(b)).normalized()).norm(), kRounding);
}

TEST_F(MaterialMaps, WhatOneFrameDoesNotKnowTheOtherTells) {
  const HistoryReader history(folder_.path());
  const ImageF roughness = sample_material_map(history, MaterialMap::Roughness, 2.0, Between::Blend);
  EXPECT_FLOAT_EQ(roughness.at(3, 3), 0.3f);
  EXPECT_FLOAT_EQ(roughness.at(0, 3), 0.4f);
  EXPECT_FLOAT_EQ(roughness.at(1, 3), kUnknownRoughness);
  EXPECT_FLOAT_EQ(sample_material_map(history, MaterialMap::Specular, 0.0, Between::Blend).at(0, 0), kUnknownSpecular);
}

TEST(MaterialMapsOfADeviation, OfABlendIsThatOfIndependentFrames) {
  const testing_support::TempFolder folder;
  HistoryManifest manifest;
  manifest.name = "noisy";
  manifest.width = 2;
  manifest.height = 1;
  HistoryWriter writer(folder.path(), manifest);
  for (int i = 0; i < 2; ++i) {
    writer.write_frame(i, i, ImageF(2, 1, 3));
    ImageF deviation(2, 1, 3);
    deviation.at(0, 0, 1) = i == 0 ? 0.3f : 0.4f;
    deviation.at(1, 0, 1) = i == 0 ? 0.0f : 0.2f;  // Not known at first.
    HistoryWriter::write_frame_extra(folder.path(), i, "stddev", deviation);
    writer.add_written_frame_extra(i, "stddev");
  }
  writer.finish();
  const HistoryReader history(folder.path());
  const ImageF half = sample_material_map(history, MaterialMap::Stddev, 0.5, Between::Blend);
  EXPECT_FLOAT_EQ(half.at(0, 0, 1), 0.25f);  // sqrt(0.15^2 + 0.2^2).
  EXPECT_FLOAT_EQ(half.at(1, 0, 1), 0.2f);
  EXPECT_FLOAT_EQ(sample_material_map(history, MaterialMap::Stddev, 1.0, Between::Blend).at(0, 0, 1), 0.4f);
}

TEST(MaterialMapsOfAPlainHistory, AreSaidToBeMissing) {
  const testing_support::TempFolder folder;
  HistoryManifest manifest;
  manifest.name = "plain";
  manifest.width = manifest.height = 1;
  HistoryWriter writer(folder.path(), manifest);
  writer.write_frame(0, 0.0, ImageF(1, 1, 3));
  writer.finish();
  const HistoryReader history(folder.path());
  EXPECT_TRUE(material_maps(history.facts()).empty());
  const std::string said =
      testing_support::error_of([&] { (void)sample_material_map(history, MaterialMap::Normal, 0.0, Between::Blend); });
  EXPECT_TRUE(testing_support::has(said, "its frames have no `normal`; beside color there is nothing")) << said;
}

}  // namespace
}  // namespace patinate
