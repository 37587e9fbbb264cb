/// \file
/// How the source's patch lies on a texel: what turns its normals into the texel's tangent space.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "patinate/atlas/direction_field.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

/// Angle in steps of 2^-20 turns, and mirroring, as one number, so that gutters can be filled with it (GutterFill).
[[nodiscard]] std::uint32_t pack_turn(float angle, bool is_mirrored);

/// Rows of coordinates.exr. @param angle_mirror  Two a texel. @param turns  kNoValue where `indices` are.
/// @throws IoError naming a texel whose mirroring is neither 0 nor 1.
void pack_checked_turns(const std::filesystem::path& file, std::span<const float> angle_mirror, int first_row,
                        int width, std::span<const std::uint32_t> indices, std::span<std::uint32_t> turns);

/// Turns of a result that was written, by pack_checked_turns(): of all texels, kNoValue outside the charts.
/// @param turns  Of each texel, as SourcePlace's; empty: all 0.
[[nodiscard]] Image<std::uint32_t> packed_turns(const TexelMap& map, const FlowFrames& frames,
                                                std::span<const std::int16_t> turns);

/// Normals of the source's tangent space into that of their texels, in place: with the source's x axis at (cos a, sin
/// a) and its y axis at
/// (-sin a, cos a), or the opposite where it is mirrored, x and y are weights of those. z stays.
/// @param turns  One a texel, kNoValue = as it is. @param xyz  Three a texel.
void turn_normals(std::span<const std::uint32_t> turns, std::span<float> xyz);

/// 127.5 + 127.5 n, rounded, as normal maps of 8 bits hold them. @param xyz  [-1, 1].
void normal_codes(std::span<const float> xyz, std::span<std::uint8_t> codes);

}  // namespace patinate::transfer
