#include "capture/relief/relief_change.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "capture/registration/surfels.h"
#include "capture/relief/relief_figures.h"
#include "capture/relief/stable_pose.h"
#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr double kSpacingsPerRadius = 4.4;  ///< 60 points of a square lattice lie within.
constexpr int kPoseRounds = 4;              ///< See docs/algorithms/height_change.md.
constexpr double kBlocksForPose = 200.0;    ///< Many for the robust fit, each of as much surface as that allows.
constexpr int kWindowsPerBlock = 4;         ///< Along a side of the blocks that show what is systematic.
constexpr std::size_t kMinBlocks = 8;       ///< Fewer blocks give no deviation.
constexpr int kStableRounds = 2;            ///< By places that have not changed, after the robust ones.
constexpr double kStays = 3.0;              ///< Standard deviations.
constexpr double kPi = 3.14159265358979323846;

struct ReferenceHeight {
  double height = 0.0;
  double variance = 0.0;
  bool is_measured = false;
};

/// A scan against the reference's places.
class Comparison {
 public:
  Comparison(const std::vector<ReliefPlace>& places, const std::vector<ReferenceHeight>& heights,
             const HeightProbe& probe)
      : places_(places), heights_(heights), probe_(probe) {}

  [[nodiscard]] std::vector<PlaceDifference> at(const std::vector<std::size_t>& chosen, const RigidTransform& pose,
                                                const RunControl& control) const {
    const RigidTransform back = pose.inverse();
    std::vector<PlaceDifference> found(chosen.size());
    parallel_for(static_cast<std::int64_t>(chosen.size()), 512, control, [&](std::int64_t begin, std::int64_t end) {
      for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
        const std::size_t i = chosen[k];
        if (!heights_[i].is_measured) continue;
        const std::optional<LocalHeight> h =
            probe_.over(back.apply(places_[i].position), back.rotation * places_[i].normal);
        if (h) found[k] = {h->height - heights_[i].height, h->variance + heights_[i].variance, true};
      }
    });
    return found;
  }

 private:
  const std::vector<ReliefPlace>& places_;
  const std::vector<ReferenceHeight>& heights_;
  const HeightProbe& probe_;
};

std::vector<ReferenceHeight> reference_heights(const std::vector<ReliefPlace>& places, const HeightProbe& probe,
                                               const RunControl& control) {
  std::vector<ReferenceHeight> heights(places.size());
  parallel_for(static_cast<std::int64_t>(places.size()), 512, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const std::optional<LocalHeight> h = probe.over(places[i].position, places[i].normal);
      if (h) heights[i] = {h->height, h->variance, true};
    }
  });
  return heights;
}

/// Pixels of a view in square blocks; a block's name is its column and row.
using BlockName = std::pair<int, int>;
BlockName block_of(const ReliefPlace& p, int side) { return {p.x / side, p.y / side}; }

/// Places that share no points, of those that may be stable.
std::vector<std::size_t> apart_places(const std::vector<ReliefPlace>& places, const ImageU8& stable, int stride) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const ReliefPlace& p = places[i];
    if (p.x % stride == stride / 2 && p.y % stride == stride / 2 && is_inside(stable, p.x, p.y)) chosen.push_back(i);
  }
  return chosen;
}

/// Means over blocks.
std::vector<HeightDifference> block_differences(const std::vector<ReliefPlace>& places,
                                                const std::vector<std::size_t>& chosen,
                                                const std::vector<PlaceDifference>& found, const Vec3& center,
                                                int side) {
  struct Sum {
    Vec6 row = Vec6::Zero();
    double change = 0.0, variance = 0.0;
    int n = 0;
  };
  std::map<BlockName, Sum> blocks;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (!found[k].is_measured) continue;
    const ReliefPlace& p = places[chosen[k]];
    Sum& sum = blocks[block_of(p, side)];
    sum.row += raising_row(p.position - center, p.normal);
    sum.change += found[k].change, sum.variance += found[k].variance, ++sum.n;
  }
  std::vector<HeightDifference> means;
  for (const auto& [name, sum] : blocks)
    means.push_back({sum.row / sum.n, sum.change / sum.n, sum.variance / sum.n / sum.n});
  return means;
}

