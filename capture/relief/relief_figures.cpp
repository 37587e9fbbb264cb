#include "capture/relief/relief_figures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace patinate::capture {

namespace {

/// Sums towards a volume and its variance.
class VolumeSum {
 public:
  explicit VolumeSum(const ChangeModel& model) : model_(model) {}

  void add(const ReliefPlace& place, const PlaceDifference& d) {
    volume_ += place.area * d.change;
    area_ += place.area;
    noise_ += place.area * place.area * model_.noise_factor * model_.noise_factor * d.variance;
    row_ += place.area * raising_row(place.position - model_.center, place.normal);
    blocks_[{place.x / model_.systematic_block, place.y / model_.systematic_block}] += place.area;
  }
  [[nodiscard]] VolumeChange volume() const {
    double systematic = 0.0;
    for (const auto& [name, area] : blocks_) systematic += area * area;
    const double variance = noise_ * std::max(1.0, model_.window_pixels) + row_.dot(model_.pose_covariance * row_) +
                            systematic * model_.systematic_mm * model_.systematic_mm;
    return {volume_, std::sqrt(variance), area_};
  }

 private:
  const ChangeModel& model_;
  double volume_ = 0.0, area_ = 0.0, noise_ = 0.0;
  Vec6 row_ = Vec6::Zero();
  std::map<std::pair<int, int>, double> blocks_;
};

double two_sided_p(double z) { return std::erfc(std::abs(z) / std::sqrt(2.0)); }

}  // namespace

double significant_p(std::vector<double> p, double false_share) {
  std::sort(p.begin(), p.end());
  for (std::size_t k = p.size(); k > 0; --k) {
    if (p[k - 1] <= false_share * static_cast<double>(k) / static_cast<double>(p.size())) return p[k - 1];
  }
  return 0.0;
}

void fill_change(ReliefChange& change, const ReliefView& view, const std::vector<ReliefPlace>& places,
                 const std::vector<PlaceDifference>& differences, const ChangeModel& model, double false_share) {
  change.change_mm = ImageF(view.width, view.height);
  change.stddev_mm = ImageF(view.width, view.height);
  change.measured = ImageU8(view.width, view.height);
  change.changed = ImageU8(view.width, view.height);
  std::vector<double> p(places.size(), 1.0), of_measured;
  double of_pose = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PlaceDifference& d = differences[i];
    if (!d.is_measured) continue;
    const ReliefPlace& place = places[i];
    const Vec6 row = raising_row(place.position - model.center, place.normal);
    const double pose = row.dot(model.pose_covariance * row);
    const double deviation = std::sqrt(model.noise_factor * model.noise_factor * d.variance + pose +
                                       model.systematic_mm * model.systematic_mm);
    change.change_mm.at(place.x, place.y) = static_cast<float>(d.change);
    change.stddev_mm.at(place.x, place.y) = static_cast<float>(deviation);
    change.measured.at(place.x, place.y) = 255;
    p[i] = two_sided_p(d.change / deviation);
    of_measured.push_back(p[i]);
    of_pose += pose;
  }
  const auto num_measured = static_cast<double>(of_measured.size());
  change.measured_share = num_measured / static_cast<double>(std::max<std::size_t>(places.size(), 1));
  change.pose_stddev_mm = std::sqrt(of_pose / std::max(1.0, num_measured));
  const double most = significant_p(std::move(of_measured), false_share);
  VolumeSum net(model), gained(model), lost(model);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!differences[i].is_measured) continue;
    net.add(places[i], differences[i]);
    if (!(p[i] <= most) || differences[i].change == 0.0) continue;
    change.changed.at(places[i].x, places[i].y) = 255;
    (differences[i].change > 0.0 ? gained : lost).add(places[i], differences[i]);
  }
  change.net = net.volume(), change.gained = gained.volume(), change.lost = lost.volume();
  change.changed_share =
      change.net.area_mm2 > 0.0 ? (change.gained.area_mm2 + change.lost.area_mm2) / change.net.area_mm2 : 0.0;
}

}  // namespace patinate::capture
