#include "capture/stability/odd_frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

namespace patinate::capture {

namespace {

/// Kinds of findings about a photograph; each is blamed by itself.
enum class Kind { Moved, Exposed, New };
constexpr std::array<Kind, 3> kKinds{Kind::Moved, Kind::Exposed, Kind::New};
constexpr int kLongestRun = 3;  ///< More frames in a row are a part of the series rather than a mistake.
constexpr int kMaxRuns = 64;    ///< Most runs of more than one frame, whose pairs across are measured: 0.2 s each.

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

/// A run is a mistake only where more frames than its own are left.
bool is_minority(const FrameRun& run, std::size_t num_pairs) { return 2 * run.size() <= static_cast<int>(num_pairs); }

/// Pairs and findings at every place between two frames.
class Series {
 public:
  Series(const std::vector<FrameFinding>& findings, const std::vector<FramePair>& neighbors,
         const std::vector<FramePair>& across, int width, int height)
      : width_(width), height_(height) {
    for (const FramePair& pair : neighbors) pairs_[pair.frame] = &pair;
    for (const FrameFinding& finding : findings) findings_[finding.frame] = &finding;
    for (const FramePair& pair : across) across_[{pair.reference, pair.frame}] = &pair;
  }

  /// Runs whose neighbors follow one another without them, as far as this kind goes. Rising; no two share a pair.
  [[nodiscard]] std::vector<FrameRun> odd_runs(Kind kind) const {
    std::vector<FrameRun> runs;
    for (const auto& [first, pair] : pairs_) {
      if (!runs.empty() && first <= runs.back().last + 1) continue;
      for (int size = 1; size <= kLongestRun; ++size) {
        const FrameRun run{first, first + size - 1};
        if (!is_odd(run, kind)) continue;
        runs.push_back(run);
        break;
      }
    }
    return runs;
  }

  /// It is the first, and wanting in a way in which the pair after it is not.
  [[nodiscard]] bool is_odd_start(int frame, Kind kind) const {
    if (pairs_.contains(frame) || !pairs_.contains(frame + 2)) return false;
    const FrameFinding* next = finding(frame + 2);
    return next == nullptr || (!has(*next, kind) && !has(*next, Kind::New));
  }

  /// The pair with this later frame is found wanting in this way.
  [[nodiscard]] bool is_found(int frame, Kind kind) const {
    const FrameFinding* own = finding(frame);
    return own != nullptr && has(*own, kind);
  }

  [[nodiscard]] const FramePair& pair(int frame) const { return *pairs_.at(frame); }
  [[nodiscard]] const FrameFinding* finding(int frame) const {
    const auto found = findings_.find(frame);
    return found == findings_.end() ? nullptr : found->second;
  }

  /// Motion of `frame` from `reference`, over the pairs between.
  [[nodiscard]] Eigen::Affine2d motion(int reference, int frame) const {
    Eigen::Affine2d motion = Eigen::Affine2d::Identity();
    for (int f = reference + 1; f <= frame; ++f) motion = pairs_.at(f)->motion.frame_from_reference * motion;
    return motion;
  }
  [[nodiscard]] std::array<double, 3> log_gain(int reference, int frame) const {
    std::array<double, 3> sum{};
    for (int f = reference + 1; f <= frame; ++f) {
      for (std::size_t c = 0; c < 3; ++c) sum[c] += pairs_.at(f)->change.log_gain[c];
    }
    return sum;
  }

 private:
  static constexpr double kLeft = 0.5;  ///< Share of a change that may be left without the odd frames.

  /// Light that comes back the way it went is a mistake even where aging hides one of its ends.
  [[nodiscard]] bool is_odd(const FrameRun& run, Kind kind) const {
    const bool is_start = is_found(run.first, kind), is_end = is_found(run.last + 1, kind);
    if (!pairs_.contains(run.last + 1) || !is_minority(run, pairs_.size())) return false;
    if (kind == Kind::Exposed) return (is_start || is_end) && is_light_back(run);
    if (!is_start || !is_end) return false;
    if (kind == Kind::Moved) return is_there_and_back(run);
    const auto skipping = across_.find({run.first - 1, run.last + 1});
    return skipping != across_.end() && is_better(*skipping->second, pair(run.first), pair(run.last + 1));
  }

  [[nodiscard]] bool is_there_and_back(const FrameRun& run) const {
    const auto size = [&](int reference, int frame) { return motion_size(motion(reference, frame), width_, height_); };
    return size(run.first - 1, run.last + 1) <
           kLeft * std::min(size(run.first - 1, run.first), size(run.last, run.last + 1));
  }

  [[nodiscard]] bool is_light_back(const FrameRun& run) const {
    const auto largest = [&](int reference, int frame) {
      double most = 0.0;
      for (const double gain : log_gain(reference, frame)) most = std::max(most, std::abs(gain));
      return most;
    };
    return largest(run.first - 1, run.last + 1) <
           kLeft * std::min(largest(run.first - 1, run.first), largest(run.last, run.last + 1));
  }

