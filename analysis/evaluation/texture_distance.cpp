#include "analysis/evaluation/texture_distance.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>
#include <utility>

#include "analysis/figures/spatial.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

namespace {

constexpr int kPatch = 7;  ///< px (docs/algorithms/evaluation.md, M4).
constexpr std::size_t kPatchPixels = kPatch * kPatch;
constexpr double kGradientBin = 1.0 / 1024.0;  ///< Width of a bin, of full scale.
constexpr std::uint32_t kSamplePurpose = 0xE1, kDirectionPurpose = 0xE2;
constexpr std::size_t kQuantiles = 1000;  ///< Quantiles of the two distributions.

/// N vectors of `size` values, one after another.
struct Vectors {
  std::size_t size = 0;
  std::vector<float> values;
};

/// Places (x, y) of whole patches. @param chart_at  Of a pixel; -1 outside.
template <class ChartAt, class Visit>
void for_each_patch(int width, int height, const ChartAt& chart_at, const Visit& visit) {
  // By column: how many pixels upward, and by row from the left, are of one chart.
  std::vector<int> above(static_cast<std::size_t>(width));
  std::vector<int> row(static_cast<std::size_t>(width), -1), row_before(static_cast<std::size_t>(width), -1);
  for (int y = 0; y < height; ++y) {
    row.swap(row_before);
    int run = 0;  // Columns that are whole from the left.
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(x);
      row[i] = chart_at(x, y);
      above[i] = row[i] < 0 ? 0 : y > 0 && row_before[i] == row[i] ? above[i] + 1 : 1;
      const bool goes_on = x > 0 && row[i] >= 0 && row[i] == row[i - 1];
      run = above[i] < kPatch ? 0 : goes_on ? run + 1 : 1;
      if (run >= kPatch) visit(x - kPatch + 1, y - kPatch + 1);
    }
  }
}

auto chart_of(const SynthesisSource& source) {
  return [mask = &source.mask](int x, int y) { return is_inside(*mask, x, y) ? 0 : -1; };
}
auto chart_of(const TexelMap& surface, const TexelRect& rect) {
  return [map = &surface, x0 = rect.x0, y0 = rect.y0](int x, int y) {
    return map->chart(TexelId{y0 + y} * map->width() + x0 + x);
  };
}

/// Place that is drawn from `n`: with replacement, so that both sides have equally many.
std::int64_t drawn_place(std::int64_t n, int number, const TextureDistanceOptions& options, std::uint32_t side) {
  const double u =
      RandomStream(options.seed, static_cast<std::uint64_t>(number), kSamplePurpose + (side << 8)).uniform();
  return std::min(static_cast<std::int64_t>(u * static_cast<double>(n)), n - 1);
}

/// The draws from [first, first + own) of `all` places, by place: (place in the part, number of the draw).
std::vector<std::pair<std::int64_t, std::int64_t>> draws_among(std::int64_t first, std::int64_t own, std::int64_t all,
                                                               const TextureDistanceOptions& options) {
  std::vector<std::pair<std::int64_t, std::int64_t>> draws;
  for (int k = 0; k < options.num_samples && all > 0; ++k) {
    const std::int64_t place = drawn_place(all, k, options, 1) - first;
    if (place >= 0 && place < own) draws.emplace_back(place, k);
  }
  std::sort(draws.begin(), draws.end());
  return draws;
}

/// Draws from the source itself. @param append  Called with a place and what to append to.
template <class Place, class Append>
std::optional<Vectors> draw_source(const std::vector<Place>& places, std::size_t size,
                                   const TextureDistanceOptions& options, std::uint32_t side, const Append& append) {
  if (places.empty()) return std::nullopt;
  Vectors out{.size = size, .values = {}};
  out.values.reserve(size * static_cast<std::size_t>(options.num_samples));
  for (int k = 0; k < options.num_samples; ++k) {
    const std::int64_t place = drawn_place(static_cast<std::int64_t>(places.size()), k, options, side);
    append(places[place], out.values);
  }
  return out;
}

std::optional<Vectors> draw_patches(const SynthesisSource& source, const ImageF& frame,
                                    const TextureDistanceOptions& options, std::uint32_t side) {
  std::vector<std::array<int, 2>> places;
  for_each_patch(frame.width(), frame.height(), chart_of(source), [&](int x, int y) { places.push_back({x, y}); });
  return draw_source(places, kPatchPixels * 3, options, side,
                     [&](const std::array<int, 2>& place, std::vector<float>& out) {
                       for (int row = place[1]; row < place[1] + kPatch; ++row) {
                         const auto values = frame.row(row).subspan(static_cast<std::size_t>(place[0]) * 3, kPatch * 3);
                         out.insert(out.end(), values.begin(), values.end());
                       }
                     });
}

