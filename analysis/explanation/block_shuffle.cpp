#include "analysis/explanation/block_shuffle.h"

#include <numeric>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::analysis {

namespace {

constexpr std::uint32_t kShufflePurpose = 0x5f1e;  ///< Keeps these draws apart from other uses of the seed.

/// Offsets from the block's middle in the plane that it is widest in.
std::vector<Vec2> flattened(std::span<const Vec3> positions_mm, const std::vector<std::uint32_t>& members) {
  const auto n = static_cast<double>(members.size());
  Vec3 middle = Vec3::Zero();
  for (const std::uint32_t i : members) middle += positions_mm[i] / n;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const std::uint32_t i : members) {
    const Vec3 d = positions_mm[i] - middle;
    spread += d * d.transpose();
  }
  const SymmetricEigen<Eigen::Matrix3d> solver = symmetric_eigen(spread);
  const Vec3 first = solver.vectors.col(2), second = solver.vectors.col(1);
  std::vector<Vec2> flat;
  flat.reserve(members.size());
  for (const std::uint32_t i : members) {
    const Vec3 d = positions_mm[i] - middle;
    flat.emplace_back(d.dot(first), d.dot(second));
  }
  return flat;
}

std::uint32_t nearest(const Vec2& place, const std::vector<Vec2>& others) {
  std::size_t best = 0;
  for (std::size_t j = 1; j < others.size(); ++j) {
    if ((others[j] - place).squaredNorm() < (others[best] - place).squaredNorm()) best = j;
  }
  return static_cast<std::uint32_t>(best);
}

}  // namespace

BlockShuffles::BlockShuffles(std::span<const Vec3> positions_mm, const SurfaceBlocks& blocks, const RunControl& control)
    : num_samples_(positions_mm.size()), members_(blocks.members), taken_(members_.size() * members_.size()) {
  std::vector<std::vector<Vec2>> flat;
  flat.reserve(members_.size());
  for (const auto& list : members_) flat.push_back(flattened(positions_mm, list));
  parallel_for(static_cast<std::int64_t>(members_.size()), 1, control, [&](std::int64_t begin, std::int64_t) {
    const auto a = static_cast<std::size_t>(begin);
    for (std::size_t b = 0; b < members_.size(); ++b) {
      std::vector<std::uint32_t>& taken = taken_[a * members_.size() + b];
      taken.reserve(members_[a].size());
      for (const Vec2& place : flat[a]) taken.push_back(members_[b][nearest(place, flat[b])]);
    }
  });
}

std::vector<std::uint32_t> BlockShuffles::shuffled(std::uint64_t seed, std::uint64_t number) const {
  std::vector<std::size_t> order(members_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  RandomStream random(seed, number, kShufflePurpose);
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  std::vector<std::uint32_t> from(num_samples_);
  for (std::size_t a = 0; a < members_.size(); ++a) {
    const std::vector<std::uint32_t>& taken = taken_[a * members_.size() + order[a]];
    for (std::size_t i = 0; i < taken.size(); ++i) from[members_[a][i]] = taken[i];
  }
  return from;
}

}  // namespace patinate::analysis
