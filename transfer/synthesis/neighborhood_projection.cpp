#include "transfer/synthesis/neighborhood_projection.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "libcommon/core/random.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::transfer {

namespace {

using window_kernel::kAxisBits;

/// Columns that span the leading eigenvectors of a symmetric matrix, by falling eigenvalue [Golub and Van Loan,
/// sec. 8.2.4]; no matter how nearly: bounds hold for any axes.
Eigen::MatrixXf leading_axes(const Eigen::MatrixXf& matrix, Eigen::Index count) {
  // Columns beyond those wanted, for faster convergence [Halko et al. 2011].
  constexpr Eigen::Index kExtra = 5;
  // Steps of subspace iteration; a fixed number, so that equal input gives equal bits.
  constexpr int kIterations = 10;
  const Eigen::Index n = matrix.rows(), columns = std::min(n, count + kExtra);
  Eigen::MatrixXf basis(n, columns);
  for (Eigen::Index k = 0; k < columns; ++k) {
    RandomStream random(0, static_cast<std::uint64_t>(k), 61);
    for (Eigen::Index i = 0; i < n; ++i) basis(i, k) = static_cast<float>(random.uniform() - 0.5);
  }
  basis = orthonormal_columns(basis);
  for (int i = 0; i < kIterations; ++i) basis = orthonormal_columns(matrix * basis);
  const SymmetricEigen<Eigen::MatrixXf> solver = symmetric_eigen(Eigen::MatrixXf(basis.transpose() * matrix * basis));
  return (basis * solver.vectors).rowwise().reverse().leftCols(std::min(count, columns));
}

}  // namespace

NeighborhoodProjection::NeighborhoodProjection(const SourceLevel& source, const Neighborhood& neighborhood, Parts parts)
    : source_(source) {
  const std::size_t size = neighborhood.offsets.size() * kAppearanceSize,
                    num_parts = parts == Parts::Whole ? 1 : kNumQuarters;
  const std::size_t values = std::tuple_size_v<ProjectedNeighborhood> / num_parts;
  for (std::size_t p = 0; p < num_parts; ++p)
    parts_.push_back(
        {.first_value = p * values, .num_axes = values - 1, .weights = std::vector<std::int16_t>(size, 0)});
  for (std::size_t k = 0; k < neighborhood.offsets.size(); ++k) {
    const Offset& o = neighborhood.offsets[k];
    deltas_.push_back((o.y * source.width() + o.x) * kAppearanceSize);
    std::fill_n(
        parts_[num_parts == 1 ? 0 : quarter_of(o)].weights.begin() + static_cast<std::ptrdiff_t>(k * kAppearanceSize),
        kAppearanceSize, neighborhood.weights[k]);
  }
  rows_.assign(std::tuple_size_v<ProjectedNeighborhood> * size, 0);
  for (const Part& part : parts_) find_axes(source, part);
  for (const Part& part : parts_)
    std::copy(part.weights.begin(), part.weights.end(), row_of(part.first_value + part.num_axes));
}

void NeighborhoodProjection::gather(std::int32_t pixel, std::span<std::int16_t> appearances) const {
  const std::int16_t* base = source_.appearance.data() + std::int64_t{pixel} * kAppearanceSize;
  for (std::size_t k = 0; k < deltas_.size(); ++k)
    std::copy_n(base + deltas_[k], kAppearanceSize, appearances.data() + k * kAppearanceSize);
}

void NeighborhoodProjection::find_axes(const SourceLevel& source, const Part& part) {
  constexpr std::size_t kNumSamples = 2048;  // Neighborhoods that the axes are computed from, evenly picked.
  const std::size_t size = part.weights.size(), count = std::min(kNumSamples, source.usable.size());
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < size; ++i) {
    if (part.weights[i] > 0) members.push_back(i);
  }
  const auto n = static_cast<Eigen::Index>(members.size());
  const auto root = [&](Eigen::Index m) { return std::sqrt(static_cast<double>(part.weights[members[m]])); };
  Eigen::MatrixXf samples(n, static_cast<Eigen::Index>(count));
  std::vector<std::int16_t> around(size);
  for (std::size_t s = 0; s < count; ++s) {
    gather(source.usable[s * source.usable.size() / count], around);
    for (Eigen::Index m = 0; m < n; ++m)
      samples(m, static_cast<Eigen::Index>(s)) = static_cast<float>(around[members[m]] * root(m));
  }
  samples.colwise() -= samples.rowwise().mean().eval();
  Eigen::MatrixXf covariance = Eigen::MatrixXf::Zero(n, n);
  covariance.selfadjointView<Eigen::Lower>().rankUpdate(samples, 1.0F / static_cast<float>(count));
  covariance.triangularView<Eigen::StrictlyUpper>() = covariance.transpose();
  const Eigen::MatrixXf axes = leading_axes(covariance, static_cast<Eigen::Index>(part.num_axes));

  // Rows b_j = axis_j * sqrt(w) / 4. |B x|^2 <= sum w x^2 / 16 holds when the largest eigenvalue of B W^-1 B' is at
  // most 1/16.
  constexpr double kMargin = 1e-9;  // Far above the rounding of the sums below.
  for (double scale = 0.999;; scale *= 0.999) {
    for (std::size_t j = 0; j < part.num_axes; ++j) {
      for (Eigen::Index m = 0; m < n; ++m) {
        const double entry = static_cast<double>(axes(m, static_cast<Eigen::Index>(j))) * root(m) / kUnit;
        row_of(part.first_value + j)[members[m]] =
            static_cast<std::int16_t>(std::lround(std::ldexp(entry * scale, kAxisBits)));
      }
    }
    double largest = 0.0;
    for (std::size_t j = 0; j < part.num_axes; ++j) {
      double circle = 0.0;
      for (std::size_t k = 0; k < part.num_axes; ++k) {
        double product = 0.0;
        for (std::size_t i : members)
          product += static_cast<double>(int{row_of(part.first_value + j)[i]} * int{row_of(part.first_value + k)[i]}) /
                     part.weights[i];
        circle += std::abs(product);
      }
      largest = std::max(largest, std::ldexp(circle, -2 * kAxisBits));
    }
    if (largest <= (1.0 - kMargin) / (kUnit * kUnit)) return;
  }
}

ProjectedNeighborhood NeighborhoodProjection::of_pixel(std::int32_t pixel) const {
  std::array<std::int16_t, kMaxAppearances> appearances;
  const std::span<std::int16_t> around = std::span(appearances).first(deltas_.size() * kAppearanceSize);
  gather(pixel, around);
  return of(around);
}

ProjectedNeighborhood NeighborhoodProjection::of(std::span<const std::int16_t> appearances) const {
  const auto sum_of = [&](std::size_t value, bool is_rest) {
    const std::int16_t* row = rows_.data() + value * appearances.size();
    std::int32_t sum = 0;  // The rest is <= 1024 * 8 * 511^2 < 2^31.
    for (std::size_t i = 0; i < appearances.size(); ++i)
      sum += window_kernel::projection_term(appearances[i], row[i], is_rest);
    return sum;
  };
  ProjectedNeighborhood result{};
  for (const Part& part : parts_) {
    const std::size_t rest = part.first_value + part.num_axes;
    std::int64_t left = window_kernel::squared_length(sum_of(rest, true));
    for (std::size_t j = part.first_value; j < rest; ++j) {
      const std::int32_t sum = sum_of(j, false);
      result[j] = window_kernel::projected_value(sum);
      left -= std::int64_t{sum} * sum;
    }
    result[rest] = window_kernel::projected_rest(left);
  }
  return result;
}

}  // namespace patinate::transfer