  /// Leaving the odd ones out halves what is new: in detail or on the surface, and neither gets worse.
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
  std::map<std::pair<int, int>, const FramePair*> across_;  ///< By the frames compared.
};

/// Says of the earlier frame what was said of the later one.
void turn_round(FrameFinding& finding, const FramePair& pair, int width, int height) {
  finding.odd_frame = pair.reference;
  finding.against = pair.frame;
  if (finding.is_shifted) describe_motion(pair.motion.frame_from_reference.inverse(), width, height, finding);
  for (double& gain : finding.gain) gain = 1.0 / gain;
}

/// A frame of a run, of which no pair says what it is: seen from the last one before the run.
FrameFinding finding_in_run(const Series& series, const FrameRun& run, int frame, Kind kind, int width, int height) {
  FrameFinding finding = *series.finding(series.is_found(run.first, kind) ? run.first : run.last + 1);
  for (Kind other : kKinds) {
    if (other != kind) drop(finding, other);
  }
  finding.is_light_unclear = false;
  finding.frame = finding.odd_frame = frame;
  finding.against = run.first - 1;
  if (finding.is_shifted) describe_motion(series.motion(finding.against, frame), width, height, finding);
  const std::array<double, 3> gain = series.log_gain(finding.against, frame);
  for (std::size_t c = 0; c < 3; ++c) finding.gain[c] = std::exp(gain[c]);
  return finding;
}

/// Frames that stand out in one way.
class OddOnes {
 public:
  OddOnes(const Series& series, Kind kind) : series_(&series), kind_(kind), runs_(series.odd_runs(kind)) {}

  /// Tells whether the earlier frame of the pair with this later one stands out.
  [[nodiscard]] bool is_earlier(int frame) const {
    const auto is_end = [&](const FrameRun& run) { return run.last + 1 == frame; };
    const auto is_start = [&](const FrameRun& run) { return run.first == frame; };
    if (std::any_of(runs_.begin(), runs_.end(), is_end)) return true;
    return std::none_of(runs_.begin(), runs_.end(), is_start) && series_->is_odd_start(frame - 1, kind_);
  }
  /// Those of a run that no pair's finding names.
  void add_untold(std::vector<FrameFinding>& findings, int width, int height) const {
    for (const FrameRun& run : runs_) {
      for (int frame = run.first; frame <= run.last; ++frame) {
        const bool is_told =
            series_->is_found(frame, kind_) || (frame == run.last && series_->is_found(run.last + 1, kind_));
        if (!is_told) findings.push_back(finding_in_run(*series_, run, frame, kind_, width, height));
      }
    }
  }

 private:
  const Series* series_;
  Kind kind_;
  std::vector<FrameRun> runs_;
};

}  // namespace

std::vector<FrameRun> runs_to_skip(const std::vector<FramePair>& neighbors, const std::vector<FrameFinding>& findings) {
  std::map<int, bool> is_wanting;
  for (const FramePair& pair : neighbors) is_wanting[pair.frame] = is_unmatched(pair);
  for (const FrameFinding& f : findings) is_wanting[f.frame] = is_wanting[f.frame] || f.is_jump || f.is_unmatched;
  std::vector<FrameRun> runs;
  int num_longer = 0;
  for (int size = 1; size <= kLongestRun; ++size) {
    for (const auto& [frame, wanting] : is_wanting) {
      const FrameRun run{frame, frame + size - 1};
      const auto after = is_wanting.find(run.last + 1);
      if (!wanting || after == is_wanting.end() || !after->second || !is_minority(run, neighbors.size())) continue;
      if (size > 1 && num_longer++ >= kMaxRuns) continue;
      runs.push_back(run);
    }
  }
  return runs;
}

void find_odd_frames(std::vector<FrameFinding>& findings, const std::vector<FramePair>& neighbors,
                     const std::vector<FramePair>& across, int width, int height) {
  const std::vector<FrameFinding> before = findings;
  const Series series(before, neighbors, across, width, height);
  std::map<Kind, OddOnes> odd;
  for (Kind kind : kKinds) odd.emplace(kind, OddOnes(series, kind));
  findings.clear();
  for (const FrameFinding& finding : before) {
    FrameFinding of_earlier = finding, of_later = finding;
    for (Kind kind : kKinds) {
      if (has(finding, kind)) drop(odd.at(kind).is_earlier(finding.frame) ? of_later : of_earlier, kind);
    }
    if (has_any(of_earlier)) {
      turn_round(of_earlier, series.pair(finding.frame), width, height);
      findings.push_back(of_earlier);
    }
    if (has_any(of_later)) findings.push_back(of_later);
  }
  for (Kind kind : kKinds) odd.at(kind).add_untold(findings, width, height);
  std::stable_sort(findings.begin(), findings.end(),
                   [](const FrameFinding& a, const FrameFinding& b) { return a.frame < b.frame; });
}

std::vector<int> group_frames(int num_frames, const std::vector<FramePair>& pairs,
                              const std::function<bool(const FramePair&)>& is_linked) {
  std::vector<int> first(static_cast<std::size_t>(num_frames));  // Earliest frame of each one's group.
  std::iota(first.begin(), first.end(), 0);
  for (const FramePair& pair : pairs) {
    if (!is_linked(pair)) continue;
    const int a = first[pair.reference], b = first[pair.frame];
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
