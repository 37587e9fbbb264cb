/// \file
/// The appearance of a history, kept in a folder of the history: what one transfer found out serves the next, whatever
/// its mesh, weights or seed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "patinate/history/history.h"
#include "patinate/transfer/appearance_space.h"

namespace patinate::transfer {

/// In the history's folder; of no other meaning to anything that reads histories, and may be removed at any time.
inline constexpr const char* kCacheFolder = ".cache";
inline constexpr int kMaxKeptAppearances =
    3;  ///< Most appearances kept of one history, for other masks and options: those used last stay.
inline constexpr std::uint64_t kMaxKeptBytes = std::uint64_t{1}
                                               << 30;  ///< Bytes of one history, all together: about 49 million pixels.

struct CacheOptions {
  bool cache = true;  ///< No result depends on it.
};
void describe(OptionVisitor& v, CacheOptions& o);

/// Content key of everything that decides an appearance but the number of levels: the compared frames as the bytes of
/// their files, the mask, the options, kAppearanceVersion. @param mask  Of the history's size. @throws IoError if a
/// frame cannot be read; Canceled.
[[nodiscard]] std::string appearance_key(const HistoryReader& history, const AppearanceOptions& options,
                                         const ImageU8& mask, const RunControl& control = {});

/// Where the appearance of a history with this key is kept.
[[nodiscard]] std::filesystem::path appearance_file(const HistoryReader& history, const std::string& key);

/// Gives what build_appearance_space() gives, to the bit, and by it unless the same was built before. What cannot be
/// kept (a folder that is read-only, a disk that is nearly full, a history that changes meanwhile) is not; a kept file
/// that is damaged, or holds fewer levels, is regenerated. Never fails for either.
/// @throws as build_appearance_space(); Canceled.
[[nodiscard]] AppearanceSpace cached_appearance_space(const HistoryReader& history, int num_levels,
                                                      const AppearanceOptions& options = {},
                                                      const RunControl& control = {}, const ImageU8& given_mask = {});

/// cached_appearance_space() of this history, which must outlive it; empty without a cache.
[[nodiscard]] AppearanceSource appearance_source(const HistoryReader& history, const CacheOptions& options);

}  // namespace patinate::transfer
