#include "analysis/grading/rust_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/grading/spot_field.h"
#include "analysis/grading/unrusted_color.h"
#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr double kHalf = 0.5;  // Opacity from which on a pixel is rust: half way to its color.
constexpr double kSure = 0.6;  // Spots of less opacity in their middle may be stains.
constexpr double kLowOpacity = -0.25, kHighOpacity = 1.25;  // Opacities of a byte's ends.
constexpr int kRing_px = 3;           // So far beyond its edge a blurred spot still adds to its area.
constexpr double kColored = 0.3;      // Share of a spot that must have the color of rust: its rim is blurred.
constexpr double kMaxChange = 0.7;    // Share of the change of the most changed hundredth that rust has.
constexpr std::size_t kMinInner = 9;  // Pixels in the middle of spots.
constexpr double kFaint = 0.2;        // Opacity of the blurred image of a spot too small for a half ...
constexpr double kFaintPeak = 0.3;    // ... and of its brightest pixel.
constexpr double kFaintSigmas = 3.5, kPeakSigmas = 5.5;  // Standard deviations of the noise of opacities.
constexpr std::size_t kMaxFaint_px = 25;                 // A larger faint place is a stain.
constexpr double kStays = 0.6;         // Share of a faint spot's opacity that later photographs show, too.
constexpr double kMinContrast = 1e-4;  // Squared distance of rust's color from the surface's, linear.
constexpr double kDarkOpacity = 0.2;   // Opacities from here on are looked at: a fainter pixel is in no spot.
constexpr double kMinTint = 0.1;       // Distance of two chromaticities that noise of a hundredth does not hide.
constexpr double kMinTintShare = 0.4;  // Less than half, by the noise of a dark pixel.
constexpr double kDarkestRust = 0.1;   // Brightness of black crusts over that of orange rust, linear.

std::array<double, 3> lab_of(const std::array<double, 3>& c) { return lab_from_linear(c[0], c[1], c[2]); }

/// A dark color of the same tint has less chroma, in proportion: the least chroma is that of the lightest rust.
bool has_rust_color(const std::array<double, 3>& lab, const RustRule& rule) {
  const double chroma = std::hypot(lab[1], lab[2]) * rule.most_lightness / std::clamp(lab[0], 1.0, rule.most_lightness);
  const double hue = std::atan2(lab[2], lab[1]) * 180.0 / std::numbers::pi;
  const double off_middle = std::remainder(hue - 0.5 * (rule.low_hue_deg + rule.high_hue_deg), 360.0);
  return chroma >= rule.least_chroma && lab[0] >= rule.least_lightness && lab[0] <= rule.most_lightness &&
         std::abs(off_middle) <= 0.5 * (rule.high_hue_deg - rule.low_hue_deg);
}

using Color = std::array<double, 3>;

Color chromaticity(const Color& linear) {
  constexpr double kBlack = 1e-3;
  const double sum = std::max(kBlack, linear[0] + linear[1] + linear[2]);
  return {linear[0] / sum, linear[1] / sum, linear[2] / sum};
}

/// Cracks, scratches and dirt darken a coating as rust does, but do not tint it: of the way from the coating's
/// chromaticity to that of rust they go less than such a mixture of the two would. Where rust has hardly another tint
/// than the coating, nothing is told apart.
bool is_only_dark(const Color& now, const Color& clean, const Color& rust, double opacity) {
  if (opacity < kDarkOpacity) return false;
  Color mixed{};
  for (std::size_t c = 0; c < 3; ++c) mixed[c] = clean[c] + std::min(opacity, 1.0) * (rust[c] - clean[c]);
  const Color from = chromaticity(clean), to = chromaticity(rust), seen = chromaticity(now),
              expected = chromaticity(mixed);
  double seen_way = 0.0, expected_way = 0.0, squared = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double way = to[c] - from[c];
    seen_way += way * (seen[c] - from[c]);
    expected_way += way * (expected[c] - from[c]);
    squared += way * way;
  }
  return squared >= kMinTint * kMinTint && seen_way < kMinTintShare * expected_way;
}

