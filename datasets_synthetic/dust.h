/// \file
/// A glazed urn on which dust settles: on what looks up, or by how much of the sky a place sees. Dark and glossy at
/// first, then pale and dull.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/geometry/ray_scene.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/camera.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// Quantity that dust follows.
enum class DustFollows {
  Facing,   ///< max(0, cosine) to the vertical, as facing_map(): still air, and nothing in its way.
  Exposure  ///< Share of the sky that is seen, as exposure_map(): dust comes from all over it.
};
/// Names of the control maps, too.
inline constexpr std::array<std::string_view, 2> kDustFollowsNames{"facing", "exposure"};

/// Settings of DustyObject.
struct DustOptions {
  int width = 320;           ///< Width of the photographs; [32, 4096].
  int height = 400;          ///< [32, 4096].
  int num_frames = 16;       ///< [2, 10000].
  double interval_d = 7.0;   ///< Days between photographs; > 0.
  double height_mm = 200.0;  ///< Height of the urn, sculpture(); > 0.
  DustFollows follows = DustFollows::Exposure;
  double rate = 0.03;       ///< Grains a day over each point of a level place under an open sky; > 0.
  double steepness = 3.0;   ///< Exponent of facing or exposure: how soon dust slides off what is steep; [0.1, 20].
  double unevenness = 1.0;  ///< Unevenness of glaze and dust; 0 = none; [0, 2].
  double shading = 1.0;     ///< How far one side is lit more than others; 0 = light is even; [0, 1].
  double gloss = 1.0;       ///< The lamp's reflection in the glaze, times that of glass; 0 = none; [0, 10].
  double noise = 0.006;     ///< Standard deviation of photographs, in 8-bit sRGB codes / 255; [0, 0.5].
  std::int64_t seed = 1;    ///< >= 0.
};
void describe(OptionVisitor& v, DustOptions& o);

/// Texels along the side of the atlas on which exposure is found: twice the photographs' height, [256, 2048].
[[nodiscard]] int dust_atlas_side(const DustOptions& o);

inline const Vec3 kDustAlbedo{0.55, 0.51, 0.45};

/// A point of the surface.
struct DustPlace {
  Vec3 position_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitY();  ///< Unit.
  double facing = 0.0;          ///< [0, 1].
  double exposure = 0.0;        ///< [0, 1].
  double light = 1.0;           ///< Irradiance over that of even light.
};

/// Appearance of a place at a time.
struct DustLook {
  Vec3 albedo = Vec3::Zero();
  double cover = 0.0;      ///< Share of the place under dust; [0, 1].
  double specular = 0.0;   ///< F0 of the mirror: the glaze's 0.04 where no dust lies.
  double roughness = 1.0;  ///< GGX: from 0.18 to 0.9.
};

/// The urn, where it is photographed from, and its dust. y up, mm. Immutable; safe to use from several threads.
class DustyObject {
 public:
  /// @throws InvalidInput if an option is out of range. Cost: 8 s of one core at the defaults, for exposure.
  explicit DustyObject(const DustOptions& options, const RunControl& control = {});

  /// Place that a pixel sees; nothing beside the urn.
  [[nodiscard]] std::optional<DustPlace> place(const Vec2& pixel) const;
  /// How many grains lie over a point on average: rate * follows^steepness * time, uneven by noise.
  [[nodiscard]] double amount(const DustPlace& place, double time_d) const;
  /// Grains fall anywhere, so that of a place 1 - exp(-amount) is covered (Poisson); albedo is the mean of glaze and
  /// dust by that share.
  [[nodiscard]] DustLook look(const DustPlace& place, double time_d) const;
  /// Linear light that the camera gets from a place.
  [[nodiscard]] Vec3 seen(const DustPlace& place, double time_d) const;

  [[nodiscard]] const DustOptions& options() const { return options_; }
  [[nodiscard]] const Mesh& mesh() const { return map_.mesh(); }
  [[nodiscard]] const Camera& camera() const { return camera_; }

 private:
  [[nodiscard]] double noise(const SmoothNoise& field, const Vec3& position_mm) const;

  DustOptions options_;
  Camera camera_;
  TexelMap map_;
  RayScene scene_;
  ImageF exposure_, light_;  ///< Over map_.
  SmoothNoise glaze_, dust_;
};

/// Surface that the photographs' pixels show; 0 beside the urn.
struct DustView {
  ImageU8 mask;                ///< 255 where all of the pixel shows the urn.
  ImageF position_mm, normal;  ///< x 3.
  ImageF facing, exposure, light;
};
[[nodiscard]] DustView dust_view(const DustyObject& object, const RunControl& control = {});

/// Linear photograph without noise: a pixel is the mean of four rays; with noise 0 it is what its center sees.
/// Same bits for any number of threads.
[[nodiscard]] ImageF dust_photo(const DustyObject& object, double time_d, const RunControl& control = {});

}  // namespace patinate::datasets
