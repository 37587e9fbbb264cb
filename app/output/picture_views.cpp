#include "app/output/picture_views.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/request/usage_error.h"
#include "libcommon/core/text.h"

namespace patinate::app {

namespace {

constexpr double kMaxTurntable = 10000;

struct Side {
  const char* name;
  double azimuth_deg;
  std::optional<double> elevation_deg;  ///< None: as --elevation says.
};
const std::array<Side, 6> kSides{Side{"front", 0.0, {}},   Side{"left", 90.0, {}}, Side{"back", 180.0, {}},
                                 Side{"right", 270.0, {}}, Side{"top", 0.0, 90.0}, Side{"bottom", 0.0, -90.0}};

PictureView parse_view(const std::string& word, const RenderOptions& options) {
  for (const Side& side : kSides) {
    if (word == side.name) return {word, side.azimuth_deg, side.elevation_deg.value_or(options.elevation_deg)};
  }
  const std::size_t colon = word.find(':');
  const std::optional<double> azimuth = parse_number(word.substr(0, colon));
  const std::optional<double> elevation =
      colon == std::string::npos ? std::optional<double>(options.elevation_deg) : parse_number(word.substr(colon + 1));
  if (!azimuth || !elevation || std::abs(*azimuth) > 3600.0 || std::abs(*elevation) > 90.0) {
    throw UsageError("--views: found `" + word +
                     "`; expected front, left, back, right, top, bottom or AZIMUTH:ELEVATION in degrees");
  }
  return {word, *azimuth, *elevation};
}

}  // namespace

void ViewChoice::apply_to(RenderOptions& options) const {
  if (!target.empty() && target.size() != 3)
    throw UsageError("--target: found " + std::to_string(target.size()) + " numbers; expected X,Y,Z");
  if (!target.empty()) options.target = Vec3(target[0], target[1], target[2]);
  if (distance && !(*distance > 0.0)) throw UsageError("--distance: found a length that is not above 0");
  options.distance = distance;
}

std::vector<PictureView> ViewChoice::resolve(const RenderOptions& options) const {
  if (turntable) {
    if (!(*turntable >= 1.0 && *turntable <= kMaxTurntable) || *turntable != std::floor(*turntable))
      throw UsageError("--turntable: expected a whole number of pictures in [1, 10000]");
    if (!views.empty()) throw UsageError("--views: cannot be given with --turntable");
    std::vector<PictureView> round;
    for (int i = 0; i < static_cast<int>(*turntable); ++i) {
      const double turned = 360.0 * i / *turntable;
      round.push_back({short_number_text(turned), options.azimuth_deg + turned, options.elevation_deg});
    }
    return round;
  }
  std::vector<PictureView> all;
  for (std::size_t begin = 0; begin < views.size();) {
    const std::size_t end = std::min(views.find(',', begin), views.size());
    all.push_back(parse_view(views.substr(begin, end - begin), options));
    begin = end + 1;
  }
  if (all.empty()) all.push_back({"", options.azimuth_deg, options.elevation_deg});
  return all;
}

}  // namespace patinate::app
