/// \file
/// A history as a value: what every algorithm takes, wherever the history is kept. history.h reads one from a folder,
/// memory_history.h makes one of images.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/image/image.h"

namespace patinate {

enum class TimeUnit { Seconds, Minutes, Hours, Days, Years };  ///< Years of 365.25 d.
/// "s", "min", "h", "d", "a".
[[nodiscard]] std::string time_unit_text(TimeUnit unit);
/// @throws InvalidInput
[[nodiscard]] TimeUnit parse_time_unit(const std::string& text);
[[nodiscard]] double seconds_per(TimeUnit unit);

inline constexpr int kMaxHistorySide_px = 65536;
inline constexpr double kLargestControl = 1e30;  ///< Largest absolute value of a control; pixels are floats.
inline constexpr std::array<std::string_view, 3> kHistoryOriginNames{"captured", "simulated", "synthetic"};

/// Maps that frames may have in addition to color: (list unchanged). Unknown values are 0; unknown metalness means
/// nonmetal.
inline constexpr std::array<std::string_view, 6> kFrameExtraNames{"stddev", "specular",  "normal",
                                                                  "height", "metalness", "tint"};
/// Images that are constant in time. `position` and `normal`: X, Y, Z; `height` and `texel_size`: Y. mm, or unit
/// vectors; 0 where there is no surface. `specular`, `metalness` and `tint` as frames have them.
inline constexpr std::array<std::string_view, 7> kHistoryMapNames{"position", "normal",    "height", "texel_size",
                                                                  "specular", "metalness", "tint"};
/// Names of the channels, as files have them. @throws InvalidInput listing the names there are.
[[nodiscard]] const std::vector<std::string>& frame_extra_channels(const std::string& name);
[[nodiscard]] const std::vector<std::string>& history_map_channels(const std::string& name);

/// A control parameter; its values are normalized to [0, 1].
struct ControlFacts {
  std::string name;
  double low = 0.0;            ///< Physical value that 0 stands for.
  double high = 1.0;           ///< Physical value that 1 stands for.
  std::string unit = "";       ///< "1/mm", "relative", ...
  bool has_deviation = false;  ///< It has read_control_deviation().

  friend bool operator==(const ControlFacts&, const ControlFacts&) = default;
};

struct FrameFacts {
  double time = 0.0;                     ///< In the history's time unit; strictly increasing.
  bool has_mask = false;                 ///< It says of its own where its color is the surface's.
  std::vector<std::string> extras = {};  ///< What it has more than color, in the order of kFrameExtraNames.
  bool is_extrapolated = false;          ///< Nobody saw it: a model continues from where the frames end.

  friend bool operator==(const FrameFacts&, const FrameFacts&) = default;
};

/// One of several histories that lie side by side in one: a library (`patinate history combine`). Everything but
/// transfers sees one history.
struct LibraryPart {
  std::string name;
  int x = 0;  ///< Its first column; its first row is 0.
  int width = 0;
  int height = 0;
  std::string key;  ///< Content key of the history that it was made from.

  friend bool operator==(const LibraryPart&, const LibraryPart&) = default;
};
/// The control of a library that says which part a pixel belongs to: its physical value is the part's index.
inline constexpr const char* kLibraryControl = "history";
inline constexpr const char* kLibraryControlUnit = "index";
inline constexpr int kMaxLibraryParts = 64;

/// Subject of a history's warning, so that a user can judge its relevance.
enum class WarningSubject { Mask, Motion, Light, Control, Series };
inline constexpr std::array<std::string_view, 5> kWarningSubjectNames{"mask", "motion", "light", "control", "series"};

/// Something found while a history was made that may make it wrong, or smaller than it looks.
struct HistoryWarning {
  WarningSubject about = WarningSubject::Series;
  std::string text;                      ///< What was found, with its figure; names the photographs it speaks of.
  std::string cure;                      ///< What helps, as an instruction; "" = nothing is known.
  double share = 0.0;                    ///< Roughly how much of the history it spoils, [0, 1]: the worst come first.
  std::vector<std::string> photos = {};  ///< Names of the photographs, without folders; may be empty.

  friend bool operator==(const HistoryWarning&, const HistoryWarning&) = default;
};
/// "TEXT: CURE".
[[nodiscard]] std::string warning_text(const HistoryWarning& warning);
/// The worst first; equal ones keep their order.
void sort_warnings(std::vector<HistoryWarning>& warnings);

/// All that is known of a history before a pixel is looked at.
/// Something that reports say of the sample: what it is, and a value as text.
struct SampleFact {
  std::string name;  ///< "coating"
  std::string text;  ///< "epoxy, 120 um"

