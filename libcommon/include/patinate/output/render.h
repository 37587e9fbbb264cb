/// \file
/// Pictures of a textured mesh by ray casting on the CPU: one soft key light with shadows, an occluded ambient term, a
/// plain backdrop that catches the shadow. For a quick look and for documents; no GPU or display.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate {

enum class UpAxis { Y, Z };
inline constexpr std::array<std::string_view, 2> kUpAxisNames{"y", "z"};
enum class Backdrop {
  Studio,  ///< A gray wall.
  White,
  Environment  ///< The surroundings that light the object (SurfaceView); without any, Studio.
};

/// Settings of render(). Angles in degrees; azimuth turns about the up axis, 0 looks at the side that faces +z (up y)
/// or -y (up z).
struct RenderOptions {
  int width = 800;              ///< [16, 8192].
  int height = 800;             ///< [16, 8192].
  int samples = 9;              ///< Rays per pixel, rounded up to a square; [1, 256]; width * height * samples <= 2^28.
  double azimuth_deg = 30.0;    ///< Camera turns to the object's left as it grows.
  double elevation_deg = 12.0;  ///< [-90, 90]; > 0 looks down.
  double fov_deg = 28.0;        ///< Larger of the two fields of view; [1, 120].
  double zoom = 1.0;            ///< > 0; 1 fits the mesh, with margin, into the picture.
  double margin = 0.08;         ///< Share of the picture left free on the tight sides; [0, 0.9].
  UpAxis up = UpAxis::Y;
  double light_azimuth_deg = -50.0;   ///< From the camera's azimuth; < 0 is on the viewer's left.
  double light_elevation_deg = 42.0;  ///< [-90, 90].
  double light_size_deg = 7.0;        ///< Half angle of the light; 0 gives hard shadows; [0, 60].
  double light_distance = 0.0;     ///< From the middle of the mesh, or the target, in the mesh's unit; the light then
                                   ///< falls off with the square of the distance; 0 = far: its rays are parallel; >= 0.
  double light = 0.80;             ///< A white surface that faces the light gets this radiance from it, where the
                                   ///< light is near: in the middle; >= 0.
  double ambient = 0.42;           ///< Radiance of a white surface under ambient light; >= 0.
  double ambient_gradient = 0.35;  ///< Share by which downward surfaces get less ambient light; [0, 1].
  int occlusion_samples = 64;      ///< Ambient rays per vertex; 0 = ambient is not occluded; [0, 4096].
  double occlusion_reach = 0.4;    ///< Length of ambient rays in bounding box diagonals; > 0.
  double specular = 0.04;          ///< Reflectance at normal incidence of a dielectric coat; 0 = diffuse; [0, 1].
  double roughness = 0.45;         ///< GGX roughness of the coat; [0.05, 1].
  bool ground = true;              ///< The backdrop catches shadows at the object's lowest point.
  Backdrop backdrop = Backdrop::Studio;
  double background = 0.62;  ///< Linear gray of the studio backdrop's brightest part; [0, 1].
  /// Point that the camera looks at, and its distance, in the mesh's unit; finite, > 0. By default the whole mesh fits
  /// into the picture; the default target is the middle of the mesh, and the default distance is that of the fitted
  /// camera.
  std::optional<Vec3> target = {};
  std::optional<double> distance = {};
};

/// Visits every field that is a plain number or choice: not target and distance.
void describe(OptionVisitor& v, RenderOptions& o);

/// Maps of a surface in addition to color. They are sampled like textures (RenderView::shade()).
struct SurfaceDetail {
  ImageF normals = {};  ///< Tangent space: x along growing u, y along growing v (up), z out of the surface; 3 channels;
                        ///< empty: the mesh's own.
  ImageF roughness = {};  ///< Of the coat, clamped to [0.05, 1]; 1 channel; empty: RenderOptions::roughness.
};

/// A mesh seen by a camera under its light: everything that does not depend on the texture. Memory is about 16 bytes
/// per sample that hits the mesh. Thread-safe.
class RenderView {
 public:
  /// @param mesh  With UVs; any length unit.
  /// @throws InvalidInput if the mesh has no UVs or no extent, or an option is out of range.
  RenderView(const Mesh& mesh, const RenderOptions& options, const RunControl& control = {});
  /// Makes a view with relief and gloss at every texel. Shadows and occlusion are those of the mesh.
  RenderView(const Mesh& mesh, const RenderOptions& options, const SurfaceDetail& detail,
             const RunControl& control = {});

  /// The picture with a texture: height x width x 3, linear, >= 0.
  /// @param texture  Any size, 1 or >= 3 channels, linear albedo; row y is v = 1 - (y + 0.5) / height. Sampled
  /// bilinearly,
  ///                 so texels beside the charts should be filled (dilate()).
  [[nodiscard]] ImageF shade(const ImageF& texture, const RunControl& control = {}) const;
  /// 0 / 255: where at least one sample hits the mesh.
  [[nodiscard]] ImageU8 coverage() const;

 private:
  struct Sample {
    float u, v;
    float diffuse;   ///< Times albedo = radiance.
    float specular;  ///< Radiance.
  };
  int width_;
  int height_;
  int num_samples_;                        ///< Per pixel.
  std::vector<std::uint32_t> num_before_;  ///< Per pixel + 1: index of its first sample.
  std::vector<Sample> samples_;
  ImageF background_;  ///< Mean radiance that samples beside the mesh give, already weighted.
};

/// RenderView(mesh, options).shade(texture). About 1.5 s for 800 x 800 on two cores. Same bits for any number of
/// threads.
///
/// Diffuse: albedo * (light * visibility * max(0, n.l) + ambient * ambient_visibility). Ambient visibility is found by
/// cosine-weighted rays at the vertices of a refined mesh and interpolated, so that it carries no noise. Shadow rays
/// start on the smooth surface [Hanika 2021, "Hacking the shadow terminator"]; the coat is a GGX lobe with Schlick's
/// Fresnel term [Walter et al. 2007, "Microfacet models for refraction through rough surfaces"].
[[nodiscard]] ImageF render(const Mesh& mesh, const ImageF& texture, const RenderOptions& options = {},
                            const RunControl& control = {});

}  // namespace patinate
