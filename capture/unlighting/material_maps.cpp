#include "capture/unlighting/material_maps.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libcommon/core/parallel.h"
#include "libcommon/output/microfacet.h"

namespace patinate::capture {

namespace {

constexpr double kGridTexels = 4000.0;  ///< See docs/algorithms/materials.md, step 1.
constexpr std::int64_t kMapRowsAChunk = 4;
constexpr double kMineral = 0.04;  ///< F0 of what is no metal, where nothing else is known.

Vec3 feature_of(const ImageF& color, int x, int y) {
  constexpr double kLightness = 0.15;  // Beside shares of channels: a metal's matt color depends on where it faces.
  const auto p = color.pixel(x, y);
  Vec3 c;
  for (int k = 0; k < 3; ++k)
    c[k] = std::max(1e-4, static_cast<double>(p[p.size() == 3 ? static_cast<std::size_t>(k) : 0]));
  return {c[0] / c.sum(), c[1] / c.sum(), kLightness * std::sqrt(c.mean())};
}

/// Step of the grid, so that it has kGridTexels or fewer.
int grid_step(const UnlightWork& work) {
  double count = 0.0;
  for (int y = 0; y < work.height; ++y)
    for (int x = 0; x < work.width; ++x) count += work.is_surface(x, y);
  return std::max(1, static_cast<int>(std::ceil(std::sqrt(count / kGridTexels))));
}

std::vector<TexelEvidence> evidence_of_grid(const UnlightWork& work, const UnlightResult& fitted, const ImageF& color,
                                            int step, std::span<const double> roughness, const RunControl& control) {
  const int rows = (work.height + step - 1) / step;
  std::vector<std::vector<TexelEvidence>> found(static_cast<std::size_t>(rows));
  parallel_for(rows, 1, control, [&](std::int64_t row, std::int64_t) {
    TexelLobes lobes(work, work.form);
    TexelEvidence texel;
    const int y = std::min(work.height - 1, static_cast<int>(row) * step + step / 2);
    for (int x = step / 2; x < work.width; x += step) {
      if (!work.is_surface(x, y) || fitted.mask.at(x, y) == 0 || !lobes.evidence(x, y, fitted, roughness, texel))
        continue;
      texel.color = feature_of(color, x, y);
      found[row].push_back(texel);
    }
  });
  std::vector<TexelEvidence> all;
  for (std::vector<TexelEvidence>& row : found)
    all.insert(all.end(), std::make_move_iterator(row.begin()), std::make_move_iterator(row.end()));
  return all;
}

std::vector<std::size_t> each_its_own(std::size_t count) {
  std::vector<std::size_t> at(count);
  std::iota(at.begin(), at.end(), std::size_t{0});
  return at;
}

/// Shares on the grid, between which texels look.
class GridShares {
 public:
  GridShares(int width, int height, int step) : step_(step), index_(width / step + 2, height / step + 2, 1, -1) {}
  void set(std::vector<TexelEvidence> texels, MaterialShares shares) {
    texels_ = std::move(texels);
    shares_ = std::move(shares);
    for (std::size_t i = 0; i < texels_.size(); ++i)
      index_.at(texels_[i].x / step_, texels_[i].y / step_) = static_cast<int>(i);
  }
  /// Adds the belief of the four grid texels around, by distance and likeness of color.
  void add(int x, int y, const Vec3& color, std::vector<double>& belief) const {
    const double u = std::max(0.0, (x - 0.5 * step_ + 0.5) / step_), v = std::max(0.0, (y - 0.5 * step_ + 0.5) / step_);
    const int i = static_cast<int>(u), j = static_cast<int>(v);
    for (int b = 0; b < 2; ++b) {
      for (int a = 0; a < 2; ++a) {
        if (!index_.contains(i + a, j + b) || index_.at(i + a, j + b) < 0) continue;
        const auto at = static_cast<std::size_t>(index_.at(i + a, j + b));
        const double weight = 4.0 * (a == 0 ? 1.0 - (u - i) : u - i) * (b == 0 ? 1.0 - (v - j) : v - j) *
                              likeness(color, texels_[at].color);
        for (std::size_t k = 0; k < belief.size(); ++k) belief[k] += weight * shares_[at][k];
      }
    }
  }

