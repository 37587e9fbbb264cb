#include "capture/unlighting/specular_form_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "capture/unlighting/specular_choice.h"
#include "capture/unlighting/specular_fit.h"
#include "libcommon/core/parallel.h"

namespace patinate::capture {

namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
/// Exponents of the tails (docs/algorithms/unlighting.md).
constexpr std::array<double, 6> kTails{kNone, 8.0, 4.0, 2.8, 2.0, 1.5};
constexpr std::array<double, 3> kSlants{1.0, 0.5, 0.0};  ///< Slants that are tried, 1 first.
constexpr std::array<SpecularTint, 2> kTints{SpecularTint::White, SpecularTint::Base};
/// Texels that are fitted (docs/algorithms/unlighting.md) and that are predicted.
constexpr std::int64_t kMaxFormTexels = 1'500, kMaxForetold = 900, kFormTexelsAChunk = 64;
constexpr std::array<double, 2> kFreedoms{0.3, 0.03};  ///< Beside what work begins with.
/// Deviation of the highlight from the form (docs/algorithms/unlighting.md).
constexpr std::array<double, 3> kOffs{0.02, 0.1, 0.2};
constexpr std::size_t kAttempts =
    kTints.size() + (kTails.size() + 1) * kSlants.size() + kFreedoms.size() + kOffs.size();

struct Highlights {
  SpecularForm form = {};
  double freedom = 0.0, off = 0.0;
};

/// How well one form of highlights predicts the lamps.
struct Tried {
  Highlights kind;
  /// State of a texel.
  struct Texel {
    double cost = -1.0;                       ///< Cost of predicting its lamps; negative where nothing is predicted.
    std::array<double, 3> albedo{}, share{};  ///< Values of highlight_share().
  };
  std::vector<Texel> texels = {};
};

/// A surface of few texels on which forms are tried.
class FormTrial {
 public:
  FormTrial(const UnlightWork& whole, int step, const RunControl& control)
      : input_(thinned_input(whole.input, step)), work_(input_, whole, step), matt_(empty_result(work_)) {
    fit_surface(work_, matt_, control);
    texels_ = work_.spread_texels(kMaxForetold);
  }

  [[nodiscard]] Tried attempt(const Highlights& kind, const RunControl& control) {
    constexpr int kPasses = 3;  // Passes of highlights and surface.
    work_.form = kind.form;
    work_.highlight_freedom = kind.freedom;
    work_.highlight_off = kind.off;
    work_.specular = ImageF();
    work_.highlight_normal = matt_.normal;
    work_.highlight_base = matt_.albedo;
    UnlightResult fitted = matt_;
    fitted.specular = ImageF(work_.width, work_.height, 2);
    for (int pass = 0; pass < kPasses; ++pass) {
      const RunControl part = control.part(0.2 * pass, 0.2 * (pass + 1));
      fit_highlights(work_, fitted, part.part(0.0, 0.5));
      if (pass + 1 < kPasses) fit_surface(work_, fitted, part.part(0.5, 1.0));
    }
    const auto values = work_.specular.values();
    has_found_ = has_found_ || std::any_of(values.begin(), values.end(), [](float v) { return v > 0.0f; });
    return {kind, foretold(control.part(0.6, 1.0))};
  }
  /// Whether any form showed a highlight anywhere.
  [[nodiscard]] bool has_found() const { return has_found_; }

 private:
  [[nodiscard]] std::vector<Tried::Texel> foretold(const RunControl& control) const {
    const TexelFitOptions options = work_.fit_options();
    std::vector<Tried::Texel> found(texels_.size());
    parallel_for(static_cast<std::int64_t>(texels_.size()), kFormTexelsAChunk, control,
                 [&](std::int64_t begin, std::int64_t end) {
                   TexelSamples texel, plain;
                   for (std::int64_t i = begin; i < end; ++i) {
                     Tried::Texel& here = found[i];
                     const std::int64_t at = texels_[i];
                     const int x = static_cast<int>(at % work_.width), y = static_cast<int>(at / work_.width);
                     work_.load(x, y, texel);
                     work_.load_raw(x, y, plain);
                     here.cost = left_out_cost(texel, plain.variance, options, x + y);
                     const TexelFit fit = fit_texel(texel, options);
                     here.albedo = fit.albedo;
                     for (int c = 0; c < work_.num_channels; ++c) here.share[c] = highlight_share(texel, fit, c);
                   }
                 });
    return found;
  }

