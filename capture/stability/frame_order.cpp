#include "capture/stability/frame_order.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numeric>

#include "libcommon/core/median.h"
#include "libcommon/metrics/correlation.h"

namespace patinate::capture {

namespace {

constexpr float kDarkLook = 0.02f;                        ///< Linear; below, ratios are those of noise and stray light.
constexpr double kFileUnit = 1e-4;                        ///< Unit of looks in files.
constexpr std::size_t kMinLooks = 6, kMaxCompared = 256;  ///< See docs/algorithms/stability.md.

/// Differences between all pairs.
class Differences {
 public:
  Differences(const std::vector<FrameLook>& looks, const RunControl& control)
      : n_(looks.size()), values_(n_ * n_, 0.0) {
    for (std::size_t i = 0; i < n_; ++i) {
      control.throw_if_stopped();
      for (std::size_t j = 0; j < i; ++j)
        values_[i * n_ + j] = values_[j * n_ + i] = look_difference(looks[i], looks[j]);
    }
  }
  [[nodiscard]] std::size_t size() const { return n_; }
  [[nodiscard]] double at(int i, int j) const {
    return values_[static_cast<std::size_t>(i) * n_ + static_cast<std::size_t>(j)];
  }
  [[nodiscard]] double length(const std::vector<int>& order) const {
    double sum = 0.0;
    for (std::size_t k = 1; k < order.size(); ++k) sum += at(order[k - 1], order[k]);
    return sum;
  }
  [[nodiscard]] double agreement(const std::vector<int>& order) const {
    std::vector<double> apart, different;
    for (std::size_t i = 0; i < order.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        apart.push_back(static_cast<double>(i - j));
        different.push_back(at(order[i], order[j]));
      }
    }
    return rank_correlation(apart, different);
  }

 private:
  std::size_t n_;
  std::vector<double> values_;
};

/// From the photograph that is farthest from all others, always to the nearest that is left.
std::vector<int> nearest_followers(const Differences& d) {
  const int n = static_cast<int>(d.size());
  std::vector<int> left(d.size());
  std::iota(left.begin(), left.end(), 0);
  const auto far = [&](int i) {
    double sum = 0.0;
    for (int j = 0; j < n; ++j) sum += d.at(i, j);
    return sum;
  };
  auto next = std::max_element(left.begin(), left.end(), [&](int a, int b) { return far(a) < far(b); });
  std::vector<int> order;
  while (true) {
    order.push_back(*next);
    left.erase(next);
    if (left.empty()) return order;
    next = std::min_element(left.begin(), left.end(),
                            [&](int a, int b) { return d.at(order.back(), a) < d.at(order.back(), b); });
  }
}

/// Turns pieces around as long as that makes the way shorter.
void shorten(const Differences& d, std::vector<int>& order, const RunControl& control) {
  constexpr int kMaxSweeps = 50;  // Sweeps of 2-opt; it ends earlier where nothing gets shorter.
  const std::size_t n = order.size();
  bool is_shorter = true;
  for (int sweep = 0; is_shorter && sweep < kMaxSweeps; ++sweep) {
    control.throw_if_stopped();
    is_shorter = false;
    for (std::size_t i = 0; i + 1 < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        double change = 0.0;
        if (i > 0) change += d.at(order[i - 1], order[j]) - d.at(order[i - 1], order[i]);
        if (j + 1 < n) change += d.at(order[i], order[j + 1]) - d.at(order[j], order[j + 1]);
        if (!(change < -1e-12)) continue;
        std::reverse(order.begin() + static_cast<std::ptrdiff_t>(i),
                     order.begin() + static_cast<std::ptrdiff_t>(j) + 1);
        is_shorter = true;
      }
    }
  }
}

