/// \file
/// A ray against four boxes or four triangles at once, in float and on the safe side: what is hit is never missed, and
/// what may be hit is decided elsewhere. With SSE2 where there is some; the plain loops beside it give the same bits.
#pragma once

#include <bit>
#include <cmath>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "simulation/tracing/ray_tracer.h"

namespace patinate::simulation {

#ifdef __SSE2__
struct Lanes {
  __m128 x;
};
inline Lanes lanes_of(float x) { return {_mm_set1_ps(x)}; }
inline Lanes load_lanes(const std::array<float, 4>& x) { return {_mm_load_ps(x.data())}; }
inline Lanes add(Lanes a, Lanes b) { return {_mm_add_ps(a.x, b.x)}; }
inline Lanes sub(Lanes a, Lanes b) { return {_mm_sub_ps(a.x, b.x)}; }
inline Lanes mul(Lanes a, Lanes b) { return {_mm_mul_ps(a.x, b.x)}; }
inline Lanes least(Lanes a, Lanes b) { return {_mm_min_ps(a.x, b.x)}; }
inline Lanes most(Lanes a, Lanes b) { return {_mm_max_ps(a.x, b.x)}; }
inline Lanes magnitude(Lanes a) { return {_mm_andnot_ps(_mm_set1_ps(-0.0F), a.x)}; }
inline unsigned which_not_above(Lanes a, Lanes b) {
  return static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(a.x, b.x)));
}
inline void store_lanes(Lanes a, std::array<float, 4>& x) { _mm_store_ps(x.data(), a.x); }
#else
using Lanes = std::array<float, 4>;
template <class F>
Lanes each_lane(const Lanes& a, const Lanes& b, F&& f) {
  return {f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])};
}
inline Lanes lanes_of(float x) { return {x, x, x, x}; }
inline Lanes load_lanes(const std::array<float, 4>& x) { return x; }
inline Lanes add(const Lanes& a, const Lanes& b) {
  return each_lane(a, b, [](float x, float y) { return x + y; });
}
inline Lanes sub(const Lanes& a, const Lanes& b) {
  return each_lane(a, b, [](float x, float y) { return x - y; });
}
inline Lanes mul(const Lanes& a, const Lanes& b) {
  return each_lane(a, b, [](float x, float y) { return x * y; });
}
inline Lanes least(const Lanes& a, const Lanes& b) {
  return each_lane(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Lanes most(const Lanes& a, const Lanes& b) {
  return each_lane(a, b, [](float x, float y) { return x > y ? x : y; });
}
inline Lanes magnitude(const Lanes& a) { return {std::abs(a[0]), std::abs(a[1]), std::abs(a[2]), std::abs(a[3])}; }
inline unsigned which_not_above(const Lanes& a, const Lanes& b) {
  return (a[0] <= b[0] ? 1u : 0u) | (a[1] <= b[1] ? 2u : 0u) | (a[2] <= b[2] ? 4u : 0u) | (a[3] <= b[3] ? 8u : 0u);
}
inline void store_lanes(const Lanes& a, std::array<float, 4>& x) { x = a; }
#endif

class RayLanes {
 public:
  /// @param axis, x, y, z  The shear of [Woop et al. 2013]; axis[2] is that of the direction's largest part.
  /// @param slack          What rounding may move a coordinate by.
  RayLanes(const Vec3& origin, const Vec3& direction, const std::array<std::size_t, 3>& axis, double x, double y,
           double z, float slack)
      : axis_(axis),
        shear_x_(lanes_of(static_cast<float>(x))),
        shear_y_(lanes_of(static_cast<float>(y))),
        shear_z_(lanes_of(static_cast<float>(z))),
        slack_(lanes_of(4.0F * slack)),
        z_slack_(lanes_of(4.0F * slack * std::abs(static_cast<float>(z)))) {
    for (std::size_t a = 0; a < 3; ++a) {
      origin_[a] = lanes_of(static_cast<float>(origin[static_cast<Eigen::Index>(a)]));
      near_side_[a] = direction[static_cast<Eigen::Index>(a)] < 0.0 ? 1 : 0;
    }
  }
  void set_inverse(std::size_t axis, float inverse) {
    inverse_[axis] = lanes_of(inverse);
    near_side_[axis] = inverse < 0.0F ? 1 : 0;
  }
  void set_interval(float from, float to) {
    from_ = lanes_of(from);
    to_ = lanes_of(to);
  }

  /// A bit for each box that the ray may enter, and where. 3 roundings each: [Ize 2013].
  [[nodiscard]] unsigned boxes_hit(const BvhNode& n, std::array<float, 4>& distance) const {
    Lanes near = from_, far = to_;
    for (std::size_t a = 0; a < 3; ++a) {
      near = most(near, mul(sub(load_lanes(n.bounds[near_side_[a]][a]), origin_[a]), inverse_[a]));
      far = least(far, mul(sub(load_lanes(n.bounds[1 - near_side_[a]][a]), origin_[a]), inverse_[a]));
    }
    store_lanes(near, distance);
    return which_not_above(near, mul(far, lanes_of(1.0F + 8.0F * 0x1.0p-23F)));
  }

  /// A bit for each triangle that the ray may hit within the interval.
  [[nodiscard]] unsigned triangles_maybe_hit(const TriangleBlock& block) const {
    std::array<Lanes, 3> x, y, z;
    for (std::size_t c = 0; c < 3; ++c) {
      z[c] = sub(load_lanes(block.corner[c][axis_[2]]), origin_[axis_[2]]);
      x[c] = sub(sub(load_lanes(block.corner[c][axis_[0]]), origin_[axis_[0]]), mul(shear_x_, z[c]));
      y[c] = sub(sub(load_lanes(block.corner[c][axis_[1]]), origin_[axis_[1]]), mul(shear_y_, z[c]));
      z[c] = mul(shear_z_, z[c]);
    }
    const Lanes size = add(add(add(magnitude(x[0]), magnitude(y[0])), add(magnitude(x[1]), magnitude(y[1]))),
                           add(magnitude(x[2]), magnitude(y[2])));
    const Lanes most_off = mul(slack_, add(size, slack_));
    const Lanes u = sub(mul(x[2], y[1]), mul(y[2], x[1]));
    const Lanes v = sub(mul(x[0], y[2]), mul(y[0], x[2]));
    const Lanes w = sub(mul(x[1], y[0]), mul(y[1], x[0]));
    const Lanes lowest = least(least(u, v), w), highest = most(most(u, v), w);
    const Lanes zero = lanes_of(0.0F);
    const unsigned is_inside = which_not_above(sub(zero, most_off), lowest) | which_not_above(highest, most_off);
    const unsigned is_in_reach = which_not_above(sub(least(least(z[0], z[1]), z[2]), z_slack_), to_) &
                                 which_not_above(from_, add(most(most(z[0], z[1]), z[2]), z_slack_));
    return is_inside & is_in_reach;
  }

 private:
  std::array<Lanes, 3> origin_, inverse_;
  std::array<std::size_t, 3> near_side_{}, axis_{};
  Lanes shear_x_, shear_y_, shear_z_, slack_, z_slack_, from_, to_;
};

}  // namespace patinate::simulation
