#include "analysis/evaluation/copied_pieces.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "libcommon/core/parallel.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

namespace {

constexpr std::int64_t kPieceChunk = 16384;
constexpr int kFeatures = 5;
constexpr std::pair<int, int> kBeside[] = {{1, 0}, {0, 1}};

/// Codes and the central differences of luma (one-sided at the border).
ImageF features_of(const ImageF& codes) {
  const int w = codes.width(), h = codes.height();
  const auto luma = [&](int x, int y) {
    return luminance(codes.pixel(std::clamp(x, 0, w - 1), std::clamp(y, 0, h - 1)));
  };
  ImageF out(w, h, kFeatures);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      std::copy_n(codes.pixel(x, y).data(), 3, out.pixel(x, y).data());
      out.at(x, y, 3) = (luma(x + 1, y) - luma(x - 1, y)) / 2.0f;
      out.at(x, y, 4) = (luma(x, y + 1) - luma(x, y - 1)) / 2.0f;
    }
  }
  return out;
}

struct PixelStep {
  int x = 0, y = 0;
};

/// The step in whole source pixels, at least one.
PixelStep whole_step(const Vec2& step_px) {
  const PixelStep step{static_cast<int>(std::lround(step_px.x())), static_cast<int>(std::lround(step_px.y()))};
  if (step.x != 0 || step.y != 0) return step;
  if (std::abs(step_px.x()) >= std::abs(step_px.y())) return {step_px.x() < 0.0 ? -1 : 1, 0};
  return {0, step_px.y() < 0.0 ? -1 : 1};
}

class SourceFeatures {
 public:
  explicit SourceFeatures(const SynthesisSource& source) : source_(source) {
    for (const ImageF& frame : source.frames) frames_.push_back(features_of(frame));
  }

  [[nodiscard]] bool contains(PixelStep p) const {
    return frames_.front().contains(p.x, p.y) && is_inside(source_.mask, p.x, p.y);
  }
  /// Sum over frames.
  [[nodiscard]] double difference(PixelStep a, PixelStep b) const {
    double sum = 0.0;
    for (const ImageF& frame : frames_) {
      double squares = 0.0;
      for (int c = 0; c < kFeatures; ++c) {
        const double d = static_cast<double>(frame.at(a.x, a.y, c)) - static_cast<double>(frame.at(b.x, b.y, c));
        squares += d * d;
      }
      sum += std::sqrt(squares);
    }
    return sum;
  }
  /// What the source has at a step `d` from a and to b; nothing where it has neither.
  [[nodiscard]] std::optional<double> own_difference(PixelStep a, PixelStep b, PixelStep d) const {
    const PixelStep after{a.x + d.x, a.y + d.y}, before{b.x - d.x, b.y - d.y};
    const bool has_after = contains(after), has_before = contains(before);
    if (!has_after && !has_before) return std::nullopt;
    return ((has_after ? difference(a, after) : 0.0) + (has_before ? difference(before, b) : 0.0)) /
           (has_after && has_before ? 2.0 : 1.0);
  }

 private:
  const SynthesisSource& source_;
  std::vector<ImageF> frames_;
};

}  // namespace

void BorderSums::add(const BorderSums& other) { count += other.count, shown += other.shown, own += other.own; }

std::optional<double> BorderSums::contrast() const {
  if (count == 0) return 1.0;
  return own > 0.0 ? std::optional(shown / own) : std::nullopt;
}

BorderSums measure_borders(const MapPart& part, const SynthesisSource& frames, const SourceScale& scale,
                           const RunControl& control) {
  const SourceFeatures features(frames);
  const SourceIndices& source = part.indices;
  return parallel_reduce(
      part.num_texels(), kPieceChunk, control, BorderSums{},
      [&](std::int64_t begin, std::int64_t end) {
        BorderSums sums;
        for (std::int64_t i = begin; i < end; ++i) {
          const TexelId t = part.texel(i);
          if (!part.surface.is_covered(t)) continue;
          for (const auto& [dx, dy] : kBeside) {
            const auto pair = interior_pair(part.surface, scale.axes, t, dx, dy);
            if (!pair || follows_surface(source, *pair, scale)) continue;
            const PixelStep a{source.x(pair->first), source.y(pair->first)},
                b{source.x(pair->second), source.y(pair->second)};
            const auto own = features.own_difference(a, b, whole_step(pair->offset_mm / scale.pixel_mm));
            if (!own) continue;
            ++sums.count;
            sums.shown += features.difference(a, b);
            sums.own += *own;
          }
        }
        return sums;
      },
      [](BorderSums a, const BorderSums& b) {
        a.add(b);
        return a;
      });
}

double overuse_of(const ReuseSums& reuse, int width, std::int64_t num_usable, double pixels_per_texel) {
  if (reuse.texels == 0) return 0.0;
  const auto side = std::max(1, static_cast<int>(std::lround(pixels_per_texel)));
  const double area = static_cast<double>(side) * side,
               num_places = std::max(1.0, static_cast<double>(num_usable) / area),
               once = std::max(1.0, std::ceil(area / (pixels_per_texel * pixels_per_texel) - 1e-6));
  const std::int64_t columns = (width + side - 1) / side;
  std::vector<std::int64_t> places;
  for (std::size_t i = 0; i < reuse.uses.size(); ++i) {
    const auto x = static_cast<std::int64_t>(i) % width, y = static_cast<std::int64_t>(i) / width;
    const auto place = static_cast<std::size_t>(y / side * columns + x / side);
    if (place >= places.size()) places.resize(place + 1);
    places[place] += reuse.uses[i];
  }
  const double texels = static_cast<double>(reuse.texels), even = texels / num_places, most = std::max(once, even),
               part = even - std::floor(even);
  double beyond = 0.0;
  for (const std::int64_t uses : places) beyond += uses > 0 ? std::max(0.0, static_cast<double>(uses) - most) : 0.0;
  // Whole uses cannot be even to a fraction.
  if (even > once) beyond -= num_places * part * (1.0 - part);
  return std::max(0.0, beyond) / texels;
}

}  // namespace patinate::analysis
