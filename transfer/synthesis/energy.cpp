#include "transfer/synthesis/energy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <numeric>
#include <utility>

#include "libcommon/core/parallel.h"

namespace patinate::transfer {

EnergyScale EnergyScale::make(const SourceLevel& source, double coherence_share,
                              std::span<const double> control_weights) {
  EnergyScale scale;
  scale.coherence_scales.push_back(0);
  for (int sum = 1; sum <= Neighborhood::kLargestSum; ++sum) {
    scale.coherence_scales.push_back(
        static_cast<std::int64_t>(kOne * coherence_share / (sum * 2.0 * source.appearance_variance)));
  }
  double sum_of_controls = 0.0;
  for (double w : control_weights) sum_of_controls += w;
  for (std::size_t c = 0; c < control_weights.size(); ++c) {
    scale.control_scale.push_back(static_cast<std::int64_t>(kOne * (1.0 - coherence_share) * control_weights[c] /
                                                            (sum_of_controls * 2.0 * source.control_variances[c])));
  }
  return scale;
}

search_kernel::CostTables cost_tables(const Neighborhood& neighborhood, const EnergyScale& scale) {
  return {.weights = neighborhood.weights.data(),
          .coherence_scales = scale.coherence_scales.data(),
          .control_scales = scale.control_scale.data(),
          .num_neighbors = static_cast<std::int32_t>(neighborhood.weights.size()),
          .radius_px = neighborhood.radius_px,
          .num_controls = static_cast<std::int32_t>(scale.control_scale.size())};
}

TexelCost::TexelCost(const SourceLevel& source, const DestinationLevel& destination, const Neighborhood& neighborhood)
    : source_(source),
      destination_(destination),
      neighborhood_(neighborhood),
      cursor_(*destination.neighbors),
      known_at_(neighborhood.offsets.size()),
      source_tables_(source_tables(source)) {
  known_.num = 0;
}

void TexelCost::visit(TexelId texel) {
  if (texel == texel_) return;
  neighbors_ = cursor_.at(texel);
  texel_ = texel;
}

void TexelCost::prepare(TexelId texel, const CoordinateMap& coordinates, const EnergyScale& scale) {
  visit(texel);
  cost_tables_ = cost_tables(neighborhood_, scale);
  std::fill(known_at_.begin(), known_at_.end(), -1);
  search_kernel::gather_known(&source_tables_, &cost_tables_, coordinates.data(), texel, neighbors_.data(), &known_,
                              known_at_.data());
  control_scale_ = scale.control_scale;
  cost_tables_.control_scales = control_scale_.data();
  target_ = destination_.target(texel);
}

unsigned TexelCost::whole_quarters() const {
  std::array<std::size_t, kNumQuarters> num_in_place{};
  for (std::size_t k = 0; k < known_at_.size(); ++k) {
    const Offset& o = neighborhood_.offsets[k];
    const PixelNeighbor& n = neighbors_[k];
    if (known_at_[k] >= 0 && whole_pixels(n.x) == o.x && whole_pixels(n.y) == o.y) ++num_in_place[quarter_of(o)];
  }
  unsigned whole = 0;
  for (unsigned q = 0; q < kNumQuarters; ++q) {
    if (kNumQuarters * num_in_place[q] == neighborhood_.offsets.size()) whole |= 1U << q;
  }
  return whole;
}

void TexelCost::appearances(std::span<std::int16_t> out) const {
  for (std::size_t k = 0; k < known_at_.size(); ++k) {
    std::copy_n(known_.appearance + std::max(0, known_at_[k]) * kAppearanceSize, kAppearanceSize,
                out.data() + k * kAppearanceSize);
  }
}

std::int64_t TexelCost::control(std::int32_t source_pixel) const {
  return search_kernel::control_cost(&source_tables_, &cost_tables_, target_.data(), source_pixel);
}

ControlInterval TexelCost::first_control_within(std::int64_t cost) const {
  const std::int64_t scale = first_control_scale();
  if (scale == 0) return {};
  const std::int64_t squared = cost / scale;
  auto reach = static_cast<std::int64_t>(std::sqrt(static_cast<double>(squared)));
  while (reach * reach > squared) --reach;  // The root is rounded.
  while ((reach + 1) * (reach + 1) <= squared) ++reach;
  return {static_cast<std::uint16_t>(std::max<std::int64_t>(0, target_[0] - reach)),
          static_cast<std::uint16_t>(std::min<std::int64_t>(kControlSteps, target_[0] + reach))};
}

std::int64_t TexelCost::coherence(std::int32_t source_pixel) const {
  return search_kernel::coherence_cost(&source_tables_, &known_, known_.delta, known_.weight, source_pixel,
                                       std::numeric_limits<std::int64_t>::max());
}

std::int64_t TexelCost::total(std::int32_t source_pixel, std::int64_t bound) const {
  return total_beside(source_pixel, 0, 0, bound);
}

std::int64_t TexelCost::total_beside(std::int32_t source_pixel, int beside_x, int beside_y, std::int64_t bound) const {
  return search_kernel::cost_beside(&source_tables_, &cost_tables_, target_.data(), &known_, source_pixel, beside_x,
                                    beside_y, bound);
}

namespace {

/// Sums over a chunk of texels, reduced in fixed order.
struct EnergySums {
  double coherence = 0.0, control = 0.0, error = 0.0;
  std::int64_t pairs = 0, coherent_pairs = 0;

