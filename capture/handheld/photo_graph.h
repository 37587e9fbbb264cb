/// \file
/// Where every photograph of a series lies in the reference one, from all pairs that were matched.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "capture/handheld/photo_pair.h"

namespace patinate::capture {

enum class PlaceStatus {
  Reference,
  Given,    ///< By `transform`.
  Aligned,  ///< Matched with the reference itself.
  Through,  ///< Over other photographs.
  Failed,   ///< Nothing ties it to the reference.
};
[[nodiscard]] std::string place_status_text(PlaceStatus status);

struct PhotoSize {
  int width = 0, height = 0;
};

/// How a photograph lies in the reference.
struct PhotoPlace {
  PlaceStatus status = PlaceStatus::Failed;
  Eigen::Matrix3d reference_from_photo = Eigen::Matrix3d::Identity();  ///< Pixel centers; lower right 1.
  AlignModel model = AlignModel::Similarity;                           ///< Similarity or Homography.
  double residual_px = 0.0;  ///< Root mean square disagreement of its matches, in the reference's pixels.
  int through = -1;          ///< For Through: the photograph next to it on the way to the reference.
  int num_pairs = 0;         ///< Accepted pairs that hold it.
};

/// All places at once: least squares over the matches of all accepted pairs, each in the pixels of its second
/// photograph over its error, with Cauchy weights that are
/// narrowed step by step; starting from the best-supported tree. A pair whose matches then
/// disagree by more than four of its errors, and three times the median pair, is dropped, and the rest solved again.
///
/// A photograph is a homography if at least half of its pairs refute a similarity, or `model` says so.
/// @param given  Per photograph: its place, if it is known; it is not changed, and holds others as the reference does.
/// @param pairs  Any. Becomes those that were kept: dropped ones are no longer accepted.
[[nodiscard]] std::vector<PhotoPlace> place_photos(const std::vector<PhotoSize>& sizes, int reference,
                                                   const std::vector<std::optional<Eigen::Matrix3d>>& given,
                                                   std::vector<PhotoPair>& pairs, AlignModel model);

/// Photographs that accepted pairs tie to one of `roots`.
[[nodiscard]] std::vector<bool> tied_to(int num_photos, const std::vector<int>& roots,
                                        const std::vector<PhotoPair>& pairs);

}  // namespace patinate::capture
