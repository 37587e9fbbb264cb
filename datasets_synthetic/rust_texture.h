/// \file
/// How rust looks.
#pragma once

#include <array>

#include "datasets_synthetic/smooth_noise.h"
#include "patinate/datasets/panel.h"
#include "patinate/geometry/mesh.h"

namespace patinate::datasets {

/// Linear light of a CIELAB color under D65.
[[nodiscard]] Vec3 linear_color(const std::array<double, 3>& lab);

/// Rust on a panel: orange where it is thin, at the rim of marks, red-brown, and dark where it is thick. Immutable;
/// safe to use from several threads.
class RustTexture {
 public:
  explicit RustTexture(const PanelOptions& o);
  /// Linear light of a pixel. @param inside_px  How deep it lies inside of a mark.
  [[nodiscard]] Vec3 at(int x, int y, double inside_px) const;

 private:
  double mm_;
  SmoothNoise broad_, fine_, grain_;
  Vec3 rim_, middle_, core_;
};

}  // namespace patinate::datasets