 private:
  int step_;
  Image<int> index_;
  std::vector<TexelEvidence> texels_;
  MaterialShares shares_;
};

double mean_of(const ImageF& image, int x, int y) {
  double sum = 0.0;
  for (const float v : image.pixel(x, y)) sum += static_cast<double>(v);
  return sum / image.channels();
}

}  // namespace

double f0_of_strength(double strength, double roughness, double facing) {
  const LobeEnergy energy = lobe_energy(roughness, facing);
  const double more = 1.0 / std::clamp(energy.scale + energy.bias, 0.05, 1.0) - 1.0;
  if (!(more > 1e-6)) return std::clamp(strength, 0.0, 1.0);
  return std::clamp((std::sqrt(1.0 + 4.0 * more * strength) - 1.0) / (2.0 * more), 0.0, 1.0);
}

double metal_share(double albedo, double f0) {
  const double sum = albedo + f0, root2 = sum * sum - 4.0 * kMineral * albedo;
  if (!(f0 > kMineral) || !(root2 > 0.0)) return 0.0;
  const double rest = 2.0 * albedo / (sum + std::sqrt(root2));
  return std::clamp(1.0 - rest, 0.0, 1.0);
}

std::vector<TexelEvidence> gather_evidence(const UnlightWork& work, const UnlightResult& fitted, const ImageF& color,
                                           const RunControl& control) {
  return evidence_of_grid(work, fitted, color, grid_step(work), kLobeRoughness, control);
}

void lay_materials(UnlightWork& work, const UnlightResult& fitted, const ImageF& color,
                   const std::vector<SurfaceMaterial>& materials, const RunControl& control) {
  ImageF specular(work.width, work.height, 2), tint(work.width, work.height, 3), metal(work.width, work.height, 2);
  if (!materials.empty()) {
    std::vector<double> roughness;
    for (const SurfaceMaterial& m : materials) roughness.push_back(std::max(kLobeRoughness.front(), m.roughness));
    const std::vector<std::size_t> at = each_its_own(materials.size());
    const int step = grid_step(work);
    std::vector<TexelEvidence> texels = evidence_of_grid(work, fitted, color, step, roughness, control.part(0.0, 0.2));
    GridShares grid(work.width, work.height, step);
    MaterialShares shares = shares_of_materials(texels, materials, at, control.part(0.2, 0.3));
    grid.set(std::move(texels), std::move(shares));
    parallel_for(work.height, kMapRowsAChunk, control.part(0.3, 1.0), [&](std::int64_t begin, std::int64_t end) {
      TexelLobes lobes(work, work.form);
      TexelEvidence texel;
      for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
        for (int x = 0; x < work.width; ++x) {
          if (!work.is_surface(x, y) || fitted.mask.at(x, y) == 0 || !lobes.evidence(x, y, fitted, roughness, texel))
            continue;
          texel.color = feature_of(color, x, y);
          std::vector<double> belief(materials.size(), 0.0);
          grid.add(x, y, texel.color, belief);
          const std::vector<double> here = shares_of_texel(texel, materials, at, std::move(belief));
          Vec3 strength = Vec3::Zero();
          double rough = 0.0, weight = 0.0;
          for (std::size_t k = 0; k < here.size(); ++k) {
            strength += here[k] * materials[k].strength;
            rough += here[k] * materials[k].strength.mean() * materials[k].roughness;
            weight += here[k] * materials[k].strength.mean();
            if (materials[k].kind == MaterialKind::Metal) metal.at(x, y, 0) += static_cast<float>(here[k]);
            if (materials[k].kind == MaterialKind::Mixed) metal.at(x, y, 1) += static_cast<float>(here[k]);
          }
          if (!(strength.mean() > 1e-4)) continue;
          specular.at(x, y, 0) = static_cast<float>(strength.mean());
          specular.at(x, y, 1) = static_cast<float>(rough / weight);
          for (int c = 0; c < 3; ++c) tint.at(x, y, c) = static_cast<float>(strength[c] / strength.mean());
        }
      }
    });
  }
  work.highlight_normal = fitted.normal;
  work.highlight_base = fitted.albedo;
  work.specular = std::move(specular);
  work.highlight_tint = std::move(tint);
  work.highlight_metal = std::move(metal);
}

void put_reflectance(const UnlightWork& work, UnlightResult& result, const RunControl& control) {
  result.reflectance = ImageF(work.width, work.height, 3);
  result.metalness = ImageF(work.width, work.height);
  parallel_for(work.height, kMapRowsAChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < work.width; ++x) {
        const double strength = static_cast<double>(result.specular.at(x, y, 0));
        if (result.mask.at(x, y) == 0 || !(strength > 0.0)) continue;
        const double facing = vector_of(result.normal, x, y).dot(work.to_camera(x, y));
        for (int c = 0; c < 3; ++c) {
          result.reflectance.at(x, y, c) =
              static_cast<float>(f0_of_strength(strength * static_cast<double>(work.highlight_tint.at(x, y, c)),
                                                static_cast<double>(result.specular.at(x, y, 1)), facing));
        }
        const double share = metal_share(mean_of(result.albedo, x, y), mean_of(result.reflectance, x, y));
        result.metalness.at(x, y) =
            static_cast<float>(std::min(1.0, static_cast<double>(work.highlight_metal.at(x, y, 0)) +
                                                 share * static_cast<double>(work.highlight_metal.at(x, y, 1))));
      }
    }
  });
}

}  // namespace patinate::capture
