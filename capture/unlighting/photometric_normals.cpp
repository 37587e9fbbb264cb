#include "capture/unlighting/photometric_normals.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

struct Triple {
  std::array<int, 3> lamps;
  Eigen::Matrix3d inverse;  ///< Inverse of the lamps' directions as rows.
};

/// Triples far enough from a plane.
std::vector<Triple> triples_of(const std::vector<Light>& lights) {
  // Up to 12 lamps all triples (220) are used, else as many random ones.
  constexpr int kMaxLamps = 12, kMaxTriples = 220;
  constexpr double kMinVolume = 1e-3;  // Determinant of three directions, below which they lie in a plane.
  const int n = static_cast<int>(lights.size());
  std::vector<Triple> triples;
  const auto add = [&](int a, int b, int c) {
    Eigen::Matrix3d rows;
    rows << lights[a].direction.transpose(), lights[b].direction.transpose(), lights[c].direction.transpose();
    if (std::abs(rows.determinant()) > kMinVolume) triples.push_back({{a, b, c}, rows.inverse()});
  };
  if (n <= kMaxLamps) {
    for (int a = 0; a < n; ++a) {
      for (int b = a + 1; b < n; ++b) {
        for (int c = b + 1; c < n; ++c) add(a, b, c);
      }
    }
    return triples;
  }
  RandomStream random(1, static_cast<std::uint64_t>(n));
  const auto count = static_cast<std::uint32_t>(n);
  for (int i = 0; i < 20 * kMaxTriples && static_cast<int>(triples.size()) < kMaxTriples; ++i) {
    const auto a = static_cast<int>(random.below(count)), b = static_cast<int>(random.below(count)),
               c = static_cast<int>(random.below(count));
    if (a != b && b != c && a != c) add(a, b, c);
  }
  return triples;
}

/// One pixel: brightness over each lamp's strength, negative = does not count.
Vec3 best_vector(const std::vector<double>& values, const std::vector<Light>& lights,
                 const std::vector<Triple>& triples) {
  Vec3 best = Vec3::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (const Triple& triple : triples) {
    const Vec3 v(values[triple.lamps[0]], values[triple.lamps[1]], values[triple.lamps[2]]);
    if (!(v.minCoeff() > 0.0)) continue;
    const Vec3 g = triple.inverse * v;
    double sum = 0.0;
    for (std::size_t k = 0; k < values.size() && sum < least; ++k) {
      if (values[k] >= 0.0) sum += std::sqrt(std::abs(values[k] - std::max(0.0, g.dot(lights[k].direction))));
    }
    if (sum < least) {
      least = sum;
      best = g;
    }
  }
  return best;
}

}  // namespace

ImageF photometric_normals(const std::vector<ImageF>& photos, const std::vector<ImageU8>& valid, const ImageU8& mask,
                           const std::vector<Light>& lights, const RunControl& control) {
  if (photos.empty() || photos.size() != lights.size())
    throw InvalidInput("photometric stereo: one photograph for each light is expected");
  for (const Light& light : lights) {
    if (light.kind != Light::Kind::Directional)
      throw InvalidInput("photometric stereo needs directional lights; near ones need a scan");
  }
  if (lights.size() < 3)
    throw InvalidInput("photometric stereo needs at least 3 lights; there are " + std::to_string(lights.size()));
  const std::vector<Triple> triples = triples_of(lights);
  if (triples.empty()) throw InvalidInput("photometric stereo: the lights lie in one plane; one is needed beside it");
  const int width = photos.front().width(), height = photos.front().height();
  ImageF normals(width, height, 3);
  parallel_for(height, 2, control, [&](std::int64_t begin, std::int64_t end) {
    std::vector<double> values(photos.size());
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        if (!is_inside(mask, x, y)) continue;
        for (std::size_t k = 0; k < photos.size(); ++k) {
          double sum = 0.0;
          for (float v : photos[k].pixel(x, y)) sum += static_cast<double>(v);
          values[k] = !valid.empty() && valid[k].at(x, y) == 0 ? -1.0 : std::max(0.0, sum / lights[k].intensity.sum());
        }
        const Vec3 g = best_vector(values, lights, triples);
        if (!(g.norm() > 0.0)) continue;
        const Vec3 n = g.normalized();
        for (int c = 0; c < 3; ++c) normals.at(x, y, c) = static_cast<float>(n[c]);
      }
    }
  });
  return normals;
}

}  // namespace patinate::capture