double dot(const Color& a, const Color& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Share f of rust in a mixture (1 - f) clean + f rust: the least-squares projection.
double mixed_share(const Color& now, const Color& clean, const Color& rust) {
  const Color way{rust[0] - clean[0], rust[1] - clean[1], rust[2] - clean[2]};
  const double whole = dot(way, way);
  return whole > kMinContrast ? dot(way, {now[0] - clean[0], now[1] - clean[1], now[2] - clean[2]}) / whole : 0.0;
}

/// The same with rust of any brightness between black crusts and the brightest: the least-squares solution of
/// now = (1 - f) clean + f b rust for f and b.
double share_of_any_rust(const Color& now, const Color& clean, const Color& rust) {
  const double cc = dot(clean, clean), cr = dot(clean, rust), rr = dot(rust, rust), nc = dot(now, clean),
               nr = dot(now, rust), determinant = cc * rr - cr * cr;
  if (!(determinant > kMinTint * kMinTint * cc * rr)) return mixed_share(now, clean, rust);  // Hardly another tint.
  const double of_clean = (nc * rr - nr * cr) / determinant, of_rust = (nr * cc - nc * cr) / determinant;
  const double share = 1.0 - of_clean, brightness = share > 0.0 ? of_rust / share : 1.0;
  if (brightness >= kDarkestRust && brightness <= 1.0) return share;
  const double b = brightness > 1.0 ? 1.0 : kDarkestRust;
  return mixed_share(now, clean, {b * rust[0], b * rust[1], b * rust[2]});
}

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/// Pixels that have the color of rust. @param before  Pixels that hardly differ from it do not count; may be empty.
ImageU8 colored(const ImageF& color, const ImageU8& mask, const RustRule& rule, const ImageF& before = {}) {
  ImageU8 out(color.width(), color.height());
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (mask.data()[i] == 0) continue;
    const std::array<double, 3> lab = lab_of(pixel_of(color, k));
    const bool has_changed = before.empty() || distance(lab, lab_of(pixel_of(before, k))) >= rule.least_change;
    out.data()[i] = has_changed && has_rust_color(lab, rule) ? 255 : 0;
  }
  return out;
}

std::uint8_t opacity_code(double opacity) {
  const double share = (opacity - kLowOpacity) / (kHighOpacity - kLowOpacity);
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0)));
}

}  // namespace

namespace {

/// Substitute of the unexposed surface: the frame, and where it has rusted already, or is not there, what is common
/// around it. Paint that has the color of rust all over is no rust.
ImageF unexposed_surface(const GradedFrames& frames, const RustRule& rule) {
  const ImageF given = frames.color(frames.unexposed.value_or(0));
  const ImageF usual =
      frames.unexposed ? common_color(given, frames.mask, ImageU8(given.width(), given.height())) : ImageF();
  const ImageU8 rust = colored(given, frames.mask, rule, usual);
  const ImageF common = common_color(given, frames.mask, rust);
  ImageF out = given;
  for (int y = 0; y < given.height(); ++y) {
    for (int x = 0; x < given.width(); ++x) {
      if (frames.unexposed && rust.at(x, y) == 0) continue;
      std::copy_n(common.pixel(x, y).begin(), 3, out.pixel(x, y).begin());
    }
  }
  return out;
}

}  // namespace

RustMap::RustMap(const GradedFrames& frames, const RustRule& rule, const RunControl& control)
    : rule_(rule),
      width_(frames.mask.width()),
      height_(frames.mask.height()),
      num_frames_(frames.num_frames),
      mask_(frames.mask) {
  if (std::none_of(mask_.values().begin(), mask_.values().end(), [](std::uint8_t v) { return v != 0; }))
    throw InvalidInput("grade: the mask leaves nothing of the surface");
  const ImageF unexposed = unexposed_surface(frames, rule);
  const std::size_t n = static_cast<std::size_t>(width_) * height_;
  const auto background_of = [&](const ImageF& color) {
    return unrusted_color(unexposed, color, mask_, colored(color, mask_, rule_, unexposed));
  };
  const ImageF last = frames.color(num_frames_ - 1);
  if (last.width() != width_ || last.height() != height_)
    throw InvalidInput("grade: frames and mask have different sizes");
  find_rust_color(last, background_of(last));
  opacity_.assign(n * num_frames_, opacity_code(0.0));
  is_colored_.assign(n * num_frames_, 0);
  for (int t = 0; t < num_frames_ && rust_color_; ++t) {
    const ImageF color = frames.color(t), background = background_of(color);
    parallel_for(static_cast<std::int64_t>(n), 1 << 14, control.part(1.0 * t / num_frames_, (t + 1.0) / num_frames_),
                 [&](std::int64_t begin, std::int64_t end) {
                   for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                     if (mask_.data()[i] == 0) continue;
                     const std::array<double, 3> now = pixel_of(color, i), clean = pixel_of(background, i);
                     const std::size_t k = n * static_cast<std::size_t>(t) + i;
                     const std::array<double, 3> lab = lab_of(now);
                     is_colored_[k] =
                         has_rust_color(lab, rule_) && distance(lab, lab_of(clean)) >= rule_.least_change ? 1 : 0;
                     double opacity = mixed_share(now, clean, *rust_color_);
                     if (is_colored_[k] != 0) opacity = std::max(opacity, share_of_any_rust(now, clean, *rust_color_));
                     opacity_[k] = opacity_code(is_only_dark(now, clean, *rust_color_, opacity) ? 0.0 : opacity);
                   }
                 });
  }
  find_noise();
  find_onsets();
}

