#include "capture/stability/survey.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/core/median.h"
#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

constexpr double kFitsAsItLies = 0.8;      ///< Detail as similar as this needs no motion when the shift is small.
constexpr double kSmallShift = 0.3;        ///< Shift of `detail`, px.
constexpr double kMinImprovement = 0.05;   ///< Share of the missing similarity that a motion must bring.
constexpr double kMovedImprovement = 0.3;  ///< Improvement from which a photograph is called moved.
constexpr int kNeighbors = 8;              ///< On either side.
constexpr double kUnclear = 2.0;           ///< In thresholds: from there on a few photographs may differ in light.
constexpr std::size_t kNearest = 3;        ///< On either side, for what a jump must stand out from.
constexpr double kNearestFactor = 0.75;    ///< Share of jump_factor.
/// Least change of correlation and of color (docs/algorithms/stability.md).
constexpr double kJumpDetail = 0.1, kJumpSurface = 0.04;
constexpr double kPlain = 0.5;  ///< Share of the series's median contrast.
constexpr double kSameColor =
    0.2;  ///< Change of the median log ratio: drying paint darkens by 0.15, a ripening banana by 0.4.
constexpr double kAlike = 0.5;  ///< Similarity as they lie from where on two frames can be taken as not moved.

/// `get` of the pairs around number `at`, without itself.
template <class Get>
std::vector<double> around(const std::vector<FramePair>& pairs, std::size_t at, Get&& get) {
  std::vector<double> values;
  const std::size_t begin = at >= kNeighbors ? at - kNeighbors : 0, end = std::min(pairs.size(), at + kNeighbors + 1);
  for (std::size_t i = begin; i < end; ++i) {
    if (i != at) values.push_back(get(pairs[i]));
  }
  return values;
}

/// At an end of the series, what the changes beside it lead to where they fall steadily away from it: what slows down
/// was faster before, and steeper. The pair next to it is left out: an odd second photograph is in it as well. 0: to
/// nothing.
template <class Get>
double change_led_to(const std::vector<FramePair>& pairs, std::size_t at, Get&& get) {
  const std::size_t last = pairs.size() - 1;
  if ((at != 0 && at != last) || pairs.size() < 5) return 0.0;
  const auto change = [&](std::size_t k) { return get(pairs[at == 0 ? k : last - k]); };
  for (std::size_t k = 1; k < 4; ++k)
    if (!(change(k) > change(k + 1))) return 0.0;
  const double steepness = change(2) / std::max(change(4), 1e-6);
  return change(2) * steepness * steepness;
}

double contrast_of(const ImageF& detail) {
  double sum = 0.0;
  for (const float v : detail.values()) sum += static_cast<double>(v) * static_cast<double>(v);
  return std::sqrt(sum / static_cast<double>(detail.num_pixels()));
}

/// The larger one of the medians of the nearest pairs before and after: where change rises or falls steeply, the next
/// one is no jump.
template <class Get>
double nearest_change(const std::vector<FramePair>& pairs, std::size_t at, Get&& get) {
  std::vector<double> before, after;
  for (std::size_t k = 1; k <= kNearest; ++k) {
    if (at >= k) before.push_back(get(pairs[at - k]));
    if (at + k < pairs.size()) after.push_back(get(pairs[at + k]));
  }
  return std::max({median(before), median(after), change_led_to(pairs, at, get)});
}

bool is_moved(const FramePair& pair, int width, int height, const SurveyOptions& options) {
  if (!pair.is_motion_measured || !pair.motion.is_reliable) return false;
  if (pair.motion.similarity < pair.similarity_before + kMovedImprovement * (1.0 - pair.similarity_before))
    return false;
  const double threshold =
      options.shift_threshold_px * std::max(1.0, static_cast<double>(std::max(width, height)) / kPreparedSide);
  return motion_size(pair.motion.frame_from_reference, width, height) >= threshold;
}

