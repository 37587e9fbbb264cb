/// \file
/// Albedo from photographs under known lamps: what one step of a relit capture is turned into, and the highlight that
/// is fitted to it, a lobe about the mirror direction.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/light.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Color of a highlight under white light: white, as on glass and lacquer, or the base color, as on metals.
enum class SpecularTint { White, Base };

/// The shape of a highlight, one for all of a surface; strength and width vary over it.
struct SpecularForm {
  /// How fast it falls far from its middle, >= 1.2: Student's t distribution of slopes [Ribardiere et al. 2017]. 2 is
  /// GGX with its long tails [Walter et al. 2007]; infinite is Beckmann, nearly Blinn and Ward, which has none.
  double tail = std::numeric_limits<double>::infinity();
  /// Light falls as cos(lamp)^slant cos(camera)^(slant - 1) beside the distribution: 1 as Blinn [and Hoffman 2013], 1/2
  /// as Ward, 0 as Cook and Torrance without their shadows; [0, 1].
  double slant = 1.0;
  bool is_about_mirror = false;  ///< About the mirrored direction, as Phong; else about the middle of lamp and camera.
  SpecularTint tint = SpecularTint::White;
  bool is_rendered = false;  ///< The lobe that `render` draws, GGX with Smith's shadowing; the four above do not count.
  [[nodiscard]] bool operator==(const SpecularForm&) const = default;
};

/// A surface shows strength x tint x specular_lobe() x the light that reaches it facing the lamp: F D / 4 of a
/// microfacet surface whose distribution D has alpha = roughness^2. Strength is the reflectance F0 of a surface that
/// faces camera and lamp: 0.04 for most non-metals.
/// @param normal,to_light,to_camera  Unit. @param roughness  (0, 1].
[[nodiscard]] double specular_lobe(const SpecularForm& form, const Vec3& normal, const Vec3& to_light,
                                   const Vec3& to_camera, double roughness);

/// The value of the lobe, and its derivative as the normal turns.
struct SpecularTurn {
  double value = 0.0;
  std::array<double, 2> slope{};  ///< Derivative by a turn toward each of the directions, per radian.
};
/// @param across  Two unit vectors across the normal.
[[nodiscard]] SpecularTurn specular_turn(const SpecularForm& form, const Vec3& normal,
                                         const std::array<Vec3, 2>& across, const Vec3& to_light, const Vec3& to_camera,
                                         double roughness);
/// From differences of specular_lobe() over a turn of 1e-4: of any form, and what the closed form is tested against.
[[nodiscard]] SpecularTurn specular_turn_by_differences(const SpecularForm& form, const Vec3& normal,
                                                        const std::array<Vec3, 2>& across, const Vec3& to_light,
                                                        const Vec3& to_camera, double roughness);

/// Kind of a material, from its samples: with or without a lobe, the lobe white or colored, with or without diffuse
/// light.
enum class MaterialKind { Matt, Dielectric, Metal, Mixed };
inline constexpr std::array<std::string_view, 4> kMaterialKindNames{"matt", "dielectric", "metal", "mixed"};
[[nodiscard]] std::string_view name_of(MaterialKind kind);

/// A lobe that many places share, at one time or several.
struct SurfaceMaterial {
  MaterialKind kind = MaterialKind::Matt;
  double share = 0.0;            ///< Share of the sampled texels, (0, 1].
  double roughness = 0.0;        ///< Roughness of the lobe as `render` draws it, [0.15, 0.9]; 0 for a matte material.
  Vec3 strength = Vec3::Zero();  ///< Strength of that lobe with single scattering, >= 0.
  Vec3 color = Vec3::Zero();     ///< Of a matt fit, where it is found: shares of red and green, and 0.15 times the
                                 ///< root of their mean.
  Vec3 spread = Vec3::Zero();    ///< Their standard deviations.
  double evidence = 0.0;         ///< Standard deviations by which left-out lamps are predicted better as metal (or as
                                 ///< nonmetal); for a matte material, better than with a lobe.
};

/// One step, in the view of the result: pixel (x, y) of every image shows the same place of the surface. Lamps,
/// positions, normals and blockers share one frame (the scanner's). H x W is the size of the first photograph.
struct UnlightInput {
  std::vector<ImageF> photos = {};  ///< L images H x W x C, C = 1 or 3, linear, the ambient light subtracted; finite.
  std::vector<ImageU8> valid = {};  ///< L images H x W, 0 = saturated or out of view; or none: every sample counts.
  ImageF position_mm = {};  ///< H x W x 3. May be empty when all lamps are directional and there are no blockers.
  ImageF normal = {};  ///< H x W x 3, from the scan, need not be exactly unit; (0, 0, 0) where it has none. Empty: from
                       ///< the photographs alone (photometric_normals()).
  ImageU8 mask = {};   ///< H x W, 0 = no surface; may be empty.
  std::vector<Light> lights = {};          ///< L, in the photographs' order.
  const Mesh* blockers = nullptr;          ///< Casts shadows, mm; may be null.
  std::optional<Vec3> camera_center = {};  ///< For highlights, mm. Not given: a camera far away along view_direction.
  Vec3 view_direction = Vec3(0, 0, 1);     ///< Unit, from the surface to the camera; read only without camera_center.
};

enum class NormalMode { Keep, Refine };
enum class Rejection { None, Robust };
enum class SpecularMode { None, Fit, Auto, Material };