std::optional<Vectors> draw_joint(const SynthesisSource& source, const ImageF& frame,
                                  const TextureDistanceOptions& options, std::uint32_t side) {
  if (source.control.empty()) throw InvalidInput("joint_distance() needs a control on both sides");
  std::vector<std::array<int, 2>> places;
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      if (is_inside(source.mask, x, y)) places.push_back({x, y});
    }
  }
  return draw_source(places, 4, options, side, [&](const std::array<int, 2>& place, std::vector<float>& out) {
    const auto color = frame.pixel(place[0], place[1]);
    out.insert(out.end(), color.begin(), color.end());
    out.push_back(255.0f * source.control.at(place[0], place[1]));
  });
}

/// The drawn pixels as vectors, by the number of their draw. @param per_draw  Pixels. @param controls  May be empty.
std::optional<Vectors> vectors_of(const ImageF& frame, const std::vector<std::int64_t>& numbers,
                                  const std::vector<std::int32_t>& pixels, std::size_t per_draw,
                                  const std::vector<float>& controls) {
  if (numbers.empty()) return std::nullopt;
  Vectors out{.size = per_draw * 3 + (controls.empty() ? 0 : 1), .values = {}};
  out.values.resize(out.size * numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    float* to = out.values.data() + static_cast<std::size_t>(numbers[i]) * out.size;
    for (std::size_t k = 0; k < per_draw; ++k)
      std::copy_n(frame.data() + std::int64_t{pixels[i * per_draw + k]} * 3, 3, to + 3 * k);
    if (!controls.empty()) to[out.size - 1] = 255.0f * controls[i];
  }
  return out;
}

Eigen::VectorXd direction(std::size_t size, std::uint64_t seed, std::size_t index) {
  RandomStream random(seed, index, kDirectionPurpose);
  Eigen::VectorXd d(static_cast<Eigen::Index>(size));
  for (double& v : d) v = random.normal();
  return d.normalized();
}

/// The projections of all vectors, ascending: one column for each direction.
Eigen::MatrixXd projected(const Vectors& vectors, const Eigen::MatrixXd& directions) {
  const auto size = static_cast<Eigen::Index>(vectors.size),
             count = static_cast<Eigen::Index>(vectors.values.size()) / size;
  const Eigen::Map<const Eigen::MatrixXf> columns(vectors.values.data(), size, count);
  Eigen::MatrixXd out = columns.cast<double>().transpose() * directions;
  for (auto column : out.colwise()) std::sort(column.begin(), column.end());
  return out;
}

double sliced(const Vectors& a, const Vectors& b, const TextureDistanceOptions& options, const RunControl& control) {
  constexpr std::int64_t kTogether = 16;  // Directions of one matrix product.
  const double sum = parallel_reduce(
      options.num_directions, kTogether, control, 0.0,
      [&](std::int64_t begin, std::int64_t end) {
        Eigen::MatrixXd directions(a.size, end - begin);
        for (std::int64_t i = begin; i < end; ++i)
          directions.col(i - begin) = direction(a.size, options.seed, static_cast<std::size_t>(i));
        return (projected(a, directions) - projected(b, directions)).cwiseAbs().colwise().mean().sum();
      },
      [](double x, double y) { return x + y; });
  return sum / options.num_directions;
}

/// @param value_at  Luma at (x, y). @param chart_at  Of it; -1 outside.
template <class LumaAt, class ChartAt>
ValueCounts gradient_counts(int width, int height, const LumaAt& luma_at, const ChartAt& chart_at) {
  ValueCounts counts(kGradientBin);
  const auto values_of = [&](int y, std::vector<double>& luma, std::vector<int>& chart) {
    luma.assign(static_cast<std::size_t>(width), 0.0);
    chart.assign(static_cast<std::size_t>(width), -1);
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(x);
      chart[i] = chart_at(x, y);
      if (chart[i] >= 0) luma[i] = luma_at(x, y);
    }
  };
  std::vector<double> luma, luma_below;
  std::vector<int> chart, chart_below;
  if (height > 0) values_of(0, luma_below, chart_below);
  for (int y = 0; y + 1 < height; ++y) {
    luma.swap(luma_below);
    chart.swap(chart_below);
    values_of(y + 1, luma_below, chart_below);
    for (std::size_t i = 0; i + 1 < chart.size(); ++i) {
      if (chart[i] < 0 || chart[i + 1] != chart[i] || chart_below[i] != chart[i]) continue;
      counts.add(std::hypot(luma[i + 1] - luma[i], luma_below[i] - luma[i]));
    }
  }
  return counts;
}

