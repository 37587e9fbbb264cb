#include "capture/gloss/standing_gloss.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "capture/unlighting/color_clusters.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

constexpr int kTilesAlong = 32;           ///< The longer side.
constexpr int kMinTilePx = 4;             ///< px; smaller tiles hold noise.
constexpr double kMinOfTile = 0.3;        ///< Share of a tile's pixels that must be of the material.
constexpr double kMaxUnknown = 0.1;       ///< Share of a tile's pixels that may be saturated.
constexpr int kLobesOfTile = 9;           ///< So many of its pixels tell a tile's lobe.
constexpr double kMember = 0.6;           ///< Share from which a pixel tells of a material.
constexpr std::size_t kMaxMaterials = 4;  ///< Classes of color (docs/algorithms/gloss.md).
constexpr double kMinShare = 0.02;        ///< Classes of less than this share of the surface are dropped.
constexpr double kTinted = 0.15;          ///< By which a channel of the lobe must differ from white.
constexpr double kMaxOfMinerals = 0.2;    ///< Reflectance that no mineral has: diamond has 0.17.
constexpr std::size_t kColorFrames = 6;   ///< Photographs that classes are found in, evenly picked.
constexpr std::int64_t kRows = 4;

/// Shares of channels and a little of lightness; the floor keeps the noise of black from having a color.
Vec3 color_feature(const Vec3& albedo) {
  // Linear albedo that keeps hues of dark places finite; weight of lightness beside them.
  constexpr double kFloor = 0.02, kLightness = 0.15;
  const Vec3 c = albedo.cwiseMax(0.0) + Vec3::Constant(kFloor);
  return {c[0] / c.sum(), c[1] / c.sum(), kLightness * std::sqrt(c.mean())};
}

Vec3 strength_of(const GlossMaterial& m, std::size_t frame) {
  return m.course.is_told ? Vec3(m.course.at[frame].strength * m.course.tint) : Vec3(Vec3::Zero());
}

/// Light that remains of what is seen without a material's highlight. A highlight is off its form by a twentieth, a
/// place off its material's albedo by a sixth: what is left too much or too little is shared out between the two, so
/// that bright highlights do not drown the color below them.
Vec3 left_by(const GlossMaterial& m, const Vec3& seen, const Vec3& highlight) {
  // Unevenness of a material's albedo, as a share, and its least, linear (a sixth: docs/algorithms/gloss.md).
  constexpr double kUneven = 0.15, kMinUneven = 0.02;
  const Vec3 left = seen - highlight;
  if (!m.albedo) return left;
  const double form = kFormOff * highlight.mean(), uneven = kUneven * m.albedo->mean() + kMinUneven,
               gain = (left.mean() - m.albedo->mean()) * form * kFormOff / (form * form + uneven * uneven);
  return left - gain * highlight;
}

/// A pixel with the highlight taken off.
struct Unlit {
  Vec3 albedo = Vec3::Zero(), strength = Vec3::Zero();
  std::vector<double> shares;
};
/// Each material is as likely as it is frequent and as the color that its own lobe leaves is like its color: a pixel of
/// that color is wholly it, one between two a mixture [Shepard 1968]. A lobe that leaves less than nothing is none of
/// it.
Unlit unlit(const GlossPixel& pixel, const Vec3& value, std::size_t frame, const std::vector<GlossMaterial>& materials,
            const std::vector<double>& lobes) {
  constexpr double kAlike = 0.006;  // Distance of hues that counts as none.
  Unlit out{.shares = std::vector<double>(materials.size(), 1.0)};
  const Vec3 seen = value.cwiseQuotient(pixel.matt);
  if (materials.empty()) {
    out.albedo = seen.cwiseMax(0.0);
    return out;
  }
  double sum = 0.0;
  std::vector<Vec3> left(materials.size());
  for (std::size_t k = 0; k < materials.size(); ++k) {
    left[k] = left_by(materials[k], seen, lobes[k] * strength_of(materials[k], frame));
    const double off2 =
        (color_feature(left[k]) - materials[k].color).squaredNorm() + left[k].cwiseMin(0.0).squaredNorm();
    const double near = 1.0 / (off2 + kAlike * kAlike);
    out.shares[k] = materials[k].share * near * near;
    sum += out.shares[k];
  }
  for (std::size_t k = 0; k < materials.size(); ++k) {
    out.shares[k] /= sum;
    out.strength += out.shares[k] * strength_of(materials[k], frame);
    out.albedo += out.shares[k] * left[k].cwiseMax(0.0);
  }
  return out;
}

