/// \file
/// What all parts of a simulation on a device work on.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "libcommon/core/kernel_language.h"
#include "libcommon/device/device.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// tally_types.inl for C++; devices read the same text.
namespace tally_types {
using namespace kernel_types;
#include "simulation/device/tally_types.inl"
}  // namespace tally_types
/// The texts of tally_types.inl and tally.cl.
extern const std::string_view kTallyTypes, kTallyKernel;

/// A sum of the tally, modulo 2^64. @param words  The tally's. @param kind  kSegments and so on.
[[nodiscard]] inline std::int64_t counted(std::span<const std::uint32_t> words, std::uint32_t kind) {
  const std::size_t at = tally_types::kFirstCount + 2 * std::size_t{kind};
  return static_cast<std::int64_t>(words[at] | std::uint64_t{words[at + 1]} << 32);
}
/// @param kind  kMassEmitted and so on.
[[nodiscard]] inline std::int64_t mass_of(std::span<const std::uint32_t> words, std::uint32_t kind, int material) {
  const std::size_t at = tally_types::kFirstMass + 2 * (8 * std::size_t{kind} + static_cast<std::size_t>(material));
  return static_cast<std::int64_t>(words[at] | std::uint64_t{words[at + 1]} << 32);
}

namespace motion_types {
struct DropRecord;  // simulation/tracing/motion_types.inl
}
class Trail;

/// Devices have no empty arrays: one value where there is none.
template <class T>
[[nodiscard]] device::Buffer<T> upload_some(const device::Device& device, std::span<const T> values) {
  static const T nothing{};
  return device.upload(values.empty() ? std::span<const T>(&nothing, 1) : values);
}

/// Arrays in a device's memory; what a surface has is there, all others are of arbitrary content. Whoever makes it
/// allocates `drops` and `trails`, whose types belong to others.
struct DeviceArrays {
  /// @throws DeviceError
  DeviceArrays(const device::Device& its_device, const SurfaceAtlas& surface, int materials, std::size_t gammatons);

  device::Device device;
  std::uint32_t num_materials, num_texels, num_tiles, num_gammatons;
  std::int32_t width;  ///< Texels of the atlas.

  device::Buffer<std::uint16_t> weights;   ///< By texel: SurfaceAtlas's.
  device::Buffer<std::int32_t> triangles;  ///< By texel; -1 outside of the charts.

  device::Buffer<std::uint16_t> amounts;    ///< By material, then texel.
  device::Buffer<std::uint32_t> dirty;      ///< By tile: a bit for each material that has changed since it was cleared.
  device::Buffer<std::int32_t> changed_in;  ///< By tile: the last iteration that changed it; -1 = none.
  device::Buffer<std::uint32_t> awake;      ///< By tile: rules may have something to do.
  device::Buffer<std::uint32_t> is_listed;  ///< By tile: it is among those to be composed,
  device::Buffer<std::uint32_t> touched;    ///< which are these.

  device::Buffer<motion_types::DropRecord> drops;  ///< By gammaton, as all of these.
  device::Buffer<std::uint32_t> cargo;             ///< Mass, by material.
  device::Buffer<Trail> trails;
  device::Buffer<std::uint32_t> contacts;                ///< The texel; kNoTexel without one.
  device::Buffer<std::uint32_t> ended;                   ///< 1 + how, of those whose cargo the tally does not have yet.
  std::array<device::Buffer<std::uint32_t>, 2> endings;  ///< Gammatons whose trails are laid: of ways, of responses.
  device::Buffer<std::uint32_t> met;                     ///< A bit for each texel.

  device::Buffer<std::uint32_t> tally;  ///< Counters of tally_types.inl.
};

/// These tiles, and no others, are to be composed. @throws DeviceError
void list_tiles(std::span<const TileIndex> tiles, DeviceArrays& arrays);

}  // namespace patinate::simulation
