/// \file
/// A transfer whose control is painted in the page: strokes change its texture at once, and a file of edits beside it
/// keeps them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/history/history_sampling.h"
#include "tools/studio/served_folder.h"
#include "tools/studio/tile_planes.h"
#include "transfer/editing/transfer_editor.h"

namespace patinate::studio {

/// What a page asks of a painted transfer.
struct PaintRequest {
  enum class What { Look, Stroke, Refine, Undo, Redo };
  What what = What::Look;
  transfer::TransferEdit edit = {};  ///< Of a stroke.
  std::int64_t gesture = 0;          ///< Of a stroke: those of one gesture are one step.
  double time = 0.0;                 ///< That the page shows.
  Between between = Between::Blend;
};
/// @throws InvalidInput, IoError
[[nodiscard]] PaintRequest parse_paint_request(const std::string& body);

/// Thread-safe; one request after the other.
class PaintedTransfer {
 public:
  /// Edits that lie beside the transfer are applied again.
  /// @throws InvalidInput if it is the served folder itself, too large, or cannot be edited; IoError; Canceled
  PaintedTransfer(const ServedFolder& folder, const std::filesystem::path& place, const RunControl& control);

  /// Does it, and writes the file of edits. @returns a binary message: the tiles that the page has to replace, 8 x 8
  /// texels of the color at that time, as /api/texture gives it (docs/studio_protocol.md).
  [[nodiscard]] std::string answer(const PaintRequest& request, const RunControl& control);

 private:
  struct Step {
    std::string label;
    std::int64_t gesture = 0;  ///< Of its strokes; 0: it was made otherwise.
    int num_edits = 1;
  };
  void apply(const PaintRequest& request, const RunControl& control);
  void mark(std::span<const TexelId> texels);
  [[nodiscard]] std::string tiles(const PaintRequest& request, const RunControl& control);
  [[nodiscard]] Json header() const;
  void save();

  const ServedFolder& folder_;
  std::filesystem::path transfer_, file_;
  std::unique_ptr<transfer::TransferEditor> editor_;
  std::vector<std::uint32_t> shown_;  ///< By texel: itself, or beside the charts the nearest inside.
  std::vector<std::uint8_t> is_edited_, is_dirty_;
  std::vector<Step> done_, undone_;  ///< The last one is undone, and redone, first.
  std::string seen_;                 ///< Which time `color_` is of.
  ImageF color_;                     ///< Of the history.
  std::mutex mutex_;
};

/// Opened ones, the last two. Thread-safe.
class PaintedTransfers {
 public:
  /// One that has changed on disk since is opened again.
  [[nodiscard]] std::shared_ptr<PaintedTransfer> open(const ServedFolder& folder, const std::filesystem::path& place,
                                                      const RunControl& control);

 private:
  struct Entry {
    std::filesystem::path path;
    std::filesystem::file_time_type changed;
    std::shared_ptr<PaintedTransfer> painted;
  };
  std::mutex mutex_;
  std::list<Entry> entries_;  ///< Last used first.
};

}  // namespace patinate::studio
