/// \file
/// Colors of a surface at a number of times, in memory, at a resolution of one's choice: what all figures are computed
/// from.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "patinate/analysis/texture_series.h"
#include "patinate/core/run_control.h"

namespace patinate::analysis {

/// Texels are those that show the surface at every time; T times x N texels x 3.
struct ColorStack {
  int width = 0;
  int height = 0;
  std::vector<double> times;  ///< Times of the series, in its unit; of a compared pair those of the common clock.
  std::vector<double> own_times = {};  ///< Own times of the series, in its unit, whatever the clock.
  std::vector<std::uint32_t> texels;   ///< y * width + x, ascending.
  std::vector<float> rgb;              ///< Linear.
  std::vector<float> lab;              ///< CIELAB, D65.
  /// Standard deviation of `rgb`, where the series states it for every frame; empty otherwise. Pixels that are means
  /// have that of their parts: neighbors may be off together, so no less is promised.
  std::vector<float> deviation = {};
  std::optional<double> pixel_mm;  ///< Surface length of a pixel of this stack.
  double seen_share = 1.0;         ///< Texels kept, of those of the history's mask.

  [[nodiscard]] std::size_t num_times() const { return times.size(); }
  [[nodiscard]] std::size_t num_texels() const { return texels.size(); }
  [[nodiscard]] std::span<const float> lab_at(std::size_t time) const {
    return {lab.data() + 3 * time * num_texels(), 3 * num_texels()};
  }
  [[nodiscard]] std::span<const float> rgb_at(std::size_t time) const {
    return {rgb.data() + 3 * time * num_texels(), 3 * num_texels()};
  }
  [[nodiscard]] const float* lab_of(std::size_t time, std::size_t texel) const {
    return lab.data() + 3 * (time * num_texels() + texel);
  }
  /// 255 at the texels.
  [[nodiscard]] ImageU8 mask() const;
  /// One channel of CIELAB as an image, 0 elsewhere.
  [[nodiscard]] ImageF lab_image(std::size_t time, int channel) const;
  /// One value a texel as an image, 0 elsewhere.
  [[nodiscard]] ImageF value_image(std::span<const float> values) const;
  /// Linear color as an image, `outside` elsewhere.
  [[nodiscard]] ImageF rgb_image(std::size_t time, float outside = 0.35f) const;
};

/// Size of a stack whose longer side has at most `size` pixels (0: as it is), in the series' proportions.
struct StackSize {
  int width = 0;
  int height = 0;
};
[[nodiscard]] StackSize stack_size(const TextureSeries& series, int size);
/// Mask (0 / 255) of the places that show the surface's own color at all of the times.
[[nodiscard]] ImageU8 common_mask(const TextureSeries& series, const std::vector<double>& times);

/// Pixels of the stack are means over the surface that they cover; those of which less than half shows it at some time
/// are excluded.
/// @param times  Not empty, of the series' unit; clamped to its ends.
/// @throws InvalidInput if no texel is left. Cost: two frames read a time; memory 24 B x T x N. Same bits for any
/// number of threads.
[[nodiscard]] ColorStack load_stack(const TextureSeries& series, const std::vector<double>& times, int size,
                                    const RunControl& control = {});

/// A surface whose colors come from anywhere.
struct SurfaceSource {
  std::string name = {};
  ImageU8 mask = {};  ///< 255 where all of the times show it.
  std::optional<double> pixel_mm = {};
  std::function<ImageF(double time)> sample =
      {};  ///< H x W x 3, linear, of the mask's size; called by several threads.
  std::function<ImageF(double time)> deviation = {};  ///< Standard deviation of the image at a time; may be empty.
};
/// Makes a stack of any source. @param scaled  Of the stack.
[[nodiscard]] ColorStack make_stack(const SurfaceSource& source, const std::vector<double>& times, StackSize scaled,
                                    const RunControl& control = {});
/// Size of a stack whose longer side has at most `size` pixels (0: as it is).
[[nodiscard]] StackSize stack_size(int width, int height, int size);
/// A map of a source's size at the stack's texels. @param mask  The source's.
[[nodiscard]] std::vector<float> values_at(const ImageF& values, const ImageU8& mask, const ColorStack& stack);

/// A control of the series at the stack's texels, in [0, 1]. @throws InvalidInput if there is no such control.
[[nodiscard]] std::vector<float> control_at(const TextureSeries& series, const std::string& name,
                                            const ColorStack& stack);

/// The stack with only those of its texels. @param kept  Ascending, all of them the stack's.
[[nodiscard]] ColorStack restricted(const ColorStack& stack, const std::vector<std::uint32_t>& kept);

/// For calls inside a loop that is parallel itself: one thread, no progress.
[[nodiscard]] RunControl on_this_thread();

}  // namespace patinate::analysis
