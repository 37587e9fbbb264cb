/// \file
/// Gammatons' ways on a device: the kernels of pieces.h, with the CPU's bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "libcommon/device/arithmetic_check.h"
#include "libcommon/device/device.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/tracing/pieces.h"

namespace patinate::simulation {

/// The texts of what it is compiled from.
extern const std::string_view kMotionTypes, kMotionVectors, kRandomDirection, kPlaceKernel, kMotionArrays,
    kFlightKernel, kWalkKernel, kFloatingKernel, kBirthKernel, kResponseKernel, kMotionEntries;

/// A scene's triangles, and what gammatons need of them, on a device.
class DeviceMotion {
 public:
  /// @param scene    Its arrays are copied; clearances are found for all triangles.
  /// @param surface  The scene's.
  /// @throws DeviceError, as all members.
  DeviceMotion(const device::Device& device, const MotionScene& scene, const SurfaceAtlas& surface,
               const RunControl& control);
  ~DeviceMotion();

  /// Brings gammatons there, where they stay.
  void put(std::span<const DropRecord> drops);
  /// trace_drop() of all that are there, the first of which is gammaton `first`, and the texels of their contacts.
  /// @param drops  As they are then.
  void trace(const MotionScene& scene, const MotionCall& call, std::span<const EmitterFacts> emitters,
             std::uint32_t first, std::span<DropRecord> drops);
  /// respond_to_contact() of those of them that are in contact, with the mesh's normals.
  void respond(const MotionScene& scene, const MotionCall& call, std::uint32_t first, std::span<DropRecord> drops);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Gammatons on a rough surface, there and here. @throws DeviceError if the device cannot run it.
[[nodiscard]] device::CheckResult check_motion(const device::Device& device);

}  // namespace patinate::simulation