double luma_of(const ImageF& frame, std::int64_t pixel) {
  return static_cast<double>(luminance(std::span<const float>(frame.data() + 3 * pixel, 3)));
}

float texture_lightness(const ImageF& frame, std::int64_t pixel) {
  std::array<double, 3> linear{};
  for (std::size_t c = 0; c < 3; ++c)
    linear[c] = static_cast<double>(linear_from_srgb(frame.data()[3 * pixel + static_cast<std::int64_t>(c)] / 255.0f));
  return static_cast<float>(lab_from_linear(linear[0], linear[1], linear[2])[0]);
}

/// A stack of L* alone. @param pixel_of  Of the frame; -1 outside.
template <class PixelOf>
SpectrumSums spectrum_of(int width, int height, const ImageF& frame, const PixelOf& pixel_of) {
  ColorStack stack;
  stack.width = width;
  stack.height = height;
  stack.times = {0.0};
  for (std::int64_t i = 0; i < std::int64_t{width} * height; ++i) {
    const std::int64_t pixel = pixel_of(i);
    if (pixel < 0) continue;
    stack.texels.push_back(static_cast<std::uint32_t>(i));
    stack.lab.insert(stack.lab.end(), {texture_lightness(frame, pixel), 0.0f, 0.0f});
  }
  if (stack.texels.empty()) return {};
  const BlockGrid grid = make_blocks(stack, 1);
  const SpatialStructure structure(stack, 0, grid, SpatialFigures::Spectrum);
  SpectrumSums sums{.num_tiles = static_cast<double>(structure.num_tiles()),
                    .frequencies = structure.frequencies(),
                    .power = structure.spectrum(grid.all())};
  for (double& power : sums.power) power *= sums.num_tiles;
  return sums;
}

}  // namespace

PartCounts count_part(const TexelMap& surface, const TexelRect& rect) {
  PartCounts counts;
  std::set<int> charts;
  int last = -1;
  for_each_patch(rect.width(), rect.height(), chart_of(surface, rect), [&](int, int) { ++counts.patches; });
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      const int chart = surface.chart(TexelId{y} * surface.width() + x);
      if (chart < 0) continue;
      ++counts.texels;
      if (chart != last) charts.insert(chart);
      last = chart;
    }
  }
  counts.charts = static_cast<std::int64_t>(charts.size());
  return counts;
}

void TextureDraws::add(const TextureDraws& other) {
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  append(patch_numbers, other.patch_numbers);
  append(texel_numbers, other.texel_numbers);
  append(patches, other.patches);
  append(texels, other.texels);
  append(controls, other.controls);
}

TextureDraws draw_texture(const MapPart& part, const ImageF& source_control, const PartCounts& before,
                          const PartCounts& all, const TextureDistanceOptions& options) {
  TextureDraws out;
  const PartCounts own = count_part(part.surface, part.rect);
  const auto patches = draws_among(before.patches, own.patches, all.patches, options),
             texels = draws_among(before.texels, own.texels, all.texels, options);
  std::int64_t place = 0;
  auto next = patches.begin();
  for_each_patch(part.rect.width(), part.rect.height(), chart_of(part.surface, part.rect), [&](int x0, int y0) {
    for (; next != patches.end() && next->first == place; ++next) {
      out.patch_numbers.push_back(next->second);
      for (int y = y0; y < y0 + kPatch; ++y) {
        for (int x = x0; x < x0 + kPatch; ++x)
          out.patches.push_back(part.indices.of(part.texel(std::int64_t{y} * part.rect.width() + x)));
      }
    }
    ++place;
  });
  place = 0;
  next = texels.begin();
  part.for_each_covered([&](TexelId t, std::int64_t i) {
    for (; next != texels.end() && next->first == place; ++next) {
      out.texel_numbers.push_back(next->second);
      out.texels.push_back(part.indices.of(t));
      if (!part.control.empty())
        out.controls.push_back(part.control.data()[i]);
      else if (!source_control.empty())
        out.controls.push_back(source_control.data()[part.indices.of(t)]);
    }
    ++place;
  });
  return out;
}

std::optional<double> patch_distance(const SynthesisSource& source, const ImageF& frame, const TextureDraws* made,
                                     const TextureDistanceOptions& options, const RunControl& control) {
  const std::optional<Vectors> from = draw_patches(source, frame, options, 0),
                               to = made ? vectors_of(frame, made->patch_numbers, made->patches, kPatchPixels, {})
                                         : draw_patches(source, frame, options, 1);
  if (!from || !to) return std::nullopt;
  return sliced(*from, *to, options, control);
}

