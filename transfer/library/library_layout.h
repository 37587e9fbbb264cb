/// \file
/// Several histories as one: where each lies, at which times, and what their controls have in common. Numbers only;
/// library_images.h lays pixels, library_job.h makes the folder.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/history/history.h"

namespace patinate::transfer {

/// Moments of the histories that become one time.
enum class LibraryClock {
  Absolute,  ///< Equal times, in the unit of the first.
  Span,      ///< Equal shares of each history's own span; times are those of the first.
};
inline constexpr std::array<std::string_view, 2> kLibraryClockNames{"absolute", "span"};

struct LibraryOptions {
  LibraryClock clock = LibraryClock::Absolute;
  std::optional<double> texel_size_mm =
      {};  ///< > 0. Of the library, and of histories that do not say theirs; not given: the finest that one says.
};
void describe(OptionVisitor& v, LibraryOptions& o);

/// One of the histories that are combined.
struct LibrarySource {
  HistoryManifest manifest;
  std::string shown;  ///< Name in messages: its path.
  std::string key;    ///< Content key.
  bool is_library = false;
};

/// Controls of the histories, one each, that become one of the library.
struct LibraryControl {
  std::string name;
  std::vector<std::string> sources;  ///< By history.
  /// Filled in by lay_out_library(): one range in one unit; or, where units differ, "relative": [0, 1] of each
  /// history's own range.
  double low = 0.0, high = 1.0;
  std::string unit = "relative";
  bool has_own_ranges = false;
};

/// A frame of the library: where in each history's frames it falls. A history's own frame has fraction 0.
struct LibraryFrame {
  double time = 0.0;
  std::vector<TimePosition> at;
};

struct LibraryLayout {
  int width = 0;
  int height = 0;  ///< Height of the tallest history.
  std::optional<double> texel_size_mm;
  TimeUnit time_unit = TimeUnit::Seconds;
  std::vector<LibraryPart>
      parts;  ///< First columns are multiples of kLibraryGutter_px, and as far at least from the part before.
  std::vector<LibraryFrame> frames;      ///< At the union of all histories' times.
  std::vector<LibraryControl> controls;  ///< Without kLibraryControl.
  std::vector<std::string> notes;        ///< Notes for the user: sentences without a full stop.
};

/// Between two histories: no neighborhood that is compared on the finest level crosses it, and pixels halved four times
/// are those of each history alone.
inline constexpr int kLibraryGutter_px = 16;

/// Lays histories side by side. A history is resampled if its texel size makes its size differ by half a pixel or more
/// (its part then has another size than its manifest); all others are copied exactly. Times that differ by less than
/// 1e-9 of the whole span count as equal. Before its first frame and after its last one, a history shows that frame.
/// @param asked  Controls with a name, and a source in each history. Controls that all histories have under the same
/// name are added automatically.
/// @throws InvalidInput unless there are 2 to kMaxLibraryParts histories. Also for a history that is a library, has a
/// control named kLibraryControl, lacks an asked control or has a span of zero; if only some histories state a texel
/// size; and for more than 65536 columns or 2^31 - 1 pixels in all.
[[nodiscard]] LibraryLayout lay_out_library(std::span<const LibrarySource> sources,
                                            const std::vector<LibraryControl>& asked,
                                            const LibraryOptions& options = {});

}  // namespace patinate::transfer