void judge_exposure(const std::vector<FramePair>& pairs, std::size_t at, const SurveyOptions& options,
                    FrameFinding& finding) {
  const LightChange& light = pairs[at].change.light;
  const double threshold = std::log1p(options.exposure_threshold);
  bool is_away = false;
  for (std::size_t c = 0; c < 3; ++c) {
    const double now = brightening(pairs[at])[c];
    const std::vector<double> others = around(pairs, at, [&](const FramePair& p) { return brightening(p)[c]; });
    const double usual = median(others);
    std::vector<double> deviations;
    for (double v : others) deviations.push_back(std::abs(v - usual));
    const double away = std::abs(now - usual);
    finding.gain[c] = std::exp(now);
    is_away = is_away || (away > threshold && away > kOutstanding * median(deviations));
  }
  if (pairs.size() > kFewPairs) {
    finding.is_exposure_changed = is_away && light.is_sure();
    finding.is_light_unclear = is_away && !light.is_sure();
  } else {
    finding.is_exposure_changed = light.is_sure() && light.share >= kSharedByMost && light.size() > threshold;
    double size = 0.0;
    for (const double gain : brightening(pairs[at])) size = std::max(size, std::abs(gain));
    finding.is_light_unclear = !finding.is_exposure_changed && size > kUnclear * threshold;
  }
}

/// @param pairs  To compare with, `at` among them. @param least_factor  Of the least changes that make a jump.
void judge_jump(const std::vector<FramePair>& pairs, std::size_t at, double least_factor, const SurveyOptions& options,
                FrameFinding& finding) {
  const auto lacking = [](const FramePair& p) {
    return p.shift.status == ShiftStatus::NoTexture ? 0.0 : 1.0 - best_similarity(p);
  };
  const auto surface = [](const FramePair& p) { return p.change.surface; };
  const double usual_lacking = median(around(pairs, at, lacking)), usual_surface = median(around(pairs, at, surface));
  const double now_lacking = lacking(pairs[at]), now_surface = surface(pairs[at]);
  const double nearest_factor = std::max(1.0, kNearestFactor * options.jump_factor);
  const auto stands_out = [&](double now, double usual, double nearest, double least) {
    return now > least_factor * least && now > options.jump_factor * usual && now > nearest_factor * nearest;
  };
  const bool is_detail_new =
      !pairs[at].is_plain && stands_out(now_lacking, usual_lacking, nearest_change(pairs, at, lacking), kJumpDetail);
  const bool is_surface_new = stands_out(now_surface, usual_surface, nearest_change(pairs, at, surface), kJumpSurface);
  constexpr double kLeast = 1e-3;  // Keeps ratios finite.
  finding.change_factor =
      std::max(now_lacking / std::max(usual_lacking, 10 * kLeast), now_surface / std::max(usual_surface, kLeast));
  finding.is_jump = pairs.size() > 2 && (is_detail_new || is_surface_new);
}

/// Moved pairs never fit as well as those that lie still, so that they are compared with their like where there are
/// enough of them.
void judge_moved_jump(const std::vector<FramePair>& pairs, const std::vector<bool>& is_moved, std::size_t at,
                      const SurveyOptions& options, FrameFinding& finding) {
  constexpr std::size_t kEnough = 3;  // Moved neighbors that a moved frame is compared with.
  constexpr double kMinFactor = 2.0;  // Resampling twice leaves up to 0.15 of the detail on real photographs.
  std::vector<FramePair> moved;
  std::size_t at_moved = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (i == at) at_moved = moved.size();
    if (is_moved[i]) moved.push_back(pairs[i]);
  }
  if (moved.size() > kEnough) {
    judge_jump(moved, at_moved, kMinFactor, options, finding);
  } else {
    judge_jump(pairs, at, kMinFactor, options, finding);
  }
}

}  // namespace

