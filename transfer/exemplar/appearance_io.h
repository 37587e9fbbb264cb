/// \file
/// An appearance space as a file: exact, and worthless unless every byte of it is what was written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "patinate/transfer/appearance_space.h"

namespace patinate::transfer {

/// An appearance space and what it belongs to. The mask of its finest level is a part of the key, and in no file.
struct KeptAppearance {
  std::string key;    ///< 32 digits: of everything that decides the integers.
  int num_asked = 0;  ///< Levels that were asked for; there are fewer where nothing is inside a coarser one.
  AppearanceSpace space;
};

/// Bytes of a file with these levels, about 22 W H. @param width,height  Of the finest. @param num_levels  [1, 31].
[[nodiscard]] std::uint64_t appearance_file_size(int width, int height, int num_levels);

/// Little-endian: a header, per level its variance, integers and (but for the finest) mask, and the content key of all
/// that. Whole or absent, but not forced to the disk: after a power cut it is no file of ours.
/// @throws CannotComplete; Canceled.
void write_appearance(const std::filesystem::path& file, const KeptAppearance& kept, const RunControl& control = {});

/// The levels that building `num_levels` would give. Nothing is allocated before the file's size fits.
/// @param mask  Of the finest level.
/// @throws IoError unless the file is whole, of this version and key, of the mask's size, and holds so many levels;
/// Canceled.
[[nodiscard]] AppearanceSpace read_appearance(const std::filesystem::path& file, const std::string& key, int num_levels,
                                              const ImageU8& mask, const RunControl& control = {});

}  // namespace patinate::transfer
