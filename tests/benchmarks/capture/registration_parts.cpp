// Registration on the bunny's range scans in $PATINATE_DATA: every row about it in the goals, next to PCL in the same
// run.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "capture/registration/joint_registration.h"
#include "capture/registration/prepared_scan.h"
#include "capture/registration/reference_methods.h"
#include "libcommon/core/random.h"
#include "libcommon/geometry/nearest_points.h"
#include "tests/benchmarks/capture/bunny.h"
#include "tests/benchmarks/capture/capture_parts.h"
#include "tests/benchmarks/timing.h"

namespace patinate::benchmarks {

namespace {

void times(const Bunny& bunny) {
  const PointCloud &target = bunny.scans[bunny.index("bun000")], &source = bunny.scans[bunny.index("bun045")];
  RunControl one;
  one.num_threads = 1;
  const RigidTransform start = perturbed(bunny.pair, source, 5.0, 3.0, 300);
  const double own = median_of_five(
      [&] { (void)capture::register_pair(target, source, start, {.start = capture::RegistrationStart::Given}, one); });
  const double prepared = median_of_five([&] {
    (void)capture::prepare_scans(std::vector<PointCloud>{target, source}, {}, one);
  });
  std::printf(
      "time, %d and %d points, normals included, one thread: %.3f s, of it %.3f s for surfels and lines of sight\n",
      target.num_points(), source.num_points(), own, prepared);
  for (const capture::RegistrationMethod method :
       {capture::RegistrationMethod::PclPoint, capture::RegistrationMethod::PclPlane,
        capture::RegistrationMethod::PclGicp}) {
    const double pcl =
        seconds([&] { (void)capture::register_pair_with_pcl(target, source, start, {.method = method}, one); }) -
        prepared;
    std::printf("  %s: %.3f s, ratio %.2f\n", std::string(capture::kRegistrationMethodNames[method]).c_str(), pcl,
                own / pcl);
  }
  const double search = seconds([&] { (void)capture::register_pair(target, source, std::nullopt, {}, one); });
  std::printf("  by search: %.2f s\n", search);
}

void halves(const Bunny& bunny) {
  constexpr int kRuns = 40;
  const PointCloud& scan = bunny.scans[bunny.index("bun000")];
  double deg = 0.0, mm = 0.0, bound_deg = 0.0, bound_mm = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random(12, static_cast<std::uint64_t>(run));
    PointCloud target, source;
    target.toward_scanner = source.toward_scanner = scan.toward_scanner;
    for (const Vec3& p : scan.points) (random.uniform() < 0.5 ? target : source).points.push_back(p);
    const RigidTransform off = perturbed({}, source, 5.0, 3.0, static_cast<std::uint64_t>(run));
    const capture::PairRegistration found = capture::register_pair(target, moved(source, off), RigidTransform{});
    const Gap error = gap(found.target_from_source * off, {}, source);
    deg += error.deg * error.deg / kRuns;
    mm += error.mm * error.mm / kRuns;
    bound_deg += found.covariance.topLeftCorner<3, 3>().trace() / kRuns;
    bound_mm += found.covariance.bottomRightCorner<3, 3>().trace() / kRuns;
  }
  std::printf(
      "halves of bun000, 5 deg / 3 mm off, %d runs, rms error: %.4f deg, %.2f um (its own covariance says %.4f, "
      "%.2f)\n",
      kRuns, std::sqrt(deg), 1000.0 * std::sqrt(mm), std::sqrt(bound_deg) / kDegree, 1000.0 * std::sqrt(bound_mm));
}

void overlapping(const Bunny& bunny) {
  const PointCloud &target = bunny.scans[bunny.index("bun000")], &source = bunny.scans[bunny.index("bun045")];
  double deg = 0.0, mm = 0.0, spread_deg = 0.0, spread_mm = 0.0, swap_deg = 0.0, swap_mm = 0.0;
  std::optional<RigidTransform> first;
  for (std::uint64_t k = 0; k < 5; ++k) {
    const RigidTransform start = perturbed(bunny.pair, source, 15.0, 10.0, 100 + k);
    const RigidTransform found = capture::register_pair(target, source, start).target_from_source,
                         back = capture::register_pair(source, target, start.inverse()).target_from_source;
    if (!first) first = found;
    const Gap off = gap(found, bunny.pair, source), spread = gap(found, *first, source),
              swapped = gap(back * found, {}, source);
    deg = std::max(deg, off.deg);
    mm = std::max(mm, off.mm);
    spread_deg = std::max(spread_deg, spread.deg);
    spread_mm = std::max(spread_mm, spread.mm);
    swap_deg = std::max(swap_deg, swapped.deg);
    swap_mm = std::max(swap_mm, swapped.mm);
  }
  std::printf(
      "bun000 from bun045, 5 starts 15 deg / 10 mm off: %.4f deg / %.4f mm from the derived reference; between starts "
      "%.1e / %.1e; swapped and forth %.1e / %.1e\n",
      deg, mm, spread_deg, spread_mm, swap_deg, swap_mm);
  for (const capture::RegistrationMethod method :
       {capture::RegistrationMethod::PclPlane, capture::RegistrationMethod::PclPoint,
        capture::RegistrationMethod::PclGicp}) {
    const Gap off = gap(capture::register_pair_with_pcl(target, source, perturbed(bunny.pair, source, 15.0, 10.0, 100),
                                                        {.method = method})
                            .target_from_source,
                        bunny.pair, source);
    std::printf("  %s: %.4f deg / %.4f mm\n", std::string(capture::kRegistrationMethodNames[method]).c_str(), off.deg,
                off.mm);
  }
}

void units(const Bunny& bunny) {
  const PointCloud &target = bunny.scans[bunny.index("bun000")], &source = bunny.scans[bunny.index("bun045")];
  const RigidTransform plain = capture::register_pair(target, source, bunny.pair).target_from_source;
  double worst = 0.0;
  for (const double unit : {1e-3, 1e3}) {
    PointCloud a = target, b = source;
    scale_cloud(a, unit);
    scale_cloud(b, unit);
    RigidTransform found =
        capture::register_pair(a, b, RigidTransform{bunny.pair.rotation, unit * bunny.pair.translation})
            .target_from_source;
    found.translation /= unit;
    worst = std::max(worst, gap(found, plain, source).mm / bounding_box(source).diagonal());
  }
  const RigidTransform far{Eigen::Matrix3d::Identity(), Vec3(1e6, 1e6, -1e6)};
  const RigidTransform found =
      capture::register_pair(moved(target, far), moved(source, far), far * bunny.pair * far.inverse())
          .target_from_source;
  std::printf("units m, mm, um: %.1e of the size; 10^6 mm off the origin: %.1e\n", worst,
              gap(far.inverse() * found * far, plain, source).mm / bounding_box(source).diagonal());
}

/// Points of the source against the plane at the nearest raw point of the target within 2 mm: median |n . (p - q)|.
double raw_residual(const PointCloud& target, const NearestPoints& tree, const std::vector<Vec3>& normals,
                    const PointCloud& source, const RigidTransform& pose) {
  std::vector<double> residuals;
  for (std::size_t i = 0; i < source.points.size(); i += 4) {
    const Vec3 p = pose.apply(source.points[i]);
    const NearestPoints::Found q = tree.nearest(p);
    const Vec3& n = normals[q.index];
    if (q.distance > 2.0 || n.isZero()) continue;
    residuals.push_back(std::abs(n.dot(p - target.points[q.index])));
  }
  if (residuals.empty()) return 0.0;
  std::nth_element(residuals.begin(), residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2),
                   residuals.end());
  return residuals[residuals.size() / 2];
}