void describe(OptionVisitor& v, SurveyOptions& o) {
  v.visit({"shift_threshold", "Shift relative to the previous photograph above which a photograph counts as moved",
           "px", above(0)},
          o.shift_threshold_px);
  v.visit({"exposure_threshold", "Relative change of a channel above which a photograph counts as exposed differently",
           "", above(0)},
          o.exposure_threshold);
  v.visit({"jump_factor", "A photograph counts as a jump if its change is more than this many times its neighbors'", "",
           above(1)},
          o.jump_factor);
}

const std::array<double, 3>& brightening(const FramePair& pair) {
  return pair.change.light.is_sure() ? pair.change.light.log_gain : pair.change.log_gain;
}

double best_similarity(const FramePair& pair) {
  return pair.is_motion_measured ? std::max(pair.motion.similarity, pair.similarity_before) : pair.similarity_before;
}

bool can_be_laid_over(const FramePair& pair) {
  return pair.is_motion_measured ? pair.motion.is_reliable : pair.similarity_before >= kAlike;
}

double plain_contrast(const std::vector<FramePair>& neighbors) {
  if (neighbors.empty()) return 0.0;
  std::vector<double> contrasts{neighbors.front().contrast[0]};
  for (const FramePair& pair : neighbors) contrasts.push_back(pair.contrast[1]);
  return kPlain * median(std::move(contrasts));
}

void mark_plain(FramePair& pair, double plain_contrast) {
  double change = 0.0;
  for (const double gain : pair.change.log_gain) change = std::max(change, std::abs(gain));
  const bool is_alike = change <= kSameColor || (change <= 2.0 * kSameColor && pair.change.surface < kJumpSurface);
  pair.is_plain = is_alike && std::min(pair.contrast[0], pair.contrast[1]) < plain_contrast;
}

bool is_unmatched(const FramePair& pair) {
  return pair.shift.status != ShiftStatus::NoTexture && !pair.is_plain && !can_be_laid_over(pair);
}

double motion_size(const Eigen::Affine2d& motion, int width, int height) {
  double sum = 0.0;
  for (int j = 0; j <= 2; ++j) {
    for (int i = 0; i <= 2; ++i) {
      const Eigen::Vector2d p(0.5 * i * (width - 1), 0.5 * j * (height - 1));
      sum += (motion * p - p).squaredNorm();
    }
  }
  return std::sqrt(sum / 9.0);  // Mean over a 3 x 3 grid.
}

void describe_motion(const Eigen::Affine2d& motion, int width, int height, FrameFinding& finding) {
  const Eigen::Vector2d middle(0.5 * (width - 1), 0.5 * (height - 1));
  const Eigen::Vector2d shift = motion * middle - middle;
  finding.shift_x = shift.x();
  finding.shift_y = shift.y();
  finding.turn_deg = std::atan2(motion(1, 0) - motion(0, 1), motion(0, 0) + motion(1, 1)) * 180.0 / std::numbers::pi;
  finding.size = std::sqrt(std::abs(motion.linear().determinant()));
}

FramePair compare_frames(int reference_index, const PreparedFrame& reference, int frame_index,
                         const PreparedFrame& frame, bool always_motion) {
  FramePair pair;
  pair.reference = reference_index;
  pair.frame = frame_index;
  pair.shift = measure_shift(reference, frame);
  pair.similarity_before = detail_similarity(reference, frame, Eigen::Affine2d::Identity());
  const double shift = std::hypot(pair.shift.x / reference.scale_x, pair.shift.y / reference.scale_y);
  const bool has_texture = pair.shift.status != ShiftStatus::NoTexture;
  if (has_texture && (always_motion || shift > kSmallShift || pair.similarity_before < kFitsAsItLies)) {
    const FrameMotion motion = measure_motion(reference, frame);
    const double missing = 1.0 - pair.similarity_before;
    if (motion.similarity > pair.similarity_before + kMinImprovement * missing) {
      pair.motion = motion;
      pair.is_motion_measured = true;
    }
  }
  pair.change = measure_change(reference, frame, pair.motion.frame_from_reference);
  pair.contrast = {contrast_of(reference.detail), contrast_of(frame.detail)};
  return pair;
}

