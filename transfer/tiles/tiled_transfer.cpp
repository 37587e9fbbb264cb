#include "transfer/tiles/tiled_transfer.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "libcommon/controls/part_controls.h"
#include "libcommon/core/text.h"
#include "transfer/files/transfer_files.h"
#include "transfer/guidance/compared_control.h"
#include "transfer/guidance/control_matcher.h"
#include "transfer/synthesis/multi_level.h"
#include "transfer/synthesis/open_options.h"
#include "transfer/synthesis/passes.h"
#include "transfer/synthesis/pyramid.h"
#include "transfer/synthesis/source_levels.h"
#include "transfer/synthesis/structure_levels.h"
#include "transfer/synthesis/transfer_controls.h"
#include "transfer/tiles/prepared_tiles.h"
#include "transfer/tiles/tile_controls.h"
#include "transfer/tiles/tile_halo.h"

namespace patinate::transfer {

namespace {

ControlFiles files_of(const std::filesystem::path& folder, std::size_t control) {
  return {.values = [=](int tile) { return folder / tile_file::values(control, tile); },
          .sorted = [=](int tile) { return folder / tile_file::sorted(control, tile); }};
}

/// How many levels there are in all.
std::size_t read_num_levels(const std::filesystem::path& folder) {
  const MappedFile file(folder / tile_file::num_levels());
  return static_cast<std::size_t>(file.values<std::int64_t>(0, 1)[0]);
}

/// The similar pixels of the tiled levels, found from the coarsest down as synthesis does.
void write_similar(const std::filesystem::path& folder, std::size_t num_tiled, std::size_t num_levels,
                   const std::vector<SourceLevel>& sources, const RunControl& control) {
  SimilarPixels similar;
  for (std::size_t l = num_levels; l-- > 0;) {
    similar = similar_of_level(sources[l], l + 1 == num_levels ? nullptr : &sources[l + 1], similar, control);
    if (l < num_tiled) write_array(folder / tile_file::similar(l), std::span<const SimilarPixels::value_type>(similar));
  }
}

}  // namespace

TiledTransfer::TiledTransfer(TiledTask task) : task_(std::move(task)), grid_(task_.transfer.input.map->sheet()) {
  const TransferTask& t = task_.transfer;
  const TransferOptions& o = t.options;
  check_ranges(o);
  if (o.method != TransferMethod::Fast) throw InvalidInput("--method reference cannot be done by tile; use fast");
  for (const TransferControl& c : t.input.controls) {
    if (c.source == kLibraryControl && !t.history->facts().parts.empty())
      throw InvalidInput("--control " + std::string(kLibraryControl) +
                         " is matched over the whole atlas, which no process holds by tile");
  }
  for (const TransferControl& c : t.input.controls) require_part_control(c.destination);
  structure_ = find_structure(*t.history, usable_mask(*t.history, t.input.source_mask), o.appearance);
  num_refined_levels_ = num_refined_levels(structure_, o.quality);
  if (const int side = smallest_side(*t.history); side >> num_tiled_levels() < kSmallestSide) {
    throw InvalidInput(t.history->label() + ": is " + std::to_string(side) + " pixels wide; by tile it has to be " +
                       std::to_string(kSmallestSide << num_tiled_levels()) +
                       " at least, so that the levels of the whole atlas fit into memory; do without --by-tile");
  }
}

TiledTransfer::~TiledTransfer() = default;

int TiledTransfer::num_passes(std::size_t level) const {
  const MultiLevelOptions& o = task_.transfer.options.multi_level;
  return level == 0 ? o.fine_passes : o.coarse_passes;
}

int TiledTransfer::num_rounds(std::size_t level) const {
  return level < num_refined_levels_ ? refinement_options(structure_, task_.transfer.options.quality).num_rounds : 0;
}

const TiledTransfer::Prepared& TiledTransfer::prepare(const Folder& folder, const RunControl& control) {
  const std::lock_guard lock(mutex_);
  if (prepared_) return *prepared_;
  auto p = std::make_unique<Prepared>();
  const TransferInput& input = task_.transfer.input;
  const History& history = *task_.transfer.history;
  p->map = std::make_shared<TexelMap>(input.map->unsearched(control));
  std::vector<std::int64_t> counts(input.map->mesh().triangles.size());
  for (int tile = 0; tile < grid_.num_tiles(); ++tile) {
    const MappedFile file(folder / tile_file::texel_counts(tile));
    for (const TriangleCount& c : file.all<TriangleCount>()) counts[c.triangle] += c.count;
  }
  p->map->count_is(counts);
  if (p->map->num_covered() == 0)
    throw InvalidInput("the mesh's UVs cover no texel of the atlas; use a larger --resolution");
  const ImageU8 mask = usable_mask(history, input.source_mask);
  p->structure = facts_of(structure_);
  p->refused_line_share = structure_.refused_line_share;
  p->options =
      with_defaults(task_.transfer.options, !structure_.empty(), !task_.transfer.history->facts().parts.empty());
  p->options.turning = PieceTurning::Never;  // As in every atlas of several tiles.
  check_large_enough(history, mask, p->options.neighborhood_radius_px);
  for (const TransferControl& c : input.controls) p->weights.push_back(c.weight);
  p->neighborhood = Neighborhood::square(p->options.neighborhood_radius_px);
  const int halvings = source_halvings(p->map->median_texel_size_mm(), input.texel_size_mm, smallest_side(history));
  p->appearance =
      appearance_of(history, input.appearance,
                    halvings + usable_levels(history, halvings, p->map->width(), p->map->height(), p->options),
                    p->options.appearance, control, mask);
  p->first = std::min(static_cast<std::size_t>(halvings), p->appearance.levels.size() - 1);
  p->placement = place_source(*p->map, input.frames, input.texel_size_mm, static_cast<int>(p->first));
  std::vector<ImageF> controls;
  for (const TransferControl& c : input.controls)
    controls.push_back(compared_control(history, c.source, mask, control));
  p->source_controls = source_control_levels(p->appearance, controls, control);
  for (std::size_t l = p->first; l < p->appearance.levels.size(); ++l) {
    p->sources.push_back(make_pyramid_source(p->appearance, p->source_controls, l, p->first, p->neighborhood));
    if (p->sources.back().usable.empty()) {
      p->sources.pop_back();
      break;
    }
  }
  if (p->sources.size() <= num_tiled_levels()) {
    throw InvalidInput(history.label() + ": has " + std::to_string(p->sources.size()) +
                       " levels to copy from, and by tile " + std::to_string(num_tiled_levels() + 1) +
                       " are needed; do without --by-tile, or give more texels or a larger history");
  }
  p->structures = structure_levels(structure_, p->options.quality, p->first, p->sources.size(), control);
  prepared_ = std::move(p);
  return *prepared_;
}

void TiledTransfer::survey(int tile, const Folder& folder, const RunControl& control) {
  const RunControl silent = control.silent();
  const TransferTask& t = task_.transfer;
  const TexelMap map = t.input.map->unsearched(silent);
  const TexelRect rect = grid_.rect(0, tile);
  std::vector<TriangleCount> counts;
  const std::vector<std::int64_t> all = map.count_texels(rect, silent);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i] > 0) counts.push_back({static_cast<std::int64_t>(i), all[i]});
  }
  write_array(folder / tile_file::texel_counts(tile), std::span<const TriangleCount>(counts));
  for (std::size_t c = 0; c < t.input.controls.size(); ++c) {
    const ImageF values = make_part_control(t.input.controls[c].destination, map, rect, task_.kinds, silent).values;
    write_control_files(files_of(folder, c), tile, map, rect, values.values(), silent);
    const auto fill = [&](int x, int y, ImageF& strip) {
      for (int row = 0; row < strip.height(); ++row)
        std::copy_n(&values.at(x - rect.x0, y + row - rect.y0), strip.width(), strip.row(row).begin());
    };
    write_control_tile(folder, t, c, tile, fill, silent);
    control.report(static_cast<double>(c + 1) / static_cast<double>(t.input.controls.size()));
  }
}

