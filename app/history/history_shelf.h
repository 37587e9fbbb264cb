/// \file
/// The library of histories to start from: what each is, and which is most like a history or a photograph.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/similarity/similarity.h"
#include "libcommon/history/history_card.h"
#include "patinate/analysis/texture_series.h"
#include "patinate/core/json.h"
#include "patinate/history/history.h"

namespace patinate::app {

/// A history of the library.
struct ShelfEntry {
  std::string name;
  std::shared_ptr<const HistoryReader> history;
  std::optional<HistoryCard> card;

  [[nodiscard]] const HistoryFacts& facts() const { return history->facts(); }
  [[nodiscard]] double duration() const { return facts().frames.back().time - facts().frames.front().time; }
  [[nodiscard]] std::string title() const { return card ? card->title : facts().name; }
  /// Members name, folder, title, origin, width, height, texel_size_mm, frames, duration, time_unit, controls, and
  /// those of its card.
  [[nodiscard]] Json json() const;
};
/// All that are found, by name; empty where there is no library. @throws IoError
[[nodiscard]] std::vector<ShelfEntry> history_shelf();

/// A history, a simulation, a transfer or a photograph, which is a history of one frame. @throws IoError
[[nodiscard]] analysis::TextureSeries series_or_photograph(const std::filesystem::path& path);
[[nodiscard]] analysis::TextureSeries series_of_photograph(ImageF color, const std::string& name);

/// How far an entry is from what it is compared with.
struct Likeness {
  std::size_t entry = 0;  ///< Index.
  analysis::Dissimilarity how;

  /// Members total, colors_delta_e, structure_octaves, rates_spans (null where unknown), time.
  [[nodiscard]] Json json() const;
};
/// The most similar first.
[[nodiscard]] std::vector<Likeness> rank_by_likeness(const analysis::TextureSeries& like,
                                                     const std::vector<ShelfEntry>& entries, const RunControl& control);

}  // namespace patinate::app
