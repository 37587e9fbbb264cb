/// \file
/// How one material's lobe changes over time, from what tiles of a surface show under one lamp. Inside of ingest only.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace patinate::capture {

/// Roughness at which tiles know their lobes; in equal steps of its logarithm from 0.1 to 0.95.
inline constexpr int kNumLobeNodes = 32;
[[nodiscard]] double lobe_node_roughness(int node);

inline constexpr double kFormOff = 0.05;  ///< Share of a highlight that its form is off by.

/// Samples of one material's tiles in one photograph: albedo + strength * lobe, in n tiles of any order.
struct TileSamples {
  std::vector<int> tile;                                          ///< Number of the tile in the picture.
  Eigen::Matrix<double, Eigen::Dynamic, 3> value;                 ///< n x 3, over what albedo 1 shows.
  Eigen::Matrix<double, Eigen::Dynamic, kNumLobeNodes> log_lobe;  ///< n x nodes.
};

/// A lobe at one time.
struct LobeAt {
  double roughness = 0.0;
  double strength = 0.0;                                       ///< Mean over channels.
  double roughness_deviation = 0.0, strength_deviation = 0.0;  ///< Standard deviations, as shares of them.
};

struct LobeCourse {
  bool is_told = false;                            ///< Whether a lobe explains the tiles better than none, clearly.
  std::vector<LobeAt> at = {};                     ///< One a photograph.
  Eigen::Vector3d tint = Eigen::Vector3d::Ones();  ///< Mean 1.
  double saved = 0.0;  ///< Chi-square that the lobe saves, over how many photographs tell the same.
};

/// Roughness and strength of every photograph such that tiles are foretold best, each photograph with an albedo of its
/// own. Prior: their logarithms walk at random, by 1 (a factor of 2.7, as from a mirror to satin) over all of the time,
/// and lie within 1 of a mineral's satin (0.5, 0.04), which is what comes out where nothing tells.
///
/// Tiles are uncertain by what they differ with the lobe taken off, as alike tiles of neighboring places are; and by a
/// twentieth of the highlight, for the lobe's form. Under a lamp that stands still a pattern of the albedo that looks
/// like a highlight looks so in all photographs: as far as their rests are alike they count as one, so that
/// deviations are too large where the lobe changes fast, by the root of the photographs at most. Under one that moves
/// each tile has an albedo of its own, the mean of its rests over photographs nearby.
/// @param frames  One a photograph; without tiles where the material is not seen. @param times  Rising.
/// @param columns  Tiles along a row of the picture.
[[nodiscard]] LobeCourse fit_lobe_course(const std::vector<TileSamples>& frames, const std::vector<double>& times,
                                         int columns, bool is_moving);

}  // namespace patinate::capture
