#include "capture/handheld/lay_photo.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "capture/handheld/photo_graph.h"

namespace patinate::capture {
namespace {

ImageF waves(int width, int height, double period) {
  ImageF image(width, height, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      image.at(x, y) = static_cast<float>(0.5 + 0.4 * std::sin(2.0 * std::numbers::pi * x / period));
  }
  return image;
}

TEST(LayPhoto, WholePixelShiftsCopyAndNameWhatIsNotShown) {
  const ImageF photo = waves(40, 30, 9.0);
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = 3.0;
  ImageU8 shown;
  const ImageF out = lay_photo(photo, shift, 40, 30, shown);
  for (int x = 0; x < 40; ++x) {
    EXPECT_EQ(shown.at(x, 7), x < 3 ? 0 : 255);
    EXPECT_EQ(out.at(x, 7), photo.at(std::max(0, x - 3), 7));
  }
}

TEST(LayPhoto, AFinerPhotographIsAveragedNotSampled) {
  // Stripes of two pixels are finer than the reference's pixels, of six: what is left of them is the part of a period
  // that a footprint holds besides whole ones, none here.
  const ImageF photo = waves(240, 180, 2.0 * 1.5);
  Eigen::Matrix3d scale;
  scale << 1.0 / 6.0, 0, 0.5 / 6.0 - 0.5, 0, 1.0 / 6.0, 0.5 / 6.0 - 0.5, 0, 0, 1;
  ImageU8 shown;
  const ImageF out = lay_photo(photo, scale, 40, 30, shown);
  for (int y = 1; y < 29; ++y) {
    for (int x = 1; x < 39; ++x) {
      EXPECT_EQ(shown.at(x, y), 255);
      EXPECT_NEAR(out.at(x, y), 0.5, 0.02);  // Single samples differ by 0.4.
    }
  }
}

PhotoPair exact_pair(int a, int b, const Eigen::Matrix3d& b_from_a) {
  PhotoPair pair{.a = a, .b = b, .is_accepted = true, .b_from_a = b_from_a, .num_agreeing = 20, .error_px = 0.2};
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector2d p(10.0 + 37.0 * (k % 5), 15.0 + 41.0 * (k / 5));
    pair.matches.push_back({p, moved_by(b_from_a, p)});
  }
  return pair;
}

TEST(PhotoGraph, AWrongPairIsDroppedWhereOthersDisagree) {
  std::vector<Eigen::Matrix3d> truth(5, Eigen::Matrix3d::Identity());
  for (int i = 1; i < 5; ++i) {
    truth[i].topLeftCorner<2, 2>() = 1.1 * Eigen::Rotation2Dd(0.7 * i).toRotationMatrix();
    truth[i](0, 2) = 11.0 * i;
  }
  std::vector<PhotoPair> pairs;
  for (int a = 0; a < 5; ++a) {
    for (int b = a + 1; b < 5; ++b) pairs.push_back(exact_pair(a, b, truth[b].inverse() * truth[a]));
  }
  Eigen::Matrix3d wrong = pairs[1].b_from_a;
  wrong(0, 2) += 40.0;
  pairs[1] = exact_pair(0, 2, wrong);
  pairs[1].num_agreeing = 90;  // It looks best.
  const std::vector<PhotoPlace> places =
      place_photos(std::vector<PhotoSize>(5, {200, 200}), 0, std::vector<std::optional<Eigen::Matrix3d>>(5), pairs,
                   AlignModel::Auto);
  EXPECT_FALSE(pairs[1].is_accepted);
  for (std::size_t i = 0; i < 5; ++i) {
    // Exact but for rounding and numeric slopes.
    EXPECT_LT((places[i].reference_from_photo - truth[i]).cwiseAbs().maxCoeff(), 1e-5) << i;
    EXPECT_LT(places[i].residual_px, 1e-5);
  }
  EXPECT_EQ(places[2].status, PlaceStatus::Through);
}

}  // namespace
}  // namespace patinate::capture
