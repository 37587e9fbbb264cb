/// \file
/// Gammatons' ways on a device: the kernels of pieces.h, with the CPU's bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "libcommon/device/device.h"
#include "patinate/core/run_control.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/device/device_arrays.h"
#include "simulation/tracing/pieces.h"

namespace patinate::simulation {

/// The texts of what it is compiled from.
extern const std::string_view kMotionTypes, kMotionVectors, kRandomDirection, kPlaceKernel, kMotionArrays,
    kFlightKernel, kWalkKernel, kFloatingKernel, kBirthKernel, kResponseKernel, kMotionEntries;

/// Rules by which gammatons' lives end and begin.
struct LifeCall {
  bool is_deposited = false;                  ///< Those that end leave their cargo along their trails.
  std::span<const std::uint32_t> loads = {};  ///< By emitter, then material: mass at birth.
};

/// A scene's triangles, and what gammatons need of them, on a device.
class DeviceMotion {
 public:
  /// @param scene    Its arrays are copied; clearances are found for all triangles.
  /// @param surface  The scene's.
  /// @throws DeviceError, as all members.
  DeviceMotion(const device::Device& device, const MotionScene& scene, const SurfaceAtlas& surface,
               const RunControl& control);
  ~DeviceMotion();

  /// trace_drop() of all gammatons of `arrays`, and what follows: contacts, trails, births and ends.
  void trace(const MotionScene& scene, const MotionCall& call, std::span<const EmitterFacts> emitters,
             const LifeCall& life, DeviceArrays& arrays);
  /// respond_to_contact() of those in contact, with the mesh's normals.
  void respond(const MotionScene& scene, const MotionCall& call, bool is_deposited, DeviceArrays& arrays);
  /// Enters into the tally who has ended and left what fits along a trail.
  void end_lives(DeviceArrays& arrays);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace patinate::simulation
