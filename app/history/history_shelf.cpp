#include "app/history/history_shelf.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/request/history_library.h"
#include "app/request/path_kind.h"
#include "patinate/history/memory_history.h"
#include "patinate/image/image_io.h"

namespace patinate::app {

namespace {}  // namespace

Json ShelfEntry::json() const {
  Json controls = Json::array();
  for (const ControlFacts& control : facts().controls) controls.push_back(control.name);
  Json json{{"name", name},
            {"folder", history->folder().string()},
            {"title", title()},
            {"origin", facts().origin},
            {"width", facts().width},
            {"height", facts().height},
            {"texel_size_mm", optional_json(facts().texel_size_mm)},
            {"frames", facts().frames.size()},
            {"duration", duration()},
            {"time_unit", time_unit_text(facts().time_unit)},
            {"controls", controls}};
  if (card) {
    json["about"] = card->about;
    json["license"] = card->license;
    json["attribution"] = card->attribution;
    json["source"] = card->source;
  }
  return json;
}

std::vector<ShelfEntry> history_shelf() {
  std::vector<ShelfEntry> entries;
  for (const LibraryEntry& found : library_entries())
    entries.push_back(
        {found.name, std::make_shared<const HistoryReader>(found.folder), read_history_card(found.folder)});
  return entries;
}

analysis::TextureSeries series_of_photograph(ImageF color, const std::string& name) {
  MemoryHistoryImages images{.name = name, .frames = {}};
  images.frames.push_back({.time = 0.0, .color = std::move(color)});
  return analysis::TextureSeries(std::make_shared<const MemoryHistory>(std::move(images)));
}

analysis::TextureSeries series_or_photograph(const std::filesystem::path& path) {
  if (kind_of(path) == PathKind::Image) return series_of_photograph(read_color(path), path.filename().string());
  return analysis::open_series(history_place(path)).series;
}

Json Likeness::json() const {
  return {{"total", how.total},
          {"colors_delta_e", how.colors},
          {"structure_octaves", optional_json(how.structure)},
          {"rates_spans", optional_json(how.rates)},
          {"time", how.time}};
}

std::vector<Likeness> rank_by_likeness(const analysis::TextureSeries& like, const std::vector<ShelfEntry>& entries,
                                       const RunControl& control) {
  const double part = 1.0 / static_cast<double>(entries.size() + 1);
  const analysis::SurfaceDescriptor mine = analysis::describe_surface(like, control.part(0.0, part));
  std::vector<Likeness> ranking;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const RunControl stage = control.part(part * static_cast<double>(i + 1),
                                          i + 1 == entries.size() ? 1.0 : part * static_cast<double>(i + 2));
    const analysis::TextureSeries series(entries[i].history);
    ranking.push_back({i, analysis::dissimilarity(mine, analysis::describe_surface(series, stage))});
  }
  std::stable_sort(ranking.begin(), ranking.end(),
                   [](const Likeness& a, const Likeness& b) { return a.how.total < b.how.total; });
  return ranking;
}

}  // namespace patinate::app
