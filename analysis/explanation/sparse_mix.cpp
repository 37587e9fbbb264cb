#include "analysis/explanation/sparse_mix.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "libcommon/core/random.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::analysis {

namespace {

constexpr std::uint32_t kPartPurpose = 0x3a27;  ///< Keeps these draws apart from other uses of the seed.
constexpr double kMinGain = 0.005;              ///< Share of the variance: less than that is of no use to anyone.
constexpr double kMinOwn = 1e-6;  ///< Share of a candidate's variance, what others must leave of it to take part.

}  // namespace

/// Sums of some samples that least squares needs.
struct MixProblem::Sums {
  double count = 0.0, y = 0.0, yy = 0.0;
  std::vector<double> v, vy, vv;

  void add(const Sums& other, double sign) {
    count += sign * other.count, y += sign * other.y, yy += sign * other.yy;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += sign * other.v[i], vy[i] += sign * other.vy[i];
    for (std::size_t i = 0; i < vv.size(); ++i) vv[i] += sign * other.vv[i];
  }
  [[nodiscard]] double covariance(std::size_t i, std::size_t j) const {
    return vv[i * v.size() + j] - v[i] * v[j] / count;
  }
  [[nodiscard]] double covariance_with_y(std::size_t i) const { return vy[i] - v[i] * y / count; }
};

/// y is about constant + the sum of slope * value.
struct MixProblem::Fit {
  std::vector<std::size_t> members;
  std::vector<double> slopes;
  double constant = 0.0;
  double explained = 0.0;  ///< Sum of squares.
};

MixProblem::MixProblem(std::vector<std::vector<double>> values, const SurfaceBlocks& blocks, std::uint64_t seed)
    : values_(std::move(values)) {
  std::vector<std::size_t> order(blocks.members.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  RandomStream random(seed, 0, kPartPurpose);
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  const std::size_t k = values_.size(), n = k == 0 ? 0 : values_.front().size();
  part_of_.resize(n);
  for (std::size_t b = 0; b < order.size(); ++b) {
    for (const std::uint32_t i : blocks.members[order[b]]) part_of_[i] = static_cast<std::uint8_t>(b % kMixFolds);
  }
  outer_.assign(kMixFolds, std::vector<double>(k * k));
  sum_.assign(kMixFolds, std::vector<double>(k));
  count_.assign(kMixFolds, 0.0);
  for (std::size_t s = 0; s < n; ++s) {
    const std::size_t p = part_of_[s];
    count_[p] += 1.0;
    for (std::size_t i = 0; i < k; ++i) {
      sum_[p][i] += values_[i][s];
      for (std::size_t j = 0; j < k; ++j) outer_[p][i * k + j] += values_[i][s] * values_[j][s];
    }
  }
}

std::vector<MixProblem::Sums> MixProblem::part_sums(std::span<const double> ranks) const {
  std::vector<Sums> parts(kMixFolds);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    parts[p] = {.count = count_[p], .v = sum_[p], .vy = std::vector<double>(values_.size()), .vv = outer_[p]};
  }
  for (std::size_t s = 0; s < ranks.size(); ++s)
    parts[part_of_[s]].y += ranks[s], parts[part_of_[s]].yy += ranks[s] * ranks[s];
  for (std::size_t i = 0; i < values_.size(); ++i) {
    for (std::size_t s = 0; s < ranks.size(); ++s) parts[part_of_[s]].vy[i] += values_[i][s] * ranks[s];
  }
  return parts;
}

MixProblem::Fit MixProblem::grown(const Sums& sums, const Fit& from) const {
  Fit best = from;
  for (std::size_t c = 0; c < values_.size(); ++c) {
    if (std::find(from.members.begin(), from.members.end(), c) != from.members.end()) continue;
    std::vector<std::size_t> members = from.members;
    members.push_back(c);
    const auto m = static_cast<Eigen::Index>(members.size());
    Eigen::MatrixXd a(m, m);
    Eigen::VectorXd b(m);
    for (Eigen::Index i = 0; i < m; ++i) {
      b(i) = sums.covariance_with_y(members[i]);
      for (Eigen::Index j = 0; j < m; ++j) a(i, j) = sums.covariance(members[i], members[j]);
    }
    const LdltFactors solver(a);
    if (!(solver.least_pivot() > kMinOwn * a.diagonal().maxCoeff())) continue;
    const Eigen::VectorXd x = solver.solve(b);
    if (!(x.dot(b) > best.explained)) continue;
    // A slope against its own relation would only correct the others.
    if (!((x.array() * b.array()) > 0.0).all()) continue;
    best.explained = x.dot(b);
    best.members = members;
    best.slopes.assign(x.data(), x.data() + m);
  }
  best.constant = sums.y / sums.count;
  for (std::size_t i = 0; i < best.members.size(); ++i)
    best.constant -= best.slopes[i] * sums.v[best.members[i]] / sums.count;
  return best;
}

double MixProblem::error_of(const Sums& part, const Fit& fit) {
  const std::size_t k = part.v.size();
  double error = part.yy - 2.0 * fit.constant * part.y + fit.constant * fit.constant * part.count;
  for (std::size_t i = 0; i < fit.members.size(); ++i) {
    const std::size_t a = fit.members[i];
    error += 2.0 * fit.slopes[i] * (fit.constant * part.v[a] - part.vy[a]);
    for (std::size_t j = 0; j < fit.members.size(); ++j)
      error += fit.slopes[i] * fit.slopes[j] * part.vv[a * k + fit.members[j]];
  }
  return error;
}

