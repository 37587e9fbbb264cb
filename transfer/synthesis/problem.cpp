#include "transfer/synthesis/problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <tuple>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "libcommon/core/parallel.h"

namespace patinate {

Neighborhood Neighborhood::square(int radius_px) {
  if (radius_px < 1 || radius_px > 5) throw InvalidInput("neighborhood: " + std::to_string(radius_px) + " is out of range; use [1, 5]");
  Neighborhood n;
  n.radius_px = radius_px;
  for (int y = -radius_px; y <= radius_px; ++y) {
    for (int x = -radius_px; x <= radius_px; ++x) {
      if (x == 0 && y == 0) continue;
      // A tent, 16 beside the texel: the nearest neighbours say most. Sums stay below 1024 up to radius 5.
      const int tent = (radius_px + 1 - std::abs(x)) * (radius_px + 1 - std::abs(y));
      n.offsets.push_back({x, y});
      n.weights.push_back(static_cast<std::int16_t>(std::max(1, 16 * tent / (radius_px * (radius_px + 1)))));
    }
  }
  return n;
}

namespace {

int grid_index(std::span<const std::uint16_t> controls) {
  constexpr int kStepsPerCell = kControlSteps / SourceLevel::kGridSide + 1;
  return controls[1] / kStepsPerCell * SourceLevel::kGridSide + controls[0] / kStepsPerCell;
}

std::span<const std::uint16_t> controls_of(const ControlImage& controls, std::int64_t pixel) {
  const auto n = static_cast<std::size_t>(controls.channels());
  return controls.values().subspan(static_cast<std::size_t>(pixel) * n, n);
}

/// Sorts the usable pixels into cells and leads every empty cell to the nearest filled one.
void fill_grid(SourceLevel& level) {
  constexpr int kSide = SourceLevel::kGridSide;
  level.grid_begin.assign(kSide * kSide + 1, 0);
  level.grid_pixels.resize(level.usable.size());
  const auto cell = [&](std::int32_t p) { return static_cast<std::size_t>(grid_index(controls_of(level.controls, p))); };
  for (std::int32_t p : level.usable) ++level.grid_begin[cell(p) + 1];
  for (std::size_t c = 1; c < level.grid_begin.size(); ++c) level.grid_begin[c] += level.grid_begin[c - 1];
  std::vector<std::int32_t> next(level.grid_begin.begin(), level.grid_begin.end() - 1);
  for (std::int32_t p : level.usable) level.grid_pixels[static_cast<std::size_t>(next[cell(p)]++)] = p;

  std::vector<std::int32_t> filled;
  for (int c = 0; c < kSide * kSide; ++c) {
    if (level.grid_begin[static_cast<std::size_t>(c)] < level.grid_begin[static_cast<std::size_t>(c) + 1]) filled.push_back(c);
  }
  for (int c = 0; c < kSide * kSide; ++c) {
    const auto squared = [&](std::int32_t f) {
      const int dx = f % kSide - c % kSide, dy = f / kSide - c / kSide;
      return dx * dx + dy * dy;
    };
    level.grid_cell.push_back(*std::min_element(filled.begin(), filled.end(), [&](auto a, auto b) { return squared(a) < squared(b); }));
  }
}

}  // namespace

std::span<const std::int32_t> SourceLevel::similar(std::span<const std::uint16_t> target, int tolerance) const {
  if (target.size() > 1) {
    const auto cell = static_cast<std::size_t>(grid_cell[static_cast<std::size_t>(grid_index(target))]);
    return {grid_pixels.begin() + grid_begin[cell], grid_pixels.begin() + grid_begin[cell + 1]};
  }
  const auto first_control = [this](std::int32_t p) { return int{controls_of(controls, p)[0]}; };
  const int value = target[0];
  auto begin = std::partition_point(usable.begin(), usable.end(), [&](std::int32_t p) { return first_control(p) < value - tolerance; });
  auto end = std::partition_point(begin, usable.end(), [&](std::int32_t p) { return first_control(p) <= value + tolerance; });
  if (begin == end) {  // The nearest values on either side.
    constexpr std::ptrdiff_t kFew = 16;
    begin -= std::min<std::ptrdiff_t>(kFew, begin - usable.begin());
    end += std::min<std::ptrdiff_t>(kFew, usable.end() - end);
  }
  return {begin, end};
}

namespace {

/// Per channel, over the usable pixels; at least one step squared.
std::vector<double> control_variances(const ControlImage& controls, std::span<const std::int32_t> pixels) {
  std::vector<double> result;
  for (int c = 0; c < controls.channels(); ++c) {
    double sum = 0.0, squares = 0.0;
    for (std::int32_t p : pixels) {
      const double v = controls.data()[static_cast<std::int64_t>(p) * controls.channels() + c];
      sum += v;
      squares += v * v;
    }
    const double n = static_cast<double>(pixels.size());
    result.push_back(std::max(1.0, squares / n - (sum / n) * (sum / n)));
  }
  return result;
}

}  // namespace

SourceLevel make_source_level(AppearanceImage appearance, ControlImage controls, const ImageU8& mask,
                              double appearance_variance, const Neighborhood& neighborhood) {
  SourceLevel level;
  level.appearance = std::move(appearance);
  level.controls = std::move(controls);
  level.appearance_variance = std::max(1.0, appearance_variance);
  const int w = level.width(), h = level.height(), r = neighborhood.radius_px;
  // Usable = no masked pixel within the neighbourhood's square: a running count over rows, then over columns.
  Image<int> outside_in_row(w, h);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      for (int dx = -r; dx <= r; ++dx) outside_in_row.at(x, y) += !mask.contains(x + dx, y) || mask.at(x + dx, y) == 0;
    }
  }
  level.is_usable.assign(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), 0);
  for (int y = r; y < h - r; ++y) {
    for (int x = r; x < w - r; ++x) {
      int outside = 0;
      for (int dy = -r; dy <= r; ++dy) outside += outside_in_row.at(x, y + dy);
      if (outside > 0) continue;
      const std::int32_t pixel = y * w + x;
      level.is_usable[static_cast<std::size_t>(pixel)] = 1;
      level.usable.push_back(pixel);
    }
  }
  if (level.usable.empty()) throw InvalidInput("the history has no pixel whose neighbourhood lies in its mask; give a larger mask");
  std::stable_sort(level.usable.begin(), level.usable.end(), [&](std::int32_t a, std::int32_t b) {
    const int n = level.controls.channels();
    return level.controls.data()[std::int64_t{a} * n] < level.controls.data()[std::int64_t{b} * n];
  });
  level.control_variances = control_variances(level.controls, level.usable);
  if (level.controls.channels() > 1) fill_grid(level);
  return level;
}

