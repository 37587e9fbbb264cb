#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "libcommon/core/parallel.h"
#include "patinate/capture/thickness.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr int kHistogramLanes = 8;  ///< Histograms are padded with 0 to whole groups of this many bins.
/// A value belongs to a peak within this many range sigmas of it: 98.8 % of what the smoothing itself spreads.
constexpr double kPeakSigmas = 2.5;

/// Parts of the whole histogram, [0, 1].
struct PeakShares {
  float first = 0.0f;   ///< Mass within `reach` of the highest bin.
  float second = 0.0f;  ///< Mass of the other peak; 0 when there is none.
  int second_at = -1;   ///< Its highest bin; -1 when there is none.
};

constexpr float kValley = 0.5f;  ///< Between two peaks the histogram falls below this share of the lower one.

float sum_around(std::span<const float> histogram, int at, int reach) {
  const auto begin = histogram.begin() + std::max(0, at - reach);
  const auto end = histogram.begin() + std::min(static_cast<int>(histogram.size()), at + reach + 1);
  return std::accumulate(begin, end, 0.0f);
}

/// The highest bin on one side of `at` behind a valley; -1 when there is none. @param step  1 or -1.
int peak_on_side(std::span<const float> histogram, int at, int reach, int step) {
  const auto value = [&](int bin) { return histogram[bin]; };
  const int num_bins = static_cast<int>(histogram.size());
  int best = -1;
  float lowest = value(at);
  for (int bin = at + step; bin >= 0 && bin < num_bins; bin += step) {
    lowest = std::min(lowest, value(bin));
    const bool is_apart = std::abs(bin - at) > 2 * reach && lowest < kValley * value(bin);
    if (is_apart && (best < 0 || value(bin) > value(best))) best = bin;
  }
  return best;
}

/// The highest bin of (1 - t) a + t b, which becomes `blended`. The lowest one wins a tie.
/// @param a,b  As many bins as `blended`, which has whole lanes.
int highest_bin(const float* a, const float* b, float t, std::span<float> blended) {
  std::array<float, kHistogramLanes> best{};
  for (std::size_t bin = 0; bin < blended.size(); bin += kHistogramLanes) {
    for (std::size_t lane = 0; lane < kHistogramLanes; ++lane) {
      const float value = (1.0f - t) * a[bin + lane] + t * b[bin + lane];
      blended[bin + lane] = value;
      best[lane] = value > best[lane] ? value : best[lane];
    }
  }
  const float highest = *std::max_element(best.begin(), best.end());
  return static_cast<int>(std::find(blended.begin(), blended.end(), highest) - blended.begin());
}

/// Position of the peak around bin `at`, by a parabola through the logarithms of three bins (exact for a Gaussian
/// peak).
double refined_peak(std::span<const float> histogram, int at) {
  const std::size_t bin = at;
  if (at < 1 || bin + 2 > histogram.size() || !(histogram[bin - 1] > 0.0f) || !(histogram[bin + 1] > 0.0f)) return at;
  const float before = std::log(histogram[bin - 1] / histogram[bin]);
  const float after = std::log(histogram[bin + 1] / histogram[bin]);
  const float curvature = before + after;
  if (!(curvature < 0.0f)) return at;
  return at + static_cast<double>(std::clamp(0.5f * (before - after) / curvature, -0.5f, 0.5f));
}

/// The other peak is the highest one that shares no bin with the first and is parted from it by a valley of less than
/// half of its own height: the flank of a broad or sloping histogram is none.
/// @param at     highest_bin(). @param reach  Bins on either side that belong to a peak; >= 1.
PeakShares peak_shares(std::span<const float> histogram, int at, int reach) {
  const float total = std::accumulate(histogram.begin(), histogram.end(), 0.0f);
  if (!(total > 0.0f)) return {};
  PeakShares shares{.first = sum_around(histogram, at, reach) / total};
  for (int step : {-1, 1}) {
    const int other = peak_on_side(histogram, at, reach, step);
    const float share = other < 0 ? 0.0f : sum_around(histogram, other, reach) / total;
    if (share <= shares.second) continue;
    shares.second = share;
    shares.second_at = other;
  }
  return shares;
}

constexpr int kMarginBins = 2;          ///< Empty bins at either end, so that every peak has neighbors.
constexpr double kStepsPerSigma = 2.5;  ///< Layers are sampled this often per spatial sigma.
constexpr double kCutSigmas = 3.0;      ///< The Gaussian is 1 % of its middle there.
constexpr std::size_t kBandBytes = std::size_t{48} << 20;  ///< Memory of a band; results do not depend on it.