void TiledTransfer::match(int tile, const Folder& folder, const RunControl& control) {
  const RunControl silent = control.silent();
  const Prepared& p = prepare(folder, silent);
  const TransferTask& t = task_.transfer;
  const TexelRect rect = grid_.rect(0, tile);
  const auto map = p.map_on(0, silent);
  const ImageU8 mask = usable_mask(*t.history, t.input.source_mask);
  std::vector<ImageF> matched;
  for (std::size_t c = 0; c < t.input.controls.size(); ++c) {
    matched.push_back(match_tile(files_of(folder, c), tile, grid_.num_tiles(), *map, rect, t.input.controls[c],
                                 *t.history, mask, silent));
  }
  const ControlImage targets = interleave(matched, silent);
  write_array(folder / tile_file::targets(0, tile), targets.values());
  for (std::size_t l = 0; l < num_tiled_levels(); ++l) {
    const auto on = p.map_on(l, silent);
    const std::vector<TexelLink> links = find_links(*on, grid_.rect(l, tile), p.finder_on(l, *on, silent));
    write_array(folder / tile_file::links(l, tile), std::span<const TexelLink>(links));
    if (num_rounds(l) > 0) write_borders(l, tile, folder, silent);
  }
  control.report(1.0);
}

void TiledTransfer::halve(std::size_t level, int tile, const Folder& folder, const RunControl& control) {
  const RunControl silent = control.silent();
  const Prepared& p = prepare(folder, silent);
  const auto fine_map = p.map_on(level - 1, silent), map = p.map_on(level, silent);
  StoredTargets fine(folder, grid_, level - 1, static_cast<int>(p.weights.size()));
  const ControlImage halved = halve_tile(fine, *fine_map, *map, grid_.rect(level, tile), silent);
  write_array(folder / tile_file::targets(level, tile), halved.values());
  control.report(1.0);
}