struct UnlightOptions {
  NormalMode normals = NormalMode::Refine;  ///< Keep: the scan's. Refine: the photographs' where they know better.
  double normal_sigma_deg = 2.0;            ///< Expected error of the scan's normals; (0, 90].
  Rejection rejection = Rejection::Robust;  ///< None: every valid sample that is lit counts (plain least squares).
  double rejection_sigma = 3.0;  ///< Samples farther off are highlights or shadows; [1.5, 20], in standard deviations.
  SpecularMode specular = SpecularMode::Auto;  ///< Fit: each neighborhood's highlight is found and subtracted. Auto:
                                               ///< where nearly all its texels are better for it. Material: as many
                                               ///< lobes as there are materials, metals among them.
  double specular_window_px = 24.0;            ///< Highlights are alike within such a distance; [2, 1000].
  bool estimate_strengths =
      false;  ///< The lamps' intensities are only a guess: find them, one for each lamp and channel.
  bool estimate_ambient =
      false;  ///< A light from everywhere was not subtracted: find it, one irradiance for each channel.
  double noise_floor = 0.001;  ///< Standard deviation of a photograph's value that does not depend on it; > 0.
  double noise_share =
      0.005;  ///< The part that grows with the value; [0, 1]. Only their ratio matters: residuals scale both.
  bool interreflection =
      false;                 ///< Light that the surface throws onto itself is not taken for the lamps'; needs blockers.
  double min_cosine = 0.05;  ///< Light that grazes more does not count; [0, 1).
  int min_lights = 2;        ///< Texels with fewer clean samples are not determined; [1, 64].
  std::optional<double> shadow_offset_mm =
      {};  ///< Blockers nearer than this cast no shadow. Not given: the median edge of the blockers.
};
void describe(OptionVisitor& v, UnlightOptions& o);

/// Use of one sample (texel, lamp).
enum class SampleState : std::uint8_t {
  Outside = 0,     ///< No surface here.
  Clean = 1,       ///< It counted.
  Unlit = 2,       ///< The surface faces away from the lamp, or nearly.
  CastShadow = 3,  ///< A blocker stands between.
  Invalid = 4,     ///< `valid` said so.
  Darker = 5,      ///< Darker than the others allow: a shadow that no blocker explains.
  Brighter = 6,    ///< Brighter than the others allow: a highlight.
};
inline constexpr int kNumSampleStates = 7;

struct LightReport {
  std::array<std::int64_t, kNumSampleStates> samples{};  ///< Indexed by SampleState, over the mask.
  Vec3 strength =
      Vec3::Ones();  ///< Times the intensity that was given; their geometric mean over the lamps is 1 in each channel.
  double residual = 0.0;  ///< Root mean square of what clean samples are off, over the mean of them.
};

/// Share of the lamps' light, for each texel, that came from other places of the surface.
struct InterreflectionReport {
  double median = 0.0;  ///< Share of the value.
  double p95 = 0.0;     ///< The share that one texel in twenty has more of.
  double unseen =
      0.0;  ///< Share of the rays that met the surface where the camera does not see it, of all that met it.
};

struct UnlightResult {
  ImageF albedo = {};       ///< H x W x C; 0 where not determined.
  ImageF stddev = {};       ///< H x W x C, standard deviation of the albedo.
  ImageF normal = {};       ///< H x W x 3, unit; the scan's where not determined.
  ImageF specular = {};     ///< H x W x 2: strength and roughness as of specular_lobe(); empty with SpecularMode::None.
  SpecularForm form = {};   ///< Form of the highlights, chosen by the best prediction of left-out lamps.
  ImageF reflectance = {};  ///< H x W x 3: F0 of that lobe by channel; with SpecularMode::Material alone.
  ImageF metalness = {};    ///< H x W, [0, 1]; with SpecularMode::Material alone.
  ImageF tint = {};         ///< H x W x 3, mean 1: the color of the lobe; with SpecularMode::Material alone.
  std::vector<SurfaceMaterial> materials = {};  ///< With SpecularMode::Material alone.
  ImageU8 mask = {};                            ///< 255 = determined.
  ImageU8 samples = {};                         ///< H x W x L, SampleState.
  ImageF indirect = {};  ///< H x W x (L C), irradiance from other places of the surface over pi, the channel running
                         ///< fastest; empty without UnlightOptions::interreflection.
  std::optional<InterreflectionReport> interreflection = {};
  std::vector<LightReport> lights = {};
  double noise_scale = 1.0;     ///< Residuals over what noise_floor and noise_share expect.
  double residual = 0.0;        ///< Root mean square over all clean samples, over their mean.
  Vec3 ambient = Vec3::Zero();  ///< Irradiance from everywhere; 0 unless it was to be estimated.
  bool is_converged = true;  ///< False when strengths or ambient were asked for and did not settle, or cannot be told.
  std::int64_t num_surface = 0;  ///< Texels of the mask.
  std::int64_t num_determined = 0;
  std::vector<std::string> notes = {};  ///< Notes for the user, one line each.
};

/// A clean sample's value is albedo / pi x intensity x max(0, n . l) / d^2 (no d^2 for directional lamps).
/// @throws InvalidInput if sizes or numbers differ, a value, position or normal inside the mask is not finite, a lamp's
/// intensity is not above 0,
///         near lamps have no positions, no sample is valid, or no lamp reaches the surface.
/// Cost: a few us for each texel and lamp. Same bits for any number of threads.
[[nodiscard]] UnlightResult unlight(const UnlightInput& input, const UnlightOptions& options = {},
                                    const RunControl& control = {});

}  // namespace patinate::capture
