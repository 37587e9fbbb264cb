#include "capture/stability/odd_frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

namespace patinate::capture {

namespace {

/// What a photograph can be found to be; each is blamed by itself.
enum class Kind { Moved, Exposed, New };
constexpr std::array<Kind, 3> kKinds{Kind::Moved, Kind::Exposed, Kind::New};

bool has(const FrameFinding& f, Kind kind) {
  if (kind == Kind::Moved) return f.is_shifted;
  if (kind == Kind::Exposed) return f.is_exposure_changed;
  return f.is_jump || f.is_unmatched;
}

void drop(FrameFinding& f, Kind kind) {
  if (kind == Kind::Moved) f.is_shifted = false;
  if (kind == Kind::Exposed) f.is_exposure_changed = false;
  if (kind == Kind::New) f.is_jump = f.is_unmatched = false;
}

bool has_any(const FrameFinding& f) {
  return std::any_of(kKinds.begin(), kKinds.end(), [&](Kind kind) { return has(f, kind); });
}

/// What pairs and findings say of every place between two frames.
class Series {
 public:
  Series(const std::vector<FrameFinding>& findings, const std::vector<FramePair>& neighbors,
         const std::vector<FramePair>& across, int width, int height)
      : width_(width), height_(height) {
    for (const FramePair& pair : neighbors) pairs_[pair.frame] = &pair;
    for (const FrameFinding& finding : findings) findings_[finding.frame] = &finding;
    for (const FramePair& pair : across) across_[pair.frame - 1] = &pair;
  }

  /// Its neighbors follow one another without it, as far as this kind goes.
  [[nodiscard]] bool is_odd(int frame, Kind kind) const {
    const FrameFinding *before = finding(frame), *after = finding(frame + 1);
    if (before == nullptr || after == nullptr || !has(*before, kind) || !has(*after, kind)) return false;
    const FramePair &in = *pairs_.at(frame), &out = *pairs_.at(frame + 1);
    if (kind == Kind::Moved) return is_there_and_back(in, out);
    if (kind == Kind::Exposed) return is_light_back(in, out);
    const auto skipping = across_.find(frame);
    return skipping != across_.end() && is_better(*skipping->second, in, out);
  }

  /// It is the first, and wanting in a way in which the pair after it is not.
  [[nodiscard]] bool is_odd_start(int frame, Kind kind) const {
    if (pairs_.contains(frame) || !pairs_.contains(frame + 2)) return false;
    const FrameFinding* next = finding(frame + 2);
    return next == nullptr || (!has(*next, kind) && !has(*next, Kind::New));
  }

  [[nodiscard]] const FramePair& pair(int frame) const { return *pairs_.at(frame); }

 private:
  static constexpr double kLeft = 0.5;  ///< Share of a change that may be left without the odd frame.

  [[nodiscard]] const FrameFinding* finding(int frame) const {
    const auto found = findings_.find(frame);
    return found == findings_.end() ? nullptr : found->second;
  }

  [[nodiscard]] bool is_there_and_back(const FramePair& in, const FramePair& out) const {
    const Eigen::Affine2d &there = in.motion.frame_from_reference, &back = out.motion.frame_from_reference;
    return motion_size(back * there, width_, height_) <
           kLeft * std::min(motion_size(there, width_, height_), motion_size(back, width_, height_));
  }

  [[nodiscard]] static bool is_light_back(const FramePair& in, const FramePair& out) {
    double there = 0.0, back = 0.0, left = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      there = std::max(there, std::abs(in.change.log_gain[c]));
      back = std::max(back, std::abs(out.change.log_gain[c]));
      left = std::max(left, std::abs(in.change.log_gain[c] + out.change.log_gain[c]));
    }
    return left < kLeft * std::min(there, back);
  }

  /// Leaving the odd one out halves what is new: in detail or on the surface, and neither gets worse.
  [[nodiscard]] static bool is_better(const FramePair& across, const FramePair& in, const FramePair& out) {
    const double detail = std::min(1.0 - best_similarity(in), 1.0 - best_similarity(out));
    const double surface = std::min(in.change.surface, out.change.surface);
    const double detail_left = 1.0 - best_similarity(across), surface_left = across.change.surface;
    return detail_left <= detail && surface_left <= surface &&
           (detail_left < kLeft * detail || surface_left < kLeft * surface);
  }

