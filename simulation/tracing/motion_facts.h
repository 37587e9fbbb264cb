/// \file
/// For C++: what gammatons move through and how they are, as kernels have it (motion_types.inl).
#pragma once

#include <array>

#include "libcommon/core/kernel_language.h"
#include "patinate/geometry/mesh.h"
#include "simulation/tracing/ray_tracer.h"

namespace patinate::simulation {

/// motion_types.inl and vectors.inl for C++; devices read the same texts.
namespace motion_types {
using namespace kernel_types;
using ray_types::RayFrame;
#include "simulation/tracing/motion_types.inl"
#include "simulation/tracing/vectors.inl"
}  // namespace motion_types
using motion_types::CornerNormals;
using motion_types::Drop;
using motion_types::DropRecord;
using motion_types::EmitterFacts;
using motion_types::MotionCall;
using motion_types::MotionFacts;
using motion_types::SpaceFacts;
using motion_types::SurfacePlace;
using motion_types::Told;
using motion_types::TriangleFrame;
using motion_types::TriangleLinks;
using motion_types::Vector;

[[nodiscard]] inline Vector vector_of(const Vec3& v) { return {.x = v.x(), .y = v.y(), .z = v.z()}; }
[[nodiscard]] inline Vec3 vec3(const Vector& v) { return {v.x, v.y, v.z}; }

[[nodiscard]] inline Drop drop_of(const DropRecord& record) {
  return {.state = record.state,
          .is_front = record.is_front != 0,
          .at = {.triangle = record.triangle, .b1 = record.b1, .b2 = record.b2},
          .position = record.position,
          .velocity = record.velocity};
}
inline void put(const Drop& drop, DropRecord& record) {
  record.state = drop.state;
  record.is_front = drop.is_front ? 1 : 0;
  record.triangle = drop.at.triangle;
  record.b1 = drop.at.b1;
  record.b2 = drop.at.b2;
  record.position = drop.position;
  record.velocity = drop.velocity;
}

}  // namespace patinate::simulation
