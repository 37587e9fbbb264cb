/// \file
/// Which descriptors of two pictures belong together.
#pragma once

#include <vector>

namespace cv {
class Mat;
}

namespace patinate::capture {

/// Index of the nearest row of `to` for every row of `from` whose second nearest is clearly farther [Lowe 2004], else
/// -1.
/// @param ratio  Of the distances, from which on it is not clear: (0, 1].
[[nodiscard]] std::vector<int> clear_matches(const cv::Mat& from, const cv::Mat& to, float ratio);

}  // namespace patinate::capture
