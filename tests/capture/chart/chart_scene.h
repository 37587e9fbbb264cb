/// \file
/// Photographs of a color chart and of other patches whose color is known, rendered by spectra: cameras, lamps, tilt,
/// vignetting, noise, and charts as they should not be.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::testing_support {

inline constexpr int kNumCameras = 3;
inline constexpr int kNumLamps = 3;

/// Spoil of the chart.
enum class ChartSpoil { None, Hidden, Mirrored, Dark, Bright, OtherMake, Bent, Absent, CutOff, Shuffled };
inline constexpr int kNumSpoils = 10;

struct ChartScene {
  int width = 720;
  int height = 480;
  int camera = 0;            ///< 0: linear codes of 16 bits. 1: sRGB, 8 bits. 2: a tone curve of its own, 8 bits.
  int lamp = 0;              ///< 0: daylight of 5000 K. 1: tungsten of 2856 K. 2: a white LED.
  double tilt_deg = 15.0;    ///< Tilt of the chart against the picture, about an axis that is drawn.
  double vignetting = 0.25;  ///< a of exp(-a r^2), r in half diagonals.
  double slope = 0.1;        ///< Largest relative change of the lamp's light over half a diagonal.
  double noise = 1.0;        ///< 1: a standard deviation of 1 % at white, 0.1 % at black.
  double largest_turn_deg = 180.0;  ///< Turn of the chart in the picture, either way.
  ChartSpoil spoil = ChartSpoil::None;
  std::uint32_t seed = 1;  ///< Seed of where the chart lies, the other patches, and the spoil.
};

/// How one photograph was exposed.
struct ChartExposure {
  double exposure = 1.0;                               ///< 1: the white patch has about half of the largest light.
  std::array<double, 3> white_balance{1.0, 1.0, 1.0};  ///< Times that which makes the lamp's gray gray.
  std::uint32_t noise_seed = 1;
};

/// A patch beside the chart.
struct KnownPatch {
  int x = 0, y = 0, side = 0;      ///< Upper left pixel; what is inside of it by two pixels is all of it.
  std::array<double, 3> lab{};     ///< Under D65.
  std::array<double, 3> linear{};  ///< Rec. 709; not clamped.
};

struct ChartPhoto {
  ImageF codes;  ///< H x W x 3, in [0, 1], rounded to the camera's bits.
  std::vector<KnownPatch> patches;
  std::array<Eigen::Vector2d, 4> corners = {};  ///< Corners as place_chart() takes them.
};

[[nodiscard]] ChartPhoto render_chart(const ChartScene& scene, const ChartExposure& exposure = {});
/// Linear light as ingest makes it of the codes: camera 0 is linear, the others say sRGB.
[[nodiscard]] ImageF linear_of(const ChartPhoto& photo, int camera);
[[nodiscard]] std::string spoil_text(ChartSpoil spoil);

}  // namespace patinate::testing_support
