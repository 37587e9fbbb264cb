/// \file
/// A rough mirror: GGX microfacets with Smith's shadowing [Walter et al. 2007], Schlick's Fresnel term, and the energy
/// that single scattering loses made good [Turquin 2019].
#pragma once

#include "patinate/geometry/mesh.h"

namespace patinate {

/// Energy that a lobe reflects of light from all around, by what it reflects at normal incidence f0: f0 * scale + bias.
struct LobeEnergy {
  double scale = 0.0;
  double bias = 0.0;
  /// Factor that gives a lobe the energy back which single scattering loses; 1 without loss. @param f0  [0, 1].
  [[nodiscard]] double compensation(double f0) const { return 1.0 + f0 * (1.0 / (scale + bias) - 1.0); }
  /// All that the compensated lobe reflects; 1 for f0 = 1.
  [[nodiscard]] double reflected(double f0) const { return compensation(f0) * (f0 * scale + bias); }
};
/// From a table. @param roughness  [0.05, 1]. @param cos_view  Of the angle between normal and view, [0, 1].
[[nodiscard]] LobeEnergy lobe_energy(double roughness, double cos_view);

/// Schlick's Fresnel term. @param cosine  Of the angle to the microfacet's normal.
[[nodiscard]] double fresnel(double f0, double cosine);

/// A lobe's value, and how it changes as the normal turns.
struct LobeTurn {
  double shape = 0.0;             ///< Shape as Lobe::Value has it.
  Vec3 by_normal = Vec3::Zero();  ///< Times a small turn of the normal, a vector across it, is the change of `shape`.
};
/// @param normal, view, light  Unit; zero where one of both lies below the surface. @param roughness  [0.05, 1].
[[nodiscard]] LobeTurn lobe_turn(const Vec3& normal, const Vec3& view, const Vec3& light, double roughness);

/// The lobe around a normal, seen from one direction.
class Lobe {
 public:
  /// @param normal, view  Unit; at an angle below 90 degrees. @param roughness  [0.05, 1].
  Lobe(const Vec3& normal, const Vec3& view, double roughness);

  struct Value {
    double shape = 0.0;        ///< Times the Fresnel term: BRDF times cosine.
    double pdf = 0.0;          ///< With which sample() gives this direction, per steradian.
    double half_cosine = 0.0;  ///< Between view and the microfacet's normal.
  };
  /// @param light  Unit. Zero below the surface.
  [[nodiscard]] Value value(const Vec3& light) const;
  /// A direction of reflection by the distribution of visible microfacets [Heitz 2018]; may lie below the surface.
  [[nodiscard]] Vec3 sample(const Vec2& square) const;

 private:
  Vec3 normal_, view_, a_, b_;
  double alpha_;
  double cos_view_;
};

}  // namespace patinate
