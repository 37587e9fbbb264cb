#include "tools/patinate/services/evaluated_tiles.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>

#include "libcommon/core/mapped_file.h"
#include "libcommon/core/text.h"
#include "libcommon/image/image_rows.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "tools/patinate/command_line/repeating_command.h"
#include "tools/patinate/services/evaluated_maps.h"
#include "transfer/files/flow_io.h"
#include "transfer/synthesis/map_audit.h"
#include "transfer/synthesis/transfer_controls.h"
#include "transfer/tiles/tile_controls.h"
#include "transfer/tiles/tile_files.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr int kRows = 64;  ///< Of a file at a time.

struct TriangleFrame {
  std::int64_t triangle = 0;
  std::array<double, 6> frame = {};
};

/// A tile's image, row by row. @param channels  In the file. @param visit  Called with y and the row's values.
template <class Visit>
void for_each_row(const fs::path& file, const Sheet& sheet, const std::vector<std::string>& channels, int begin,
                  int end, const Visit& visit) {
  ImageRowReader reader(file, channels);
  if (reader.width() != sheet.tile_width || reader.height() != sheet.tile_height) {
    throw IoError(file.string(), "is " + size_text(reader.width(), reader.height()) + "; expected " +
                                     size_text(sheet.tile_width, sheet.tile_height));
  }
  for (int first = begin; first < end; first += kRows) {
    const ImageF rows = reader.read(first, std::min(first + kRows, end));
    for (int y = 0; y < rows.height(); ++y) visit(first + y, rows.row(y));
  }
}

/// A transfer's folder, read a tile at a time.
class TransferTiles {
 public:
  TransferTiles(fs::path path, const analysis::EvaluationOptions& options, std::uint64_t seed,
                const transfer::CacheOptions& cache)
      : folder_(path), options_(options), seed_(seed), cache_(cache), name_(std::move(path)) {}

  [[nodiscard]] const transfer::TransferManifest& manifest() const { return folder_.manifest(); }
  [[nodiscard]] const Sheet& sheet() const { return folder_.sheet(); }
  [[nodiscard]] std::vector<std::string> survey_files() const {
    std::vector<std::string> files{"flow"};
    for (std::size_t c = 0; c < manifest().controls.size(); ++c)
      files.insert(files.end(), {"values" + std::to_string(c), "sorted" + std::to_string(c)});
    return files;
  }
  [[nodiscard]] std::shared_ptr<TexelMap> surface(const RunControl& control) const {
    return std::make_shared<TexelMap>(sheet_mesh(folder_.read_atlas(), sheet()), sheet(), control,
                                      TexelFinding::WhereLooked);
  }

  void survey(int tile, const TexelMap& surface, const fs::path& folder, const RunControl& control) const {
    const TexelRect rect = cell_of(sheet(), tile);
    std::vector<TriangleFrame> flow;
    if (manifest().flow != "uv") {
      FlowFrames frames(surface.mesh().triangles.size(), FlowFrame::Zero());
      read_flow_tile(manifest(), surface, tile, frames);
      for (std::size_t i = 0; i < frames.size(); ++i) {
        if (frames[i].isZero(0.0)) continue;
        TriangleFrame& f = flow.emplace_back();
        f.triangle = static_cast<std::int64_t>(i);
        std::copy_n(frames[i].data(), f.frame.size(), f.frame.begin());
      }
    }
    transfer::write_array(folder / ("flow." + std::to_string(tile)), std::span<const TriangleFrame>(flow));
    for (std::size_t c = 0; c < manifest().controls.size(); ++c) {
      ImageF values(rect.width(), rect.height());
      const fs::path file = tile_path(manifest().controls[c].file, sheet().names[tile]);
      for_each_row(file, sheet(), {"Y"}, 0, sheet().tile_height, [&](int y, std::span<const float> row) {
        std::copy(row.begin(), row.end(), &values.at(sheet().margin(), sheet().margin() + y));
      });
      write_control_files(files_of(folder, c), tile, surface, rect, values.values(), control);
    }
  }