std::optional<double> joint_distance(const SynthesisSource& source, const ImageF& frame, const TextureDraws* made,
                                     const TextureDistanceOptions& options, const RunControl& control) {
  const std::optional<Vectors> from = draw_joint(source, frame, options, 0),
                               to = made ? vectors_of(frame, made->texel_numbers, made->texels, 1, made->controls)
                                         : draw_joint(source, frame, options, 1);
  if (!from || !to) return std::nullopt;
  return sliced(*from, *to, options, control);
}

ValueCounts count_gradients(const SynthesisSource& source, const ImageF& frame) {
  return gradient_counts(
      frame.width(), frame.height(), [&](int x, int y) { return luma_of(frame, std::int64_t{y} * frame.width() + x); },
      chart_of(source));
}

ValueCounts count_gradients(const MapPart& part, const ImageF& frame) {
  return gradient_counts(
      part.rect.width(), part.rect.height(),
      [&](int x, int y) {
        return luma_of(frame, part.indices.of(part.texel(std::int64_t{y} * part.rect.width() + x)));
      },
      chart_of(part.surface, part.rect));
}

std::optional<double> gradient_distance(const ValueCounts& a, const ValueCounts& b) {
  if (a.total() == 0 || b.total() == 0) return std::nullopt;
  const auto quantiles_of = [](const ValueCounts& counts) {
    std::vector<double> shares;
    std::vector<std::int64_t> ranks;
    const auto last = static_cast<double>(counts.total() - 1);
    for (std::size_t i = 0; i < kQuantiles; ++i) {
      const double rank = (static_cast<double>(i) + 0.5) / kQuantiles * static_cast<double>(counts.total()) - 0.5,
                   low = std::clamp(std::floor(rank), 0.0, last);
      shares.push_back(std::clamp(rank - low, 0.0, 1.0));
      ranks.push_back(static_cast<std::int64_t>(low));
      ranks.push_back(std::min(ranks.back() + 1, counts.total() - 1));
    }
    std::vector<double> lower, upper, out;
    std::vector<std::int64_t> some(kQuantiles);
    for (std::size_t i = 0; i < kQuantiles; ++i) some[i] = ranks[2 * i];
    lower = counts.at_ranks(some);
    for (std::size_t i = 0; i < kQuantiles; ++i) some[i] = ranks[2 * i + 1];
    upper = counts.at_ranks(some);
    for (std::size_t i = 0; i < kQuantiles; ++i) out.push_back(lower[i] + shares[i] * (upper[i] - lower[i]));
    return out;
  };
  const std::vector<double> p = quantiles_of(a), q = quantiles_of(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < kQuantiles; ++i) sum += std::abs(p[i] - q[i]);
  return sum / kQuantiles;
}

void SpectrumSums::add(const SpectrumSums& other) {
  if (other.power.empty()) return;
  if (power.empty()) {
    *this = other;
    return;
  }
  num_tiles += other.num_tiles;
  for (std::size_t i = 0; i < power.size(); ++i) power[i] += other.power[i];
}

SpectrumSums measure_spectrum(const SynthesisSource& source, const ImageF& frame) {
  return spectrum_of(frame.width(), frame.height(), frame, [&](std::int64_t i) {
    return source.mask.empty() || source.mask.data()[i] != 0 ? i : std::int64_t{-1};
  });
}

SpectrumSums measure_spectrum(const MapPart& part, const ImageF& frame) {
  // Without the margins, so that the grid of tiles begins where a picture's does.
  const int m = part.surface.sheet().margin(), width = part.rect.width() - 2 * m, height = part.rect.height() - 2 * m;
  return spectrum_of(width, height, frame, [&](std::int64_t i) {
    const TexelId t = part.texel((i / width + m) * part.rect.width() + i % width + m);
    return part.surface.is_covered(t) ? std::int64_t{part.indices.of(t)} : std::int64_t{-1};
  });
}

std::optional<double> spectrum_distance(const SpectrumSums& a, const SpectrumSums& b) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < a.power.size(); ++i) {
    for (std::size_t j = 0; j < b.power.size(); ++j) {  // Tiles of another size have fewer of the same rings.
      if (std::abs(a.frequencies[i] - b.frequencies[j]) > 1e-9 * a.frequencies[i] || !(a.power[i] > 0.0) ||
          !(b.power[j] > 0.0))
        continue;
      sum += std::abs(std::log10(a.power[i] / a.num_tiles / (b.power[j] / b.num_tiles)));
      ++count;
    }
  }
  return count > 0 ? std::optional(sum / count) : std::nullopt;
}

}  // namespace patinate::analysis