void TiledTransfer::synthesize_coarse(const Folder& folder, const RunControl& control) {
  const RunControl silent = control.silent();
  const Prepared& p = prepare(folder, silent);
  const std::size_t finest = num_tiled_levels();
  TexelMap map = p.map->unsearched(silent);
  for (std::size_t l = 0; l < finest; ++l)
    map = map.halved(silent, l + 1 == finest ? TexelFinding::AtOnce : TexelFinding::WhereLooked);
  StoredTargets stored(folder, grid_, finest, static_cast<int>(p.weights.size()));
  std::vector<SynthesisLevel> levels(finest);
  append_levels(levels, p.appearance, p.first, p.source_controls, stored.image(grid_.whole(finest)),
                std::make_shared<TexelMap>(std::move(map)), p.placement, p.neighborhood, silent);
  const auto num_levels = static_cast<std::int64_t>(levels.size());
  if (levels.size() <= finest)
    throw InvalidInput("the atlas is too small to be transferred by tile; do without --by-tile");
  const auto seed = static_cast<std::uint64_t>(p.options.seed);
  const PlaceMap places =
      synthesize_multi_level(levels, p.neighborhood, *p.options.coherence_share, p.weights, seed, p.options.multi_level,
                             control, refinement_of(p.structures, p.options, p.weights, &grid_), nullptr, finest);
  const TexelMap& covered = *levels[finest].destination.map;
  write_places(folder / tile_file::coarse(), covered, covered.rect(), places, {});
  write_array(folder / tile_file::num_levels(), std::span(&num_levels, 1));
  write_similar(folder, finest, static_cast<std::size_t>(num_levels), p.sources, silent);
}