/// Lobes of every material, at this photograph and pixel.
std::vector<double> lobes_of(const GlossPixel& pixel, std::size_t frame, const std::vector<GlossMaterial>& materials) {
  std::vector<double> lobes;
  for (const GlossMaterial& m : materials)
    lobes.push_back(m.course.is_told ? pixel.lobe(m.course.at[frame].roughness) : 0.0);
  return lobes;
}

Vec3 value_at(const ImageF& image, int x, int y) {
  const auto p = image.pixel(x, y);
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

class GlossFinder {
 public:
  GlossFinder(const GlossRig& rig, const std::vector<double>& times, const std::function<GlossPhoto(int)>& read_photo)
      : rig_(rig), times_(times), read_photo_(read_photo) {
    const int longer = std::max(rig.normal.width(), rig.normal.height());
    tile_px_ = std::max(kMinTilePx, (longer + kTilesAlong - 1) / kTilesAlong);
    columns_ = (rig.normal.width() + tile_px_ - 1) / tile_px_;
    rows_ = (rig.normal.height() + tile_px_ - 1) / tile_px_;
  }

  std::vector<GlossMaterial> find(const RunControl& control) {
    constexpr int kRounds = 3;  // Rounds of classes and lobes (docs/algorithms/gloss.md).
    materials_ = {GlossMaterial{.share = 1.0, .course = {.at = std::vector<LobeAt>(times_.size())}}};
    for (int round = 0; round < kRounds; ++round) {
      const RunControl part = control.part(1.0 * round / kRounds, (round + 1.0) / kRounds);
      if (round > 0) find_colors(part.part(0.0, 0.2));
      fit(part.part(0.2, 1.0));
    }
    std::stable_sort(materials_.begin(), materials_.end(),
                     [](const auto& a, const auto& b) { return a.share > b.share; });
    return materials_;
  }

 private:
  /// Classes of color, where the highlight is weaker than in the other half of the pixels; with the lobes so far.
  void find_colors(const RunControl& control) {
    std::vector<std::pair<double, Vec3>> found;  // Half angle and albedo.
    const std::size_t count = std::min(times_.size(), kColorFrames);
    for (std::size_t k = 0; k < count; ++k) {
      control.throw_if_stopped();
      const int frame = static_cast<int>(count == 1 ? 0 : k * (times_.size() - 1) / (count - 1));
      const GlossPhoto photo = read_photo_(frame);
      const int step = std::max(1, tile_px_ / 4);
      for (int y = step / 2; y < rig_.normal.height(); y += step) {
        for (int x = step / 2; x < rig_.normal.width(); x += step) {
          const GlossPixel pixel = gloss_pixel(rig_, frame, x, y);
          if (!pixel.is_lit || !is_inside(photo.valid, x, y)) continue;
          const auto at = static_cast<std::size_t>(frame);
          const Unlit u = unlit(pixel, value_at(photo.color, x, y), at, materials_, lobes_of(pixel, at, materials_));
          found.emplace_back(pixel.half_angle(), u.albedo);
        }
      }
    }
    if (found.empty()) return;
    const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
    std::nth_element(found.begin(), middle, found.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Vec3> colors;
    for (auto at = middle; at != found.end(); ++at) colors.push_back(color_feature(at->second));
    ColorClusters clusters = color_clusters(colors, kMaxMaterials);
    std::vector<double> shares(clusters.centers.size(), 0.0);
    std::vector<Vec3> albedos(clusters.centers.size(), Vec3::Zero());
    for (std::size_t i = 0; i < colors.size(); ++i) {
      shares[clusters.of[i]] += 1.0 / static_cast<double>(colors.size());
      albedos[clusters.of[i]] += (middle + static_cast<std::ptrdiff_t>(i))->second / static_cast<double>(colors.size());
    }
    const std::vector<GlossMaterial> before = std::move(materials_);
    materials_.clear();
    for (std::size_t k = 0; k < shares.size(); ++k) {
      if (shares[k] < kMinShare) continue;
      // The lobe of the nearest of the materials so far, until its own is fitted.
      const auto nearest = std::min_element(before.begin(), before.end(), [&](const auto& a, const auto& b) {
        return (a.color - clusters.centers[k]).squaredNorm() < (b.color - clusters.centers[k]).squaredNorm();
      });
      materials_.push_back({.color = clusters.centers[k],
                            .albedo = albedos[k] / shares[k],
                            .share = shares[k],
                            .is_metallic = nearest->is_metallic,
                            .course = nearest->course});
    }
  }

  void fit(const RunControl& control) {
    const std::size_t num = materials_.size();
    std::vector<std::vector<TileSamples>> samples(num, std::vector<TileSamples>(times_.size()));
    std::vector<std::vector<double>> counts(times_.size());
    parallel_for(static_cast<std::int64_t>(times_.size()), 1, control.part(0.0, 0.8),
                 [&](std::int64_t begin, std::int64_t) {
                   const auto frame = static_cast<std::size_t>(begin);
                   std::vector<TileSamples> of_frame = tiles_of(static_cast<int>(begin), counts[frame]);
                   for (std::size_t k = 0; k < num; ++k) samples[k][frame] = std::move(of_frame[k]);
                 });
    std::vector<double> shares(num, 0.0);
    for (const std::vector<double>& of_frame : counts)
      for (std::size_t k = 0; k < num; ++k) shares[k] += of_frame[k];
    const double all = std::max(1.0, std::accumulate(shares.begin(), shares.end(), 0.0));
    const RunControl silent = control.silent();
    parallel_for(static_cast<std::int64_t>(num), 1, silent, [&](std::int64_t k, std::int64_t) {
      GlossMaterial& m = materials_[k];
      m.share = shares[k] / all;
      m.course = fit_lobe_course(samples[k], times_, columns_, rig_.is_moving());
      const bool is_tinted = m.course.is_told && (m.course.tint.array() - 1.0).abs().maxCoeff() > kTinted;
      if (!is_tinted) m.course.tint.setOnes();
      double strength = 0.0;
      for (const LobeAt& at : m.course.at) strength += at.strength / static_cast<double>(m.course.at.size());
      m.is_metallic =
          is_tinted || (m.course.is_told && rig_.lights.front().is_intensity_known && strength > kMaxOfMinerals);
    });
    control.report(1.0);
  }

  /// Sum of each material over a tile.
  struct TileSum {
    explicit TileSum(std::size_t num) : value(num, Vec3::Zero()), members(num, 0.0), told(num, 0.0), lobe(num) {
      for (auto& l : lobe) l.setZero();
    }
    std::vector<Vec3> value;            ///< Over what albedo 1 shows.
    std::vector<double> members, told;  ///< Pixels; and those whose lobes are asked.
    std::vector<Eigen::Matrix<double, kNumLobeNodes, 1>> lobe;
    double inside = 0.0, unknown = 0.0;
  };
  TileSum sum_tile(const GlossPhoto& photo, int frame, int tile) const {
    const std::size_t num = materials_.size();
    const int x0 = tile % columns_ * tile_px_, y0 = tile / columns_ * tile_px_;
    const int every = std::max(1, static_cast<int>(std::lround(tile_px_ / std::sqrt(kLobesOfTile))));
    const auto at = static_cast<std::size_t>(frame);
    TileSum sum(num);
    for (int y = y0; y < std::min(rig_.normal.height(), y0 + tile_px_); ++y) {
      for (int x = x0; x < std::min(rig_.normal.width(), x0 + tile_px_); ++x) {
        const GlossPixel pixel = gloss_pixel(rig_, frame, x, y);
        if (!pixel.is_lit) continue;
        sum.inside += 1.0;
        if (!is_inside(photo.valid, x, y)) {
          sum.unknown += 1.0;
          continue;
        }
        const Vec3 value = value_at(photo.color, x, y);
        std::size_t k = 0;
        if (num > 1) {
          const Unlit u = unlit(pixel, value, at, materials_, lobes_of(pixel, at, materials_));
          k = static_cast<std::size_t>(std::max_element(u.shares.begin(), u.shares.end()) - u.shares.begin());
          if (u.shares[k] < kMember) continue;
        }
        sum.value[k] += value.cwiseQuotient(pixel.matt);
        sum.members[k] += 1.0;
        if ((x - x0) % every != every / 2 || (y - y0) % every != every / 2) continue;
        for (int node = 0; node < kNumLobeNodes; ++node) sum.lobe[k][node] += pixel.lobe(lobe_node_roughness(node));
        sum.told[k] += 1.0;
      }
    }
    return sum;
  }

  /// Tiles of one photograph, for each material. @param counts  Pixels of each.
  std::vector<TileSamples> tiles_of(int frame, std::vector<double>& counts) const {
    const GlossPhoto photo = read_photo_(frame);
    const std::size_t num = materials_.size();
    counts.assign(num, 0.0);
    std::vector<TileSamples> out(num);
    std::vector<std::vector<double>> rows(num);
    for (int tile = 0; tile < columns_ * rows_; ++tile) {
      const TileSum sum = sum_tile(photo, frame, tile);
      if (sum.unknown > kMaxUnknown * sum.inside) continue;
      for (std::size_t k = 0; k < num; ++k) {
        counts[k] += sum.members[k];
        if (!(sum.members[k] > kMinOfTile * tile_px_ * tile_px_) || !(sum.told[k] > 0.0)) continue;
        out[k].tile.push_back(tile);
        for (int c = 0; c < 3; ++c) rows[k].push_back(sum.value[k][c] / sum.members[k]);
        for (int node = 0; node < kNumLobeNodes; ++node)
          rows[k].push_back(std::log(std::max(1e-9, sum.lobe[k][node] / sum.told[k])));
      }
    }
    for (std::size_t k = 0; k < num; ++k) {
      const auto n = static_cast<Eigen::Index>(out[k].tile.size());
      const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3 + kNumLobeNodes, Eigen::RowMajor>> all(
          rows[k].data(), n, 3 + kNumLobeNodes);
      out[k].value = all.leftCols<3>();
      out[k].log_lobe = all.rightCols<kNumLobeNodes>();
    }
    return out;
  }

  const GlossRig& rig_;
  const std::vector<double>& times_;
  const std::function<GlossPhoto(int)>& read_photo_;
  int tile_px_, columns_, rows_;
  std::vector<GlossMaterial> materials_;
};

}  // namespace

bool StandingGloss::is_any_told() const {
  return std::any_of(materials.begin(), materials.end(), [](const GlossMaterial& m) { return m.course.is_told; });
}
bool StandingGloss::is_any_metallic() const {
  return std::any_of(materials.begin(), materials.end(), [](const GlossMaterial& m) { return m.is_metallic; });
}

StandingGloss find_standing_gloss(const GlossRig& rig, const std::vector<double>& times,
                                  const std::function<GlossPhoto(int)>& read_photo, const RunControl& control) {
  StandingGloss gloss;
  const auto [nearest, farthest] = half_angles_deg(rig, static_cast<int>(times.size()));
  gloss.nearest_deg = nearest;
  gloss.farthest_deg = farthest;
  const auto degrees = [](double v) { return short_number_text(std::round(10.0 * v) / 10.0) + " degrees"; };
  if (nearest > farthest) {
    gloss.refusal = "the lamp and the camera face no pixel of the surface";
  } else if (nearest > kNearMirrorDeg) {
    gloss.refusal = "no pixel is nearer than " + degrees(nearest) + " to the mirror's direction of lamp and camera (" +
                    degrees(kNearMirrorDeg) + " or less tell the top of a highlight)";
  } else if (farthest - nearest < kMinSpreadDeg) {
    gloss.refusal = "all pixels lie within " + degrees(farthest - nearest) +
                    " of one another as to the mirror's direction (" + degrees(kMinSpreadDeg) +
                    " or more tell a highlight from the color below it)";
  }
  if (!gloss.refusal.empty()) return gloss;
  gloss.materials = GlossFinder(rig, times, read_photo).find(control);
  return gloss;
}

GlossFrame take_gloss_off(const GlossRig& rig, int frame, const ImageF& color, const StandingGloss& gloss,
                          const RunControl& control) {
  const int width = color.width(), height = color.height();
  GlossFrame out{ImageF(width, height, 3), ImageF(width, height, 3), ImageF(width, height), ImageF(width, height)};
  const auto at = static_cast<std::size_t>(frame);
  parallel_for(height, kRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        const GlossPixel pixel = gloss_pixel(rig, frame, x, y);
        if (!pixel.is_lit) continue;
        const Unlit u = unlit(pixel, value_at(color, x, y), at, gloss.materials, lobes_of(pixel, at, gloss.materials));
        double rough = 0.0, weight = 0.0;
        for (std::size_t k = 0; k < u.shares.size(); ++k) {
          const GlossMaterial& m = gloss.materials[k];
          if (!m.course.is_told) continue;
          const double strength = u.shares[k] * m.course.at[at].strength;
          rough += strength * m.course.at[at].roughness;
          weight += strength;
          if (m.is_metallic) out.metallic.at(x, y) += static_cast<float>(u.shares[k]);
        }
        for (int c = 0; c < 3; ++c) {
          out.albedo.at(x, y, c) = static_cast<float>(u.albedo[c]);
          out.strength.at(x, y, c) = static_cast<float>(u.strength[c]);
        }
        if (weight > 0.0) out.roughness.at(x, y) = static_cast<float>(rough / weight);
      }
    }
  });
  return out;
}

}  // namespace patinate::capture