void joint(const Bunny& bunny) {
  std::vector<std::optional<RigidTransform>> initial;
  for (std::size_t k = 0; k < bunny.names.size(); ++k)
    initial.emplace_back(perturbed(bunny.published[k], bunny.scans[k], 10.0, 5.0, 200 + k));
  capture::JointRegistration found;
  const double time = seconds([&] { found = capture::register_jointly(bunny.scans, initial, 0); });
  double deg = 0.0, mm = 0.0, conf_deg = 0.0, conf_mm = 0.0;
  for (std::size_t k = 1; k < bunny.names.size(); ++k) {
    const Gap off =
        gap(found.scans[k].reference_from_scan, bunny.derived[0].inverse() * bunny.derived[k], bunny.scans[k]);
    const Gap conf =
        gap(found.scans[k].reference_from_scan, bunny.published[0].inverse() * bunny.published[k], bunny.scans[k]);
    deg = std::max(deg, off.deg);
    mm = std::max(mm, off.mm);
    conf_deg = std::max(conf_deg, conf.deg);
    conf_mm = std::max(conf_mm, conf.mm);
  }
  std::printf(
      "joint, ten scans from 10 deg / 5 mm off: %.1f s, %zu pairs; at most %.3f deg / %.3f mm from the derived joint "
      "poses, %.3f / %.3f from bun.conf\n",
      time, found.edges.size(), deg, mm, conf_deg, conf_mm);
  std::printf("  loops before the joint solve: median %.3f deg / %.3f mm, largest %.3f / %.3f\n",
              found.median_closure_deg, found.median_closure, found.largest_closure_deg, found.largest_closure);
  std::vector<NearestPoints> trees;
  std::vector<std::vector<Vec3>> normals;
  for (const PointCloud& scan : bunny.scans) {
    trees.emplace_back(scan.points);
    const double spacing = capture::point_spacing(scan.points);
    normals.emplace_back(scan.points.size(), Vec3::Zero());
    for (const capture::Surfel& s : capture::make_surfels(scan.points, {}, 1e-3 * spacing, 2.5 * spacing).surfels)
      normals.back()[s.point] = s.normal;
  }
  std::vector<RigidTransform> own;
  for (const capture::RegisteredScan& s : found.scans) own.push_back(s.reference_from_scan);
  for (const auto& [name, poses] :
       {std::pair<const char*, const std::vector<RigidTransform>*>{"published", &bunny.published},
        {"derived", &bunny.derived},
        {"ours", &own}}) {
    std::vector<double> medians;
    for (const capture::RegistrationEdge& e : found.edges) {
      const auto t = static_cast<std::size_t>(e.target), s = static_cast<std::size_t>(e.source);
      medians.push_back(
          raw_residual(bunny.scans[t], trees[t], normals[t], bunny.scans[s], (*poses)[t].inverse() * (*poses)[s]));
    }
    std::sort(medians.begin(), medians.end());
    std::printf("  median |point to plane| of raw points over the pairs, %s poses: median %.3f, p90 %.3f mm\n", name,
                medians[medians.size() / 2], medians[0.9 * static_cast<double>(medians.size())]);
  }
}