void TiledTransfer::start(std::size_t level, int tile, const Folder& folder, const RunControl& control) {
  const RunControl silent = control.silent();
  const Prepared& p = prepare(folder, silent);
  const std::size_t coarser = level + 1;
  const TexelRect rect = grid_.rect(level, tile);
  auto part = std::make_shared<LevelPart>();
  part->rect = rect;
  StoredTargets stored(folder, grid_, level, static_cast<int>(p.weights.size()));
  stored.load(rect, {}, *part);
  SynthesisLevel fine = p.level_of(level, p.map_on(level, silent), part, silent);
  const NeighborFinder find = p.finder_on(level, *fine.destination.map, silent);
  fine.destination.neighbors = std::make_shared<TexelNeighborhood>(find({}));
  SynthesisLevel coarse{.source = p.sources[coarser], .destination = {}};
  coarse.destination.map = p.map_on(coarser, silent);
  PlaceMap parents(grid_.num_texels(coarser), coarse.source.width(), true);
  const TexelRect around{std::max(0, rect.x0 / 2 - 1), std::max(0, rect.y0 / 2 - 1),
                         std::min(grid_.width(coarser), rect.x1 / 2 + 1),
                         std::min(grid_.height(coarser), rect.y1 / 2 + 1)};
  if (coarser == num_tiled_levels()) {
    StoredPlaces places([&](int) { return folder / tile_file::coarse(); }, [&](int) { return grid_.whole(coarser); });
    places.load(0, around, grid_.width(coarser), parents, {});
  } else {
    stored_places(folder, grid_, coarser, num_passes(coarser) + num_rounds(coarser)).load_part(around, parents);
  }
  const PlaceMap places = upsample(parents, coarse, fine, static_cast<std::uint64_t>(p.options.seed) + level);
  write_places(folder / tile_file::places(level, 0, tile), *fine.destination.map, rect, places, {});
  const SimilarPixels none;
  const EnergyScale scale = EnergyScale::make(fine.source, 0.5, p.weights);
  const Improver improver(fine, p.neighborhood, none, scale, 0, 0, nullptr);
  write_counts(folder / tile_file::counts(level, 0, tile), improver.count(places, silent));
  control.report(1.0);
}

void TiledTransfer::pass(std::size_t level, int pass, int tile, const Folder& folder, const RunControl& control) {
  const RunControl silent = control.silent();
  const Prepared& p = prepare(folder, silent);
  const std::size_t num_levels = read_num_levels(folder);
  const TexelRect rect = grid_.rect(level, tile);
  const auto map = p.map_on(level, silent);
  const NeighborFinder find = p.finder_on(level, *map, silent);
  const StoredLinks links(folder, level, grid_.num_tiles());
  TileHalo halo = find_halo(*map, rect, find, links, silent);
  auto part = std::make_shared<LevelPart>();
  part->rect = rect;
  part->others = std::move(halo.decided);
  part->sets = std::move(halo.sets);
  StoredTargets(folder, grid_, level, static_cast<int>(p.weights.size())).load(rect, part->others, *part);
  SynthesisLevel synthesis = p.level_of(level, map, part, control);
  synthesis.destination.neighbors = std::make_shared<TexelNeighborhood>(find({rect, part->others}));
  const SimilarPixels similar = read_similar(folder, level);
  const MultiLevelOptions& o = p.options.multi_level;
  const EnergyScale scale = EnergyScale::make(
      synthesis.source, coherence_of_level(level, num_levels - 1, *p.options.coherence_share, o), p.weights);
  PlaceMap places(map->num_texels(), synthesis.source.width(), true);
  Improver improver(synthesis, p.neighborhood, similar, scale, o.num_random, static_cast<std::uint64_t>(p.options.seed),
                    nullptr);
  TiledPlaces before = stored_places(folder, grid_, level, pass);
  before.load(rect, tile, places, improver.changed_near());
  before.load(part->others, places, improver.changed_near());
  before.load(halo.looked_at, places, improver.changed_near());
  improver.go_on_after(pass);
  const bool is_last = level == 0 && pass + 1 == num_passes(level);  // The last word is the energy's.
  PlaceCounts counts;
  if (!is_last) {
    for (int other = 0; other < grid_.num_tiles(); ++other)
      counts.add(read_counts(folder / tile_file::counts(level, pass, other)));
  }
  improver.pass(is_last ? kEnergyAlone : preferences_of(o), is_last, stream_of(level, pass), counts, places, silent);
  write_places(folder / tile_file::places(level, pass + 1, tile), *map, rect, places, improver.changed_near());
  if (pass + 1 < num_passes(level)) {
    write_counts(folder / tile_file::counts(level, pass + 1, tile), improver.count(places, silent));
  } else if (num_rounds(level) > 0) {
    write_amounts(folder / tile_file::amounts(level, 0, tile),
                  Amounts(synthesis.source).count(synthesis.destination, places, silent));
  }
  control.report(1.0);
}