DestinationLevel make_destination_level(std::shared_ptr<const TexelMap> map, ControlImage controls,
                                        const Neighborhood& neighborhood, double source_pixel_mm, const RunControl& control) {
  DestinationLevel level;
  std::vector<Vec2> offsets_mm;
  for (const Offset& o : neighborhood.offsets) offsets_mm.emplace_back(o.x * source_pixel_mm, o.y * source_pixel_mm);
  level.neighbors = std::make_shared<TexelNeighborhood>(*map, std::move(offsets_mm), control);
  for (TexelId t = 0; t < map->num_texels(); ++t) {
    if (map->is_covered(t)) level.texels.push_back(t);
  }
  level.map = std::move(map);
  level.controls = std::move(controls);
  return level;
}

EnergyScale EnergyScale::make(const SourceLevel& source, double coherence_share, std::span<const double> control_weights) {
  EnergyScale scale;
  scale.coherence_share = coherence_share;
  scale.appearance_variance = source.appearance_variance;
  double sum = 0.0;
  for (double w : control_weights) sum += w;
  for (std::size_t c = 0; c < control_weights.size(); ++c) {
    scale.control_scale.push_back(static_cast<std::int64_t>(
        kOne * (1.0 - coherence_share) * control_weights[c] / (sum * 2.0 * source.control_variances[c])));
  }
  return scale;
}

std::int64_t EnergyScale::coherence_scale(int sum_of_weights) const {
  if (sum_of_weights == 0) return 0;
  return static_cast<std::int64_t>(kOne * coherence_share / (sum_of_weights * 2.0 * appearance_variance));
}

TexelCost::TexelCost(const SourceLevel& source, const DestinationLevel& destination, const Neighborhood& neighborhood)
    : source_(source), destination_(destination), neighborhood_(neighborhood), neighbors_(neighborhood.offsets.size()) {
  appearance_.resize(neighbors_.size() * kAppearanceSize);
  weight_.resize(neighbors_.size());
  delta_.resize(neighbors_.size());
}