/// Order of photographs that are in their order.
FrameOrder order_of(const std::vector<FrameLook>& looks, const RunControl& control) {
  FrameOrder result;
  std::vector<int> given(looks.size());
  std::iota(given.begin(), given.end(), 0);
  result.best = given;
  if (looks.size() < kMinLooks) return result;
  const Differences differences(looks, control);
  std::vector<int> other = nearest_followers(differences);
  for (std::vector<int>* order : {&result.best, &other}) shorten(differences, *order, control);
  if (differences.length(other) < differences.length(result.best)) result.best = std::move(other);
  double along = 0.0;  // > 0 where later places have later photographs.
  for (std::size_t k = 0; k < result.best.size(); ++k)
    along += (2.0 * static_cast<double>(k) + 1.0 - static_cast<double>(looks.size())) * result.best[k];
  if (along < 0.0) std::reverse(result.best.begin(), result.best.end());
  const double least = differences.length(result.best);
  if (!(least > 0.0)) return result;
  result.detour = differences.length(given) / least;
  result.agreement = differences.agreement(given);
  result.best_agreement = differences.agreement(result.best);
  return result;
}

}  // namespace

FrameLook frame_look(const PreparedFrame& frame) {
  const ImageF& light = frame.light;
  FrameLook look{};
  for (int y = 0; y < kLookSide; ++y) {
    for (int x = 0; x < kLookSide; ++x) {
      const auto first = [](int k, int n) { return k * n / kLookSide; };
      const auto end = [&](int k, int n) { return std::max(first(k, n) + 1, first(k + 1, n)); };  // One pixel at least.
      std::array<double, 3> sum{};
      int count = 0;
      for (int v = first(y, light.height()); v < end(y, light.height()); ++v) {
        for (int u = first(x, light.width()); u < end(x, light.width()); ++u, ++count) {
          for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(light.at(u, v, static_cast<int>(c)));
        }
      }
      for (std::size_t c = 0; c < 3; ++c) look[y * kLookSide + x][c] = static_cast<float>(sum[c] / count);
    }
  }
  return look;
}

double look_difference(const FrameLook& a, const FrameLook& b) {
  double squares = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> ratios;
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (a[k][c] >= kDarkLook && b[k][c] >= kDarkLook)
        ratios.push_back(std::log(static_cast<double>(a[k][c]) / static_cast<double>(b[k][c])));
    }
    if (4 * ratios.size() < a.size()) continue;
    const double gain = median(ratios);
    double sum = 0.0;
    for (const double r : ratios) sum += (r - gain) * (r - gain);
    squares += sum / static_cast<double>(ratios.size());
  }
  return std::sqrt(squares / 3.0);
}

bool FrameOrder::is_disordered() const {
  return detour >= 1.25 && best_agreement >= 0.6 && best_agreement - agreement >= 0.3;
}

Json look_to_json(const FrameLook& look) {
  Json json = Json::array();
  for (const auto& place : look) {
    for (const float v : place) json.push_back(std::llround(static_cast<double>(v) / kFileUnit));
  }
  return json;
}

FrameLook look_from_json(const JsonReader& json) {
  FrameLook look{};
  const std::vector<double> values = json.numbers(3 * look.size());
  for (std::size_t i = 0; i < values.size(); ++i) look[i / 3][i % 3] = static_cast<float>(values[i] * kFileUnit);
  return look;
}

FrameOrder find_order(const std::vector<FrameLook>& looks, const std::vector<int>& odd, const RunControl& control) {
  std::vector<int> belonging, picked;
  for (int i = 0; i < static_cast<int>(looks.size()); ++i) {
    if (!std::binary_search(odd.begin(), odd.end(), i)) belonging.push_back(i);
  }
  const std::size_t num = std::min(kMaxCompared, belonging.size());
  std::vector<FrameLook> seen;
  for (std::size_t k = 0; k < num; ++k) {
    picked.push_back(belonging[k * belonging.size() / num]);
    seen.push_back(looks[picked.back()]);
  }
  FrameOrder order = order_of(seen, control);
  for (int& k : order.best) k = picked[k];
  return order;
}

}  // namespace patinate::capture
