#include "tests/capture/handheld/handheld_scene.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <string>

#include "libcommon/core/text.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::testing_support {

HandheldPhoto draw_photo(const HandheldScene& scene, int index, int width, int height) {
  HandheldPhoto photo{.width = width, .height = height};
  if (index == 0) return photo;
  std::mt19937 random(scene.seed * 1000u + static_cast<std::uint32_t>(index));
  const auto draw = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967295.0;
  };
  const double turn = std::numbers::pi / 180.0 * draw(-scene.largest_turn_deg, scene.largest_turn_deg);
  const double scale = std::exp(draw(std::log(scene.least_scale), std::log(scene.largest_scale)));
  const double crop_x = draw(scene.least_crop, 1.0), crop_y = draw(scene.least_crop, 1.0);
  const Eigen::Vector2d middle(draw(0.5 * crop_x, 1.0 - 0.5 * crop_x) * width,
                               draw(0.5 * crop_y, 1.0 - 0.5 * crop_y) * height);
  photo.width = std::max(32, static_cast<int>(std::lround(crop_x * width * scale)));
  photo.height = std::max(32, static_cast<int>(std::lround(crop_y * height * scale)));
  const double tilt_x = draw(-scene.largest_tilt, scene.largest_tilt) / photo.width;
  const double tilt_y = draw(-scene.largest_tilt, scene.largest_tilt) / photo.height;
  Eigen::Matrix3d to_middle = Eigen::Matrix3d::Identity(), turned = Eigen::Matrix3d::Identity(),
                  tilted = Eigen::Matrix3d::Identity(), to_corner = Eigen::Matrix3d::Identity();
  to_middle.topRightCorner<2, 1>() = -middle;
  turned.topLeftCorner<2, 2>() = scale * Eigen::Rotation2Dd(turn).toRotationMatrix();
  tilted(2, 0) = tilt_x;
  tilted(2, 1) = tilt_y;
  to_corner.topRightCorner<2, 1>() = Eigen::Vector2d(0.5 * (photo.width - 1), 0.5 * (photo.height - 1));
  photo.photo_from_frame = to_corner * tilted * turned * to_middle;
  const double stops = draw(-scene.largest_stops, scene.largest_stops);
  for (double& g : photo.gain) g = std::exp2(stops) * std::exp(draw(-scene.largest_tint, scene.largest_tint));
  return photo;
}

ImageF take_photo(const ImageF& frame, const HandheldPhoto& photo, const HandheldScene& scene, int index) {
  constexpr int kSamples = 8;
  std::mt19937 random(scene.seed * 7919u + static_cast<std::uint32_t>(index));
  std::normal_distribution<float> noise(0.0f, static_cast<float>(scene.noise));
  const Eigen::Matrix3d frame_from_photo = photo.photo_from_frame.inverse();
  ImageF image(photo.width, photo.height, 3);
  for (int y = 0; y < photo.height; ++y) {
    for (int x = 0; x < photo.width; ++x) {
      std::array<double, 3> sum{};
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const Eigen::Vector2d at(x + (s % kSamples + 0.5) / kSamples - 0.5, y + (s / kSamples + 0.5) / kSamples - 0.5);
        const Eigen::Vector2d p = (frame_from_photo * at.homogeneous()).hnormalized();
        const double px = std::clamp(p.x(), 0.0, frame.width() - 1.001),
                     py = std::clamp(p.y(), 0.0, frame.height() - 1.001);
        // Beside the frame lies a gray table.
        const bool is_outside =
            p.x() < -0.5 || p.y() < -0.5 || p.x() > frame.width() - 0.5 || p.y() > frame.height() - 0.5;
        const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
        const double u = px - x0, v = py - y0;
        for (int c = 0; c < 3; ++c) {
          const auto value = [&](int i, int j) { return static_cast<double>(frame.at(x0 + i, y0 + j, c)); };
          sum[c] += is_outside ? 0.2
                               : (1 - v) * ((1 - u) * value(0, 0) + u * value(1, 0)) +
                                     v * ((1 - u) * value(0, 1) + u * value(1, 1));
        }
      }
      for (int c = 0; c < 3; ++c) {
        const std::size_t k = c;
        const double light = std::clamp(photo.gain[k] * sum[k] / (kSamples * kSamples), 0.0, 1.0);
        const float code = srgb_from_linear(static_cast<float>(light)) + noise(random);
        image.at(x, y, c) = linear_from_srgb(std::clamp(code, 0.0f, 1.0f));
      }
    }
  }
  return image;
}

std::vector<HandheldPhoto> write_handheld(const std::vector<ImageF>& frames, const HandheldScene& scene,
                                          const std::filesystem::path& folder, const std::string& more_json) {
  std::filesystem::create_directories(folder / "photos");
  std::vector<HandheldPhoto> photos;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const int index = static_cast<int>(i);
    photos.push_back(draw_photo(scene, index, frames[i].width(), frames[i].height()));
    write_srgb8(folder / "photos" / (zero_padded(i, 3) + ".png"), take_photo(frames[i], photos.back(), scene, index));
  }
  std::ofstream(folder / "capture.json")
      << R"({"format": "patinate.capture", "version": 1, "name": "hand", "kind": "fixed", "time_unit": "d", )"
      << more_json << R"("frames": {"pattern": "photos/*.png", "interval": 1}})";
  return photos;
}

double transform_error_px(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b, int width, int height) {
  constexpr int kSteps = 8;
  double sum = 0.0;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const Eigen::Vector3d p(i * (width - 1.0) / kSteps, j * (height - 1.0) / kSteps, 1.0);
      sum += ((a * p).hnormalized() - (b * p).hnormalized()).squaredNorm();
    }
  }
  return std::sqrt(sum / ((kSteps + 1) * (kSteps + 1)));
}

}  // namespace patinate::testing_support