/// Symmetric Gaussian weights -radius..radius of sum 1.
std::vector<float> gaussian_kernel(double sigma) {
  const int radius = std::max(1, static_cast<int>(std::ceil(kCutSigmas * sigma)));
  std::vector<double> weights;
  double sum = 0.0;
  for (int k = -radius; k <= radius; ++k) sum += weights.emplace_back(std::exp(-0.5 * k * k / (sigma * sigma)));
  std::vector<float> kernel;
  for (double w : weights) kernel.push_back(static_cast<float>(w / sum));
  return kernel;
}

/// Where values and pixels fall among the bins and nodes.
struct Layout {
  double step = 1.0;    ///< Pixels between two nodes.
  int num_columns = 0;  ///< Nodes across; the last lies at or past the last pixel.
  int num_rows = 0;
  double low = 0.0;  ///< Value of bin 0.
  double bin_width = 1.0;
  int num_bins = 0;    ///< Padded to whole lanes.
  int peak_reach = 1;  ///< Bins on either side that belong to a peak.
  std::vector<float> spatial_kernel;
  std::vector<float> range_kernel;

  [[nodiscard]] int spatial_radius() const { return static_cast<int>(spatial_kernel.size() / 2); }
  [[nodiscard]] std::size_t row_size() const {
    return static_cast<std::size_t>(num_columns) * static_cast<std::size_t>(num_bins);
  }
};

Layout make_layout(const ImageF& in, double low, double high, const ModeFilterOptions& options) {
  Layout layout;
  const double window = options.spatial_sigma_px.value_or(kModeFilterWindow_px);
  layout.step = std::max(1.0, window / kStepsPerSigma);
  const auto num_nodes = [&](int length) { return static_cast<int>(std::floor((length - 1) / layout.step)) + 2; };
  layout.num_columns = num_nodes(in.width());
  layout.num_rows = num_nodes(in.height());
  layout.num_bins = (options.num_bins + kHistogramLanes - 1) / kHistogramLanes * kHistogramLanes;
  layout.bin_width = (high - low) / (options.num_bins - 1 - 2 * kMarginBins);
  layout.low = low - kMarginBins * layout.bin_width;
  // Linear weights between nodes add a variance of step^2 / 6 when splatting and again when reading; between bins once.
  const double sigma = window / layout.step;
  layout.spatial_kernel = gaussian_kernel(layout.step > 1.0 ? std::sqrt(sigma * sigma - 2.0 / 6.0) : sigma);
  const double range_sigma = std::max(1.0, options.range_sigma / layout.bin_width);
  layout.peak_reach = static_cast<int>(std::lround(kPeakSigmas * range_sigma));
  const double longest = layout.num_bins / kCutSigmas;
  layout.range_kernel = gaussian_kernel(std::min(longest, std::sqrt(range_sigma * range_sigma - 1.0 / 6.0)));
  return layout;
}

/// Histograms of one row of nodes: every pixel within a step of it, with linear weights.
void splat_row(const ImageF& in, const ImageU8& mask, const Layout& layout, int node_row, std::span<float> out) {
  std::fill(out.begin(), out.end(), 0.0f);
  const double center = node_row * layout.step;
  const int first = std::max(0, static_cast<int>(std::floor(center - layout.step)) + 1);
  const int last = std::min(in.height() - 1, static_cast<int>(std::ceil(center + layout.step)) - 1);
  const std::size_t num_bins = layout.num_bins;
  const double bins_per_unit = 1.0 / layout.bin_width;
  for (int y = first; y <= last; ++y) {
    const float weight_y = static_cast<float>(1.0 - std::abs(y - center) / layout.step);
    for (int x = 0; x < in.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      const double column = x / layout.step;
      const double bin = (static_cast<double>(in.at(x, y)) - layout.low) * bins_per_unit;
      const std::size_t c = static_cast<std::size_t>(column), b = static_cast<std::size_t>(bin);
      const float right = static_cast<float>(column - static_cast<double>(c)) * weight_y, left = weight_y - right;
      const float upper = static_cast<float>(bin - static_cast<double>(b));
      float* histogram = &out[c * num_bins + b];
      histogram[0] += left * (1.0f - upper);
      histogram[1] += left * upper;
      histogram[num_bins] += right * (1.0f - upper);
      histogram[num_bins + 1] += right * upper;
    }
  }
}