void basin(const Bunny& bunny) {
  const PointCloud &target = bunny.scans[bunny.index("bun000")], &source = bunny.scans[bunny.index("bun045")];
  const std::vector<capture::PreparedScan> scans = capture::prepare_scans(std::vector<PointCloud>{target, source}, {});
  std::printf("basin, 20 starts (20 mm off as well), right / called converged though wrong:");
  for (const double angle : {45.0, 60.0, 90.0, 120.0, 180.0}) {
    int right = 0, wrong = 0;
    for (std::uint64_t k = 0; k < 20; ++k) {
      const capture::PairRegistration found =
          capture::register_pair(scans[0], scans[1], perturbed(bunny.pair, source, angle, 20.0, 1000 + k));
      const bool is_right = gap(found.target_from_source, bunny.pair, source).deg < 0.5;
      right += is_right && found.status == capture::RegistrationStatus::Converged ? 1 : 0;
      wrong += !is_right && found.status == capture::RegistrationStatus::Converged ? 1 : 0;
    }
    std::printf("  %.0f deg %d / %d", angle, right, wrong);
  }
  std::printf("\n");
}

void all_pairs(const Bunny& bunny) {
  const std::vector<capture::PreparedScan> scans = capture::prepare_scans(bunny.scans, {});
  int converged = 0, wrong = 0;
  for (std::size_t i = 0; i < bunny.names.size(); ++i) {
    for (std::size_t j = i + 1; j < bunny.names.size(); ++j) {
      const capture::PairRegistration found = capture::register_pair(scans[i], scans[j], std::nullopt);
      if (found.status != capture::RegistrationStatus::Converged) continue;
      ++converged;
      wrong += gap(found.target_from_source, bunny.derived[i].inverse() * bunny.derived[j], bunny.scans[j]).deg > 1.0
                   ? 1
                   : 0;
    }
  }
  std::printf("all 45 pairs by search alone: %d converged, %d of them wrong\n", converged, wrong);
}

/// @param work  Of the scans, when they are there.
template <class... Work>
void with_bunny(const Work&... work) {
  const std::optional<Bunny> bunny = find_bunny();
  if (bunny) (work(*bunny), ...);
}

}  // namespace

void measure_pair() { with_bunny(times, halves, overlapping, units); }
void measure_joint() { with_bunny(joint); }
void measure_basin() { with_bunny(basin, all_pairs); }

}  // namespace patinate::benchmarks
