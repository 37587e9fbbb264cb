/// \file
/// All photographs of a series laid over one of them.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "capture/handheld/landmarks.h"
#include "capture/handheld/outline.h"
#include "capture/handheld/photo_graph.h"
#include "patinate/core/run_control.h"

namespace patinate::capture {

/// A series that is to be aligned; vectors have an entry a photograph, in the order of time.
struct PhotoSeries {
  std::vector<PhotoSize> sizes;
  int reference = 0;
  AlignModel model = AlignModel::Auto;
  std::vector<std::optional<Eigen::Matrix3d>> given;  ///< Reference from photograph, where it is known.
  std::vector<PhotoMarks> marks;                      ///< May be empty: no landmarks at all.
  bool are_marks_exact = false;                       ///< Corners that a program found: to a quarter of a pixel. Those
                                                      ///< that carry the corners of a photograph over with an error of
                                                      ///< more than a hundredth of its side are not enough.
  /// Details of a photograph; empty: no features are used.
  std::function<PhotoFeatures(int)> features;
  /// Outline of the object in a photograph; empty: none is used.
  std::function<PhotoOutline(int)> outlines;
};

struct SeriesAlignment {
  std::vector<PhotoPlace> places;
  std::vector<PhotoPair> pairs;  ///< All that were tried.
};

/// Pairs from landmarks: all photographs that share enough. Pairs from features, or from outlines: of up to ten
/// photographs all; of more every one with the two after it, with the reference and with the one in the middle; then,
/// while a photograph is tied to nothing, it is tried against the nearest 24 in time of those that are. Then, twice,
/// patches of the accepted pairs and of all photographs with the reference take the features' place, where they fit.
/// With both, outlines are for what features leave untied.
/// Same result for any number of threads.
[[nodiscard]] SeriesAlignment align_series(const PhotoSeries& series, const RunControl& control);

}  // namespace patinate::capture