void add_scaled(float weight, const float* in, std::size_t size, float* out) {
  for (std::size_t i = 0; i < size; ++i) out[i] += weight * in[i];
}

/// Blurs along columns of nodes and along bins.
void blur_row(std::span<const float> in, const Layout& layout, std::span<float> out) {
  const std::size_t num_bins = layout.num_bins;
  const int radius = layout.spatial_radius(), range_radius = static_cast<int>(layout.range_kernel.size() / 2);
  std::vector<float> histogram(num_bins);
  std::fill(out.begin(), out.end(), 0.0f);
  for (int column = 0; column < layout.num_columns; ++column) {
    std::fill(histogram.begin(), histogram.end(), 0.0f);
    for (int k = std::max(-radius, -column); k <= std::min(radius, layout.num_columns - 1 - column); ++k) {
      add_scaled(layout.spatial_kernel[k + radius], &in[static_cast<std::size_t>(column + k) * num_bins], num_bins,
                 histogram.data());
    }
    float* target = &out[static_cast<std::size_t>(column) * num_bins];
    const int last_shift = std::min(range_radius, layout.num_bins - 1);
    for (int k = -last_shift; k <= last_shift; ++k) {
      const std::size_t from = static_cast<std::size_t>(std::max(0, -k)), to = static_cast<std::size_t>(std::max(0, k));
      add_scaled(layout.range_kernel[k + range_radius], &histogram[from],
                 num_bins - static_cast<std::size_t>(std::abs(k)), target + to);
    }
  }
}

/// Rows of nodes [first_row, first_row + rows.size()), a sliding part of the whole.
class NodeRows {
 public:
  NodeRows(std::size_t row_size, int capacity)
      : row_size_(row_size), values_(row_size * static_cast<std::size_t>(capacity)) {}
  /// Slot of a row; rows `capacity` apart share one.
  [[nodiscard]] std::span<float> row(int index) {
    const std::size_t capacity = values_.size() / row_size_;
    return std::span<float>(values_).subspan(static_cast<std::size_t>(index) % capacity * row_size_, row_size_);
  }

 private:
  std::size_t row_size_;
  std::vector<float> values_;
};

/// Where results go; `shares` may be missing.
struct FilterOutput {
  ImageF& values;
  ModeFilterResult* shares = nullptr;
};

void filter_pixel_row(const ImageU8& mask, const Layout& layout, int y, NodeRows& blurred, const FilterOutput& out) {
  const double node_row = y / layout.step;
  const int above = static_cast<int>(node_row);
  const float fraction = static_cast<float>(node_row - above);
  std::vector<float> histograms(layout.row_size());
  const auto upper = blurred.row(above), lower = blurred.row(above + 1);
  for (std::size_t i = 0; i < histograms.size(); ++i)
    histograms[i] = (1.0f - fraction) * upper[i] + fraction * lower[i];
  std::vector<float> blended(static_cast<std::size_t>(layout.num_bins));
  for (int x = 0; x < out.values.width(); ++x) {
    if (!is_inside(mask, x, y)) continue;
    const double column = x / layout.step;
    const int left = static_cast<int>(column);
    const float* a = &histograms[static_cast<std::size_t>(left) * static_cast<std::size_t>(layout.num_bins)];
    const int at = highest_bin(a, a + layout.num_bins, static_cast<float>(column - left), blended);
    out.values.at(x, y) = static_cast<float>(layout.low + refined_peak(blended, at) * layout.bin_width);
    if (out.shares == nullptr) continue;
    const PeakShares peaks = peak_shares(blended, at, layout.peak_reach);
    out.shares->share.at(x, y) = peaks.first;
    out.shares->second_share.at(x, y) = peaks.second;
    const int second = peaks.second_at < 0 ? at : peaks.second_at;
    out.shares->second_value.at(x, y) = static_cast<float>(layout.low + second * layout.bin_width);
  }
}

/// Smallest and largest value inside the mask. @throws InvalidInput
std::pair<float, float> checked_range(const ImageF& in, const ImageU8& mask) {
  bool is_any = false;
  float low = 0.0f, high = 0.0f;
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      const float value = in.at(x, y);
      if (!std::isfinite(value)) {
        throw InvalidInput("mode_filter: the value at (" + std::to_string(x) + ", " + std::to_string(y) +
                           ") is not finite; mask it out");
      }
      low = is_any ? std::min(low, value) : value;
      high = is_any ? std::max(high, value) : value;
      is_any = true;
    }
  }
  if (!is_any) throw InvalidInput("mode_filter: the mask is empty; it must cover at least one pixel");
  return {low, high};
}

