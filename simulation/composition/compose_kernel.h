/// \file
/// The inner loops of composition: a tile of 64 texels from integers to integers, compiled for several instruction sets
/// from one source (compose_kernel.inl). Every result is defined by integer arithmetic alone, so that all of them, and
/// another device, give the same bytes.
#pragma once

#include <array>
#include <cstdint>

#include "libcommon/core/instruction_set.h"

namespace patinate::simulation::composition {

inline constexpr int kTile = 64;                     ///< Texels.
inline constexpr std::uint32_t kOne = 16384;         ///< Amounts, weights and specular values: 1.
inline constexpr std::uint32_t kMaxWeight = 65535;   ///< A weight saturates here, just under 4.
inline constexpr std::int32_t kMaxHeight = 1 << 27;  ///< Height quanta.
inline constexpr int kHeightQuanta = 1024;           ///< In the size of a median texel.
inline constexpr std::int32_t kMaxStep = 32767;      ///< Height differences over two texels saturate here: 32 texels.
inline constexpr std::int32_t kSlopeOne = 1024;
inline constexpr std::int32_t kMaxSlope = 16 * kSlopeOne;  ///< 86.4 degrees.
inline constexpr int kSrgbShift = 3;  ///< Linear values of 16 bit, shifted by this, index a table of sRGB codes.
inline constexpr int kSrgbSize = 65536 >> kSrgbShift;

/// A MaterialAppearance as integers. What changes with the amount is F = amount difference * (1 + variation * xi), in
/// quanta of 1 / kOne.
struct QuantizedAppearance {
  std::uint32_t strength = 0;        ///< 1 = kOne.
  std::uint32_t limit = kMaxWeight;  ///< Amount differences above it weigh kMaxWeight.
  std::int32_t variation = 0;        ///< 1 = 32768.
  std::int32_t specular = 0;         ///< 1 = 8192.
  std::int32_t specular_variation = 0;
  std::int32_t height = 0;        ///< F * height >> height_shift are height quanta; |height| <= 8192.
  std::int32_t height_shift = 0;  ///< [0, 30].
  std::int32_t height_variation = 0;
  std::array<std::uint16_t, 3> color{};         ///< Linear, 1 = 65535.
  std::array<std::uint16_t, 3> second_color{};  ///< At xi = 1; `color` at -1.
  bool has_second_color = false;
  std::uint32_t noise_key = 0;
};

/// What texels look like when they are new.
struct BaseTile {
  alignas(64) std::uint16_t linear[3][kTile];  ///< 1 = 65535.
  alignas(64) std::int32_t specular[kTile];    ///< 1 = kOne.
  alignas(64) std::uint32_t
      code[kTile];  ///< R | G << 8 | B << 16 | specular << 24: exactly what is shown where nothing changed.
};

/// A tile in which some amounts differ from the originals.
struct ComposeTask {
  int num_materials = 0;  ///< Of those that differ.
  std::array<const QuantizedAppearance*, 8> look{};
  std::array<const std::uint16_t*, 8> amount{};  ///< 64 each.
  std::array<const std::uint16_t*, 8> original{};
  std::array<const std::int32_t*, 8> xi{};        ///< 64, 1 = 32768, in place of noise(); may be null.
  std::array<const std::uint16_t*, 8> picture{};  ///< 3 x 64 linear values in place of the look's color; may be null.
  const BaseTile* base = nullptr;
  const std::int32_t* height = nullptr;  ///< Height quanta when new.
  const std::uint8_t* srgb = nullptr;    ///< kSrgbSize codes.
  std::uint32_t first_texel = 0;
  bool is_published_form = false;
};

/// What turns height differences of a triangle's texels into slopes along its tangents T (+u) and B (+v, orthogonal to
/// T): along T (right - left) * t >> shift; along B ((right - left) * bt - (below - above) * b) >> shift; rounded, 1 =
/// kSlopeOne.
struct Frame {
  std::int16_t t = 0;  ///< |.| < 2^14, as the other two.
  std::int16_t bt = 0;
  std::int16_t b = 0;
  std::int16_t shift = 1;  ///< [1, 30].
};

/// Normals of a tile from heights.
struct NormalTask {
  const std::int32_t* here = nullptr;  ///< 64 height quanta.
  const std::int32_t* right =
      nullptr;  ///< Of the tiles beside; `here` where there is none (their texels are on a border, and redone).
  const std::int32_t* left = nullptr;
  const std::int32_t* below = nullptr;
  const std::int32_t* above = nullptr;
  const std::int32_t* triangle = nullptr;  ///< 64; -1 = none.
  const Frame* frame = nullptr;            ///< By triangle + 1.
};

/// Slopes along T and B, 1 = kSlopeOne, in [-kMaxSlope, kMaxSlope].
struct SlopeTile {
  alignas(64) std::int32_t along_t[kTile];
  alignas(64) std::int32_t along_b[kTile];
};

struct Kernels {
  /// Colors as R | G << 8 | B << 16 | specular << 24, and heights in quanta.
  void (*compose)(const ComposeTask& task, std::uint32_t* rgba, std::int32_t* height);
  void (*slopes)(const NormalTask& task, SlopeTile& slopes);
  /// 3 x 64 bytes: x, y, z as 127.5 + 127.5 n, rounded.
  void (*encode)(const SlopeTile& slopes, std::uint8_t* normal);
  /// Copies `num_words` (a multiple of 16) and tells whether any was different.
  bool (*replace)(std::uint32_t* to, const std::uint32_t* from, int num_words);
};

/// @param set  One that the machine has.
[[nodiscard]] const Kernels& kernels(InstructionSet set);

/// xi of a texel and material, 1 = 32768: uniform in [-32768, 32767].
[[nodiscard]] constexpr std::int32_t noise(std::uint32_t texel, std::uint32_t noise_key) {
  std::uint32_t x = texel * 0x9E3779B1u ^ noise_key;
  x ^= x >> 16;
  x *= 0x7FEB352Du;
  x ^= x >> 15;
  x *= 0x846CA68Bu;
  return static_cast<std::int32_t>(x) >> 16;
}

}  // namespace patinate::simulation::composition
