#include "tests/support/mold_errors.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "libcommon/metrics/correlation.h"
#include "patinate/core/json.h"
#include "patinate/geometry/rigid_transform.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"

namespace patinate::testing_support {

namespace {

namespace fs = std::filesystem;

Vec3 vector_at(const ImageF& image, std::int64_t i) {
  const float* v = image.data() + 3 * i;
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

RigidTransform transform_of(const Json& rows) {
  Eigen::Matrix4d m;
  for (std::size_t r = 0; r < 4; ++r) {
    for (std::size_t c = 0; c < 4; ++c)
      m(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = rows.at(r).at(c).get<double>();
  }
  return rigid_transform(m);
}

}  // namespace

MoldErrors mold_errors(const fs::path& data, const fs::path& folder) {
  const HistoryReader history(folder);
  const Json truth = load_json(data / "truth/truth.json"), report = load_json(folder / "relit.json");
  const ImageU8 object = read_mask(data / "truth/mask.png"), spot = read_mask(data / "truth/lacquered.png"),
                inside = history.read_mask();
  const ImageF true_normal = read_channels(data / "truth/normal.exr", {"X", "Y", "Z"}),
               position = read_channels(data / "truth/position.exr", {"X", "Y", "Z"});
  std::vector<double> errors, angles;
  double error2 = 0.0, truth2 = 0.0;
  std::int64_t num_object = 0, num_valid = 0;
  std::vector<Vec3> spot_means;
  std::vector<Vec3> sums(static_cast<std::size_t>(object.num_pixels()), Vec3::Zero()), squares = sums;
  std::vector<int> counts(sums.size(), 0);
  MoldErrors out;
  int frame_index = 0;
  for (std::size_t k = 0; k < report.at("steps").size(); ++k) {
    const Json& step = report.at("steps").at(k);
    if (!step.at("in_history").get<bool>()) continue;
    const Json& known = truth.at("steps").at(step.at("step").get<std::size_t>());
    const ImageF found = history.read_frame(frame_index),
                 expected = read_channels(data / "truth" / known.at("albedo").get<std::string>(), {"R", "G", "B"});
    const ImageU8 valid = history.read_frame_mask(frame_index);
    const std::optional<ImageF> normal = history.read_frame_extra(frame_index, "normal");
    const RigidTransform off =
        transform_of(step.at("reference_from_scan")) * transform_of(known.at("reference_from_scan")).inverse();
    Vec3 spot_sum = Vec3::Zero();
    int num_spot = 0;
    for (std::int64_t i = 0; i < object.num_pixels(); ++i) {
      if (object.data()[i] == 0) continue;
      ++num_object;
      if (valid.data()[i] == 0 || inside.data()[i] == 0) continue;
      ++num_valid;
      const Vec3 a = vector_at(found, i), t = vector_at(expected, i);
      error2 += (a - t).squaredNorm();
      truth2 += t.squaredNorm();
      for (int c = 0; c < 3; ++c) errors.push_back(std::abs(a[c] - t[c]) / t[c]);
      if (normal && vector_at(*normal, i).norm() > 0.5) {
        angles.push_back(std::acos(std::clamp(vector_at(*normal, i).dot(vector_at(true_normal, i)), -1.0, 1.0)) *
                         180.0 / std::numbers::pi);
      }
      if (spot.data()[i] == 0) continue;
      out.pose_mm = std::max(out.pose_mm, (off.apply(vector_at(position, i)) - vector_at(position, i)).norm());
      spot_sum += a;
      ++num_spot;
      const std::size_t j = i;
      sums[j] += a;
      squares[j] += a.cwiseProduct(a);
      ++counts[j];
    }
    if (num_spot > 0) spot_means.push_back(spot_sum / num_spot);
    ++frame_index;
  }
  out.albedo_rms = std::sqrt(error2 / truth2);
  out.albedo_median = quantile(errors, 0.5);
  out.albedo_p95 = quantile(errors, 0.95);
  out.albedo_worst = quantile(errors, 1.0);
  out.valid_share = static_cast<double>(num_valid) / static_cast<double>(num_object);
  out.normal_median_deg = quantile(angles, 0.5);
  Vec3 mean = Vec3::Zero();
  for (const Vec3& m : spot_means) mean += m / static_cast<double>(spot_means.size());
  for (const Vec3& m : spot_means)
    out.spot_drift = std::max(out.spot_drift, ((m - mean).cwiseQuotient(mean)).cwiseAbs().maxCoeff());
  std::vector<double> deviations;
  for (std::size_t j = 0; j < sums.size(); ++j) {
    if (counts[j] < 2) continue;
    const Vec3 m = sums[j] / counts[j],
               variance = (squares[j] / counts[j] - m.cwiseProduct(m)).cwiseMax(0.0) * counts[j] / (counts[j] - 1.0);
    deviations.push_back(variance.cwiseSqrt().cwiseQuotient(m).mean());
  }
  out.spot_texel_drift = quantile(deviations, 0.5);
  const ImageF accessibility = history.read_control("accessibility"),
               curvature = read_gray(data / "truth/accessibility.exr");
  std::vector<double> a, b;
  for (std::int64_t i = 0; i < object.num_pixels(); ++i) {
    if (object.data()[i] == 0 || inside.data()[i] == 0) continue;
    a.push_back(static_cast<double>(accessibility.data()[i]));
    b.push_back(static_cast<double>(curvature.data()[i]));
  }
  out.accessibility_correlation = rank_correlation(a, b);
  return out;
}

}  // namespace patinate::testing_support
