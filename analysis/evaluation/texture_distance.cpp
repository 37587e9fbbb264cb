#include "analysis/evaluation/texture_distance.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/figures/spatial.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

namespace {

constexpr int kPatch = 7;
constexpr std::uint32_t kSamplePurpose = 0xE1, kDirectionPurpose = 0xE2;
constexpr std::size_t kQuantiles = 1000;

/// N vectors of `size` values, one after another.
struct Vectors {
  std::size_t size = 0;
  std::vector<float> values;
};

bool is_whole_patch(const TextureView& view, int x0, int y0) {
  const int w = view.codes.width();
  const auto chart = [&](int x, int y) {
    return view.chart.empty()
               ? 0
               : view.chart[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)];
  };
  const int first = chart(x0, y0);
  if (first < 0) return false;
  for (int y = y0; y < y0 + kPatch; ++y) {
    for (int x = x0; x < x0 + kPatch; ++x) {
      if (!is_inside(view.mask, x, y) || chart(x, y) != first) return false;
    }
  }
  return true;
}

/// Draws with replacement, so that both sides have equally many. @param n  Of places to choose from.
template <class Append>
Vectors draw(std::size_t n, std::size_t size, const TextureDistanceOptions& options, std::uint32_t side,
             Append&& append) {
  Vectors out{.size = size, .values = {}};
  out.values.reserve(size * static_cast<std::size_t>(options.num_samples));
  for (int k = 0; k < options.num_samples; ++k) {
    const double u = RandomStream(options.seed, static_cast<std::uint64_t>(k), kSamplePurpose + (side << 8)).uniform();
    append(std::min(static_cast<std::size_t>(u * static_cast<double>(n)), n - 1), out.values);
  }
  return out;
}

std::optional<Vectors> draw_patches(const TextureView& view, const TextureDistanceOptions& options,
                                    std::uint32_t side) {
  std::vector<std::array<int, 2>> places;
  for (int y = 0; y + kPatch <= view.codes.height(); ++y) {
    for (int x = 0; x + kPatch <= view.codes.width(); ++x) {
      if (is_whole_patch(view, x, y)) places.push_back({x, y});
    }
  }
  if (places.empty()) return std::nullopt;
  return draw(places.size(), kPatch * kPatch * 3, options, side, [&](std::size_t i, std::vector<float>& out) {
    const auto [x, y] = places[i];
    for (int row = y; row < y + kPatch; ++row) {
      const auto values = view.codes.row(row).subspan(static_cast<std::size_t>(x) * 3, kPatch * 3);
      out.insert(out.end(), values.begin(), values.end());
    }
  });
}

std::optional<Vectors> draw_joint(const TextureView& view, const TextureDistanceOptions& options, std::uint32_t side) {
  if (!view.control) throw InvalidInput("joint_distance() needs a control on both sides");
  std::vector<std::array<int, 2>> places;
  for (int y = 0; y < view.codes.height(); ++y) {
    for (int x = 0; x < view.codes.width(); ++x) {
      if (is_inside(view.mask, x, y)) places.push_back({x, y});
    }
  }
  if (places.empty()) return std::nullopt;
  return draw(places.size(), 4, options, side, [&](std::size_t i, std::vector<float>& out) {
    const auto [x, y] = places[i];
    const auto color = view.codes.pixel(x, y);
    out.insert(out.end(), color.begin(), color.end());
    out.push_back(255.0f * view.control->at(x, y));
  });
}

std::vector<double> direction(std::size_t size, std::uint64_t seed, std::size_t index) {
  RandomStream random(seed, index, kDirectionPurpose);
  std::vector<double> d(size);
  double length = 0.0;
  for (double& v : d) {
    v = random.normal();
    length += v * v;
  }
  for (double& v : d) v /= std::sqrt(length);
  return d;
}

std::vector<double> projected(const Vectors& vectors, const std::vector<double>& d) {
  std::vector<double> out(vectors.values.size() / vectors.size);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const float* v = vectors.values.data() + i * vectors.size;
    double sum = 0.0;
    for (std::size_t k = 0; k < vectors.size; ++k) sum += static_cast<double>(v[k]) * d[k];
    out[i] = sum;
  }
  std::sort(out.begin(), out.end());
  return out;
}

double sliced(const Vectors& a, const Vectors& b, const TextureDistanceOptions& options, const RunControl& control) {
  const double sum = parallel_reduce(
      options.num_directions, 1, control, 0.0,
      [&](std::int64_t begin, std::int64_t) {
        const std::vector<double> d = direction(a.size, options.seed, static_cast<std::size_t>(begin));
        const std::vector<double> p = projected(a, d), q = projected(b, d);
        double distance = 0.0;
        for (std::size_t i = 0; i < p.size(); ++i) distance += std::abs(p[i] - q[i]);
        return distance / static_cast<double>(p.size());
      },
      [](double x, double y) { return x + y; });
  return sum / options.num_directions;
}

