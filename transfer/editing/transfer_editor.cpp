#include "transfer/editing/transfer_editor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "patinate/core/error.h"
#include "transfer/files/flow_io.h"
#include "transfer/files/transfer_files.h"
#include "transfer/synthesis/open_options.h"
#include "transfer/synthesis/prepared.h"
#include "transfer/synthesis/pyramid.h"

namespace patinate::transfer {

namespace {

constexpr std::size_t kMaxUndoBytes = std::size_t{192} << 20;  // As the studio's steps of a scene.

/// Seed of an edit: those of a list differ, so that the same place is not searched among the same pixels again.
std::uint64_t seed_of(std::int64_t seed, std::size_t edit) {
  constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15;  // [Knuth, vol. 3, sec. 6.4]: 2^64 over the golden ratio.
  return static_cast<std::uint64_t>(seed) + (edit + 1) * kGolden;
}

/// Places of the finest level as the folder has them. @throws IoError
PlaceMap read_places(const TransferReader& reader, const TexelMap& map, const PreparedTransfer& prepared,
                     std::span<const std::int16_t> turns) {
  const SynthesisLevel& level = prepared.levels[0];
  PlaceMap places(map.num_texels(), level.source.width());
  if (level.destination.placement.turns != nullptr) places.keep_turns();
  for (const TexelId t : level.destination.texels) {
    const float* const xy = reader.coordinates().data() + 2 * t;
    const auto fixed = [](float along) { return static_cast<std::int32_t>(std::lround(along * 256.0f)); };
    const FixedPoint point{fixed(xy[0]), fixed(xy[1])};
    const PlaceMap::Beside beside = PlaceMap::beside_of({0, point});
    const SourcePlace full{whole_pixels(point.y) * prepared.source_width + whole_pixels(point.x), beside.x, beside.y,
                           turns.empty() ? std::int16_t{0} : turns[t]};
    const SourcePlace place =
        from_full_size(full, level.source.width(), static_cast<int>(prepared.first), prepared.source_width);
    if (xy[0] < 0.0f || place.pixel < 0 || level.source.is_usable[place.pixel] == 0) {
      throw IoError(reader.manifest().mesh.parent_path().string(),
                    "texel (" + std::to_string(t % map.width()) + ", " + std::to_string(t / map.width()) +
                        ") shows a pixel that cannot be copied; make the transfer again");
    }
    places.set(t, place.pixel, {place.beside_x, place.beside_y});
    if (place.turn == 0 || places.turns().empty()) continue;
    Place turned = places.at(t);
    turned.turn = place.turn;
    places.set(t, turned);
  }
  return places;
}

}  // namespace

struct TransferEditor::Saved {
  std::vector<Place> places;
  std::vector<std::uint16_t> targets;
};

struct TransferEditor::Step {
  TransferEdit edit;
  std::vector<TexelId> texels;
  Saved other;
  [[nodiscard]] std::size_t bytes() const {
    return texels.size() * (sizeof(TexelId) + sizeof(Place)) + other.targets.size() * sizeof(std::uint16_t);
  }
};

TransferEditor::~TransferEditor() = default;

TransferEditor::TransferEditor(const std::filesystem::path& path, const AppearanceSource& appearance,
                               const RunControl& control)
    : reader_(std::make_shared<const TransferReader>(path)) {
  const TransferManifest& manifest = reader_->manifest();
  history_ = std::make_shared<const HistoryReader>(manifest.history);
  TransferOptions options = read_used_options(path);
  options.seed = manifest.seed;
  if (!keeps_fractions(options, history_->facts()))
    throw InvalidInput("only transfers by --method fast with a --neighborhood of 2 or more can be edited");
  map_ = std::make_shared<const TexelMap>(reader_->mesh(), reader_->sheet(), control.silent());
  LaidFlow flow = read_flow(manifest, *map_);
  TransferInput input{
      .history = history_, .map = map_, .texel_size_mm = manifest.texel_size_mm, .controls = {}, .frames = flow.frames};
  for (std::size_t i = 0; i < manifest.controls.size(); ++i) {
    input.controls.push_back(reader_->control(i));
    controls_.push_back(manifest.controls[i].source);
  }
  if (manifest.source_mask) input.source_mask = reader_->source_mask();
  input.appearance = appearance;
  PreparedTransfer prepared = prepare_transfer(input, options, control.part(0.0, 1.0));
  PlaceMap places = read_places(*reader_, *map_, prepared, flow.turns);
  synthesis_ = std::make_unique<RegionSynthesis>(std::move(prepared), std::move(places), control.silent());
  brush_ = std::make_unique<SurfaceBrush>(*map_, control);
  if (manifest.edits) earlier_ = read_transfer_edits(*manifest.edits);
  check_edits(earlier_, controls_);
  for (const TransferEdit& edit : earlier_.edits) {
    if (edit.kind == EditKind::Stroke) paint(edit, brushed_texels(edit, control.silent()));
  }
  if (!earlier_.edits.empty()) synthesis_->update(synthesis_->destination().texels);
  look_back();
  control.report(1.0);
}

bool TransferEditor::has_structure() const {
  const PreparedTransfer& prepared = synthesis_->prepared();
  return prepared.used.quality == TransferQuality::Best ||
         (prepared.used.quality == TransferQuality::Good && !prepared.structure.empty());
}

std::size_t TransferEditor::control_index(const TransferEdit& edit) const {
  check_edits({{edit}}, controls_);
  return static_cast<std::size_t>(std::find(controls_.begin(), controls_.end(), edit.control) - controls_.begin());
}

std::vector<BrushedTexel> TransferEditor::brushed_texels(const TransferEdit& edit, const RunControl& control) const {
  std::vector<BrushedTexel> texels = brush_->find(edit.stroke, control);
  if (texels.empty()) throw InvalidInput(unreached_text(edit.stroke));
  return texels;
}

void TransferEditor::paint(const TransferEdit& edit, std::span<const BrushedTexel> texels) {
  const std::size_t index = control_index(edit);
  for (const BrushedTexel& b : texels) {
    std::uint16_t& wanted = synthesis_->target(b.texel)[index];
    wanted = static_cast<std::uint16_t>(
        std::floor(brushed(static_cast<double>(wanted), edit.value * kControlSteps, b.kept) + 0.5));
  }
}

TexelSet TransferEditor::painted_region(const RunControl& control) const {
  const TransferEdits all = edits();
  std::vector<TexelId> texels;
  for (std::size_t i = all.edits.size(); i-- > 0 && all.edits[i].kind == EditKind::Stroke;) {
    for (const BrushedTexel& b : brush_->find(all.edits[i].stroke, control)) texels.push_back(b.texel);
  }
  if (texels.empty())
    throw InvalidInput("there is nothing to refine: no stroke stands before it, or after the last one");
  return synthesis_->with_reach(texels);
}

std::span<const TexelId> TransferEditor::apply(const TransferEdit& edit, const RunControl& control) {
  const bool is_stroke = edit.kind == EditKind::Stroke;
  std::vector<BrushedTexel> painted;
  if (is_stroke) {
    (void)control_index(edit);
    painted = brushed_texels(edit, control.silent());
  }
  std::vector<TexelId> under;
  for (const BrushedTexel& b : painted) under.push_back(b.texel);
  const TexelSet region = is_stroke ? synthesis_->with_reach(under) : painted_region(control.silent());
  Step step{.edit = edit, .texels = {region.begin(), region.end()}, .other = {}};
  save(step.texels, step.other);
  try {
    if (is_stroke) paint(edit, painted);
    synthesis_->synthesize(region, is_stroke ? RegionWork::Search : RegionWork::Structure,
                           seed_of(synthesis_->prepared().used.seed, earlier_.edits.size() + num_applied_),
                           control.silent());
  } catch (...) {
    swap(step);
    throw;
  }
  steps_.resize(num_applied_);
  steps_.push_back(std::move(step));
  ++num_applied_;
  is_painted_since_ = is_stroke;
  forget_old_steps();
  return steps_.back().texels;
}

void TransferEditor::save(std::span<const TexelId> texels, Saved& saved) const {
  saved.places.reserve(texels.size());
  for (const TexelId t : texels) {
    saved.places.push_back(std::as_const(*synthesis_).places().at(t));
    const auto target = synthesis_->destination().target(t);
    saved.targets.insert(saved.targets.end(), target.begin(), target.end());
  }
}

std::span<const TexelId> TransferEditor::swap(Step& step) {
  Saved now;
  save(step.texels, now);
  auto targets = step.other.targets.begin();
  for (std::size_t i = 0; i < step.texels.size(); ++i) {
    const TexelId t = step.texels[i];
    synthesis_->places().set(t, step.other.places[i]);
    const std::span<std::uint16_t> target = synthesis_->target(t);
    std::copy_n(targets, target.size(), target.begin());
    targets += static_cast<std::ptrdiff_t>(target.size());
  }
  synthesis_->update({map_->num_texels(), step.texels});
  step.other = std::move(now);
  return step.texels;
}

std::span<const TexelId> TransferEditor::undo() {
  if (num_undoable() == 0) return {};
  const std::span<const TexelId> texels = swap(steps_[--num_applied_]);
  look_back();
  return texels;
}

std::span<const TexelId> TransferEditor::redo() {
  if (num_redoable() == 0) return {};
  const std::span<const TexelId> texels = swap(steps_[num_applied_++]);
  look_back();
  return texels;
}

std::size_t TransferEditor::num_redoable() const { return steps_.size() - num_applied_; }

void TransferEditor::look_back() {
  const std::vector<TransferEdit> all = edits().edits;
  is_painted_since_ = !all.empty() && all.back().kind == EditKind::Stroke;
}

void TransferEditor::forget_old_steps() {
  std::size_t bytes = 0;
  for (std::size_t i = steps_.size(); i-- > num_forgotten_;) {
    bytes += steps_[i].bytes();
    if (bytes <= kMaxUndoBytes || i + 1 == steps_.size()) continue;
    for (; num_forgotten_ <= i; ++num_forgotten_) steps_[num_forgotten_].other = {};
    return;
  }
}

TransferEdits TransferEditor::edits() const {
  TransferEdits all = earlier_;
  for (std::size_t i = 0; i < num_applied_; ++i) all.edits.push_back(steps_[i].edit);
  return all;
}

SourcePlace TransferEditor::place(TexelId t) const {
  const PreparedTransfer& prepared = synthesis_->prepared();
  return to_full_size(std::as_const(*synthesis_).places().source_place(t), prepared.levels[0].source.width(),
                      static_cast<int>(prepared.first), prepared.source_width);
}

double TransferEditor::wanted(std::size_t control, TexelId t) const {
  return static_cast<double>(synthesis_->destination().target(t)[control]) / kControlSteps;
}

void TransferEditor::write(const RunControl& control) const {
  const LaidFlow flow = read_flow(reader_->manifest(), *map_);
  std::vector<TexelId> texels;
  for (std::size_t i = 0; i < num_applied_; ++i)
    texels.insert(texels.end(), steps_[i].texels.begin(), steps_[i].texels.end());
  const EditedPlaces edited{.texels = {map_->num_texels(), texels},
                            .map = *map_,
                            .frames = flow.frames.get(),
                            .parts = history_->facts().parts,
                            .source_width = history_->facts().width,
                            .place_of = [this](TexelId t) { return place(t); }};
  rewrite_coordinates(reader_->manifest(), edited, control);
  const std::filesystem::path folder = reader_->manifest().mesh.parent_path();
  write_transfer_edits(folder / kEditsFile, edits());
  rewrite_transfer_manifest(folder, synthesis_->energy(control.silent()));
}

}  // namespace patinate::transfer
