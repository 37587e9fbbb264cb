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
constexpr std::array<double, 6> kTails{kNone, 8.0, 4.0, 2.8, 2.0, 1.5};
constexpr std::array<double, 3> kSlants{1.0, 0.5, 0.0};
constexpr std::array<SpecularTint, 2> kTints{SpecularTint::White, SpecularTint::Base};
constexpr std::int64_t kMaxTexels = 1'500, kMaxForetold = 900, kChunk = 64;
constexpr std::array<double, 2> kFreedoms{0.3, 0.03};  ///< Beside what work begins with.
constexpr std::array<double, 3> kOffs{0.02, 0.1, 0.2};
constexpr std::size_t kAttempts =
    kTints.size() + (kTails.size() + 1) * kSlants.size() + kFreedoms.size() + kOffs.size();

struct Highlights {
  SpecularForm form = {};
  double freedom = 0.0, off = 0.0;
};

/// A surface of few texels on which forms are tried.
class FormTrial {
 public:
  FormTrial(const UnlightWork& whole, int step, const RunControl& control)
      : input_(thinned_input(whole.input, step)), work_(input_, whole, step), matt_(empty_result(work_)) {
    options_ = whole.options;
    fit_surface(work_, matt_, control);
    texels_ = work_.spread_texels(kMaxForetold);
  }

  /// Of each texel, what it costs to foretell its lamps; negative where nothing is foretold.
  [[nodiscard]] std::vector<double> costs(const Highlights& kind, const RunControl& control) {
    constexpr int kPasses = 3;
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
    return left_out_costs(control.part(0.6, 1.0));
  }
  /// Whether any form showed a highlight anywhere.
  [[nodiscard]] bool has_found() const { return has_found_; }

 private:
  [[nodiscard]] std::vector<double> left_out_costs(const RunControl& control) const {
    const TexelFitOptions options = work_.fit_options();
    std::vector<double> costs(texels_.size(), -1.0);
    parallel_for(static_cast<std::int64_t>(texels_.size()), kChunk, control, [&](std::int64_t begin, std::int64_t end) {
      TexelSamples texel, plain;
      for (std::int64_t i = begin; i < end; ++i) {
        const std::int64_t at = texels_[static_cast<std::size_t>(i)];
        const int x = static_cast<int>(at % work_.width), y = static_cast<int>(at / work_.width);
        work_.load(x, y, texel);
        work_.load_raw(x, y, plain);
        costs[static_cast<std::size_t>(i)] = left_out_cost(texel, plain.variance, options, x + y);
      }
    });
    return costs;
  }

  UnlightInput input_;
  UnlightOptions options_;
  UnlightWork work_;
  UnlightResult matt_;  ///< Without highlights.
  std::vector<std::int64_t> texels_;
  bool has_found_ = false;
};

/// Sum of the differences of costs of texels that both foretell.
double excess(const std::vector<double>& other, const std::vector<double>& costs) {
  double sum = 0.0;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (costs[i] >= 0.0 && other[i] >= 0.0) sum += other[i] - costs[i];
  }
  return sum;
}

}  // namespace

void choose_specular_form(UnlightWork& work, const RunControl& control) {
  const auto num_texels =
      static_cast<std::int64_t>(work.spread_texels(std::numeric_limits<std::int64_t>::max() / 2).size());
  const int step = std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(num_texels) / kMaxTexels))));
  FormTrial trial(work, step, control.part(0.0, 0.05));
  std::vector<double> least;
  Highlights best{.freedom = work.highlight_freedom, .off = work.highlight_off};
  double done = 0.0;
  const auto attempt = [&](const Highlights& kind) {
    constexpr double kFrom = 0.05, kEach = (1.0 - kFrom) / kAttempts;
    std::vector<double> costs = trial.costs(kind, control.part(kFrom + kEach * done, kFrom + kEach * (done + 1.0)));
    done += 1.0;
    if (!least.empty() && !(excess(costs, least) < 0.0)) return;
    least = std::move(costs);
    best = kind;
  };
  const auto attempt_form = [&](const SpecularForm& form) {
    attempt({.form = form, .freedom = best.freedom, .off = best.off});
  };
  for (const SpecularTint tint : kTints) {
    if (tint == SpecularTint::White || work.num_channels == 3) attempt_form({.tail = 4.0, .slant = 0.5, .tint = tint});
  }
  if (!trial.has_found()) return;
  const SpecularTint tint = best.form.tint;
  for (const double slant : kSlants) {
    for (const double tail : kTails) attempt_form({.tail = tail, .slant = slant, .tint = tint});
  }
  const double tail = best.form.tail;
  for (const double slant : kSlants)
    attempt_form({.tail = tail, .slant = slant, .is_about_mirror = true, .tint = tint});
  const Highlights formed = best;
  for (const double freedom : kFreedoms) attempt({.form = formed.form, .freedom = freedom, .off = formed.off});
  const Highlights free = best;
  for (const double off : kOffs) attempt({.form = free.form, .freedom = free.freedom, .off = off});
  work.form = best.form;
  work.highlight_freedom = best.freedom;
  work.highlight_off = best.off;
}

}  // namespace patinate::capture
