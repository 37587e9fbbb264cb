#include "transfer/synthesis/energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <mutex>
#include <utility>

#include "libcommon/core/parallel.h"
#include "transfer/synthesis/window_kernel.h"

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

void TexelCost::prepare(TexelId texel, const CoordinateMap& coordinates, const EnergyScale& scale, Turn turn) {
  visit(texel);
  if (turn != 0) {  // Neighbors of the texel lie turned in the source.
    turned_.assign(neighbors_.begin(), neighbors_.end());
    for (PixelNeighbor& n : turned_) {
      const FixedPoint p = turned({n.x, n.y}, turn);
      n.x = static_cast<std::int16_t>(p.x), n.y = static_cast<std::int16_t>(p.y);
    }
    neighbors_ = turned_;
    texel_ = -1;
  }
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
    if (known_at_[k] >= 0 && window_kernel::lies_at(n, o.x, o.y)) ++num_in_place[quarter_of(o)];
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
  return search_kernel::cost_of_pixel(&source_tables_, &cost_tables_, target_.data(), &known_, source_pixel, bound);
}

std::int64_t TexelCost::total_beside(std::int32_t source_pixel, int beside_x, int beside_y, std::int64_t bound) const {
  return search_kernel::cost_beside(&source_tables_, &cost_tables_, target_.data(), &known_, source_pixel, beside_x,
                                    beside_y, bound);
}

void EnergyFigures::Sum::add(std::int64_t cost) {
  high += cost >> 32;
  low += cost & 0xFFFFFFFF;
}

double EnergyFigures::Sum::mean(std::int64_t count) const {
  return (std::ldexp(static_cast<double>(high), 32) + static_cast<double>(low)) / EnergyScale::kOne /
         static_cast<double>(count);
}

namespace {

void add_each(std::vector<std::int64_t>& sums, const std::vector<std::int64_t>& others) {
  std::transform(sums.begin(), sums.end(), others.begin(), sums.begin(), std::plus<>());
}

}  // namespace

void EnergyFigures::add(const EnergyFigures& other) {
  for (auto [sum, more] : {std::pair{&coherence, &other.coherence}, {&control, &other.control}}) {
    sum->high += more->high;
    sum->low += more->low;
  }
  num_texels += other.num_texels;
  difference += other.difference;
  pairs += other.pairs;
  coherent_pairs += other.coherent_pairs;
  add_each(differences, other.differences);
  add_each(wanted, other.wanted);
  add_each(missed, other.missed);
  is_used.resize(std::max(is_used.size(), other.is_used.size()));
  for (std::size_t p = 0; p < other.is_used.size(); ++p) is_used[p] |= other.is_used[p];
}

namespace {

/// Means of the error over quarters of the texels by what is asked for; texels of one value count as often as a quarter
/// needs.
std::array<double, 4> error_quarters(const EnergyFigures& figures) {
  const double total = static_cast<double>(figures.num_texels);
  std::array<double, 4> means{};
  double before = 0.0;
  for (std::size_t v = 0; v < figures.wanted.size(); ++v) {
    if (figures.wanted[v] == 0) continue;
    const double count = static_cast<double>(figures.wanted[v]);
    const double error = static_cast<double>(figures.missed[v]) / count / kControlSteps;
    for (std::size_t q = 0; q < means.size(); ++q) {
      const double begin = static_cast<double>(q) * total / 4.0, end = static_cast<double>(q + 1) * total / 4.0;
      const double shared = std::min(before + count, end) - std::max(before, begin);
      if (shared > 0.0) means[q] += error * shared / (total / 4.0);
    }
    before += count;
  }
  return means;
}

/// Adds the pairs (t, right) and (t, below) of one texel.
void count_coherent_pairs(const DestinationLevel& destination, const SourceLevel& source,
                          const CoordinateMap& coordinates, TexelId t, Turn turn, EnergyFigures& figures) {
  // Tolerance of a pixel, or of a texel where that is more: both ends are rounded to half of one.
  const double tolerance =
      0.99 * std::max(1.0, destination.map->median_texel_size_mm() / destination.neighbors->pixel_mm());
  const int w = destination.map->width();
  const auto chart = destination.map->chart(t);
  const Eigen::Matrix2d steps =
      Eigen::Rotation2Dd(radians_of(turn)) * destination.neighbors->pixels_per_texel(destination.map->triangle(t));
  const auto count = [&](TexelId neighbor, int column) {
    if (destination.map->chart(neighbor) != chart) return;
    const std::int32_t a = coordinates[t], b = coordinates[neighbor];
    const Vec2 expected = steps.col(column);
    const Vec2 error =
        Vec2(b % source.width() - a % source.width(), b / source.width() - a / source.width()) - expected;
    ++figures.pairs;
    figures.coherent_pairs += error.cwiseAbs().maxCoeff() <= tolerance;
  };
  if (t % w + 1 < w) count(t + 1, 0);
  if (t + w < destination.map->num_texels()) count(t + w, 1);
}

}  // namespace

