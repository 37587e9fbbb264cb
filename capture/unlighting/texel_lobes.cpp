#include "capture/unlighting/texel_lobes.h"

namespace patinate::capture {

namespace {

using Turns = Eigen::Matrix<double, 2, 1>;

/// Chi-square and lobes with unknowns eliminated: `inverse` of their normal equations, `pull` their right side.
template <int N>
struct Eliminated {
  Eigen::Matrix<double, N, N> inverse;
  Eigen::Matrix<double, N, 1> pull;

  [[nodiscard]] double saved() const { return pull.dot(inverse * pull); }
  /// @param slopes  Of each channel: products of its lobe with the unknowns' slopes.
  [[nodiscard]] ChannelLobe lobe(const ChannelLobe& whole, const Eigen::Matrix<double, N, 3>& slopes) const {
    const Eigen::Matrix<double, N, 3> projected = inverse * slopes;
    ChannelLobe out;
    out.whole = whole.whole;
    out.lobe = whole.lobe - slopes.transpose() * projected;
    out.value = whole.value - projected.transpose() * pull;
    return out;
  }
};

}  // namespace

bool TexelLobes::evidence(int x, int y, const UnlightResult& fitted, std::span<const double> roughness,
                          TexelEvidence& out) {
  gather(x, y, fitted);
  if (samples_.size() < 3) return false;
  const Vec3 to_camera = work_.to_camera(x, y);
  leave_each_out();
  Normals matrix = prior();
  Unknowns pull = prior_pull();
  Eigen::Matrix2d turns = matrix.bottomRightCorner<2, 2>();
  Turns turns_pull = pull.tail<2>();
  out.x = x;
  out.y = y;
  out.matt = out.black = 0.0;
  out.num_values = static_cast<int>(samples_.size()) * work_.num_channels;
  for (const LobeSample& s : samples_) {
    matrix += s.slope.transpose() * s.weight.asDiagonal() * s.slope;
    pull += s.slope.transpose() * s.weight.cwiseProduct(s.value);
    const Eigen::Matrix<double, 3, 2> turn = s.slope.rightCols<2>();
    turns += turn.transpose() * s.weight.asDiagonal() * turn;
    turns_pull += turn.transpose() * s.weight.cwiseProduct(s.whole);
    out.matt += s.weight.dot(s.value.cwiseAbs2());
    out.black += s.weight.dot(s.whole.cwiseAbs2());
  }
  const Eliminated<5> diffuse{matrix.inverse(), pull};
  const Eliminated<2> black{turns.inverse(), turns_pull};
  if (!diffuse.inverse.allFinite() || !black.inverse.allFinite()) return false;
  out.matt -= diffuse.saved();
  out.black -= black.saved();
  out.albedo = (diffuse.inverse * diffuse.pull).head<3>();
  for (int c = 0; c < work_.num_channels; ++c) out.albedo[c] += static_cast<double>(fitted.albedo.at(x, y, c));
  out.glossy.clear();
  out.metal.clear();
  out.albedo_less.clear();
  for (const double r : roughness) {
    ChannelLobe glossy, metal;
    Eigen::Matrix<double, 5, 3> slopes = Eigen::Matrix<double, 5, 3>::Zero();
    for (const LobeSample& s : samples_) {
      const Channels lobe = specular_lobe(form_, s.normal, s.direction, to_camera, r) * s.light,
                     weighted = s.weight.cwiseProduct(lobe);
      glossy.whole += weighted.cwiseProduct(lobe);
      glossy.value += weighted.cwiseProduct(s.value);
      metal.value += weighted.cwiseProduct(s.whole);
      slopes += s.slope.transpose() * weighted.asDiagonal();
    }
    glossy.lobe = glossy.whole.asDiagonal();
    metal.whole = glossy.whole;
    metal.lobe = glossy.lobe;
    out.glossy.push_back(diffuse.lobe(glossy, slopes));
    out.albedo_less.emplace_back((diffuse.inverse * slopes).topRows<3>());
    out.metal.push_back(black.lobe(metal, slopes.bottomRows<2>()));
  }
  return out.glossy.front().value.allFinite() && out.metal.front().value.allFinite();
}

}  // namespace patinate::capture
