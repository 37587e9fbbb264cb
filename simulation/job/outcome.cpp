#include "simulation/job/outcome.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/median.h"
#include "libcommon/core/text.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"

namespace patinate::simulation {

namespace {

constexpr double kShows = 0.1;        ///< Share of the color.
constexpr double kNoticeable = 2.3;   ///< Delta E 1976, a just noticeable difference [Mahy et al. 1994].
constexpr double kNearlyAll = 0.95;   ///< Share of an object.
constexpr double kMostlyUnmet = 0.5;  ///< Share of an object that is warned of.

double delta_e_at(const ImageF& before, const ImageF& now, std::int64_t pixel) {
  const auto lab = [pixel](const ImageF& image) {
    const float* const p = image.data() + 3 * pixel;
    return lab_from_linear(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
  };
  const auto a = lab(before), b = lab(now);
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/// Texels of one object.
struct Part {
  std::vector<TexelIndex> texels = {};
  std::vector<std::int64_t> pixels = {};  ///< Pixels of the same, in the user's order.
  double area = 0.0;
};

std::vector<Part> parts_of(const Simulation& simulation) {
  const SurfaceAtlas& surface = simulation.atlas().surface();
  std::vector<Part> parts(simulation.scene().objects.size());
  const int side = simulation.scene().resolution;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const TexelIndex t = surface.grid().index(x, y);
      if (!surface.is_covered(t)) continue;
      Part& part = parts[surface.object(surface.triangle(t))];
      part.texels.push_back(t);
      part.pixels.push_back(std::int64_t{y} * side + x);
      part.area += surface.weight(t);
    }
  }
  return parts;
}

/// The 95th percentile; reorders.
double high_of(std::vector<float>& values) {
  const auto rank = static_cast<std::size_t>(0.95 * static_cast<double>(values.size() - 1));
  return static_cast<double>(value_at_rank(values, rank));
}

MaterialOutcome material_outcome(const Simulation& simulation, const Part& part, int material) {
  const MaterialAtlas& atlas = simulation.atlas();
  const auto m = static_cast<std::size_t>(material);
  MaterialOutcome out{.material = simulation.scene().materials[m]};
  const double strength = simulation.scene().appearance[m].strength;
  for (const Rule& rule : simulation.scene().rules) out.is_made = out.is_made || rule.products[m] > 0.0;
  std::vector<float> shares;
  double mean_come = 0.0;
  for (const TexelIndex t : part.texels) {
    const double share = atlas.surface().weight(t) / part.area;
    const int quanta = atlas.amount(material, t);
    const double amount = static_cast<double>(quanta) / kAmountOne,
                 come = amount - static_cast<double>(atlas.original(material, t)) / kAmountOne;
    out.mean += share * amount;
    mean_come += share * std::max(0.0, come);
    shares.push_back(static_cast<float>(std::clamp(come * strength, 0.0, 1.0)));
    out.largest = std::max(out.largest, amount);
    if (come * strength >= kShows) out.shows_share += share;
    if (come * strength >= 1.0) out.hides_share += share;
    if (quanta == static_cast<int>(kMaxAmount)) out.full_share += share;
  }
  out.color_share = high_of(shares);
  if (out.color_share == 0.0) out.color_share = mean_come * strength;
  return out;
}

}  // namespace

std::vector<ObjectOutcome> outcome_of(Simulation& simulation, const ImageF& before, const RunControl& control) {
  const ImageF now = simulation.compose(control).color_linear();
  if (!before.same_size(now) || before.channels() != 3) throw InvalidInput("outcome: expected a color for every texel");
  const std::vector<Part> parts = parts_of(simulation);
  const std::optional<ImageU8> met = simulation.met(control);
  std::vector<ObjectOutcome> outcome;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Part& part = parts[i];
    ObjectOutcome& object = outcome.emplace_back();
    object.object = simulation.scene().objects[i].name;
    if (part.texels.empty()) continue;
    std::vector<float> changes;
    double never_met = 0.0;
    for (std::size_t k = 0; k < part.texels.size(); ++k) {
      const double share = simulation.atlas().surface().weight(part.texels[k]) / part.area;
      const double change = delta_e_at(before, now, part.pixels[k]);
      object.change_mean += share * change;
      changes.push_back(static_cast<float>(change));
      if (met && met->data()[part.pixels[k]] == 0) never_met += share;
    }
    if (met) object.never_met_share = never_met;
    object.change_p95 = high_of(changes);
    for (int m = 0; m < static_cast<int>(simulation.scene().materials.size()); ++m)
      object.materials.push_back(material_outcome(simulation, part, m));
  }
  return outcome;
}

namespace {

/// Cure that makes something visible where it changed by at most `most`. What rules make counts where it has more to
/// grow than the color: a film of water shows, too.
std::string cure_of(const std::vector<ObjectOutcome>& outcome, double most) {
  std::string made;
  double share = 0.0;
  bool has_rules = false;
  for (const ObjectOutcome& object : outcome) {
    for (const MaterialOutcome& material : object.materials) {
      has_rules = has_rules || material.is_made;
      if (!material.is_made || material.color_share <= share) continue;
      share = material.color_share;
      made = material.material;
    }
  }
  if (has_rules && share == 0.0) return "rules have made nothing: their drivers are 0, or their rates far too small";
  double times = most > 0.0 ? kVisibleDeltaE / most : 0.0;
  if (share > 0.0) times = std::max(times, kShows / share);
  if (times == 0.0) return "check that emitters are on, hit the objects, and carry what the rules need";
  const std::string factor =
      times < 1e4 ? "about " + short_number_text(rounded(times, 1)) : std::string("more than 10,000");
  return "rates or loads are " + factor + " times too small, or the run as many times too short" +
         (made.empty() ? ""
                       : " (of what rules make, " + made + " covers most, " +
                             short_number_text(rounded(100.0 * share, 2)) + " %" + " of the color)");
}

}  // namespace

std::vector<std::string> outcome_advice(const std::vector<ObjectOutcome>& outcome) {
  std::vector<std::string> advice;
  double most = 0.0;
  for (const ObjectOutcome& object : outcome) most = std::max(most, object.change_p95);
  if (most < kNoticeable) {
    advice.push_back("nothing visible happened: 95 % of every object changed by less than " +
                     short_number_text(rounded(most, 2)) + " Delta E (2.3 is just noticeable); " +
                     cure_of(outcome, most));
  }
  for (const ObjectOutcome& object : outcome) {
    if (object.never_met_share.value_or(0.0) > kMostlyUnmet) {
      advice.push_back("object '" + object.object + "': gammatons never hit " +
                       fixed_percent_text(*object.never_met_share) +
                       " of it: use more gammatons, more iterations, or other emitter positions");
    }
    for (const MaterialOutcome& material : object.materials) {
      if (!(material.hides_share > kNearlyAll)) continue;
      advice.push_back("object '" + object.object + "': " + material.material + " hides " +
                       fixed_percent_text(material.hides_share) +
                       " of it, and these places look uniform: lower the rate that makes it, or its strength");
    }
  }
  return advice;
}

}  // namespace patinate::simulation
