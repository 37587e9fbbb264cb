/// \file
/// A history in memory: built from images, without a folder.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"

namespace patinate {

/// An image that belongs to something, by one of kFrameExtraNames or kHistoryMapNames.
struct NamedImage {
  std::string name;
  ImageF image;  ///< H x W x the channels of the name, finite.
};

struct MemoryFrame {
  double time = 0.0;  ///< Later than that of the frame before; as find_time_problem() wants them (history_times.h).
  ImageF color;       ///< H x W x 3, linear, finite.
  ImageU8 mask = {};  ///< H x W; 0 where the color is not the surface's. Empty: none of its own.
  std::vector<NamedImage> extras = {};  ///< Of different names.
  bool is_extrapolated = false;
};

struct MemoryControl {
  ControlFacts facts;     ///< A name of a file (file_name.h); low <= high, both within +-kLargestControl.
  ImageF values;          ///< H x W x 1 in [0, 1]: the share of the way from `low` to `high`.
  ImageF deviation = {};  ///< Their standard deviation, finite, >= 0. Empty: not known; facts.has_deviation follows it.
};

/// What a history consists of. Its size is that of the first frame.
struct MemoryHistoryImages {
  std::string name;
  std::string origin = "captured";           ///< One of kHistoryOriginNames.
  std::optional<double> texel_size_mm = {};  ///< Within kMinTexel_mm and kLargestTexel_mm (length_unit.h).
  TimeUnit time_unit = TimeUnit::Seconds;
  std::vector<MemoryFrame> frames;            ///< At least one.
  std::vector<MemoryControl> controls = {};   ///< Of different names.
  ImageU8 mask = {};                          ///< H x W; not 0 = inside, somewhere. Empty: everything is.
  std::vector<NamedImage> maps = {};          ///< Of different names.
  std::vector<LibraryPart> parts = {};        ///< Of a library.
  std::vector<HistoryWarning> warnings = {};  ///< The worst first.
};

/// Holds every image; reading copies one. Values are those that were given: a folder keeps colors as half floats.
class MemoryHistory final : public History {
 public:
  /// @throws InvalidInput, naming the history and what of it is wrong, unless everything is as above.
  explicit MemoryHistory(MemoryHistoryImages images);

  [[nodiscard]] const HistoryFacts& facts() const override { return facts_; }
  [[nodiscard]] const std::string& label() const override { return label_; }

 private:
  [[nodiscard]] ImageF load_frame(std::size_t frame) const override { return images_.frames[frame].color; }
  [[nodiscard]] ImageF load_control(std::size_t control) const override { return images_.controls[control].values; }
  [[nodiscard]] ImageF load_control_deviation(std::size_t control) const override {
    return images_.controls[control].deviation;
  }
  [[nodiscard]] ImageU8 load_mask() const override { return images_.mask; }
  [[nodiscard]] ImageF load_map(std::size_t map) const override { return images_.maps[map].image; }
  [[nodiscard]] ImageF load_frame_extra(std::size_t frame, std::size_t extra) const override {
    return images_.frames[frame].extras[extra].image;
  }
  [[nodiscard]] ImageU8 load_frame_mask(std::size_t frame) const override { return images_.frames[frame].mask; }

  MemoryHistoryImages images_;
  HistoryFacts facts_;
  std::string label_;
};

/// All of a history. Memory: that of all its images as floats. @throws as History; Canceled.
[[nodiscard]] MemoryHistory read_into_memory(const History& history, const RunControl& control = {});

}  // namespace patinate
