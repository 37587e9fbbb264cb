#include "simulation/transport/pieces.h"

#include <algorithm>

#include "libcommon/core/parallel.h"
#include "simulation/transport/part_sums.h"
#include "simulation/transport/transfer.h"

namespace patinate::simulation {

namespace {

constexpr std::int64_t kSplatChunk = 256;  ///< Contacts.
constexpr std::int64_t kTrailChunk = 16;   ///< Endings, each with a splat for every contact of its trail.
constexpr std::size_t kPiecesAhead = 16;   ///< Contacts that memory is asked for before their turn.

std::int64_t chunk_of(const WideContacts& of) { return of.endings.empty() ? kSplatChunk : kTrailChunk; }

/// Splats along a trail, each with a larger share than the one before: the way ends dark, and begins without a step.
/// @param sums  Working memory. @returns how many parts they have, of a texel each; the first is the texel at the end.
std::size_t append_trail(const SplatShape& shape, const Trail& trail, PartSums& sums, std::vector<SplatPart>& parts) {
  const std::size_t first = parts.size(), n = trail.size();
  const std::uint32_t whole = transfer_kernel::trail_whole(static_cast<std::uint32_t>(n));
  std::array<SplatPart, Trail::kLength> places;  // a slow one touches a texel again and again
  std::size_t num_places = 0;
  for (std::size_t i = n; i-- > 0;) {
    std::size_t p = 0;
    while (p < num_places && places[p].texel != trail.texel(i)) ++p;
    if (p == num_places) places[num_places++] = {trail.texel(i), 0};
    places[p].share += static_cast<std::uint32_t>(i + 1);
  }
  std::uint32_t rest = SplatShape::kWhole;
  for (std::size_t p = 0; p < num_places; ++p) {
    shape.append(places[p].texel, parts);
    for (std::size_t k = first; k < parts.size(); ++k) {
      const std::uint32_t share = transfer_kernel::trail_share(parts[k].share, places[p].share, whole);
      sums.add(parts[k].texel, share);
      rest -= share;
    }
    parts.resize(first);
  }
  sums.add(places[0].texel, rest);
  sums.take(places[0].texel, parts);
  return parts.size() - first;
}

}  // namespace

/// Appends parts of some contacts, and how many each has in first_piece_ of the next.
void Pieces::append_parts(const WideContacts& of, std::size_t begin, std::size_t end, std::vector<SplatPart>& parts) {
  const bool is_deposit = !of.endings.empty();
  PartSums sums;
  parts.clear();
  for (std::size_t i = begin; i < end; ++i) {
    if (is_deposit) {
      const Trail& trail = of.endings[i].trail;
      const SplatShape& shape = *shapes_[trail.size()];
      for (std::size_t k = 0; k < trail.size(); ++k) shape.prefetch(trail.texel(k));
      first_piece_[i + 1] = static_cast<std::uint32_t>(append_trail(shape, trail, sums, parts));
    } else {
      const std::size_t from = i == begin ? i : i + kPiecesAhead - 1;
      for (std::size_t k = from; k < std::min(i + kPiecesAhead, end); ++k) shapes_[0]->prefetch(of.contacts[k].texel);
      first_piece_[i + 1] = static_cast<std::uint32_t>(shapes_[0]->append(of.contacts[i].texel, parts));
    }
    randoms_[i] = transfer_randoms(of.seed, of.contacts[i].gammaton, of.random_key, is_deposit ? kDepositPiece : 0,
                                   static_cast<int>(of.active.size()));
  }
}

const SplatShape& Pieces::shape_of(const SurfaceAtlas& surface, double width, std::size_t length) {
  const double wide = length == 0 ? width : width * transfer_kernel::stain_width(static_cast<std::uint32_t>(length));
  std::optional<SplatShape>& shape = shapes_[length];
  if (!shape || shape->width() != wide) shape.emplace(surface, wide);
  return *shape;
}

void Pieces::lay(const WideContacts& of, double width, const RunControl& control) {
  const std::size_t num = of.contacts.size();
  const auto n = static_cast<std::int64_t>(num);
  const std::int64_t chunk = chunk_of(of);
  for (std::size_t k = 0; k < (of.endings.empty() ? 1 : shapes_.size()); ++k) (void)shape_of(of.surface, width, k);
  parts_.resize((n + chunk - 1) / chunk);
  first_piece_.resize(num + 1);
  randoms_.resize(num);
  parallel_for(n, chunk, control, [&](std::int64_t begin, std::int64_t end) {
    append_parts(of, static_cast<std::size_t>(begin), static_cast<std::size_t>(end), parts_[begin / chunk]);
  });
  first_piece_[0] = 0;
  for (std::size_t i = 0; i < num; ++i) first_piece_[i + 1] += first_piece_[i];
}

void Pieces::cut(const WideContacts& of, double width, const Regions& regions, const Cargo& cargo,
                 const RunControl& control) {
  lay(of, width, control);
  const std::size_t num_active = of.active.size();
  const auto n = static_cast<std::int64_t>(of.contacts.size());
  const std::int64_t chunk = chunk_of(of);
  pieces_.resize(first_piece_.back());
  regions_.resize(pieces_.size());
  mass_.resize(pieces_.size() * num_active);
  parallel_for(n, chunk, control, [&](std::int64_t begin, std::int64_t end) {
    const SplatPart* part = parts_[begin / chunk].data();
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const std::size_t first = first_piece_[i], num_parts = first_piece_[i + 1] - first;
      const Contact& contact = of.contacts[i];
      const std::uint32_t weight = of.surface.weight(contact.texel);
      for (std::size_t a = 0; a < num_active; ++a) {
        deal(
            cargo.mass[contact.gammaton][of.active[a]], randoms_[i][a], weight, num_parts,
            [&](std::size_t k) { return part[k].share; },
            [&](std::size_t k, std::uint32_t mass) { mass_[(first + k) * num_active + a] = mass; });
      }
      for (std::size_t k = 0; k < num_parts; ++k, ++part) {
        pieces_[first + k] = {.texel = part->texel,
                              .contact = static_cast<std::uint32_t>(i),
                              .number = static_cast<std::uint16_t>(k),
                              .share = part->share};
        regions_[first + k] = static_cast<std::uint16_t>(regions.region_of(part->texel));
      }
    }
  });
}

void Pieces::join(const WideContacts& of, Cargo& cargo, const RunControl& control) const {
  const std::size_t num_active = of.active.size();
  parallel_for(static_cast<std::int64_t>(of.contacts.size()), chunk_of(of), control,
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                   for (std::size_t a = 0; a < num_active; ++a) {
                     std::uint32_t sum = 0;
                     for (std::size_t p = first_piece_[i]; p < first_piece_[i + 1]; ++p)
                       sum += mass_[p * num_active + a];
                     cargo.mass[of.contacts[i].gammaton][of.active[a]] = sum;
                   }
                 }
               });
}

}  // namespace patinate::simulation
