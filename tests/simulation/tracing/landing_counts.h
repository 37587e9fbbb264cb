/// \file
/// Contacts by where they lie in their triangle: whether landing spots know of edges.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate::testing_support {

/// Parts of triangles by distance from the nearest edge.
enum class Zone {
  Below,   ///< Within the band, below the nearest edge: flow under gravity enters the triangle over it.
  Beside,  ///< Within the band of an edge that flow leaves over, or runs along.
  Between,
  Middle  ///< More than twice the band from all edges.
};
inline constexpr std::size_t kZones = 4;

/// Counts contacts of triangles that have a middle, and what is expected of each zone when a triangle's contacts are
/// spread evenly over it.
class LandingCounts {
 public:
  /// @param band_mm   Width.
  /// @param is_front  Side of the triangles that is looked at.
  /// @param down      Unit.
  LandingCounts(const Mesh& mesh, double band_mm, bool is_front, const Vec3& down);

  /// @param triangle  Any; those without a middle are passed over.
  void add(int triangle, double b1, double b2);

  struct Ratio {
    double value = 0.0;      ///< Contacts per area of the zone over those of the middle.
    double deviation = 0.0;  ///< Its standard deviation, were contacts independent of each other.
    double expected = 0.0;   ///< Contacts of the zone, were they even.
  };
  /// @param is_wanted  By triangle; empty: all.
  [[nodiscard]] Ratio over_middle(Zone zone, const std::vector<bool>& is_wanted = {}) const;

 private:
  [[nodiscard]] Zone zone_of(int triangle, double b1, double b2) const;

  struct Item {
    std::array<double, 3> height{};      ///< Height of the corners over the edges across, mm.
    std::array<bool, 3> is_upper{};      ///< The edge across from the corner is the upper one.
    std::array<double, kZones> share{};  ///< Share of the area.
    std::array<std::int64_t, kZones> hits{};
    bool counts = false;
  };
  double band_;
  std::vector<Item> items_;
};

}  // namespace patinate::testing_support