void RustMap::find_noise() {
  for (int t = 0; t < num_frames_; ++t) {
    // Differences of neighbors: stains and rust are smooth beside noise. A difference has the noise of two.
    std::vector<double> steps;
    for (int y = 0; y < height_; ++y) {
      for (int x = 1; x < width_; x += 2) {
        const std::size_t i = static_cast<std::size_t>(y) * width_ + x;
        if (mask_.data()[i] != 0 && mask_.data()[i - 1] != 0)
          steps.push_back(std::abs(opacity(t, i) - opacity(t, i - 1)));
      }
    }
    noise_.push_back(kSigmaOfMad * median(std::move(steps)) / std::numbers::sqrt2);
  }
}

double RustMap::opacity(int frame, std::size_t pixel) const {
  const std::size_t n = static_cast<std::size_t>(width_) * height_;
  const double share = opacity_[n * static_cast<std::size_t>(frame) + pixel] / 255.0;
  return kLowOpacity + share * (kHighOpacity - kLowOpacity);
}

void RustMap::find_rust_color(const ImageF& color, const ImageF& background) {
  const ImageU8 seen = colored(color, mask_, rule_);
  std::vector<double> changes(seen.values().size(), 0.0);
  std::vector<double> all;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (seen.data()[i] == 0) continue;
    changes[i] = distance(lab_of(pixel_of(color, i)), lab_of(pixel_of(background, i)));
    if (changes[i] >= rule_.least_change) all.push_back(changes[i]);
  }
  if (all.size() < 2) return;
  // Stains and blurred edges differ less from the surface than rust does.
  const std::size_t rank = all.size() - 1 - all.size() / 100;
  const double enough = kMaxChange * value_at_rank(all, rank);
  const auto is_rust = [&](int x, int y) { return changes[static_cast<std::size_t>(y) * width_ + x] >= enough; };
  std::vector<std::size_t> inner, any;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (!is_rust(x, y)) continue;
      any.push_back(static_cast<std::size_t>(y) * width_ + x);
      const bool is_inner = x > 0 && y > 0 && x + 1 < width_ && y + 1 < height_ && is_rust(x - 1, y) &&
                            is_rust(x + 1, y) && is_rust(x, y - 1) && is_rust(x, y + 1);
      if (is_inner) inner.push_back(any.back());
    }
  }
  std::array<double, 3>& rust = rust_color_.emplace();
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const std::size_t i : inner.size() >= kMinInner ? inner : any) values.push_back(pixel_of(color, i)[c]);
    rust[c] = median(std::move(values));
  }
}

void RustMap::find_onsets() {
  const std::size_t n = static_cast<std::size_t>(width_) * height_;
  onset_.assign(n, static_cast<std::uint16_t>(num_frames_));
  if (!rust_color_) return;
  // Rust stays: of all frames the one from which on opacities are above a half, and before it below, with the least sum
  // of what contradicts.
  for (std::size_t i = 0; i < n; ++i) {
    if (mask_.data()[i] == 0) continue;
    double cost = 0.0, best = 0.0;
    int onset = num_frames_;
    for (int t = num_frames_ - 1; t >= 0; --t) {
      cost += kHalf - opacity(t, i);
      if (cost < best) {
        best = cost;
        onset = t;
      }
    }
    onset_[i] = static_cast<std::uint16_t>(onset);
  }
}