void TiledTransfer::finish(int tile, const Folder& folder, const RunControl& control) {
  const RunControl silent = control.silent();
  const Prepared& p = prepare(folder, silent);
  const TexelRect rect = grid_.rect(0, tile);
  const auto map = p.map_on(0, silent);
  const NeighborFinder find = p.finder_on(0, *map, silent);
  auto part = std::make_shared<LevelPart>();
  part->rect = rect;
  StoredTargets(folder, grid_, 0, static_cast<int>(p.weights.size())).load(rect, {}, *part);
  SynthesisLevel synthesis = p.level_of(0, map, part, control);
  synthesis.destination.neighbors = std::make_shared<TexelNeighborhood>(find({rect, {}}));
  PlaceMap places(map->num_texels(), synthesis.source.width(), true);
  if (num_tiled_levels() == 0) {  // Of two tiles all levels are coarse ones.
    StoredPlaces whole([&](int) { return folder / tile_file::coarse(); }, [&](int) { return grid_.whole(0); });
    whole.load(0, grid_.whole(0), grid_.width(0), places, {});
  } else {
    TiledPlaces stored = stored_places(folder, grid_, 0, num_passes(0) + num_rounds(0));
    stored.load(rect, tile, places, {});
    stored.load(find_rim(*map, {rect, {}}, find), places, {});
  }
  write_figures(folder / tile_file::figures(tile), measure_figures(synthesis.source, synthesis.destination,
                                                                   p.neighborhood, places.pixels, p.weights, silent));
  const int source_width = synthesis.source.width(), full_width = task_.transfer.history->facts().width;
  const bool is_subpixel = keeps_fractions(p.options, task_.transfer.history->facts());
  const auto place_of = [&](TexelId t) {
    SourcePlace place = places.source_place(t);
    if (!is_subpixel) place.beside_x = place.beside_y = 0;
    return to_full_size(place, source_width, static_cast<int>(p.first), full_width);
  };
  write_coordinate_tile(folder, task_.transfer, tile, *map, place_of, silent);
  control.report(1.0);
}

void TiledTransfer::join(const Folder& folder, const Folder& final_folder, const std::string& key,
                         const RunControl& control) {
  const Prepared& p = prepare(folder, control.silent());
  EnergyFigures figures;
  for (int tile = 0; tile < grid_.num_tiles(); ++tile) figures.add(read_figures(folder / tile_file::figures(tile)));
  TransferResult result;
  result.energy = figures.report(p.sources[0], *p.options.coherence_share);
  result.explained_variance = p.appearance.explained_variance;
  result.used = p.options;
  result.structure = p.structure;
  result.refused_line_share = p.refused_line_share;
  TransferTask task = task_.transfer;
  task.input.map = p.map;
  write_surface_files(folder, task);
  write_transfer_manifest(folder, final_folder, task, result, key);
  control.report(1.0);
}

}  // namespace patinate::transfer
