/// \file
/// A copper mold that patinates: a shape with exact truth that is scanned, photographed under near lights, and moved in
/// between.
#pragma once

#include <cstdint>
#include <vector>

#include "datasets_synthetic/smooth_noise.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/camera.h"
#include "patinate/geometry/light.h"
#include "patinate/geometry/mesh.h"
#include "patinate/geometry/point_cloud.h"
#include "patinate/geometry/rigid_transform.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// Settings of the mold, of how it is captured, and of what disturbs that.
struct MoldOptions {
  int width = 320;           ///< Width of the photographs; [32, 4096].
  int height = 240;          ///< [32, 4096].
  int num_steps = 4;         ///< [1, 1000].
  int num_lights = 5;        ///< [1, 64].
  double interval_d = 20.0;  ///< Days between steps; > 0.
  double radius_mm =
      60.0;             ///< Radius of the mold; > 0. Its other lengths, and where camera and lights stand, go with it.
  int num_spokes = 10;  ///< [0, 40].
  int num_dents = 7;    ///< [0, 100].
  double scan_spacing_mm = 0.7;  ///< Between the scanner's points; > 0.
  double scan_noise_mm = 0.02;   ///< Standard deviation along the scanner's direction; >= 0.
  double noise = 0.004;          ///< Standard deviation of photographs, in 8-bit sRGB codes / 255; [0, 0.5].
  double motion_deg = 5.0;       ///< How far the object is turned between steps, at most; [0, 180].
  double motion_mm = 3.0;        ///< How far it is moved, at most; >= 0.
  double highlights = 1.0;       ///< Strength of the polish, times that of bright copper; [0, 10].
  bool shadows = true;           ///< Whether the object casts shadows.
  double ambient = 0.01;         ///< Value of a white surface with all lights off; [0, 1].
  double drift = 0.03;           ///< Standard deviation of exposure and white balance from step to step; [0, 0.5].
  bool metal = false;       ///< Bare copper is metal: tinted reflection without diffuse light, under no `highlights`.
  double relief_mm = 0.0;   ///< How high the patina grows, about; >= 0.
  bool exact = false;       ///< Nothing disturbs: noise, motion, highlights, shadows, ambient light and drift are
                            ///< 0 or off.
  bool transforms = false;  ///< The project says how the object was moved, so that nothing has to be registered.
  std::int64_t seed = 1;    ///< >= 0.
};
void describe(OptionVisitor& v, MoldOptions& o);
/// The options with what `exact` means put in. @throws InvalidInput if one is out of range.
[[nodiscard]] MoldOptions checked_mold(MoldOptions options);

/// Appearance of a place of the surface at a time.
struct MoldLook {
  Vec3 albedo = Vec3::Zero();
  double specular = 0.0;  ///< Strength of mold_lobe(): reflectance of the polish from straight above.
  double roughness =
      1.0;  ///< Its width: the lobe falls to about 1/e where the half vector's angle has the tangent roughness^2.
  double metalness = 0.0;           ///< Share of bare metal; 0 but for MoldOptions::metal.
  Vec3 reflectance = Vec3::Zero();  ///< Reflectance of metal_lobe() from straight above, F0; `specular` is its mean.
};

/// The highlight over the light that arrives, E max(0, n . l): s exp(-tan^2 a / m^2) / (4 pi m^2 cos^4 a), a the half
/// vector's angle to the normal and m = roughness^2 [Cook and Torrance 1982, Beckmann's distribution].
[[nodiscard]] double mold_lobe(const MoldLook& look, const Vec3& normal, const Vec3& to_light, const Vec3& to_camera);

/// The lobe of MoldOptions::metal over the light that arrives, E max(0, n . l): that of `render`, GGX of the look's
/// roughness with Smith's shadowing, Schlick's Fresnel term of its reflectance, and the energy of several bounces.
[[nodiscard]] Vec3 metal_lobe(const MoldLook& look, const Vec3& normal, const Vec3& to_light, const Vec3& to_camera);