void TexelCost::prepare(TexelId texel, const CoordinateMap& coordinates, const EnergyScale& scale) {
  destination_.neighbors->gather(texel, neighbors_);
  int sum_of_weights = 0;
  num_known_ = 0;
  for (std::size_t k = 0; k < neighbors_.size(); ++k) {
    // Where texels are larger than the offset, a texel would be its own neighbour: that says nothing.
    const bool is_other = neighbors_[k] >= 0 && neighbors_[k] != texel;
    const std::int32_t s = is_other ? coordinates[static_cast<std::size_t>(neighbors_[k])] : -1;
    if (s < 0) continue;
    const auto i = static_cast<std::size_t>(num_known_++);
    std::copy_n(source_.appearance.data() + std::int64_t{s} * kAppearanceSize, kAppearanceSize,
                appearance_.data() + i * kAppearanceSize);
    weight_[i] = neighborhood_.weights[k];
    delta_[i] = (neighborhood_.offsets[k].y * source_.width() + neighborhood_.offsets[k].x) * kAppearanceSize;
    sum_of_weights += neighborhood_.weights[k];
  }
  coherence_scale_ = scale.coherence_scale(sum_of_weights);
  control_scale_ = scale.control_scale;
  target_ = destination_.target(texel);
}

std::int64_t TexelCost::control(std::int32_t source_pixel) const {
  const std::uint16_t* value = source_.controls.data() + std::int64_t{source_pixel} * source_.controls.channels();
  std::int64_t cost = 0;
  for (std::size_t c = 0; c < target_.size(); ++c) {
    const std::int64_t difference = std::int64_t{value[c]} - target_[c];
    cost += difference * difference * control_scale_[c];
  }
  return cost;
}

std::int64_t TexelCost::coherence(std::int32_t source_pixel) const {
  const std::int16_t* base = source_.appearance.data() + std::int64_t{source_pixel} * kAppearanceSize;
  const auto n = static_cast<std::size_t>(num_known_);
  // |difference| <= 1022, weights <= 16 and 1024 in all: a lane of two components stays below 2^31.
#if defined(__SSE2__)
  __m128i sum = _mm_setzero_si128();
  for (std::size_t k = 0; k < n; ++k) {
    const __m128i known = _mm_loadu_si128(reinterpret_cast<const __m128i*>(appearance_.data() + k * kAppearanceSize));
    const __m128i candidate = _mm_loadu_si128(reinterpret_cast<const __m128i*>(base + delta_[k]));
    const __m128i difference = _mm_sub_epi16(known, candidate);
    sum = _mm_add_epi32(sum, _mm_madd_epi16(difference, _mm_mullo_epi16(difference, _mm_set1_epi16(weight_[k]))));
  }
  alignas(16) std::array<std::int32_t, 4> lanes{};
  _mm_store_si128(reinterpret_cast<__m128i*>(lanes.data()), sum);
  const std::int64_t total = std::int64_t{lanes[0]} + lanes[1] + lanes[2] + lanes[3];
#else
  std::int64_t total = 0;
  for (std::size_t k = 0; k < n; ++k) {
    std::int32_t squares = 0;
    for (std::size_t d = 0; d < kAppearanceSize; ++d) {
      const std::int32_t difference = appearance_[k * kAppearanceSize + d] - base[delta_[k] + static_cast<std::int32_t>(d)];
      squares += difference * difference;
    }
    total += std::int64_t{squares} * weight_[k];
  }
#endif
  return total * coherence_scale_;
}

std::int64_t TexelCost::total(std::int32_t source_pixel, std::int64_t bound) const {
  const std::int64_t cost = control(source_pixel);
  return cost >= bound ? cost : cost + coherence(source_pixel);
}

namespace {

/// Sums over a chunk of texels; integers where order could matter, doubles reduced in fixed order.
struct EnergySums {
  double coherence = 0.0, control = 0.0, error = 0.0;
  std::int64_t pairs = 0, coherent_pairs = 0;
  std::vector<std::int64_t> error_histogram = std::vector<std::int64_t>(kControlSteps + 1, 0);