  [[nodiscard]] analysis::OpenedTiles open(std::shared_ptr<const TexelMap> surface, const fs::path& folder) const;

 private:
  [[nodiscard]] static transfer::ControlFiles files_of(const fs::path& folder, std::size_t control) {
    const std::string number = std::to_string(control);
    return {.values = [=](int tile) { return folder / ("values" + number + "." + std::to_string(tile)); },
            .sorted = [=](int tile) { return folder / ("sorted" + number + "." + std::to_string(tile)); }};
  }
  [[nodiscard]] ImageU8 source_mask() const {
    return transfer::usable_mask(folder_.history(),
                                 manifest().source_mask ? read_mask(*manifest().source_mask) : ImageU8());
  }
  [[nodiscard]] FlowFrames frames(const TexelMap& surface, const fs::path& folder) const {
    FlowFrames frames = uv_frames(surface);
    for (int tile = 0; tile < sheet().num_tiles(); ++tile) {
      const MappedFile file(folder / ("flow." + std::to_string(tile)));
      for (const TriangleFrame& f : file.all<TriangleFrame>())
        std::copy(f.frame.begin(), f.frame.end(), frames.at(static_cast<std::size_t>(f.triangle)).data());
    }
    return frames;
  }
  [[nodiscard]] ImageF wanted(std::size_t control, int tile, const TexelMap& surface, const fs::path& folder,
                              const ImageU8& mask, const RunControl& run) const {
    const transfer::RecordedControl& c = manifest().controls[control];
    const transfer::TransferControl spec{c.source, c.destination, {}, c.range, c.weight, c.mapping};
    return transfer::match_tile(files_of(folder, control), tile, sheet().num_tiles(), surface, cell_of(sheet(), tile),
                                spec, folder_.history(), mask, run);
  }
  /// Of a rectangle inside one tile.
  void read_coordinates(const TexelRect& rect, const analysis::CoordinateVisitor& visit) const {
    for (int tile = 0; tile < sheet().num_tiles(); ++tile) {
      if (!cell_of(sheet(), tile).contains(rect.x0, rect.y0)) continue;
      const int x0 = sheet().first_x(tile), y0 = sheet().first_y(tile);
      std::vector<float> row(2 * static_cast<std::size_t>(rect.width()), -1.0f);
      const int left = std::max(x0, rect.x0), right = std::min(x0 + sheet().tile_width, rect.x1);
      const int begin = std::clamp(rect.y0 - y0, 0, sheet().tile_height),
                end = std::clamp(rect.y1 - y0, 0, sheet().tile_height);
      for_each_row(manifest().tiles[tile].coordinates, sheet(),
                   {transfer::kCoordinateChannels[0], transfer::kCoordinateChannels[1]}, begin, end,
                   [&](int y, std::span<const float> values) {
                     std::copy(values.begin() + 2 * (left - x0), values.begin() + 2 * (right - x0),
                               row.begin() + 2 * (left - rect.x0));
                     visit(y0 + y, row);
                   });
    }
  }
  [[nodiscard]] std::vector<std::int64_t> audit(int tile, std::int64_t before, const analysis::OpenedTiles& opened,
                                                const std::vector<ImageF>& wanted, const RunControl& control) const;

  transfer::TransferFolder folder_;
  analysis::EvaluationOptions options_;
  std::uint64_t seed_;
  transfer::CacheOptions cache_;
  fs::path name_;
};

