/// \file
/// What the module `patinate-markers` does: OpenCV's detector of printed markers, whose library brings a hundred
/// others. It is loaded when a series is searched for markers (libcommon/core/module.h). Inside of handheld only.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace patinate::capture {

/// 4x4, 5x5, 6x6 and 7x7 (up to 250 markers each), the original ArUco, AprilTag 36h11.
inline constexpr std::array<const char*, 6> kMarkerDictionaries{"4x4", "5x5", "6x6", "7x7", "original", "36h11"};

struct SeenMarker {
  int id = 0;
  std::array<std::array<float, 2>, 4> corners{};  ///< Pixels, to about one.
};

/// Raise the number in kMarkersEntry with every change of this class or of SeenMarker.
class MarkersModule {
 public:
  virtual ~MarkersModule() = default;
  /// @param gray  Codes of 8 bits, row by row. @param dictionary  Into kMarkerDictionaries.
  [[nodiscard]] virtual std::vector<SeenMarker> detect(const std::uint8_t* gray, int width, int height,
                                                       int dictionary) = 0;
};

/// The module's function that gives it: `MarkersModule* patinate_markers_1()`.
inline constexpr const char* kMarkersEntry = "patinate_markers_1";

}  // namespace patinate::capture