std::vector<FrameFinding> judge_frames(const std::vector<FramePair>& neighbors, int width, int height,
                                       const SurveyOptions& options) {
  check_ranges(options);
  std::vector<FrameFinding> findings;
  std::vector<bool> moved;
  for (const FramePair& pair : neighbors) moved.push_back(is_moved(pair, width, height, options));
  for (std::size_t i = 0; i < neighbors.size(); ++i) {
    const FramePair& pair = neighbors[i];
    FrameFinding finding;
    finding.frame = finding.odd_frame = pair.frame;
    finding.against = pair.reference;
    finding.similarity = best_similarity(pair);
    finding.is_unmatched = is_unmatched(pair);
    judge_exposure(neighbors, i, options, finding);
    finding.is_shifted = moved[i];
    if (finding.is_shifted) {
      describe_motion(pair.motion.frame_from_reference, width, height, finding);
      judge_moved_jump(neighbors, moved, i, options, finding);
    } else {
      judge_jump(neighbors, i, 1.0, options, finding);
    }
    if (finding.is_shifted || finding.is_exposure_changed || finding.is_light_unclear || finding.is_jump ||
        finding.is_unmatched)
      findings.push_back(finding);
  }
  return findings;
}

FindingTexts finding_texts(const FrameFinding& f) {
  const auto rounded = [](double v, double steps) { return short_number_text(std::round(steps * v) / steps); };
  const auto tenths = [&](double v) { return rounded(v, 10.0); };
  const int distance = f.odd_frame - f.against;
  const std::string other = distance == 1   ? "the one before"
                            : distance == 2 ? "the one before the one before"
                                            : "the one after it";
  const std::string against = distance == 1 ? "" : " against " + other;
  FindingTexts texts;
  if (f.is_shifted) {
    texts.moved = "moved by " + tenths(std::abs(f.shift_x)) + " px " + (f.shift_x < 0 ? "left" : "right") + " and " +
                  tenths(std::abs(f.shift_y)) + " px " + (f.shift_y < 0 ? "up" : "down");
    if (std::abs(f.turn_deg) >= 0.05) texts.moved += ", turned by " + tenths(f.turn_deg) + " degrees";
    if (std::abs(f.size - 1.0) >= 0.0005)
      texts.moved += ", " + tenths(100.0 * std::abs(f.size - 1.0)) + (f.size > 1.0 ? " % larger" : " % smaller");
    texts.moved += against;
  }
  const std::string gains = " times " + rounded(f.gain[0], 100.0) + ", " + rounded(f.gain[1], 100.0) + ", " +
                            rounded(f.gain[2], 100.0) + " (red, green, blue)" + against;
  if (f.is_exposure_changed) {
    texts.exposed = "light" + gains;
  } else if (f.is_light_unclear) {
    texts.unclear = "brighter or darker" + gains + ", which may be the light or the surface";
  }
  if (f.is_unmatched) {
    texts.unmatched = "cannot be aligned with " + other + ", because no motion explains how they differ (similarity " +
                      rounded(f.similarity, 100.0) + " of 1)";
  } else if (f.is_jump) {
    texts.jump =
        "a jump: it differs " + tenths(f.change_factor) + " times as much from " + other + " as its neighbors do";
  }
  return texts;
}

std::string finding_text(const FrameFinding& finding) {
  const FindingTexts texts = finding_texts(finding);
  std::string all;
  for (const std::string& text : {texts.moved, texts.exposed, texts.unclear, texts.unmatched, texts.jump}) {
    if (!text.empty()) all += (all.empty() ? "" : "; ") + text;
  }
  return all;
}

}  // namespace patinate::capture
