#include "capture/report/report_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>

#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr int kOutside = 0, kOutOfView = 1, kMasked = 2;  // Channels of ReportFrame::marks.

/// Where the middle nine tenths of counts lie. @param counts  Not all 0.
std::pair<int, int> middle_of(const std::vector<std::int64_t>& counts) {
  constexpr double kLeftOutEnd = 0.05;  // Share at both ends that the trimmed mean leaves out.
  std::int64_t total = 0, sum = 0;
  for (const std::int64_t n : counts) total += n;
  const double low = kLeftOutEnd * static_cast<double>(total), high = (1.0 - kLeftOutEnd) * static_cast<double>(total);
  std::pair<int, int> ends{-1, 0};
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (static_cast<double>(sum) < high) ends.second = static_cast<int>(i);
    sum += counts[i];
    if (ends.first < 0 && static_cast<double>(sum) > low) ends.first = static_cast<int>(i);
  }
  return ends;
}

/// @param own  The frame's own mask; may be empty.
void measure_mask(const ImageU8& own, ReportFrame& frame) {
  if (own.empty()) return;
  std::vector<std::int64_t> columns(static_cast<std::size_t>(own.width())),
      rows(static_cast<std::size_t>(own.height()));
  std::int64_t num_masked = 0;
  for (int y = 0; y < own.height(); ++y) {
    for (int x = 0; x < own.width(); ++x) {
      if (own.at(x, y) != 0) continue;
      ++columns[x], ++rows[y], ++num_masked;
    }
  }
  if (num_masked == 0) return;
  frame.masked_share = static_cast<double>(num_masked) / static_cast<double>(own.num_pixels());
  const auto [left, right] = middle_of(columns);
  const auto [top, bottom] = middle_of(rows);
  frame.masked_at = PixelSpan{left, right, top, bottom};
}

std::optional<std::array<double, 3>> mean_lab(const ImageF& color, const ImageU8& mask, const ImageU8& own) {
  std::array<double, 3> sum{};
  std::int64_t count = 0;
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) {
      if (!is_inside(mask, x, y) || !is_inside(own, x, y)) continue;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(color.at(x, y, static_cast<int>(c)));
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  const double n = static_cast<double>(count);
  std::array<double, 3> lab = lab_from_linear(sum[0] / n, sum[1] / n, sum[2] / n);
  constexpr double kSteps = 1e4;  // More steps of gray, a* and b* would be rounding errors.
  for (double& v : lab) v = std::round(kSteps * v) / kSteps + 0.0;
  return lab;
}

ImageF marks_of(const ImageU8& mask, const ImageU8& own, const ImageU8& unseen, int width, int height) {
  ImageF marks(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool is_masked = !is_inside(own, x, y);
      const bool is_unseen = is_masked && !unseen.empty() && unseen.at(x, y) != 0;
      if (is_masked)
        marks.at(x, y, is_unseen ? kOutOfView : kMasked) = 1.0f;
      else if (!is_inside(mask, x, y))
        marks.at(x, y, kOutside) = 1.0f;
    }
  }
  return marks;
}

/// In how many frames a place is masked, in 255ths of it: sums of integers do not depend on the order of the frames.
class MaskedCounts {
 public:
  void add(const ImageU8& own) {
    ImageF shares(own.width(), own.height());
    std::transform(own.values().begin(), own.values().end(), shares.values().begin(),
                   [](std::uint8_t v) { return v == 0 ? 255.0f : 0.0f; });
    shares = reduced_to(shares, kReportMapSide_px);
    const std::lock_guard lock(mutex_);
    if (counts_.empty()) counts_ = Image<std::int64_t>(shares.width(), shares.height());
    for (std::int64_t i = 0; i < shares.num_pixels(); ++i) counts_.data()[i] += std::lround(shares.data()[i]);
  }
  [[nodiscard]] ImageF shares(std::size_t num_frames) const {
    ImageF result(counts_.width(), counts_.height());
    const double whole = 255.0 * static_cast<double>(num_frames);
    std::transform(counts_.values().begin(), counts_.values().end(), result.values().begin(),
                   [whole](std::int64_t n) { return static_cast<float>(static_cast<double>(n) / whole); });
    return result;
  }

 private:
  std::mutex mutex_;
  Image<std::int64_t> counts_;
};

}  // namespace

ReportFrames look_at_frames(const HistoryManifest& history, const fs::path& folder, const ImageU8& mask,
                            const std::vector<bool>& is_shown, const std::function<ImageU8(int)>& out_of_view,
                            const RunControl& control) {
  ReportFrames result{.frames = std::vector<ReportFrame>(history.frames.size()), .masked = {}};
  MaskedCounts counts;
  parallel_for(static_cast<std::int64_t>(history.frames.size()), 1, control, [&](std::int64_t begin, std::int64_t) {
    const auto i = static_cast<std::size_t>(begin);
    ReportFrame& frame = result.frames[i];
    const ImageF color = read_color(folder / history.frames[i].file);
    const ImageU8 own = history.frames[i].mask ? read_mask(folder / *history.frames[i].mask) : ImageU8();
    measure_mask(own, frame);
    frame.lab = mean_lab(color, mask, own);
    if (frame.masked_at) counts.add(own);
    if (!is_shown[i]) return;
    const ImageU8 unseen = frame.masked_at && out_of_view ? out_of_view(static_cast<int>(i)) : ImageU8();
    frame.thumbnail = reduced_to(color, kThumbnailSide_px);
    frame.marks = reduced_to(marks_of(mask, own, unseen, color.width(), color.height()), kThumbnailSide_px);
  });
  result.masked = counts.shares(history.frames.size());
  return result;
}

std::vector<bool> shown_frames(const std::vector<bool>& is_marked) {
  const std::size_t num_frames = is_marked.size();
  if (num_frames <= kMaxThumbnails) return std::vector<bool>(num_frames, true);
  std::vector<bool> is_shown(num_frames, false);
  std::size_t num_marked = 0;
  for (std::size_t i = 0; i < num_frames && num_marked < kMaxMarkedFrames; ++i) {
    is_shown[i] = is_marked[i];
    num_marked += is_marked[i] ? 1 : 0;
  }
  const std::size_t num_even = kMaxThumbnails - num_marked;
  for (std::size_t k = 0; k < num_even; ++k) is_shown[k * (num_frames - 1) / (num_even - 1)] = true;
  return is_shown;
}

ImageF reduced_to(const ImageF& image, int longest) {
  const double factor = static_cast<double>(longest) / std::max(image.width(), image.height());
  if (factor >= 1.0) return image;
  const auto side = [factor](int v) { return std::max(1, static_cast<int>(std::lround(v * factor))); };
  return downscale_area(image, side(image.width()), side(image.height()));
}

}  // namespace patinate::capture