/// Deviation of the mean over blocks of places that exceeds their noise; robust.
std::optional<double> systematic_part(const std::vector<ReliefPlace>& places, const std::vector<std::size_t>& chosen,
                                      const std::vector<PlaceDifference>& found, double noise_variance_factor,
                                      int side) {
  struct Sum {
    double change = 0.0, variance = 0.0;
    int n = 0;
  };
  std::map<BlockName, Sum> blocks;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (!found[k].is_measured) continue;
    Sum& sum = blocks[block_of(places[chosen[k]], side)];
    sum.change += found[k].change, sum.variance += noise_variance_factor * found[k].variance, ++sum.n;
  }
  std::vector<double> sizes, noise;
  for (const auto& [name, sum] : blocks) {
    if (2 * sum.n < kWindowsPerBlock * kWindowsPerBlock) continue;
    sizes.push_back(std::abs(sum.change / sum.n));
    noise.push_back(sum.variance / sum.n / sum.n);
  }
  if (sizes.size() < kMinBlocks) return std::nullopt;
  const double size = kSigmaOfMad * median(std::move(sizes));
  return std::sqrt(std::max(0.0, size * size - median(std::move(noise))));
}

struct PlacedScan {
  RigidTransform reference_from_scan;
  StablePose pose;  ///< About the center; its motion is what was left at the end.
  double noise_factor = 1.0;
  std::optional<double> systematic_mm;
  double stable_share = 0.0;
};

struct Surface {
  const std::vector<ReliefPlace>& places;
  Vec3 center;
  double size;
  int stride;      ///< Pixels between places that share no points.
  int pose_block;  ///< Pixels.
};

/// Brings the scan to where most of the places show no change.
void correct_pose(PlacedScan& placed, const Comparison& comparison, const Surface& surface,
                  const std::vector<std::size_t>& chosen, const RunControl& control) {
  const std::vector<PlaceDifference> found = comparison.at(chosen, placed.reference_from_scan, control);
  placed.pose = find_stable_pose(block_differences(surface.places, chosen, found, surface.center, surface.pose_block),
                                 surface.size);
  const Eigen::Matrix3d turn = rotation_of(placed.pose.motion.head<3>());
  const RigidTransform correction{turn, surface.center - turn * surface.center + placed.pose.motion.tail<3>()};
  placed.reference_from_scan = correction * placed.reference_from_scan;
}

bool stays(const PlaceDifference& d, double scale) {
  return std::abs(d.change) <= kStays * scale * std::sqrt(d.variance);
}

/// Changes over their standard deviations, summed over a place and its neighbors a window away, over the root of their
/// number; absolute.
std::vector<double> neighborhood_changes(const Surface& surface, const std::vector<std::size_t>& chosen,
                                         const std::vector<PlaceDifference>& found) {
  const auto block = [&](std::size_t k) { return block_of(surface.places[chosen[k]], surface.stride); };
  std::map<BlockName, double> of_block;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (found[k].is_measured) of_block[block(k)] = found[k].change / std::sqrt(found[k].variance);
  }
  std::vector<double> means(chosen.size());
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const auto [column, row] = block(k);
    int n = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto at = of_block.find({column + dx, row + dy});
        if (at != of_block.end()) means[k] += at->second, ++n;
      }
    }
    means[k] = std::abs(means[k]) / std::sqrt(std::max(n, 1));
  }
  return means;
}

/// Places that stay, alone and on the mean with their neighbors: a change reaches over
/// several windows, so that the mean shows what is within the noise of each, and would pull the scan along. What is
/// systematic makes all means larger, and is no change.
std::vector<std::size_t> unchanged_places(const Surface& surface, const std::vector<std::size_t>& chosen,
                                          const std::vector<PlaceDifference>& found, double scale) {
  const std::vector<double> means = neighborhood_changes(surface, chosen, found);
  std::vector<double> of_measured;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (found[k].is_measured) of_measured.push_back(means[k]);
  }
  const double scale_of_means = std::max(scale, inner_scale(std::move(of_measured)));
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (found[k].is_measured && means[k] <= kStays * scale_of_means && stays(found[k], scale)) kept.push_back(k);
  }
  return kept;
}

double scale_of(const std::vector<PlaceDifference>& found) {
  std::vector<double> sizes;
  for (const PlaceDifference& d : found) {
    if (d.is_measured) sizes.push_back(std::abs(d.change) / std::sqrt(d.variance));
  }
  return inner_scale(std::move(sizes));
}

/// Share of the measured places that show no change by themselves.
double agreeing_share(const std::vector<PlaceDifference>& found, double scale) {
  double num_measured = 0.0, num_agreeing = 0.0;
  for (const PlaceDifference& d : found) {
    num_measured += d.is_measured ? 1.0 : 0.0;
    num_agreeing += d.is_measured && stays(d, scale) ? 1.0 : 0.0;
  }
  return num_agreeing / std::max(1.0, num_measured);
}