void RustMap::add_faint_spots(int frame, const std::vector<int>& steps, RustFrame& out) const {
  const std::size_t n = static_cast<std::size_t>(width_) * height_;
  const double noise = noise_[static_cast<std::size_t>(frame)];
  const double least = std::max(kFaint, kFaintSigmas * noise), peak = std::max(kFaintPeak, kPeakSigmas * noise);
  std::vector<char> is_faint(n);
  for (std::size_t i = 0; i < n; ++i)
    is_faint[i] = mask_.data()[i] != 0 && steps[i] == kFarFromSpots && opacity(frame, i) >= least ? 1 : 0;
  const SpotField field = spot_field(is_faint, width_, height_);
  for (const std::vector<std::size_t>& pixels : field.pixels) {
    double highest = 0.0, x = 0.0, y = 0.0;
    std::vector<std::size_t> inside;
    std::vector<double> around;
    for (const std::size_t i : pixels) {
      if (field.steps[i] > kRing_px) around.push_back(opacity(frame, i));
      if (field.steps[i] > 0) continue;
      inside.push_back(i);
      highest = std::max(highest, opacity(frame, i));
    }
    const double ground = median(around);
    if (inside.size() > kMaxFaint_px || highest - ground < peak) continue;
    const auto mean_at = [&](int t) {
      double sum = 0.0;
      for (const std::size_t i : inside) sum += opacity(t, i);
      return sum / static_cast<double>(inside.size());
    };
    bool stays = true, becomes_rust = false;
    for (int t = frame + 1; t < num_frames_; ++t) stays = stays && mean_at(t) >= kStays * mean_at(frame);
    for (const std::size_t i : inside) becomes_rust = becomes_rust || onset_[i] < num_frames_;
    if (!stays) continue;
    RustSpot spot{0.0, 0.0, 0.0, static_cast<double>(inside.size()), becomes_rust};
    for (const std::size_t i : pixels) {
      if (field.steps[i] > kRing_px - 1 || mask_.data()[i] == 0) continue;
      const double share = std::min(1.0, (opacity(frame, i) - ground) / (1.0 - ground));
      out.coverage.data()[i] = static_cast<float>(share);
      out.labels[i] = static_cast<int>(out.spots.size());
      spot.area_px += share;
    }
    for (const std::size_t i : inside) {
      x += static_cast<double>(i % static_cast<std::size_t>(width_)) / static_cast<double>(inside.size());
      y += static_cast<double>(i / static_cast<std::size_t>(width_)) / static_cast<double>(inside.size());
    }
    spot.x = x;
    spot.y = y;
    out.spots.push_back(spot);
  }
}

RustFrame RustMap::at(int frame) const {
  const std::size_t n = static_cast<std::size_t>(width_) * height_;
  RustFrame out{ImageF(width_, height_), std::vector<int>(n, -1), {}};
  if (!rust_color_) return out;
  std::vector<char> is_inside(n);
  for (std::size_t i = 0; i < n; ++i) is_inside[i] = onset_[i] <= frame ? 1 : 0;
  const SpotField field = spot_field(is_inside, width_, height_);
  for (const std::vector<std::size_t>& pixels : field.pixels) {
    double inside = 0.0, is_colored = 0.0, edge = 0.0, x = 0.0, y = 0.0;
    std::vector<double> middle, around;
    for (const std::size_t i : pixels) {
      const int step = field.steps[i];
      if (step > kRing_px) around.push_back(opacity(frame, i));
      if (step > 0) continue;
      ++inside;
      if (step == 0) ++edge;
      if (step <= -1) middle.push_back(opacity(frame, i));
      is_colored += is_colored_[n * static_cast<std::size_t>(frame) + i];
      x += static_cast<double>(i % static_cast<std::size_t>(width_));
      y += static_cast<double>(i / static_cast<std::size_t>(width_));
    }
    if (is_colored < kColored * inside || is_colored < 1.0) continue;
    // Shares between what surrounds the spot and its middle; a spot too small for a middle has that of all rust.
    const double low = around.empty() ? 0.0 : std::clamp(median(around), 0.0, kHalf - 0.05);
    const double high = middle.size() < 5 ? 1.0 : std::clamp(median(middle), kHalf + 0.05, 1.0);
    RustSpot spot{x / inside, y / inside, 0.0, edge, middle.size() < 5 || high >= kSure};
    std::vector<std::pair<std::size_t, double>> shares;
    for (const std::size_t i : pixels) {
      if (field.steps[i] > kRing_px || mask_.data()[i] == 0) continue;
      const double share = field.steps[i] <= -kRing_px
                               ? 1.0
                               : std::min(1.0, (opacity(frame, i) - low) / (high - low));  // Noise cancels in sums.
      shares.emplace_back(i, share);
      spot.area_px += share;
    }
    if (spot.area_px < rule_.least_area_px) continue;
    for (const auto& [i, share] : shares) {
      out.coverage.data()[i] = static_cast<float>(share);
      out.labels[i] = static_cast<int>(out.spots.size());
    }
    out.spots.push_back(spot);
  }
  add_faint_spots(frame, field.steps, out);
  return out;
}

}  // namespace patinate::analysis
