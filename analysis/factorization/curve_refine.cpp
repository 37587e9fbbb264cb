#include "analysis/factorization/curve_refine.h"

#include <ceres/ceres.h>

#include <cmath>

#include "analysis/factorization/place_fit.h"
#include "analysis/factorization/temporal_curve.h"
#include "libcommon/core/silent_log.h"

namespace patinate::analysis {

namespace {

constexpr double kBending =
    1.0;  ///< Weight of a second difference of coefficients against one residual of one standard deviation.

/// One channel of one place: parameters (log rate, delay, gain and base of every channel) and the channel's
/// coefficients. Residuals are sign(z) sqrt(rho(z^2)), so that every value has a loss of its own; after them, in the
/// first channel, what is expected of a clock.
class ChannelCost final : public ceres::CostFunction {
 public:
  ChannelCost(const PlaceSeries& places, std::int64_t place, int channel, const TemporalModel& model, double middle,
              double span)
      : times_(places.times),
        values_(places.place(place) + static_cast<std::size_t>(channel) * places.times.size()),
        seen_(places.seen(place)),
        channel_(static_cast<std::size_t>(channel)),
        domain_(model.curve),
        noise_(model.scale(channel_)),
        middle_(middle),
        span_(span) {
    set_num_residuals(static_cast<int>(times_.size()) + 2);
    mutable_parameter_block_sizes()->push_back(2 + 2 * places.num_channels);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(domain_.coefficients[channel_].size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double* place = parameters[0];
    const double* coefficients = parameters[1];
    const double rate = std::exp(place[0]), gain = place[2 + 2 * channel_], base = place[3 + 2 * channel_];
    if (!(rate < 1e3 && rate > 1e-3)) return false;
    const auto place_size = static_cast<std::size_t>(parameter_block_sizes()[0]),
               curve_size = static_cast<std::size_t>(parameter_block_sizes()[1]);
    double* by_place = jacobians != nullptr ? jacobians[0] : nullptr;
    double* by_curve = jacobians != nullptr ? jacobians[1] : nullptr;
    if (by_place != nullptr)
      std::fill(by_place, by_place + place_size * static_cast<std::size_t>(num_residuals()), 0.0);
    if (by_curve != nullptr)
      std::fill(by_curve, by_curve + curve_size * static_cast<std::size_t>(num_residuals()), 0.0);
    constexpr double k2 = PlaceFit::kCauchyScale * PlaceFit::kCauchyScale;
    for (std::size_t t = 0; t < times_.size(); ++t) {
      residuals[t] = 0.0;
      if (seen_ != nullptr && seen_[t] == 0) continue;
      const double along = rate * (times_[t] - middle_);
      const CurveBasis basis = curve_basis(domain_, along + middle_ - place[1]);
      double phi = 0.0, slope = 0.0;
      for (std::size_t i = 0; i < 4; ++i)
        phi += basis.weights[i] * coefficients[basis.first + i],
            slope += basis.slopes[i] * coefficients[basis.first + i];
      const double z = (gain * phi + base - static_cast<double>(values_[t])) / noise_, q = z * z / k2;
      const double f = q > 1e-12 ? std::copysign(std::sqrt(k2 * std::log1p(q)), z) : z;
      const double d = (q > 1e-12 ? z / (f * (1.0 + q)) : 1.0) / noise_;
      residuals[t] = f;
      if (by_place != nullptr) {
        double* row = by_place + t * place_size;
        row[0] = d * gain * slope * along, row[1] = -d * gain * slope, row[2 + 2 * channel_] = d * phi,
        row[3 + 2 * channel_] = d;
      }
      if (by_curve != nullptr) {
        for (std::size_t i = 0; i < 4; ++i) by_curve[t * curve_size + basis.first + i] = d * gain * basis.weights[i];
      }
    }
    const std::size_t n = times_.size();
    const double on = channel_ == 0 ? 1.0 : 0.0;
    residuals[n] = on * place[0] / PlaceFit::kRateWidth,
    residuals[n + 1] = on * place[1] / (PlaceFit::kDelayWidth * span_);
    if (by_place != nullptr)
      by_place[n * place_size] = on / PlaceFit::kRateWidth,
                   by_place[(n + 1) * place_size + 1] = on / (PlaceFit::kDelayWidth * span_);
    return true;
  }

 private:
  const std::vector<double>& times_;
  const float* values_;
  const std::uint8_t* seen_;
  std::size_t channel_;
  TemporalCurve domain_;
  double noise_, middle_, span_;
};

class BendingCost final : public ceres::CostFunction {
 public:
  explicit BendingCost(int size) {
    set_num_residuals(size - 2);
    mutable_parameter_block_sizes()->push_back(size);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const int size = parameter_block_sizes()[0];
    double* rows = jacobians != nullptr ? jacobians[0] : nullptr;
    if (rows != nullptr) std::fill(rows, rows + static_cast<std::ptrdiff_t>(size) * (size - 2), 0.0);
    for (int k = 0; k + 2 < size; ++k) {
      const double* c = parameters[0] + k;
      residuals[k] = kBending * (c[0] - 2.0 * c[1] + c[2]);
      if (rows == nullptr) continue;
      double* row = rows + static_cast<std::ptrdiff_t>(size) * k + k;
      row[0] = kBending, row[1] = -2.0 * kBending, row[2] = kBending;
    }
    return true;
  }
};

/// Progress and canceling between the iterations, of which each takes a second on many places.
class IterationReport final : public ceres::IterationCallback {
 public:
  IterationReport(const RunControl& control, int max_iterations) : control_(control), max_iterations_(max_iterations) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (control_.stop.stop_requested()) return ceres::SOLVER_ABORT;
    control_.report(static_cast<double>(summary.iteration) / (max_iterations_ + 1.0));
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const RunControl& control_;
  int max_iterations_;
};

}  // namespace

void refine_curve(const PlaceSeries& places, TemporalModel& model, std::vector<PlaceFactors>& factors,
                  int max_iterations, const RunControl& control) {
  const int channels = places.num_channels;
  const double middle = 0.5 * (places.times.front() + places.times.back()),
               span = places.times.back() - places.times.front();
  // All parameters in one array: Ceres takes blocks by address, so that sums run in the same order every time.
  const std::size_t place_size = 2 + 2 * static_cast<std::size_t>(channels),
                    curve_size = model.curve.coefficients.front().size();
  std::vector<double> parameters;
  for (const PlaceFactors& f : factors) {
    parameters.push_back(std::log(f.rate)), parameters.push_back(f.offset - (f.rate - 1.0) * middle);
    for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c)
      parameters.push_back(f.gain[c]), parameters.push_back(f.base[c]);
  }
  for (const auto& coefficients : model.curve.coefficients)
    parameters.insert(parameters.end(), coefficients.begin(), coefficients.end());
  double* const curves = parameters.data() + factors.size() * place_size;
  ceres::Problem problem;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t i = 0; i < factors.size(); ++i) {
    double* const place = parameters.data() + i * place_size;
    for (int c = 0; c < channels; ++c)
      problem.AddResidualBlock(new ChannelCost(places, static_cast<std::int64_t>(i), c, model, middle, span), nullptr,
                               place, curves + static_cast<std::size_t>(c) * curve_size);
    ordering->AddElementToGroup(place, 0);
  }
  for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
    problem.AddResidualBlock(new BendingCost(static_cast<int>(curve_size)), nullptr, curves + c * curve_size);
    ordering->AddElementToGroup(curves + c * curve_size, 1);
  }
  const SilentLog silent;
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-7;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  IterationReport report(control, max_iterations);
  options.callbacks.push_back(&report);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  control.throw_if_stopped();
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const double* const place = parameters.data() + i * place_size;
    factors[i].rate = std::exp(place[0]);
    factors[i].offset = (factors[i].rate - 1.0) * middle + place[1];
    for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c)
      factors[i].gain[c] = place[2 + 2 * c], factors[i].base[c] = place[3 + 2 * c];
  }
  for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c)
    model.curve.coefficients[c].assign(curves + c * curve_size, curves + (c + 1) * curve_size);
}

}  // namespace patinate::analysis