  int width_, height_;
  std::map<int, const FramePair*> pairs_;  ///< By their later frame.
  std::map<int, const FrameFinding*> findings_;
  std::map<int, const FramePair*> across_;  ///< By the frame between.
};

/// Says of the earlier frame what was said of the later one.
void turn_round(FrameFinding& finding, const FramePair& pair, int width, int height) {
  finding.odd_frame = pair.reference;
  if (finding.is_shifted) describe_motion(pair.motion.frame_from_reference.inverse(), width, height, finding);
  for (double& gain : finding.gain) gain = 1.0 / gain;
}

}  // namespace

std::vector<int> frames_to_skip(const std::vector<FramePair>& neighbors, const std::vector<FrameFinding>& findings) {
  std::map<int, bool> is_wanting;
  for (const FramePair& pair : neighbors)
    is_wanting[pair.frame] = pair.shift.status != ShiftStatus::NoTexture && !can_be_laid_over(pair);
  for (const FrameFinding& f : findings) is_wanting[f.frame] = is_wanting[f.frame] || f.is_jump || f.is_unmatched;
  std::vector<int> frames;
  for (const auto& [frame, wanting] : is_wanting) {
    const auto next = is_wanting.find(frame + 1);
    if (wanting && next != is_wanting.end() && next->second) frames.push_back(frame);
  }
  return frames;
}

void find_odd_frames(std::vector<FrameFinding>& findings, const std::vector<FramePair>& neighbors,
                     const std::vector<FramePair>& across, int width, int height) {
  const std::vector<FrameFinding> before = findings;
  const Series series(before, neighbors, across, width, height);
  std::map<Kind, int> last_odd{{Kind::Moved, -1}, {Kind::Exposed, -1}, {Kind::New, -1}};
  findings.clear();
  for (const FrameFinding& finding : before) {
    FrameFinding of_earlier = finding, of_later = finding;
    for (Kind kind : kKinds) {
      if (!has(finding, kind)) continue;
      const int earlier = finding.frame - 1;
      const bool is_later_odd = earlier != last_odd[kind] && series.is_odd(finding.frame, kind);
      const bool is_earlier_odd = !is_later_odd && (earlier == last_odd[kind] || series.is_odd_start(earlier, kind));
      if (is_later_odd) last_odd[kind] = finding.frame;
      drop(is_earlier_odd ? of_later : of_earlier, kind);
    }
    if (has_any(of_earlier)) {
      turn_round(of_earlier, series.pair(finding.frame), width, height);
      findings.push_back(of_earlier);
    }
    if (has_any(of_later)) findings.push_back(of_later);
  }
}

std::vector<int> group_frames(int num_frames, const std::vector<FramePair>& pairs,
                              const std::function<bool(const FramePair&)>& is_linked) {
  std::vector<int> first(static_cast<std::size_t>(num_frames));  // Earliest frame of each one's group.
  std::iota(first.begin(), first.end(), 0);
  for (const FramePair& pair : pairs) {
    if (!is_linked(pair)) continue;
    const int a = first[static_cast<std::size_t>(pair.reference)], b = first[static_cast<std::size_t>(pair.frame)];
    std::replace(first.begin(), first.end(), std::max(a, b), std::min(a, b));
  }
  std::map<int, int> sizes;
  for (int f : first) ++sizes[f];
  std::vector<std::pair<int, int>> order(sizes.begin(), sizes.end());
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::map<int, int> number;
  for (const auto& [f, size] : order) number.emplace(f, static_cast<int>(number.size()));
  std::vector<int> groups;
  for (int f : first) groups.push_back(number.at(f));
  return groups;
}

std::vector<int> frames_outside(const std::vector<int>& groups) {
  std::vector<int> frames;
  const bool is_any_tied = std::count(groups.begin(), groups.end(), 0) > 1;
  for (std::size_t i = 0; i < groups.size() && groups.size() > 1; ++i) {
    if (groups[i] != 0 || !is_any_tied) frames.push_back(static_cast<int>(i));
  }
  return frames;
}

}  // namespace patinate::capture