std::vector<double> gradient_lengths(const TextureView& view) {
  std::vector<double> lengths;
  const int w = view.codes.width();
  const auto luma = [&](int x, int y) { return static_cast<double>(luminance(view.codes.pixel(x, y))); };
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x);
  };
  for (int y = 0; y + 1 < view.codes.height(); ++y) {
    for (int x = 0; x + 1 < w; ++x) {
      if (!is_inside(view.mask, x, y) || !is_inside(view.mask, x + 1, y) || !is_inside(view.mask, x, y + 1)) continue;
      if (!view.chart.empty() &&
          (view.chart[at(x, y)] != view.chart[at(x + 1, y)] || view.chart[at(x, y)] != view.chart[at(x, y + 1)]))
        continue;
      lengths.push_back(std::hypot(luma(x + 1, y) - luma(x, y), luma(x, y + 1) - luma(x, y)));
    }
  }
  std::sort(lengths.begin(), lengths.end());
  return lengths;
}

/// The power in every ring, or nothing.
struct Spectrum {
  std::vector<double> frequencies, power;
};
Spectrum spectrum_of(const TextureView& view) {
  ColorStack stack;
  stack.width = view.codes.width();
  stack.height = view.codes.height();
  stack.times = {0.0};
  for (int y = 0; y < stack.height; ++y) {
    for (int x = 0; x < stack.width; ++x) {
      if (!is_inside(view.mask, x, y)) continue;
      stack.texels.push_back(static_cast<std::uint32_t>(y * stack.width + x));
      std::array<double, 3> linear{};
      for (std::size_t c = 0; c < 3; ++c)
        linear[c] = static_cast<double>(linear_from_srgb(view.codes.pixel(x, y)[c] / 255.0f));
      for (double v : lab_from_linear(linear[0], linear[1], linear[2])) stack.lab.push_back(static_cast<float>(v));
    }
  }
  if (stack.texels.empty()) return {};
  const BlockGrid grid = make_blocks(stack, 1);
  const SpatialStructure structure(stack, 0, grid);
  return {structure.frequencies(), structure.spectrum(grid.all())};
}

}  // namespace

std::optional<double> patch_distance(const TextureView& a, const TextureView& b, const TextureDistanceOptions& options,
                                     const RunControl& control) {
  const std::optional<Vectors> from = draw_patches(a, options, 0), to = draw_patches(b, options, 1);
  if (!from || !to) return std::nullopt;
  return sliced(*from, *to, options, control);
}

std::optional<double> joint_distance(const TextureView& a, const TextureView& b, const TextureDistanceOptions& options,
                                     const RunControl& control) {
  const std::optional<Vectors> from = draw_joint(a, options, 0), to = draw_joint(b, options, 1);
  if (!from || !to) return std::nullopt;
  return sliced(*from, *to, options, control);
}

std::optional<double> gradient_distance(const TextureView& a, const TextureView& b) {
  const std::vector<double> p = gradient_lengths(a), q = gradient_lengths(b);
  if (p.empty() || q.empty()) return std::nullopt;
  const auto quantile = [](const std::vector<double>& sorted, std::size_t i) {
    const double rank = (static_cast<double>(i) + 0.5) / kQuantiles * static_cast<double>(sorted.size()) - 0.5;
    const double low = std::clamp(std::floor(rank), 0.0, static_cast<double>(sorted.size() - 1));
    const auto k = static_cast<std::size_t>(low);
    const double next = sorted[std::min(k + 1, sorted.size() - 1)];
    return sorted[k] + std::clamp(rank - low, 0.0, 1.0) * (next - sorted[k]);
  };
  double sum = 0.0;
  for (std::size_t i = 0; i < kQuantiles; ++i) sum += std::abs(quantile(p, i) - quantile(q, i));
  return sum / kQuantiles;
}

std::optional<double> spectrum_distance(const TextureView& a, const TextureView& b) {
  const Spectrum p = spectrum_of(a), q = spectrum_of(b);
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < p.power.size(); ++i) {
    for (std::size_t j = 0; j < q.power.size(); ++j) {  // Tiles of another size have fewer of the same rings.
      if (std::abs(p.frequencies[i] - q.frequencies[j]) > 1e-9 * p.frequencies[i] || !(p.power[i] > 0.0) ||
          !(q.power[j] > 0.0))
        continue;
      sum += std::abs(std::log10(p.power[i] / q.power[j]));
      ++count;
    }
  }
  return count > 0 ? std::optional(sum / count) : std::nullopt;
}

}  // namespace patinate::analysis