/// Where the given pose has it; what points scatter is believed.
PlacedScan kept_scan(const Comparison& comparison, const std::vector<std::size_t>& chosen, const RigidTransform& given,
                     const RunControl& control) {
  PlacedScan kept;
  kept.reference_from_scan = given;
  kept.stable_share = agreeing_share(comparison.at(chosen, given, control), 1.0);
  return kept;
}

PlacedScan place_scan(const Comparison& comparison, const Surface& surface, const std::vector<std::size_t>& chosen,
                      const RigidTransform& given, const RunControl& control) {
  PlacedScan placed;
  placed.reference_from_scan = given;
  for (int round = 0; round < kPoseRounds; ++round) correct_pose(placed, comparison, surface, chosen, control);
  const double agreeing = placed.pose.agreeing;
  // Then by what shows no change in its neighborhood either.
  for (int round = 0; round < kStableRounds; ++round) {
    const std::vector<PlaceDifference> found = comparison.at(chosen, placed.reference_from_scan, control);
    std::vector<std::size_t> stable;
    for (const std::size_t k : unchanged_places(surface, chosen, found, scale_of(found))) stable.push_back(chosen[k]);
    correct_pose(placed, comparison, surface, stable, control);
  }
  // The rest on places that show no change by themselves tells how well the points' scatter states the deviation.
  const std::vector<PlaceDifference> found = comparison.at(chosen, placed.reference_from_scan, control);
  placed.noise_factor = scale_of(found);
  placed.stable_share = std::min(agreeing_share(found, placed.noise_factor), agreeing);
  std::vector<std::size_t> stable;
  std::vector<PlaceDifference> of_stable;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (!found[k].is_measured || !stays(found[k], placed.noise_factor)) continue;
    stable.push_back(chosen[k]);
    of_stable.push_back(found[k]);
  }
  placed.systematic_mm = systematic_part(surface.places, stable, of_stable, placed.noise_factor * placed.noise_factor,
                                         kWindowsPerBlock * surface.stride);
  return placed;
}

/// Lengths that were not given.
struct Lengths {
  double window, texel, reach;
};

Lengths lengths_of(const PointCloud& reference, const ReliefOptions& options) {
  const double spacing = point_spacing(reference.points);
  Lengths lengths{};
  lengths.window = options.window_mm > 0.0 ? options.window_mm : 2.0 * kSpacingsPerRadius * spacing;
  lengths.texel = options.texel_mm > 0.0 ? options.texel_mm : spacing;
  lengths.reach = options.reach_mm > 0.0 ? options.reach_mm : 2.0 * lengths.window;
  return lengths;
}

void add_reference_maps(Relief& relief, const std::vector<ReliefPlace>& places) {
  const ReliefView& view = relief.view;
  relief.position_mm = ImageF(view.width, view.height, 3);
  relief.normal = ImageF(view.width, view.height, 3);
  relief.surface = ImageU8(view.width, view.height);
  for (const ReliefPlace& p : places) {
    relief.surface.at(p.x, p.y) = 255;
    for (int c = 0; c < 3; ++c) {
      relief.position_mm.at(p.x, p.y, c) = static_cast<float>(p.position[c]);
      relief.normal.at(p.x, p.y, c) = static_cast<float>(p.normal[c]);
    }
  }
}

double root_mean_square_shift(const std::vector<ReliefPlace>& places, const RigidTransform& from,
                              const RigidTransform& to) {
  const RigidTransform back = from.inverse();
  double squares = 0.0;
  for (const ReliefPlace& p : places) {
    const double d = p.normal.dot(to.apply(back.apply(p.position)) - p.position);
    squares += d * d;
  }
  return std::sqrt(squares / static_cast<double>(places.size()));
}

/// Surface of the places, where they lie on the whole.
Surface surface_of(const std::vector<ReliefPlace>& places, std::size_t num_stable, const Lengths& lengths) {
  Surface surface{.places = places, .center = Vec3::Zero(), .size = 0.0, .stride = 1, .pose_block = 1};
  for (const ReliefPlace& p : places) surface.center += p.position / static_cast<double>(places.size());
  double squares = 0.0;
  for (const ReliefPlace& p : places) squares += (p.position - surface.center).squaredNorm();
  surface.size = std::sqrt(squares / static_cast<double>(places.size()));
  surface.stride = std::max(1, static_cast<int>(std::ceil(lengths.window / lengths.texel)));
  const double windows = static_cast<double>(num_stable) / (surface.stride * surface.stride);
  surface.pose_block = surface.stride * std::max(1, static_cast<int>(std::sqrt(windows / kBlocksForPose)));
  return surface;
}

}  // namespace

