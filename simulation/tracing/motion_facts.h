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
using motion_types::drop_of;
using motion_types::DropRecord;
using motion_types::EmitterFacts;
using motion_types::MotionCall;
using motion_types::MotionFacts;
using motion_types::put_drop;
using motion_types::SpaceFacts;
using motion_types::SurfacePlace;
using motion_types::Told;
using motion_types::TriangleFrame;
using motion_types::TriangleLinks;
using motion_types::Vector;

[[nodiscard]] inline Vector vector_of(const Vec3& v) { return {.x = v.x(), .y = v.y(), .z = v.z()}; }
[[nodiscard]] inline Vec3 vec3(const Vector& v) { return {v.x, v.y, v.z}; }

}  // namespace patinate::simulation
