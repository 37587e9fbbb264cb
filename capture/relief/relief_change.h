/// \file
/// How much higher or lower a surface stands in one scan than in another, place by place, with what is significant and
/// what volume it makes.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "capture/relief/relief_places.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/point_cloud.h"
#include "patinate/geometry/rigid_transform.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Lengths in mm.
struct ReliefOptions {
  double window_mm = 0.0;  ///< Diameter of the cylinders whose points make a height; 0: so that 60 points are in one.
  double texel_mm = 0.0;   ///< 0: the spacing of the reference scan's points.
  double reach_mm = 0.0;   ///< How far along the normal a surface is looked for; 0: two windows.
  std::array<double, 3> toward{0.0, 0.0, 0.0};  ///< The viewer, in the reference's frame; 0, 0, 0: by the scan.
  bool keep_poses = false;    ///< The given poses are exact (a mount, a measured motion): no scan is moved.
  double false_share = 0.05;  ///< At most so many of the places called changed are not, on the mean; (0, 0.5].
};
void describe(OptionVisitor& v, ReliefOptions& o);

/// A volume with its standard deviation; mm3.
struct VolumeChange {
  double mm3 = 0.0;
  double stddev_mm3 = 0.0;
  double area_mm2 = 0.0;  ///< Area of the surface that it is taken over.
};

/// One scan against the reference. Images are of the view's size.
struct ReliefChange {
  ImageF change_mm;                    ///< Along the reference's normal; > 0: it stands higher. 0 where not measured.
  ImageF stddev_mm;                    ///< Standard deviation: scanner noise, the scan's place and a systematic part.
  ImageU8 measured;                    ///< 255 where both scans have a surface.
  ImageU8 changed;                     ///< 255 where the change is significant.
  RigidTransform reference_from_scan;  ///< The given one, corrected by the stable surface.
  double moved_mm = 0.0;               ///< By that correction, along the normal, root mean square.
  double stable_share = 0.0;           ///< Stable share of what may be stable: the share that shows no change.
  int num_dofs = 0;                    ///< That the heights constrain.
  double noise_factor = 1.0;           ///< Deviations are so many times what points scatter about their planes.
  double pose_stddev_mm = 0.0;         ///< Part of the deviation: the scan's place; root mean square.
  /// Part of the deviation: what stays on the mean of blocks of stable surface, more than noise; nothing where there
  /// are less than 8 blocks.
  std::optional<double> systematic_mm;
  double measured_share = 0.0;  ///< Measured share of the reference's places.
  double changed_share = 0.0;   ///< Changed share of the measured area.
  VolumeChange net;             ///< Over all that is measured.
  VolumeChange gained, lost;    ///< Over what has changed up and down; lost.mm3 <= 0.
};

struct Relief {
  ReliefView view;
  double window_mm = 0.0;  ///< Window as used.
  double reach_mm = 0.0;
  ImageF position_mm, normal;  ///< Position and normal of the reference, in its frame; 0 where there is no surface.
  ImageU8 surface;             ///< 255 where there is.
  std::vector<ReliefChange> changes;  ///< One a scan but the reference, in order.
};

/// Heights are those of planes through the points around each place (HeightProbe) in both scans; the scan is first
/// brought to where the stable surface shows no change (find_stable_pose), so that the given poses need not be better
/// than a window; with keep_poses it stays where it is.
/// @param scans  In mm, each in its own frame; at least 2. @param reference_from_scan  As many.
/// @param stable  Given the view: an image of its size, not 0 where the surface is known to stay; or an empty one.
/// @throws InvalidInput if scans have no surface in common, or too little of it is stable to place them; Canceled.
[[nodiscard]] Relief measure_relief(std::span<const PointCloud> scans,
                                    std::span<const RigidTransform> reference_from_scan, std::size_t reference,
                                    const std::function<ImageU8(const ReliefView&)>& stable,
                                    const ReliefOptions& options, const RunControl& control = {});

}  // namespace patinate::capture
