#include "analysis/evaluation/tile_items.h"

#include <fstream>
#include <string>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/mapped_file.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

enum Stage { kSurvey = 0, kMeasure = 1, kConclude = 2 };

struct TriangleCount {
  std::int64_t triangle = 0, count = 0;
};

template <class T>
void write_values(const fs::path& file, const std::vector<T>& values) {
  write_atomically(file, std::string_view(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)));
}
template <class T>
std::vector<T> read_values(const fs::path& file) {
  const MappedFile mapped(file);
  const auto all = mapped.all<T>();
  return {all.begin(), all.end()};
}

/// One map's tiles, as items see them.
class TileWork {
 public:
  TileWork(std::shared_ptr<const EvaluationTask> task, std::size_t index) : task_(std::move(task)), index_(index) {}

  [[nodiscard]] const TilesToEvaluate& tiles() const { return *task_->maps[index_].tiles; }
  /// Below the output folder.
  [[nodiscard]] fs::path work_folder() const {
    return fs::path(kJobWorkFolder) / ("map" + std::to_string(index_) + "-tiles");
  }
  [[nodiscard]] fs::path file(const std::string& name, int tile) const {
    return work_folder() / (name + "." + std::to_string(tile));
  }
  [[nodiscard]] std::vector<fs::path> survey_files(int tile) const {
    std::vector<fs::path> files{file("texels", tile), file("counts", tile)};
    for (const std::string& name : tiles().survey_files) files.push_back(file(name, tile));
    return files;
  }
  [[nodiscard]] std::vector<fs::path> measure_files(int tile) const { return {file("sums", tile), file("more", tile)}; }

  void survey(int tile, const fs::path& folder, const RunControl& control) const {
    fs::create_directories(folder / work_folder());
    const std::shared_ptr<TexelMap> surface = tiles().surface(control);
    const TexelRect rect = cell_of(tiles().sheet, tile);
    const std::vector<std::int64_t> all = surface->count_texels(rect, control);
    std::vector<TriangleCount> counts;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all[i] > 0) counts.push_back({static_cast<std::int64_t>(i), all[i]});
    }
    write_values(folder / file("texels", tile), counts);
    const PartCounts own = count_part(*surface, rect);
    write_values(folder / file("counts", tile), std::vector<std::int64_t>{own.texels, own.patches, own.charts});
    tiles().survey(tile, *surface, folder / work_folder(), control);
  }

  void measure(int tile, const fs::path& folder, const RunControl& control) const {
    const OpenedTiles opened = open(folder, control);
    PartCounts before, all;
    for (int other = 0; other < tiles().sheet.num_tiles(); ++other) {
      if (other == tile) before = all;
      const auto own = read_values<std::int64_t>(folder / file("counts", other));
      all.add({own.at(0), own.at(1), own.at(2)});
    }
    write_values(folder / file("more", tile),
                 opened.measure_more ? opened.measure_more(tile, before.texels, control) : std::vector<std::int64_t>{});
    const MapFigures figures(opened.source, opened.map, task_->options, task_->seed, control);
    write_map_sums(folder / file("sums", tile),
                   figures.measure(tile, opened.coordinates, opened.wanted ? opened.wanted(tile, control) : ImageF(),
                                   before, all, nullptr, control));
  }

  [[nodiscard]] ConcludedMap conclude(const fs::path& folder, const RunControl& control) const {
    OpenedTiles opened = open(folder, control);
    MapSums sums;
    std::vector<std::int64_t> more;
    for (int tile = 0; tile < tiles().sheet.num_tiles(); ++tile) {
      sums.add(read_map_sums(folder / file("sums", tile)));
      const auto own = read_values<std::int64_t>(folder / file("more", tile));
      more.insert(more.end(), own.begin(), own.end());
    }
    ConcludedMap made;
    if (opened.more) made.more = opened.more(more);
    const MapFigures figures(opened.source, opened.map, task_->options, task_->seed, control);
    made.evaluation = figures.conclude(std::move(sums), false, control);
    made.source = std::move(opened.source);
    return made;
  }

 private:
  [[nodiscard]] OpenedTiles open(const fs::path& folder, const RunControl& control) const {
    const std::shared_ptr<TexelMap> surface = tiles().surface(control);
    std::vector<std::int64_t> counts(surface->mesh().triangles.size());
    for (int tile = 0; tile < tiles().sheet.num_tiles(); ++tile) {
      for (const TriangleCount& c : read_values<TriangleCount>(folder / file("texels", tile)))
        counts.at(static_cast<std::size_t>(c.triangle)) += c.count;
    }
    surface->count_is(counts);
    return tiles().open(surface, folder / work_folder(), control);
  }

  std::shared_ptr<const EvaluationTask> task_;
  std::size_t index_;
};

}  // namespace

void add_tile_items(
    JobPlan& plan, const std::shared_ptr<const EvaluationTask>& task, std::size_t index, std::vector<fs::path> outputs,
    std::function<void(const fs::path& folder, ConcludedMap made, const RunControl& control)> conclude) {
  const auto work = std::make_shared<const TileWork>(task, index);
  const std::string map = "map" + std::to_string(index);
  const int num_tiles = work->tiles().sheet.num_tiles();
  for (int tile = 0; tile < num_tiles; ++tile) {
    const std::string number = "." + std::to_string(tile);
    plan.items.push_back({.name = map + "-survey" + number,
                          .outputs = work->survey_files(tile),
                          .run =
                              [=](const fs::path& folder, const RunControl& control) {
                                work->survey(tile, folder, control.silent());
                                control.report(1.0);
                              },
                          .stage = kSurvey});
    plan.items.push_back({.name = map + "-tile" + number,
                          .outputs = work->measure_files(tile),
                          .run =
                              [=](const fs::path& folder, const RunControl& control) {
                                work->measure(tile, folder, control.silent());
                                control.report(1.0);
                              },
                          .stage = kMeasure,
                          .weight = 10.0});
  }
  plan.items.push_back({.name = map,
                        .outputs = std::move(outputs),
                        .run =
                            [=](const fs::path& folder, const RunControl& control) {
                              conclude(folder, work->conclude(folder, control.silent()), control);
                              control.report(1.0);
                            },
                        .stage = kConclude});
}

}  // namespace patinate::analysis