EnergyScale full_scale(const SourceLevel& source, std::span<const double> control_weights) {
  EnergyScale parts = EnergyScale::make(source, 1.0, control_weights);
  parts.control_scale = EnergyScale::make(source, 0.0, control_weights).control_scale;
  return parts;
}

EnergyFigures measure_figures(const SourceLevel& source, const DestinationLevel& destination,
                              const Neighborhood& neighborhood, const CoordinateMap& coordinates,
                              std::span<const double> control_weights, const RunControl& control, const CostSums* sums,
                              std::span<const Turn> turns) {
  const EnergyScale parts = full_scale(source, control_weights);
  EnergyFigures all;
  std::mutex all_mutex;
  parallel_for(static_cast<std::int64_t>(destination.texels.size()), 16384, control,
               [&](std::int64_t begin, std::int64_t end) {
                 EnergyFigures some;
                 TexelCost cost(source, destination, neighborhood);
                 auto at = destination.texels.from(static_cast<std::size_t>(begin));
                 for (std::int64_t i = begin; i < end; ++i, ++at) {
                   const TexelId t = *at;
                   const std::int32_t s = coordinates[t];
                   const Turn turn = turns.empty() ? Turn{0} : turns[t];
                   if (sums == nullptr) {
                     cost.prepare(t, coordinates, parts, turn);
                     some.coherence.add(cost.coherence(s));
                     some.control.add(cost.control(s));
                   }
                   const int wanted = destination.target(t)[0];
                   const int missed =
                       std::abs(int{source.controls.data()[std::int64_t{s} * source.controls.channels()]} - wanted);
                   ++some.wanted[wanted];
                   some.missed[wanted] += missed;
                   some.difference += missed;
                   ++some.differences[missed];
                   count_coherent_pairs(destination, source, coordinates, t, turn, some);
                 }
                 some.num_texels = end - begin;
                 const std::lock_guard lock(all_mutex);
                 all.add(some);
               });
  if (sums != nullptr) {
    all.coherence = sums->coherence;
    all.control = sums->control;
  }
  all.is_used.assign(source.is_usable.size(), 0);
  for (TexelId t : destination.texels) all.is_used[coordinates[static_cast<std::size_t>(t)]] = 1;
  return all;
}

EnergyReport EnergyFigures::report(const SourceLevel& source, double coherence_share) const {
  EnergyReport report;
  if (num_texels == 0) return report;
  report.coherence = coherence.mean(num_texels);
  report.control_mismatch = control.mean(num_texels);
  report.energy = coherence_share * report.coherence + (1.0 - coherence_share) * report.control_mismatch;
  report.control_error_mean = static_cast<double>(difference) / kControlSteps / static_cast<double>(num_texels);
  std::int64_t below = 0;
  for (std::size_t i = 0; i < differences.size() && below < (num_texels * 95 + 99) / 100; ++i) {
    below += differences[i];
    report.control_error_p95 = static_cast<double>(i) / kControlSteps;
  }
  report.control_error_quarters = error_quarters(*this);
  report.coherent_share = pairs > 0 ? static_cast<double>(coherent_pairs) / static_cast<double>(pairs) : 1.0;
  report.used_share =
      static_cast<double>(std::count(is_used.begin(), is_used.end(), 1)) / static_cast<double>(source.usable.size());
  return report;
}

EnergyReport measure_energy(const SourceLevel& source, const DestinationLevel& destination,
                            const Neighborhood& neighborhood, const CoordinateMap& coordinates, double coherence_share,
                            std::span<const double> control_weights, const RunControl& control, const CostSums* sums,
                            std::span<const Turn> turns) {
  return measure_figures(source, destination, neighborhood, coordinates, control_weights, control, sums, turns)
      .report(source, coherence_share);
}

}  // namespace patinate::transfer