  friend bool operator==(const SampleFact&, const SampleFact&) = default;
};
inline constexpr std::size_t kMaxSampleFacts = 50;

struct HistoryFacts {
  std::string name;
  std::string origin = "captured";  ///< One of kHistoryOriginNames.
  int width = 0;
  int height = 0;
  std::optional<double> texel_size_mm;
  TimeUnit time_unit = TimeUnit::Seconds;
  std::vector<FrameFacts> frames;      ///< At least one.
  std::vector<ControlFacts> controls;  ///< Of different names.
  bool has_mask = false;
  std::vector<std::string> maps;   ///< In the order of kHistoryMapNames.
  std::vector<LibraryPart> parts;  ///< From left to right, apart from each other; empty: the history is no library.
  std::vector<HistoryWarning> warnings = {};  ///< The worst first.
  std::vector<SampleFact> sample = {};

  friend bool operator==(const HistoryFacts&, const HistoryFacts&) = default;
};
/// @throws InvalidInput if some frames have `metalness` or `tint` and others have not, or `specular`, `metalness` or
/// `tint` is both a map that is constant and one of frames.
void check_material_maps(const HistoryFacts& facts);
/// @throws InvalidInput if parts leave the history, lie over one another, or kLibraryControl is missing beside them.
void check_library_parts(const HistoryFacts& facts);

/// Position of a time between frames: frames `index` and `index + 1` with the weights (1 - fraction) and fraction.
/// Clamped to the ends.
struct TimePosition {
  int index = 0;
  double fraction = 0.0;
};

/// A material history: color of a surface over time, with its controls. Nothing here says where it is kept. Immutable
/// and thread-safe.
class History {
 public:
  virtual ~History() = default;

  [[nodiscard]] virtual const HistoryFacts& facts() const = 0;
  /// Name in messages: the folder, or the history's name.
  [[nodiscard]] virtual const std::string& label() const = 0;

  [[nodiscard]] int num_frames() const { return static_cast<int>(facts().frames.size()); }
  [[nodiscard]] std::vector<double> times() const;
  /// H x W x 3, linear. @throws InvalidInput if there is no such index; IoError if a file is truncated or holds NaN.
  [[nodiscard]] ImageF read_frame(int index) const;
  /// H x W x 1 in [0, 1]. @throws InvalidInput if there is no such control; IoError if a value is outside.
  [[nodiscard]] ImageF read_control(const std::string& name) const;
  /// Standard deviation of read_control(), in the same units: H x W x 1, >= 0; nothing when it is not known.
  /// @throws InvalidInput if there is no such control; IoError if a value is negative.
  [[nodiscard]] std::optional<ImageF> read_control_deviation(const std::string& name) const;
  /// 0 / 255; all 255 when the history has no mask. @throws IoError if it is 0 everywhere.
  [[nodiscard]] ImageU8 read_mask() const;
  /// H x W x the channels of the map. @throws InvalidInput listing the maps there are; IoError.
  [[nodiscard]] ImageF read_map(const std::string& name) const;
  /// What a frame has more than color: H x W x (3, 2, 3, 1, 1, 3) for the names of kFrameExtraNames; nothing when the
  /// frame has none of it.
  /// @throws InvalidInput if there is no such index or name; IoError.
  [[nodiscard]] std::optional<ImageF> read_frame_extra(int index, const std::string& name) const;
  /// Where frame `index` shows the surface itself: read_mask() and the frame's own mask. 0 / 255; may be 0 everywhere.
  /// @throws InvalidInput if there is no such index; IoError.
  [[nodiscard]] ImageU8 read_frame_mask(int index) const;
  /// @throws InvalidInput listing the names there are.
  [[nodiscard]] const ControlFacts& control(const std::string& name) const;
  /// @throws InvalidInput if `time` is NaN.
  [[nodiscard]] TimePosition locate(double time) const;
  /// The history at any time: two frames and a blend. Equal to read_frame() at frame times, to the bit.
  [[nodiscard]] ImageF sample(double time) const;

 protected:
  History() = default;
  History(const History&) = default;
  History(History&&) = default;
  History& operator=(const History&) = default;
  History& operator=(History&&) = default;

 private:
  // Of the facts' size, and checked. Indices are of the facts' lists.
  [[nodiscard]] virtual ImageF load_frame(std::size_t frame) const = 0;
  [[nodiscard]] virtual ImageF load_control(std::size_t control) const = 0;
  [[nodiscard]] virtual ImageF load_control_deviation(std::size_t control) const = 0;  ///< Where has_deviation.
  [[nodiscard]] virtual ImageU8 load_mask() const = 0;                                 ///< Asked for where has_mask.
  [[nodiscard]] virtual ImageF load_map(std::size_t map) const = 0;
  [[nodiscard]] virtual ImageF load_frame_extra(std::size_t frame, std::size_t extra) const = 0;
  [[nodiscard]] virtual ImageU8 load_frame_mask(
      std::size_t frame) const = 0;  ///< Asked for where the frame's has_mask.

  [[nodiscard]] std::size_t checked(int index) const;
  [[nodiscard]] std::size_t control_index(const std::string& name) const;
};

}  // namespace patinate