void describe(OptionVisitor& v, ReliefOptions& o) {
  v.visit(
      {"window_mm", "Diameter of the surface patches whose heights are compared; 0: wide enough for about 60 points",
       "mm", at_least(0)},
      o.window_mm);
  v.visit({"texel_mm", "Side of a pixel of the maps; 0: the spacing of the reference scan's points", "mm", at_least(0)},
          o.texel_mm);
  v.visit({"reach_mm", "Search distance along the normal; 0: two windows", "mm", at_least(0)}, o.reach_mm);
  v.visit(
      {"toward",
       "Direction of view, in the reference scan's frame; 0,0,0: perpendicular to the plane that fits the scan best"},
      std::span<double>(o.toward));
  v.visit({"keep_poses", "The scans' poses are exact, for example from a mount: move none of them"}, o.keep_poses);
  v.visit({"false_share",
           "Largest expected share of false positives among the places reported as changed",
           "",
           {.low = 0.0, .high = 0.5, .is_low_open = true}},
          o.false_share);
}

Relief measure_relief(std::span<const PointCloud> scans, std::span<const RigidTransform> reference_from_scan,
                      std::size_t reference, const std::function<ImageU8(const ReliefView&)>& stable,
                      const ReliefOptions& options, const RunControl& control) {
  check_ranges(options);
  const PointCloud& first = scans[reference];
  const Lengths lengths = lengths_of(first, options);
  const double radius = 0.5 * lengths.window;
  Relief relief;
  relief.window_mm = lengths.window, relief.reach_mm = lengths.reach;
  relief.view =
      relief_view(first, {options.toward[0], options.toward[1], options.toward[2]}, lengths.texel, -0.5 * radius);
  const HeightProbe reference_probe(first.points, radius, lengths.reach);
  const std::vector<ReliefPlace> places = relief_places(first.points, reference_probe, relief.view, radius, control);
  if (places.empty())
    throw InvalidInput("relief: the reference scan shows no surface with windows of " +
                       short_number_text(rounded(lengths.window, 3)) + " mm; a larger --window-mm takes more points");
  add_reference_maps(relief, places);
  const std::vector<ReferenceHeight> heights = reference_heights(places, reference_probe, control);
  const ImageU8 stays = stable ? stable(relief.view) : ImageU8();
  const auto num_stable = static_cast<std::size_t>(
      std::count_if(places.begin(), places.end(), [&](const ReliefPlace& p) { return is_inside(stays, p.x, p.y); }));
  const Surface surface = surface_of(places, num_stable, lengths);
  const std::vector<std::size_t> apart = apart_places(places, stays, surface.stride);
  std::vector<std::size_t> all(places.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  for (std::size_t k = 0; k < scans.size(); ++k) {
    if (k == reference) continue;
    const HeightProbe probe(scans[k].points, radius, lengths.reach);
    const Comparison comparison(places, heights, probe);
    const PlacedScan placed = options.keep_poses
                                  ? kept_scan(comparison, apart, reference_from_scan[k], control)
                                  : place_scan(comparison, surface, apart, reference_from_scan[k], control);
    ReliefChange change;
    change.reference_from_scan = placed.reference_from_scan;
    change.moved_mm = root_mean_square_shift(places, reference_from_scan[k], placed.reference_from_scan);
    change.stable_share = placed.stable_share;
    change.num_dofs = placed.pose.num_dofs;
    change.noise_factor = placed.noise_factor;
    change.systematic_mm = placed.systematic_mm;
    const ChangeModel model{.pose_covariance = placed.pose.covariance,
                            .center = surface.center,
                            .noise_factor = placed.noise_factor,
                            .systematic_mm = placed.systematic_mm.value_or(0.0),
                            .systematic_block = kWindowsPerBlock * surface.stride,
                            .window_pixels = kPi * radius * radius / (lengths.texel * lengths.texel)};
    fill_change(change, relief.view, places, comparison.at(all, placed.reference_from_scan, control), model,
                options.false_share);
    relief.changes.push_back(std::move(change));
  }
  return relief;
}

}  // namespace patinate::capture
