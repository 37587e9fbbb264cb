/// \file
/// A survey of a time-lapse: which photographs are moved, differently exposed, or do not follow from the one before.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "capture/stability/frame_change.h"
#include "patinate/core/json.h"

namespace patinate::capture {

/// From where on a difference between neighbors in time is named.
struct SurveyOptions {
  double shift_threshold_px =
      0.5;  ///< Root mean square motion over the picture; > 0. In the photograph's pixels, or its reduction's to 1024.
  double exposure_threshold = 0.05;  ///< Relative change of a channel's light, beyond the neighbors' own; > 0.
  double jump_factor = 2.0;          ///< Change of the surface against the neighbors' median; > 1.
};
void describe(OptionVisitor& v, SurveyOptions& o);

/// Two photographs compared.
struct FramePair {
  int reference = 0;
  int frame = 0;
  FrameShift shift;
  FrameMotion motion;  ///< Identity when it was not measured (is_motion_measured).
  bool is_motion_measured = false;
  double similarity_before = 0.0;    ///< Similarity of the detail as the frames lie.
  FrameChange change;                ///< When one is laid over the other.
  std::array<double, 2> contrast{};  ///< Root mean square of the detail: of the reference, of the frame.
  bool is_plain = false;             ///< mark_plain(): one of the two shows too little detail to be compared by it.
};

/// Measures the shift, and the whole motion if the frames do not fit as they lie, or `always_motion`.
/// A fixed camera's frames are left as they lie: the motion is kept only when it makes the detail more alike.
[[nodiscard]] FramePair compare_frames(int reference_index, const PreparedFrame& reference, int frame_index,
                                       const PreparedFrame& frame, bool always_motion);

/// Number of pairs up to which nothing is usual, so that none stands out.
inline constexpr std::size_t kFewPairs = 6;
/// Median deviations of gains from where on one stands out: six standard deviations.
inline constexpr double kOutstanding = 6.0 * 1.4826;

/// Change of the light in a pair, log gains: what the picture shares where that is sure, else its median.
[[nodiscard]] const std::array<double, 3>& brightening(const FramePair& pair);
/// Correlation of the pair's detail as it fits best: moved, or as it lies. [-1, 1]
[[nodiscard]] double best_similarity(const FramePair& pair);
/// One can be laid over the other: a motion is reliable, or they fit as they lie.
[[nodiscard]] bool can_be_laid_over(const FramePair& pair);
/// Contrast below which a photograph is plain among its series: half of the median. A surface on which nothing has
/// happened yet shows its grain and the noise alone. @param neighbors  In order; 0 of none.
[[nodiscard]] double plain_contrast(const std::vector<FramePair>& neighbors);
/// Sets `is_plain`: one of the two is plainer than `plain_contrast`, but most of the picture keeps its color (median
/// ratios within 0.2, or 0.4 where nothing else changes by 0.04). Nothing says that they show another view, whatever
/// their detail does.
void mark_plain(FramePair& pair, double plain_contrast);
/// It cannot: another view, another crop, another object, or aging that left little alike. Pictures without texture and
/// plain pairs say nothing.
[[nodiscard]] bool is_unmatched(const FramePair& pair);

/// Problem of a photograph against the one before.
struct FrameFinding {
  int frame = 0;      ///< Frame of the pair: the later one.
  int odd_frame = 0;  ///< Frame that stands out; `frame`, until find_odd_frames() says otherwise.
  int against = 0;    ///< From which one that is seen: the other of the pair, or the last before a run of odd ones.
  bool is_shifted = false;
  bool is_exposure_changed = false;
  bool is_light_unclear = false;  ///< Bright or colored differently, but the surface may be what changed.
  bool is_jump = false;           ///< It does not follow from the one before, and no motion explains it.
  bool is_unmatched = false;      ///< The pair is_unmatched().
  double similarity = 0.0;        ///< best_similarity() of the pair.
  /// From here on as the odd frame is seen from the other one.
  double shift_x = 0.0,
         shift_y = 0.0;               ///< Shift of the picture's middle, photograph's pixels; right and down positive.
  double turn_deg = 0.0, size = 1.0;  ///< Clockwise; 1.05 = 5 % larger.
  std::array<double, 3> gain{1.0, 1.0, 1.0};
  double change_factor = 1.0;  ///< Change of the surface against the neighbors' median.
};
/// Root mean square motion over the picture.
[[nodiscard]] double motion_size(const Eigen::Affine2d& motion, int width, int height);
/// Sets shift, turn and size of a finding. @param motion  Of the odd frame from the other one.
void describe_motion(const Eigen::Affine2d& motion, int width, int height, FrameFinding& finding);

/// Texts of a finding, kind by kind; empty where it has none.
struct FindingTexts {
  std::string moved;      ///< "moved by 12.3 px left and 21.8 px up, turned by -1.9 degrees, 4.7 % larger".
  std::string exposed;    ///< "light times 1.1, 1.1, 1.3 (red, green, blue)".
  std::string unclear;    ///< "brighter or darker times ..., which may be the light or the surface".
  std::string jump;       ///< "a jump: ..."; empty when `unmatched` says it.
  std::string unmatched;  ///< "cannot be laid over the one before: ...".
};
[[nodiscard]] FindingTexts finding_texts(const FrameFinding& finding);
/// All of them.
[[nodiscard]] std::string finding_text(const FrameFinding& finding);

/// Judges neighbors: pairs (i - 1, i) for i = 1, 2, ... in order.
///
/// - shifted: the motion fits (is_reliable), is larger than shift_threshold_px and makes up 0.3 of what its detail
/// lacked;
/// - exposure: the log gain of a channel (find_light_change(), where that is sure) is away from the median of the 8
/// pairs
///   on either side by more than exposure_threshold and six times their own median deviation: aging that brightens
///   steadily is no change of exposure. Where it is not sure the finding is unclear: the surface may have changed.
///   With fewer than 6 other pairs there is no usual course: then what 0.7 of the picture shares to within half of it
///   and is more than exposure_threshold is the light's; more than twice the threshold, not shared so, is unclear;
/// - jump: what is left when it is laid over the one before (1 - similarity, or the surface's change) exceeds
/// jump_factor times the same median, 0.75 of it times the
///   medians of the three nearest pairs on either side (the start of fast aging is no row of jumps) and, at an
///   end of the series, what steadily falling changes beside it lead to, and 0.1 (0.04). A moved pair is compared with
///   moved ones, if there are three, and must exceed twice as much;
/// - unmatched: is_unmatched(), however many of the neighbors are.
/// @param width,height  Of the photographs. @throws InvalidInput if an option is out of range.
[[nodiscard]] std::vector<FrameFinding> judge_frames(const std::vector<FramePair>& neighbors, int width, int height,
                                                     const SurveyOptions& options = {});

/// For files that a later step reads: equal pairs give equal text.
[[nodiscard]] Json pair_to_json(const FramePair& pair);
/// @throws IoError
[[nodiscard]] FramePair pair_from_json(JsonReader json);
[[nodiscard]] Json finding_to_json(const FrameFinding& finding);

}  // namespace patinate::capture