std::vector<std::int64_t> TransferTiles::audit(int tile, std::int64_t before, const analysis::OpenedTiles& opened,
                                               const std::vector<ImageF>& wanted, const RunControl& control) const {
  const transfer::TransferManifest& m = manifest();
  const HistoryReader history(folder_.history().folder());  // Its pixels, as the transfer compared them.
  transfer::MapToAudit made{.surface = opened.map.surface,
                            .coordinates = {},
                            .pixel_mm = m.texel_size_mm,
                            .controls = {},
                            .frames = opened.map.frames,
                            .source_mask = opened.source.mask};
  for (std::size_t i = 0; i < m.controls.size(); ++i)
    made.controls.push_back({m.controls[i].source, wanted[i], m.controls[i].weight});
  const TexelMap& surface = *opened.map.surface;
  const auto look_up = [&](const std::vector<TexelId>& texels, const transfer::TileToAudit::Visit& visit) {
    analysis::SourceIndices indices(opened.map.name, surface.num_texels(), opened.source.width(),
                                    opened.source.height());
    indices.read(surface, texels, opened.coordinates);
    for (const TexelId t : texels) visit(t, indices.x(t), indices.y(t));
  };
  std::vector<std::int64_t> numbers;
  for (const transfer::AuditedTexel& t :
       transfer::audit_tile(history, made, {tile, before, look_up}, m.measured_with, options_.num_audits, seed_,
                            control, transfer::appearance_source(history, cache_)))
    numbers.insert(numbers.end(), {t.own, t.least});
  return numbers;
}

analysis::OpenedTiles TransferTiles::open(std::shared_ptr<const TexelMap> surface, const fs::path& folder) const {
  const transfer::TransferManifest& m = manifest();
  analysis::OpenedTiles out;
  out.source = evaluated_source(folder_.history(), m.controls.empty() ? "" : m.controls.front().source, m.texel_size_mm,
                                options_.num_times);
  out.source.mask = source_mask();
  out.map = {.name = input_name(name_),
             .surface = surface,
             .frames = std::make_shared<const FlowFrames>(frames(*surface, folder)),
             .has_control = !m.controls.empty()};
  out.coordinates = [this](const TexelRect& rect, const analysis::CoordinateVisitor& visit) {
    read_coordinates(rect, visit);
  };
  if (m.controls.empty()) return out;
  out.wanted = [this, surface, folder, mask = out.source.mask](int tile, const RunControl& control) {
    return wanted(0, tile, *surface, folder, mask, control);
  };
  if (options_.num_audits > 0) {
    out.measure_more = [this, folder, opened = std::make_shared<analysis::OpenedTiles>(out)](
                           int tile, std::int64_t before, const RunControl& control) {
      std::vector<ImageF> all;
      for (std::size_t c = 0; c < manifest().controls.size(); ++c)
        all.push_back(wanted(c, tile, *opened->map.surface, folder, opened->source.mask, control));
      return audit(tile, before, *opened, all, control);
    };
  }
  out.more = [this](const std::vector<std::int64_t>& numbers) {
    std::vector<transfer::AuditedTexel> audited;
    for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) audited.push_back({numbers[i], numbers[i + 1]});
    return transfer_figures(manifest(),
                            options_.num_audits > 0 ? std::optional(transfer::summary_of(audited)) : std::nullopt);
  };
  return out;
}

}  // namespace

std::optional<analysis::TilesToEvaluate> transfer_tiles(const fs::path& transfer,
                                                        const analysis::EvaluationOptions& options, std::uint64_t seed,
                                                        const transfer::CacheOptions& cache) {
  const transfer::TransferManifest manifest = transfer::read_transfer_manifest(transfer);
  if (manifest.sheet().num_tiles() == 1) return std::nullopt;
  for (const transfer::RecordedControl& c : manifest.controls) {
    if (c.source == kLibraryControl) return std::nullopt;
  }
  const auto tiles = std::make_shared<const TransferTiles>(transfer, options, seed, cache);
  return analysis::TilesToEvaluate{
      .sheet = tiles->sheet(),
      .surface = [tiles](const RunControl& control) { return tiles->surface(control); },
      .survey_files = tiles->survey_files(),
      .survey = [tiles](int tile, const TexelMap& surface, const fs::path& folder,
                        const RunControl& control) { tiles->survey(tile, surface, folder, control); },
      .open = [tiles](std::shared_ptr<const TexelMap> surface, const fs::path& folder,
                      const RunControl&) { return tiles->open(std::move(surface), folder); }};
}

}  // namespace patinate::cli