  static EnergySums merge(EnergySums a, const EnergySums& b) {
    a.coherence += b.coherence;
    a.control += b.control;
    a.error += b.error;
    a.pairs += b.pairs;
    a.coherent_pairs += b.coherent_pairs;
    for (std::size_t i = 0; i < a.error_histogram.size(); ++i) a.error_histogram[i] += b.error_histogram[i];
    return a;
  }
};

/// Adds the pairs (t, right) and (t, below) of one texel.
void count_coherent_pairs(const DestinationLevel& destination, const SourceLevel& source, const CoordinateMap& coordinates,
                          TexelId t, EnergySums& sums) {
  const int w = destination.map->width();
  const auto chart = destination.map->chart(t);
  const auto count = [&](TexelId neighbor, int dx, int dy) {
    if (destination.map->chart(neighbor) != chart) return;
    const std::int32_t a = coordinates[static_cast<std::size_t>(t)], b = coordinates[static_cast<std::size_t>(neighbor)];
    ++sums.pairs;
    sums.coherent_pairs += b % source.width() - a % source.width() == dx && b / source.width() - a / source.width() == dy;
  };
  if (t % w + 1 < w) count(t + 1, 1, 0);
  if (t + w < destination.map->num_texels()) count(t + w, 0, 1);
}

}  // namespace

EnergyReport measure_energy(const SourceLevel& source, const DestinationLevel& destination, const Neighborhood& neighborhood,
                            const CoordinateMap& coordinates, double coherence_share, std::span<const double> control_weights,
                            const RunControl& control) {
  // Each part with the full weight, so that the report does not depend on rounding by a.
  const EnergyScale coherence_only = EnergyScale::make(source, 1.0, control_weights);
  const EnergyScale control_only = EnergyScale::make(source, 0.0, control_weights);
  const auto n = static_cast<std::int64_t>(destination.texels.size());
  const EnergySums sums = parallel_reduce(
      n, 16384, control, EnergySums{},
      [&](std::int64_t begin, std::int64_t end) {
        EnergySums part;
        TexelCost coherence(source, destination, neighborhood), mismatch(source, destination, neighborhood);
        for (std::int64_t i = begin; i < end; ++i) {
          const TexelId t = destination.texels[static_cast<std::size_t>(i)];
          const std::int32_t s = coordinates[static_cast<std::size_t>(t)];
          coherence.prepare(t, coordinates, coherence_only);
          mismatch.prepare(t, coordinates, control_only);
          part.coherence += static_cast<double>(coherence.coherence(s)) / EnergyScale::kOne;
          part.control += static_cast<double>(mismatch.control(s)) / EnergyScale::kOne;
          const int difference = std::abs(int{source.controls.data()[std::int64_t{s} * source.controls.channels()]} -
                                          int{destination.controls.data()[t * destination.controls.channels()]});
          part.error += static_cast<double>(difference) / kControlSteps;
          ++part.error_histogram[static_cast<std::size_t>(difference)];
          count_coherent_pairs(destination, source, coordinates, t, part);
        }
        return part;
      },
      [](EnergySums a, const EnergySums& b) { return EnergySums::merge(std::move(a), b); });

  EnergyReport report;
  if (n == 0) return report;
  const double count = static_cast<double>(n);
  report.coherence = sums.coherence / count;
  report.control_mismatch = sums.control / count;
  report.energy = coherence_share * report.coherence + (1.0 - coherence_share) * report.control_mismatch;
  report.control_error_mean = sums.error / count;
  std::int64_t below = 0;
  for (std::size_t i = 0; i < sums.error_histogram.size() && below < (n * 95 + 99) / 100; ++i) {
    below += sums.error_histogram[i];
    report.control_error_p95 = static_cast<double>(i) / kControlSteps;
  }
  report.coherent_share = sums.pairs > 0 ? static_cast<double>(sums.coherent_pairs) / static_cast<double>(sums.pairs) : 1.0;
  std::vector<std::uint8_t> is_used(source.is_usable.size(), 0);
  for (TexelId t : destination.texels) is_used[static_cast<std::size_t>(coordinates[static_cast<std::size_t>(t)])] = 1;
  report.used_share = static_cast<double>(std::count(is_used.begin(), is_used.end(), 1)) / static_cast<double>(source.usable.size());
  return report;
}

}  // namespace patinate