/// One value everywhere: no histogram has a width.
void fill_constant(const ImageU8& mask, float value, const FilterOutput& out) {
  for (int y = 0; y < out.values.height(); ++y) {
    for (int x = 0; x < out.values.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      out.values.at(x, y) = value;
      if (out.shares == nullptr) continue;
      out.shares->share.at(x, y) = 1.0f;
      out.shares->second_value.at(x, y) = value;
    }
  }
}

void filter_into(const ImageF& in, const ImageU8& mask, const ModeFilterOptions& options, const FilterOutput& out,
                 const RunControl& control) {
  check_ranges(options);
  if (in.channels() != 1) throw InvalidInput("mode_filter: the image has several channels; give one");
  if (!mask.empty() && !in.same_size(mask)) throw InvalidInput("mode_filter: image and mask differ in size");
  const auto [low, high] = checked_range(in, mask);
  if (!(low < high)) {
    fill_constant(mask, low, out);
    control.report(1.0);
    return;
  }
  const Layout layout = make_layout(in, static_cast<double>(low), static_cast<double>(high), options);
  const int radius = layout.spatial_radius();
  const int rows_that_fit = static_cast<int>(kBandBytes / (layout.row_size() * sizeof(float)));
  const int band = std::min(std::max(rows_that_fit, 2), layout.num_rows - 1);  // Intervals between node rows at a time.
  NodeRows raw(layout.row_size(), band + 1 + 2 * radius), blurred(layout.row_size(), band + 1);
  const RunControl inner = control.silent();
  int num_splatted = 0, num_blurred = 0;
  for (int begin = 0; begin < layout.num_rows - 1; begin += band) {
    const int end =
        std::min(begin + band, layout.num_rows - 1);  // The pixels from node row `begin` up to node row `end`.
    const int splat_end = std::min(layout.num_rows, end + 1 + radius);
    parallel_for(splat_end - num_splatted, 1, inner, [&](std::int64_t i, std::int64_t) {
      const int row = num_splatted + static_cast<int>(i);
      splat_row(in, mask, layout, row, raw.row(row));
    });
    num_splatted = splat_end;
    parallel_for(end + 1 - num_blurred, 1, inner, [&](std::int64_t i, std::int64_t) {
      const int row = num_blurred + static_cast<int>(i);
      std::vector<float> sum(layout.row_size());
      for (int k = std::max(-radius, -row); k <= std::min(radius, layout.num_rows - 1 - row); ++k) {
        add_scaled(layout.spatial_kernel[k + radius], raw.row(row + k).data(), sum.size(), sum.data());
      }
      blur_row(sum, layout, blurred.row(row));
    });
    num_blurred = end + 1;
    const int first_y = static_cast<int>(std::ceil(begin * layout.step));
    const int last_y = std::min(in.height(), static_cast<int>(std::ceil(end * layout.step)));
    parallel_for(last_y - first_y, 4, inner, [&](std::int64_t i, std::int64_t i_end) {
      for (; i < i_end; ++i) filter_pixel_row(mask, layout, first_y + static_cast<int>(i), blurred, out);
    });
    control.report(static_cast<double>(end) / (layout.num_rows - 1));
  }
}

}  // namespace

void describe(OptionVisitor& v, ModeFilterOptions& o) {
  v.visit({"spatial_sigma",
           "Gaussian window of the mode filter, larger than the widest crack; default: chosen from the layer",
           "px",
           {0.5, 10000}},
          o.spatial_sigma_px);
  v.visit({"range_sigma", "Smoothing of the local histogram, in units of the image's value", "", above(0)},
          o.range_sigma);
  v.visit({"num_bins", "Bins of the local histogram; peaks are refined between them", "", between(16, 4096)},
          o.num_bins);
}

ImageF mode_filter(const ImageF& in, const ImageU8& mask, const ModeFilterOptions& options, const RunControl& control) {
  ImageF out(in.width(), in.height());
  filter_into(in, mask, options, {out}, control);
  return out;
}

ModeFilterResult mode_filter_shares(const ImageF& in, const ImageU8& mask, const ModeFilterOptions& options,
                                    const RunControl& control) {
  const ImageF empty(in.width(), in.height());
  ModeFilterResult result{empty, empty, empty, empty};
  filter_into(in, mask, options, {result.values, &result}, control);
  return result;
}

}  // namespace patinate::capture