namespace {

/// Whether the gains of the parts are worth a further member. @param variance  Of all parts together, a sum of squares.
bool is_worth_it(std::span<const double> gains, double variance) {
  const auto n = static_cast<double>(gains.size());
  const double sum = std::accumulate(gains.begin(), gains.end(), 0.0);
  double squares = 0.0;
  for (const double g : gains) squares += (g - sum / n) * (g - sum / n);
  const double error_of_sum = std::sqrt(squares / (n - 1.0) * n);
  return sum > kMinGain * variance && sum > error_of_sum;
}

}  // namespace

MixProblem::Found MixProblem::find(std::span<const double> ranks, int most) const {
  const std::vector<Sums> parts = part_sums(ranks);
  Sums all = parts.front();
  for (std::size_t p = 1; p < parts.size(); ++p) all.add(parts[p], 1.0);
  const double variance = all.yy - all.y * all.y / all.count;
  std::vector<Fit> fits(parts.size());  // Fits of what is left without each part.
  std::vector<double> errors(parts.size());
  Fit whole;
  for (int size = 1; size <= most; ++size) {
    const Fit larger = grown(all, whole);
    std::vector<Fit> grown_fits;
    std::vector<double> gains, grown_errors;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      Sums others = all;
      others.add(parts[p], -1.0);
      grown_fits.push_back(grown(others, fits[p]));
      grown_errors.push_back(error_of(parts[p], grown_fits.back()));
      gains.push_back(errors[p] - grown_errors.back());
    }
    if (larger.members.size() == whole.members.size()) break;
    if (size > 1 && !is_worth_it(gains, variance)) break;
    whole = larger, fits = std::move(grown_fits), errors = std::move(grown_errors);
  }
  Found found{.mix = {},
              .explained = 1.0 - std::accumulate(errors.begin(), errors.end(), 0.0) / variance,
              .predicted = std::vector<double>(ranks.size())};
  for (std::size_t s = 0; s < ranks.size(); ++s) {
    const Fit& fit = fits[part_of_[s]];
    found.predicted[s] = fit.constant;
    for (std::size_t i = 0; i < fit.members.size(); ++i)
      found.predicted[s] += fit.slopes[i] * values_[fit.members[i]][s];
  }
  double total = 0.0;
  for (const double slope : whole.slopes) total += std::abs(slope);
  for (std::size_t i = 0; i < whole.members.size(); ++i)
    found.mix.push_back({whole.members[i], whole.slopes[i] < 0.0, std::abs(whole.slopes[i]) / total});
  std::stable_sort(found.mix.begin(), found.mix.end(),
                   [](const MixMember& a, const MixMember& b) { return a.weight > b.weight; });
  return found;
}

Mix weighted_mix(const Mix& chosen, const std::vector<std::vector<double>>& values, std::span<const double> ranks) {
  const auto m = static_cast<Eigen::Index>(chosen.size());
  const auto n = static_cast<double>(ranks.size());
  const double mean_rank = std::accumulate(ranks.begin(), ranks.end(), 0.0) / n;
  Eigen::MatrixXd centered(static_cast<Eigen::Index>(ranks.size()), m);
  Eigen::VectorXd target(static_cast<Eigen::Index>(ranks.size()));
  for (Eigen::Index s = 0; s < target.size(); ++s) target(s) = ranks[s] - mean_rank;
  for (Eigen::Index i = 0; i < m; ++i) {
    const MixMember& member = chosen[i];
    const std::vector<double>& own = values[member.candidate];
    const double mean = std::accumulate(own.begin(), own.end(), 0.0) / n, sign = member.is_inverse ? -1.0 : 1.0;
    for (Eigen::Index s = 0; s < target.size(); ++s) centered(s, i) = sign * (own[s] - mean);
  }
  Eigen::VectorXd weights =
      solve_ldlt(Eigen::MatrixXd(centered.transpose() * centered), Eigen::VectorXd(centered.transpose() * target));
  if (!(weights.array() > 0.0).all()) {  // Their ranks agree, their values do not: as strong as among ranks.
    for (Eigen::Index i = 0; i < m; ++i) weights(i) = chosen[i].weight / centered.col(i).norm();
  }
  weights /= weights.sum();
  Mix mix = chosen;
  for (Eigen::Index i = 0; i < m; ++i) mix[i].weight = weights(i);
  std::stable_sort(mix.begin(), mix.end(), [](const MixMember& a, const MixMember& b) { return a.weight > b.weight; });
  double rest = 1.0;  // Hundredths: the largest takes what rounding leaves.
  for (std::size_t i = mix.size(); i-- > 1;) {
    mix[i].weight = std::max(0.01, std::round(100.0 * mix[i].weight) / 100.0);
    rest -= mix[i].weight;
  }
  mix.front().weight = std::round(100.0 * rest) / 100.0;
  return mix;
}

std::string mix_expression(const Mix& mix, std::span<const std::string> names) {
  const auto is_plain = [](const std::string& name) {
    return std::all_of(name.begin(), name.end(), [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; });
  };
  std::string text;
  for (const MixMember& member : mix) {
    const std::string& name = names[member.candidate];
    if (!text.empty()) text += " + ";
    if (mix.size() > 1) text += number_text(member.weight) + "*";
    text += (member.is_inverse ? "!" : "") + (is_plain(name) ? name : "(" + name + ")");
  }
  return text;
}

}  // namespace patinate::analysis