/// The object in its own frame: a height function z(x, y) in mm over a disc, z toward the viewer, and its patina.
/// Times are in days, >= 0; the shape depends on them where there is a relief.
/// Immutable.
class Mold {
 public:
  /// @param options  Of checked_mold().
  explicit Mold(const MoldOptions& options, const RunControl& control = {});

  [[nodiscard]] double height(double x, double y, double time_d = 0.0) const;
  /// Unit, of the height function (central differences over 2e-4 mm).
  [[nodiscard]] Vec3 normal(double x, double y, double time_d = 0.0) const;
  /// How much the surface has risen since the beginning, along the normal that it had there, mm: what is between the
  /// two height functions on that line.
  [[nodiscard]] double relief(double x, double y, double time_d) const;
  /// Triangles of the disc, edges of about `spacing_mm`, with normal() at its corners.
  [[nodiscard]] Mesh mesh(double spacing_mm, double time_d = 0.0) const;
  /// height_curvature() of the height function, 1/mm, concave positive, at a width of radius / 40. What the patina
  /// follows.
  [[nodiscard]] double curvature(double x, double y) const;
  [[nodiscard]] double curvature_width_mm() const { return options_.radius_mm / 40.0; }
  /// Whether the place is lacquered, so that it never changes.
  [[nodiscard]] bool is_lacquered(double x, double y) const { return lacquer(x, y) > 0.99; }
  /// Copper goes brown, then green: soon where it is concave, late on ridges. @param time_d  >= 0.
  [[nodiscard]] MoldLook look(double x, double y, double time_d) const;
  [[nodiscard]] const MoldOptions& options() const { return options_; }

 private:
  struct Dent {
    double x, y, depth, width;
  };
  /// 1 under the lacquer, 0 beside it, smooth between.
  [[nodiscard]] double lacquer(double x, double y) const;
  /// curvature(), by a cubic B-spline: twice differentiable, a hair smoother.
  [[nodiscard]] double smooth_curvature(double x, double y) const;
  /// [0, 1], of the patina. @param curvature  Of the place.
  [[nodiscard]] double progress(double x, double y, double time_d, double curvature) const;
  /// Height that the patina adds to the height function, mm; twice differentiable.
  [[nodiscard]] double growth(double x, double y, double time_d) const;
  [[nodiscard]] MoldLook metal_look(double x, double y, double progress, double dull) const;
  [[nodiscard]] double bare_height(double x, double y) const;
  /// Unevenness of metal and patina, about [-0.6, 0.6].
  [[nodiscard]] double mottle(double x, double y) const;

  MoldOptions options_;
  SmoothNoise coarse_, fine_;
  std::vector<Dent> dents_;
  ImageF curvature_;  ///< On a grid of curvature_spacing_, its middle the object's.
  double curvature_spacing_ = 1.0;
  double curvature_low_ = 0.0, curvature_high_ = 1.0;  ///< 2nd and 98th percentile.
};

/// Where everything stands, in the scanner's frame: z up toward the scanner, mm.
struct MoldRig {
  Camera camera;
  std::vector<Light> lights;
  std::vector<RigidTransform> scanner_from_object;  ///< One a step.
  std::vector<Vec3> gains;                          ///< Red, green, blue of every step's photographs; 1 at step 0.
  double table_mm = 0.0;                            ///< z of the table that the mold lies on.
  Box card;                                         ///< A gray card on the table, for `reference_patch`; z not used.
};
inline constexpr double kMoldCardAlbedo = 0.45;
[[nodiscard]] MoldRig mold_rig(const MoldOptions& options);
/// Corners of the card's inner part in the photographs.
[[nodiscard]] std::vector<Vec2> card_polygon(const MoldRig& rig);

/// View of the scanner at a step: a square grid of points along z, moved along z by its noise; triangles between
/// neighbors, none over jumps; normals of the object only when there is no noise. In the scanner's frame.
[[nodiscard]] PointCloud mold_scan(const Mold& mold, const MoldRig& rig, int step, const RunControl& control = {});

}  // namespace patinate::datasets
