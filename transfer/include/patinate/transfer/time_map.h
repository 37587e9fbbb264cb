/// \file
/// Lookups with a time of its own at every texel: an object of which one side is older.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "patinate/core/run_control.h"
#include "patinate/history/history_sampling.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

struct PackedPlaces;
struct PlacesView;

struct TimeMapOptions {
  std::int64_t frame_bytes = std::int64_t{256}
                             << 20;  ///< Of decoded frames kept at once; two are kept whatever it says.
};

/// gather_at_times() row by row, for an atlas that is not in memory. Frames that fit into options.frame_bytes all at
/// once are read once, however many calls there are; else once a call. Not thread-safe: a call uses threads itself.
class TimeMapLookup {
 public:
  TimeMapLookup(const History& history, Between between, const TimeMapOptions& options = {});
  ~TimeMapLookup();
  TimeMapLookup(const TimeMapLookup&) = delete;
  TimeMapLookup& operator=(const TimeMapLookup&) = delete;

  /// @param places,times  Whole rows of an atlas, as gather_at_times() takes them. @param first_row  Where they stand,
  /// for the message.
  /// @param out  As many rows, 3 channels: 0 where texels have no place.
  void look_up(const PlacesView& places, std::span<const float> times, int first_row, ImageF& out,
               const RunControl& control = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The history's color at every texel's own time.
///
/// Texels are visited in the atlas's order, once for as many frames as fit into options.frame_bytes: memory does not
/// grow with the number of frames. Frames are read when a texel first asks for them. With one time everywhere the
/// result equals gather() of sample() to the bit.
/// @param places  H x W, in the history's frames (packed_lookup.h).
/// @param times   H x W x 1, in the history's unit, clamped to its ends; not looked at where texels have no place.
/// @returns H x W x 3, linear; 0 where texels have no place.
/// @throws InvalidInput if sizes differ or a time is NaN (naming the texel); IoError of the history.
/// Cost: two pixels a texel; each frame that any texel needs is read once, those at the ends of a block perhaps twice.
[[nodiscard]] ImageF gather_at_times(const History& history, const PackedPlaces& places, const ImageF& times,
                                     Between between, const RunControl& control = {},
                                     const TimeMapOptions& options = {});
/// The same. @param coordinates  H x W x 2, places inside the history's frames, in pixels, or -1. @throws InvalidInput
/// also where they are not, naming the texel.
[[nodiscard]] ImageF gather_at_times(const History& history, const ImageF& coordinates, const ImageF& times,
                                     Between between, const RunControl& control = {},
                                     const TimeMapOptions& options = {});

}  // namespace patinate::transfer