  UnlightInput input_;
  UnlightWork work_;
  UnlightResult matt_;  ///< Without highlights.
  std::vector<std::int64_t> texels_;
  bool has_found_ = false;
};

/// Excess cost of one over another, over the texels that both predict.
struct Excess {
  double sum = 0.0, stddev = 0.0;
};
Excess excess_of(const Tried& one, const Tried& other) {
  Excess excess;
  for (std::size_t i = 0; i < one.texels.size(); ++i) {
    const double a = one.texels[i].cost, b = other.texels[i].cost;
    if (a < 0.0 || b < 0.0) continue;
    excess.sum += a - b;
    excess.stddev += (a - b) * (a - b);
  }
  excess.stddev = std::sqrt(excess.stddev);
  return excess;
}

/// By which share of the highlights the albedos of two forms differ; squared.
double difference2(const Tried& one, const Tried& other) {
  double difference = 0.0, highlight = 0.0;
  for (std::size_t i = 0; i < one.texels.size(); ++i) {
    const Tried::Texel &a = one.texels[i], &b = other.texels[i];
    if (a.cost < 0.0 || b.cost < 0.0) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      if (!(a.albedo[c] > 0.0)) continue;
      difference += std::pow(b.albedo[c] / a.albedo[c] - 1.0, 2);
      highlight += a.share[c] * a.share[c];
    }
  }
  return highlight > 0.0 ? difference / highlight : 0.0;
}

/// The standard deviation over forms that foretell nearly as well, weighted by how likely the differences are chance.
double deviation_of(const Tried& best, const std::vector<Tried>& tried) {
  double sum = 0.0, weights = 0.0;
  for (const Tried& other : tried) {
    const Excess excess = excess_of(other, best);
    const double z = excess.stddev > 0.0 ? std::max(0.0, excess.sum / excess.stddev) : 0.0,
                 weight = std::exp(-0.5 * z * z);
    sum += weight * difference2(best, other);
    weights += weight;
  }
  return weights > 0.0 ? std::sqrt(sum / weights) : 0.0;
}

}  // namespace

void choose_specular_form(UnlightWork& work, const RunControl& control) {
  const auto num_texels =
      static_cast<std::int64_t>(work.spread_texels(std::numeric_limits<std::int64_t>::max() / 2).size());
  const int step =
      std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(num_texels) / kMaxFormTexels))));
  FormTrial trial(work, step, control.part(0.0, 0.05));
  Tried best{.kind = {.freedom = work.highlight_freedom, .off = work.highlight_off}};
  std::vector<Tried> tried;
  double done = 0.0;
  const auto attempt = [&](const Highlights& kind) {
    constexpr double kFrom = 0.05, kEach = (1.0 - kFrom) / kAttempts;
    tried.push_back(trial.attempt(kind, control.part(kFrom + kEach * done, kFrom + kEach * (done + 1.0))));
    done += 1.0;
    if (best.texels.empty() || excess_of(tried.back(), best).sum < 0.0) best = tried.back();
  };
  const auto attempt_form = [&](const SpecularForm& form) {
    attempt({.form = form, .freedom = best.kind.freedom, .off = best.kind.off});
  };
  for (const SpecularTint tint : kTints) {
    if (tint == SpecularTint::White || work.num_channels == 3) attempt_form({.tail = 4.0, .slant = 0.5, .tint = tint});
  }
  if (!trial.has_found()) return;
  const SpecularTint tint = best.kind.form.tint;
  for (const double slant : kSlants) {
    for (const double tail : kTails) attempt_form({.tail = tail, .slant = slant, .tint = tint});
  }
  const double tail = best.kind.form.tail;
  for (const double slant : kSlants)
    attempt_form({.tail = tail, .slant = slant, .is_about_mirror = true, .tint = tint});
  work.form_deviation = deviation_of(best, tried);
  const Highlights formed = best.kind;
  for (const double freedom : kFreedoms) attempt({.form = formed.form, .freedom = freedom, .off = formed.off});
  const Highlights free = best.kind;
  for (const double off : kOffs) attempt({.form = free.form, .freedom = free.freedom, .off = off});
  work.form = best.kind.form;
  work.highlight_freedom = best.kind.freedom;
  work.highlight_off = best.kind.off;
}

}  // namespace patinate::capture