  static EnergySums merge(EnergySums a, const EnergySums& b) {
    a.coherence += b.coherence;
    a.control += b.control;
    a.error += b.error;
    a.pairs += b.pairs;
    a.coherent_pairs += b.coherent_pairs;
    return a;
  }
};

/// Of the first control: how often a value is asked for, and by how much it is missed in all. Integers: the order of
/// the chunks does not matter.
struct ControlErrors {
  std::vector<std::int64_t> counts = std::vector<std::int64_t>(kControlSteps + 1, 0);
  std::vector<std::int64_t> sums = std::vector<std::int64_t>(kControlSteps + 1, 0);

  void add(int wanted, int difference) {
    ++counts[static_cast<std::size_t>(wanted)];
    sums[static_cast<std::size_t>(wanted)] += difference;
  }
  void add(const ControlErrors& other) {
    for (std::size_t v = 0; v < counts.size(); ++v) {
      counts[v] += other.counts[v];
      sums[v] += other.sums[v];
    }
  }
  /// Means over quarters of the texels by what is asked for; texels of one value count as often as a quarter needs.
  [[nodiscard]] std::array<double, 4> quarters() const {
    const double total = static_cast<double>(std::accumulate(counts.begin(), counts.end(), std::int64_t{0}));
    std::array<double, 4> means{};
    double before = 0.0;
    for (std::size_t v = 0; v < counts.size(); ++v) {
      if (counts[v] == 0) continue;
      const double count = static_cast<double>(counts[v]);
      const double error = static_cast<double>(sums[v]) / count / kControlSteps;
      for (std::size_t q = 0; q < means.size(); ++q) {
        const double begin = static_cast<double>(q) * total / 4.0, end = static_cast<double>(q + 1) * total / 4.0;
        const double shared = std::min(before + count, end) - std::max(before, begin);
        if (shared > 0.0) means[q] += error * shared / (total / 4.0);
      }
      before += count;
    }
    return means;
  }
};

/// Adds the pairs (t, right) and (t, below) of one texel.
void count_coherent_pairs(const DestinationLevel& destination, const SourceLevel& source,
                          const CoordinateMap& coordinates, TexelId t, EnergySums& sums) {
  // Of a pixel, or of a texel where that is more: both ends are rounded to half of one.
  const double tolerance =
      0.99 * std::max(1.0, destination.map->median_texel_size_mm() / destination.neighbors->pixel_mm());
  const int w = destination.map->width();
  const auto chart = destination.map->chart(t);
  const Eigen::Matrix2d steps = destination.neighbors->pixels_per_texel(destination.map->triangle(t));
  const auto count = [&](TexelId neighbor, int column) {
    if (destination.map->chart(neighbor) != chart) return;
    const std::int32_t a = coordinates[static_cast<std::size_t>(t)],
                       b = coordinates[static_cast<std::size_t>(neighbor)];
    const Vec2 expected = steps.col(column);
    const Vec2 error =
        Vec2(b % source.width() - a % source.width(), b / source.width() - a / source.width()) - expected;
    ++sums.pairs;
    sums.coherent_pairs += error.cwiseAbs().maxCoeff() <= tolerance;
  };
  if (t % w + 1 < w) count(t + 1, 0);
  if (t + w < destination.map->num_texels()) count(t + w, 1);
}

}  // namespace

EnergyReport measure_energy(const SourceLevel& source, const DestinationLevel& destination,
                            const Neighborhood& neighborhood, const CoordinateMap& coordinates, double coherence_share,
                            std::span<const double> control_weights, const RunControl& control) {
  // Each part with the full weight, so that the report does not depend on rounding by a.
  EnergyScale parts = EnergyScale::make(source, 1.0, control_weights);
  parts.control_scale = EnergyScale::make(source, 0.0, control_weights).control_scale;
  const auto n = static_cast<std::int64_t>(destination.texels.size());
  std::vector<std::int64_t> error_histogram(kControlSteps + 1, 0);  // Counts: the order of the chunks does not matter.
  ControlErrors control_errors;
  std::mutex histogram_mutex;
  const EnergySums sums = parallel_reduce(
      n, 16384, control, EnergySums{},
      [&](std::int64_t begin, std::int64_t end) {
        EnergySums part;
        std::vector<std::int32_t> errors(kControlSteps + 1, 0);
        ControlErrors by_value;
        TexelCost cost(source, destination, neighborhood);
        auto at = destination.texels.from(static_cast<std::size_t>(begin));
        for (std::int64_t i = begin; i < end; ++i, ++at) {
          const TexelId t = *at;
          const std::int32_t s = coordinates[static_cast<std::size_t>(t)];
          cost.prepare(t, coordinates, parts);
          part.coherence += static_cast<double>(cost.coherence(s)) / EnergyScale::kOne;
          part.control += static_cast<double>(cost.control(s)) / EnergyScale::kOne;
          const int wanted = destination.controls.data()[t * destination.controls.channels()];
          const int difference =
              std::abs(int{source.controls.data()[std::int64_t{s} * source.controls.channels()]} - wanted);
          by_value.add(wanted, difference);
          part.error += static_cast<double>(difference) / kControlSteps;
          ++errors[static_cast<std::size_t>(difference)];
          count_coherent_pairs(destination, source, coordinates, t, part);
        }
        const std::lock_guard lock(histogram_mutex);
        for (std::size_t e = 0; e < errors.size(); ++e) error_histogram[e] += errors[e];
        control_errors.add(by_value);
        return part;
      },
      EnergySums::merge);

  EnergyReport report;
  if (n == 0) return report;
  const double count = static_cast<double>(n);
  report.coherence = sums.coherence / count;
  report.control_mismatch = sums.control / count;
  report.energy = coherence_share * report.coherence + (1.0 - coherence_share) * report.control_mismatch;
  report.control_error_mean = sums.error / count;
  std::int64_t below = 0;
  for (std::size_t i = 0; i < error_histogram.size() && below < (n * 95 + 99) / 100; ++i) {
    below += error_histogram[i];
    report.control_error_p95 = static_cast<double>(i) / kControlSteps;
  }
  report.control_error_quarters = control_errors.quarters();
  report.coherent_share =
      sums.pairs > 0 ? static_cast<double>(sums.coherent_pairs) / static_cast<double>(sums.pairs) : 1.0;
  std::vector<std::uint8_t> is_used(source.is_usable.size(), 0);
  for (TexelId t : destination.texels) is_used[static_cast<std::size_t>(coordinates[static_cast<std::size_t>(t)])] = 1;
  report.used_share =
      static_cast<double>(std::count(is_used.begin(), is_used.end(), 1)) / static_cast<double>(source.usable.size());
  return report;
}

}  // namespace patinate::transfer
