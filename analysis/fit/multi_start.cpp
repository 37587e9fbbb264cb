#include "analysis/fit/multi_start.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libcommon/core/latin_hypercube.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr int kMaxDesignGenerations = 6;  ///< See docs/algorithms/fit.md.
constexpr std::uint32_t kDesignPurpose = 0xde5160;
constexpr std::uint32_t kChainPurpose = 1u << 24;  ///< Between the random numbers of one descent and the next.
constexpr double kApart = 0.2;                     ///< Least distance of two starts, root mean square of a coordinate.
constexpr double kSameValley = 0.01;               ///< Share of every coordinate's range: nearer is the same valley.
constexpr double kMinFirstStep = 0.1;              ///< Share of a range.
constexpr int kMaxHalvings = 20;                   ///< Beyond 2^-20 a rank has no weight.

double rms_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

double largest_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

std::vector<std::size_t> order_of(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  return order;
}

}  // namespace

MultiStart::MultiStart(const std::vector<double>& start, double start_value, const MultiStartOptions& options)
    : options_(options), points_{start}, values_{start_value} {
  if (!(options.starts >= 1 && options.starts <= 100))
    throw InvalidInput("search: the number of starts must be in [1, 100]");
  population_ = Evolution(start, options.search).population();
  if (std::isnan(start_value)) throw InvalidInput("search: the start's value is NaN");
  if (options.starts == 1) {
    begin(0, options.search.step);
    return;
  }
  const int generations = std::min(static_cast<int>(start.size()), kMaxDesignGenerations);
  RandomStream random(options.search.seed, options.search.purpose, kDesignPurpose);
  for (std::vector<double>& point :
       spread_latin_hypercube(static_cast<std::size_t>(generations * population_), start.size(), random.next_u32()))
    points_.push_back(std::move(point));
}

std::size_t MultiStart::design_index(int k) const {
  return 1 + static_cast<std::size_t>(generation_) * static_cast<std::size_t>(population_) +
         static_cast<std::size_t>(k);
}

std::vector<double> MultiStart::candidate(int k) const {
  return is_design() ? points_[design_index(k)] : chains_[current_].search.candidate(k);
}

std::size_t MultiStart::origin(int k) const { return is_design() ? design_index(k) : chains_[current_].found.origin; }

double MultiStart::spread() const { return is_design() ? options_.search.step : chains_[current_].search.spread(); }

void MultiStart::begin(std::size_t origin, double step) {
  EvolutionOptions search = options_.search;
  search.step = step;
  search.purpose += static_cast<std::uint32_t>(chains_.size()) * kChainPurpose;
  chains_.push_back({.search = Evolution(points_[origin], search),
                     .found = {.origin = origin, .at = points_[origin], .value = values_[origin]}});
}

void MultiStart::choose_starts() {
  // About as far as the next point of the design.
  const auto n = static_cast<double>(points_.front().size());
  const double between = 0.5 * std::pow(static_cast<double>(points_.size()), -1.0 / n);
  const double step = std::min(options_.search.step, std::max(kMinFirstStep, between));
  const std::size_t most = std::min(static_cast<std::size_t>(options_.starts), 2 * points_.front().size());
  for (const std::size_t i : order_of(values_)) {
    if (chains_.size() == most) break;
    const bool is_near = std::any_of(chains_.begin(), chains_.end(), [&](const Chain& chain) {
      return rms_distance(points_[i], points_[chain.found.origin]) < kApart;
    });
    if (!is_near && (std::isfinite(values_[i]) || chains_.empty())) begin(i, step);
  }
}

void MultiStart::tell(std::span<const double> values) {
  if (values.size() != static_cast<std::size_t>(population_))
    throw InvalidInput("search: found " + std::to_string(values.size()) + " values for " + std::to_string(population_) +
                       " candidates");
  if (is_done_) return;
  if (is_design()) {
    if (std::any_of(values.begin(), values.end(), [](double v) { return std::isnan(v); }))
      throw InvalidInput("search: a value is NaN");
    values_.insert(values_.end(), values.begin(), values.end());
    ++generation_;
    if (values_.size() == points_.size()) {
      choose_starts();
      choose_next();
    }
    return;
  }
  Chain& chain = chains_[current_];
  chain.values.push_back(chain.found.value);
  for (int k = 0; k < population_; ++k) {
    const double value = values[k];
    if (!(value < chain.found.value)) continue;
    chain.found.value = value;
    chain.found.at = chain.search.candidate(k);
  }
  chain.search.tell(values);
  ++chain.found.generations;
  const auto patience = static_cast<std::size_t>(Evolution::patience_of(points_.front().size()));
  if (chain.values.size() > patience)
    chain.found.lately_gained = chain.values[chain.values.size() - patience] - chain.found.value;
  ++generation_;
  chain.found.is_converged = chain.search.is_done();
  for (const Chain& other : chains_) {
    if (other.found.is_converged && !chain.found.is_converged && other.found.value <= chain.found.value &&
        largest_distance(other.found.at, chain.found.at) < kSameValley)
      chain.found.is_given_up = true;
  }
  choose_next();
}

void MultiStart::choose_next() {
  std::vector<double> values;
  for (const Chain& chain : chains_) values.push_back(chain.found.value);
  double least = std::numeric_limits<double>::infinity();
  int rank = 0;
  for (const std::size_t i : order_of(values)) {
    const Descent& found = chains_[i].found;
    if (found.is_converged || found.is_given_up) continue;
    const double weighed = std::ldexp(found.generations, std::min(rank++, kMaxHalvings));
    if (!(weighed < least)) continue;
    least = weighed;
    current_ = i;
  }
  is_done_ = rank == 0;
}

std::vector<MultiStart::Descent> MultiStart::descents() const {
  std::vector<double> values;
  for (const Chain& chain : chains_) values.push_back(chain.found.value);
  std::vector<Descent> out;
  for (const std::size_t i : order_of(values)) out.push_back(chains_[i].found);
  return out;
}

bool MultiStart::is_converged() const {
  const std::vector<Descent> found = descents();
  return !found.empty() && found.front().is_converged && found.front().value <= least_value();
}

double MultiStart::lately_gained() const {
  const std::vector<Descent> found = descents();
  return !found.empty() && found.front().value <= least_value() ? found.front().lately_gained
                                                                : std::numeric_limits<double>::infinity();
}

double MultiStart::least_value() const { return *std::min_element(values_.begin(), values_.end()); }

Minimum minimize(const std::function<double(const std::vector<double>&)>& f, const std::vector<double>& start,
                 int budget, const MultiStartOptions& options) {
  Minimum minimum{.at = start, .value = f(start), .num_evaluations = 1};
  MultiStart search(start, minimum.value, options);
  std::vector<double> values(static_cast<std::size_t>(search.population()));
  while (!search.is_done() && minimum.num_evaluations + search.population() <= budget) {
    for (int k = 0; k < search.population(); ++k) {
      const std::vector<double> x = search.candidate(k);
      const double value = f(x);
      values[k] = value;
      if (!(value < minimum.value)) continue;
      minimum.at = x;
      minimum.value = value;
    }
    minimum.num_evaluations += search.population();
    search.tell(values);
  }
  minimum.is_converged = search.is_converged();
  return minimum;
}

}  // namespace patinate::analysis
