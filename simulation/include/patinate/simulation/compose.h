/// \file
/// From amounts of materials to what is seen: color, specular value, height and normal of every texel.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "patinate/simulation/material_atlas.h"
#include "patinate/simulation/scene.h"

namespace patinate {
enum class InstructionSet;
}

namespace patinate::device {
class DeviceError;
}

namespace patinate::simulation {

struct DeviceArrays;
class LayerAtlas;

/// How weights w_i of materials, a = sum w_i, become a color. The first two give sum w_i C_i / a where a >= 1.
enum class ColorForm {
  Normalized,  ///< C0 (1 - a) + sum w_i C_i: weights sum to 1. The default (docs/decisions/0009-composition-forms.md).
  Published,   ///< C0 (1 - a) + a sum w_i C_i, as the authors' shader does: half a cover darkens by up to a quarter.
  Printed  ///< C0 (1 - a) + a sum w_i C_i as the authors' equation is printed, with a = min(1, sum b_i (1 + v_i xi_i))
           ///< without amounts, over the materials that were added; ends at white.
};
inline constexpr std::array<std::string_view, 3> kColorFormNames{"normalized", "published", "printed"};

/// Composes an atlas [Guenther et al. 2012, sec. 4.5]. With delta_i = amount - original, xi_i in [-1, 1) fixed per
/// texel and material:
///     w_i      = min(4, min(4, max(0, delta_i) b_i) (1 + v_i xi_i))           then ColorForm
///     specular = clamp(s0 + sum delta_i specular_i (1 + v_i xi_i), 0, 1)
///     height   = h0 + sum delta_i height_i (1 + v_i xi_i)
///     normal   = (-dh/dT, -dh/dB, 1) / |.|, slopes to 16 (86.4 degrees) by differences to the neighbors on the
///     surface, across seams
/// in integers throughout: same bytes for any number of threads, any instruction set and any order of the calls. Colors
/// are sRGB codes of 8 bit and blended linearly. Normals are in the frame of glTF: T along +u, B at right angles to it
/// toward +v.
///
/// Memory: 7 bytes a texel; 4 more once anything has a height; 4 for each of color and height maps where objects have
/// them. Not thread-safe.
class Composer {
 public:
  /// @param scene       Materials, their appearance, objects with maps. Not kept.
  /// @param scene_mesh  As it stood when `surface` was made. Not kept.
  /// @param surface     Outlives the composer.
  /// @throws InvalidInput if a look has a value out of range.
  Composer(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface,
           ColorForm form = ColorForm::Normalized, const RunControl& control = {});
  ~Composer();
  Composer(Composer&&) noexcept;
  Composer& operator=(Composer&&) noexcept;

  /// Other appearance parameters for the same amounts: everything is composed again at the next compose(); normals only
  /// where heights change.
  /// @throws InvalidInput unless there is one for each material, in range.
  void set_appearance(const std::vector<MaterialAppearance>& appearance);
  void set_form(ColorForm form);
  /// Where objects have layers: the thicknesses that decide which one shows, and how high it lies. @param layers  Of
  /// the scene and surface of the composer; outlives it. Everything is composed again at the next compose().
  void set_layers(const LayerAtlas* layers);
  /// For tests and benchmarks. @throws InvalidInput if this machine lacks it.
  void use(InstructionSet set);

  /// Brings the dirty tiles, and the normals around them, up to date; everything at the first call and after
  /// set_appearance().
  /// @param atlas  Of the same surface, with as many materials as there are appearances.
  /// @param dirty  Tiles whose amounts may have changed since the last call; any order.
  /// @return tiles of which anything changed, in order.
  /// @throws InvalidInput for another atlas or a tile out of range; Canceled: everything is then composed again at the
  /// next call.
  std::vector<TileIndex> compose(const MaterialAtlas& atlas, std::span<const TileIndex> dirty,
                                 const RunControl& control = {});

  /// Composes on a device, with the same bytes: the tiles listed there, or all of them. Results stay on the device
  /// until they are requested. @param atlas  Gives the original amounts. @throws DeviceError
  void compose_there(const MaterialAtlas& atlas, DeviceArrays& arrays, const RunControl& control);
  /// Tiles that the last compose_there() changed, in order. @throws DeviceError
  [[nodiscard]] std::vector<TileIndex> changed_there() const;
  /// Called before what a device has composed is taken over: may compose again.
  void on_asked(std::function<void()> make_sure);
  /// Called where what a device has composed is asked for, and it cannot give it back: is to call forget_there() and
  /// compose(), of amounts as they are then.
  void on_lost(std::function<void(const device::DeviceError&)> compose_here);
  /// Everything is to be composed anew.
  void forget_there();

  /// By texel, in tile order: R | G << 8 | B << 16 | specular << 24, color as sRGB codes. 0 outside the charts and
  /// before compose().
  [[nodiscard]] std::span<const std::uint32_t> codes() const;
  /// By tile: 64 values of x, then of y, then of z; 127.5 + 127.5 n, rounded. Flat is (128, 128, 255).
  [[nodiscard]] std::span<const std::uint8_t> normals() const;
  [[nodiscard]] double height_mm(TexelIndex t) const;
  /// Slopes dh/dT and dh/dB of a covered texel, mm/mm.
  [[nodiscard]] std::array<double, 2> slopes(TexelIndex t) const;
  /// A normal tilted by the relief: for rays that are to be reflected by it.
  /// @param normal       Unit.
  /// @param mm_per_texel Texel steps of the triangle where it stands now: SurfaceAtlas::mm_per_texel, turned as its
  /// object.
  [[nodiscard]] Vec3 perturbed_normal(TexelIndex t, const Vec3& normal,
                                      const Eigen::Matrix<double, 3, 2>& mm_per_texel) const;

  // Pictures in the user's order of pixels; what lies outside the charts repeats the nearest texel inside.
  [[nodiscard]] ImageU8 color_srgb8() const;  ///< H x W x 3.
  [[nodiscard]] ImageF color_linear() const;  ///< H x W x 3, of the same codes.
  [[nodiscard]] ImageU8 specular8() const;    ///< H x W x 1.
  [[nodiscard]] ImageU8 normal8() const;      ///< H x W x 3.
  [[nodiscard]] ImageF height_mm() const;     ///< H x W x 1, in steps of 1 / 1024 of a median texel's size.
  [[nodiscard]] std::size_t memory() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace patinate::simulation
