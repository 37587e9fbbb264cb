#include "patinate/capture/unlight.h"

#include <algorithm>
#include <cmath>

#include "capture/unlighting/interreflection.h"
#include "capture/unlighting/lamp_estimate.h"
#include "capture/unlighting/material_maps.h"
#include "capture/unlighting/specular_choice.h"
#include "capture/unlighting/specular_fit.h"
#include "capture/unlighting/specular_form_choice.h"
#include "capture/unlighting/unlight_work.h"
#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr std::int64_t kFitRowsAChunk = 2;
constexpr std::array<std::string_view, 2> kNormalModeNames{"keep", "refine"};
constexpr std::array<std::string_view, 2> kRejectionNames{"none", "robust"};
constexpr std::array<std::string_view, 4> kSpecularNames{"none", "fit", "auto", "material"};

void put(ImageF& image, int x, int y, const Vec3& v) {
  for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(v[c]);
}

void fit_row(const UnlightWork& work, const TexelFitOptions& options, int y, TexelSamples& texel,
             UnlightResult& result) {
  for (int x = 0; x < work.width; ++x) {
    if (!work.is_surface(x, y)) continue;
    work.load(x, y, texel);
    const TexelFit fit = fit_texel(texel, options);
    for (std::size_t k = 0; k < texel.state.size(); ++k)
      result.samples.at(x, y, static_cast<int>(k)) = static_cast<std::uint8_t>(texel.state[k]);
    put(result.normal, x, y, fit.is_determined ? fit.normal : vector_of(work.normal, x, y));
    result.mask.at(x, y) = fit.is_determined ? 255 : 0;
    if (!work.specular.empty()) {
      result.specular.at(x, y, 0) = work.specular.at(x, y, 0) * static_cast<float>(fit.is_determined ? fit.gain : 1.0);
      result.specular.at(x, y, 1) = work.specular.at(x, y, 1);
    }
    for (int c = 0; c < work.num_channels; ++c) {
      result.albedo.at(x, y, c) = static_cast<float>(fit.is_determined ? fit.albedo[c] : 0.0);
      const double shared = fit.is_determined && texel.highlight.strength > 0.0
                                ? work.form_deviation * highlight_share(texel, fit, c) * fit.albedo[c]
                                : 0.0;
      result.stddev.at(x, y, c) = static_cast<float>(fit.is_determined ? std::hypot(fit.stddev[c], shared) : 0.0);
    }
  }
}

/// Sums over a few rows of what LightReport and UnlightResult tell.
struct Sums {
  std::vector<LightReport> lights;
  std::vector<double> squares, values;  ///< Squares of residuals, and photographed values, for each lamp.
  std::vector<std::int64_t> clean;
  std::int64_t surface = 0;
  std::int64_t determined = 0;
};

void add_row(const UnlightWork& work, int y, const UnlightResult& result, TexelSamples& texel, Sums& sums) {
  for (int x = 0; x < work.width; ++x) {
    if (!work.is_surface(x, y)) continue;
    ++sums.surface;
    const bool is_determined = result.mask.at(x, y) != 0;
    sums.determined += is_determined ? 1 : 0;
    if (is_determined) work.load(x, y, texel);
    if (is_determined && !result.specular.empty())
      texel.highlight.strength = static_cast<double>(result.specular.at(x, y, 0));
    const Vec3 n = vector_of(result.normal, x, y);
    for (int k = 0; k < work.num_lights; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const std::uint8_t state = result.samples.at(x, y, k);
      ++sums.lights[i].samples[state];
      if (!is_determined || state != static_cast<std::uint8_t>(SampleState::Clean)) continue;
      const double cosine = std::max(0.0, n.dot(texel.direction[i]));
      for (int c = 0; c < work.num_channels; ++c) {
        const auto at = texel.index(k, c);
        const double unit = texel.irradiance[at] * cosine + texel.ambient[at];
        const double off =
            texel.value[at] - static_cast<double>(result.albedo.at(x, y, c)) * unit - highlight_value(texel, k, c, n);
        sums.squares[i] += off * off;
        sums.values[i] += texel.value[at];
        ++sums.clean[i];
      }
    }
  }
}

void report(const UnlightWork& work, UnlightResult& result, const RunControl& control) {
  const auto l = static_cast<std::size_t>(work.num_lights);
  const Sums zero{
      std::vector<LightReport>(l), std::vector<double>(l), std::vector<double>(l), std::vector<std::int64_t>(l), 0, 0};
  const auto map = [&](std::int64_t begin, std::int64_t end) {
    Sums sums = zero;
    TexelSamples texel;
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) add_row(work, y, result, texel, sums);
    return sums;
  };
  const Sums sums = parallel_reduce(work.height, std::int64_t{16}, control, zero, map, [&](Sums a, const Sums& b) {
    for (std::size_t k = 0; k < l; ++k) {
      for (std::size_t s = 0; s < kNumSampleStates; ++s) a.lights[k].samples[s] += b.lights[k].samples[s];
      a.squares[k] += b.squares[k];
      a.values[k] += b.values[k];
      a.clean[k] += b.clean[k];
    }
    a.surface += b.surface;
    a.determined += b.determined;
    return a;
  });
  result.lights = sums.lights;
  for (std::size_t k = 0; k < l; ++k) result.lights[k].strength = work.strengths[k];
  result.num_surface = sums.surface;
  result.num_determined = sums.determined;
  const auto relative = [](double squares, double values, std::int64_t n) {
    return n > 0 && values > 0.0 ? std::sqrt(squares * static_cast<double>(n)) / values : 0.0;
  };
  double squares = 0.0, values = 0.0;
  std::int64_t clean = 0;
  for (std::size_t k = 0; k < l; ++k) {
    result.lights[k].residual = relative(sums.squares[k], sums.values[k], sums.clean[k]);
    squares += sums.squares[k];
    values += sums.values[k];
    clean += sums.clean[k];
  }
  result.residual = relative(squares, values, clean);
}

/// Judges each lamp by its samples. @throws InvalidInput where nothing can come of it.
void judge_lights(UnlightResult& result) {
  constexpr double kMany = 0.5;  // Share of the used samples.
  std::int64_t num_lit = 0, num_valid = 0;
  for (std::size_t k = 0; k < result.lights.size(); ++k) {
    const auto& n = result.lights[k].samples;
    const auto of = [&](SampleState s) { return n[static_cast<std::size_t>(s)]; };
    const std::int64_t used = of(SampleState::Clean) + of(SampleState::Darker) + of(SampleState::Brighter);
    num_lit += used + of(SampleState::Invalid);
    num_valid += used;
    const std::string name = "light " + std::to_string(k + 1);
    if (used == 0 && of(SampleState::Invalid) > 0) {
      result.notes.push_back("photograph " + std::to_string(k + 1) + " is saturated everywhere " + name +
                             " reaches; it is not used");
    } else if (used == 0) {
      result.notes.push_back(
          name + " lights nothing that the camera sees: the lamp is behind the surface, or the surface shades itself");
    } else if (static_cast<double>(of(SampleState::Darker)) > kMany * static_cast<double>(used)) {
      result.notes.push_back(
          name + ": " + fixed_percent_text(static_cast<double>(of(SampleState::Darker)) / static_cast<double>(used)) +
          " of its samples are darker than the other lamps allow; check its position, its strength "
          "and the photographs' order");
    } else if (static_cast<double>(of(SampleState::Brighter)) > kMany * static_cast<double>(used)) {
      result.notes.push_back(
          name + ": " + fixed_percent_text(static_cast<double>(of(SampleState::Brighter)) / static_cast<double>(used)) +
          " of its samples are brighter than the other lamps allow; check its position, its "
          "strength and the photographs' order");
    }
  }
  if (result.num_surface == 0) throw InvalidInput("the mask leaves no surface");
  if (num_lit == 0)
    throw InvalidInput(
        "no light reaches the surface that is seen; check that lights and scan are in the same frame and unit");
  if (num_valid == 0) throw InvalidInput("the photographs are saturated (white) wherever a light shines");
}

void check_not_black(const UnlightWork& work) {
  for (std::size_t k = 0; k < work.input.photos.size(); ++k) {
    bool is_lit = false, is_black = true;
    for (int y = 0; y < work.height && is_black; ++y) {
      for (int x = 0; x < work.width && is_black; ++x) {
        if (work.samples.at(x, y, static_cast<int>(k)) != static_cast<std::uint8_t>(SampleState::Clean)) continue;
        is_lit = true;
        for (float v : work.input.photos[k].pixel(x, y)) is_black = is_black && !(v > 0.0f);
      }
    }
    if (is_lit && is_black)
      throw InvalidInput("photograph " + std::to_string(k + 1) + " is black everywhere; expected what its light shows");
  }
}

}  // namespace

void describe(OptionVisitor& v, UnlightOptions& o) {
  v.visit_choice({"normals", "keep those of the scan, or refine them from the photographs"}, o.normals,
                 kNormalModeNames);
  v.visit({"normal_sigma", "expected error of the scan's normals", "deg", {0, 90, true}}, o.normal_sigma_deg);
  v.visit_choice({"rejection", "none: use every valid lit sample; robust: reject shadows and highlights"}, o.rejection,
                 kRejectionNames);
  v.visit({"rejection_sigma", "samples farther off than this are shadows or highlights", "standard deviations",
           between(1.5, 20)},
          o.rejection_sigma);
  v.visit_choice(
      {"specular",
       "none; fit: find and subtract highlights; auto: subtract them only where that improves the fit of nearly all "
       "nearby texels; material: one lobe for each material, metals included"},
      o.specular, kSpecularNames);
  v.visit({"specular_window", "distance within which highlights are assumed equal", "px", between(2, 1000)},
          o.specular_window_px);
  v.visit({"strengths", "estimate the lamps' strengths; the given intensities are only a guess"}, o.estimate_strengths);
  v.visit({"ambient", "estimate the ambient light that was not subtracted"}, o.estimate_ambient);
  v.visit({"interreflection", "subtract the light that the surface reflects into its own hollows; needs a scan"},
          o.interreflection);
  v.visit({"noise_floor", "noise of a photograph's value that does not depend on it", "", above(0)}, o.noise_floor);
  v.visit({"noise_share", "noise that grows with the value, as a share of it", "", between(0, 1)}, o.noise_share);
  v.visit({"min_cosine", "smallest cosine of the angle of incidence; light at a smaller one is ignored", "", {0, 0.99}},
          o.min_cosine);
  v.visit({"min_lights", "texels with fewer clean samples are not determined", "", between(1, 64)}, o.min_lights);
  v.visit({"shadow_offset", "blockers nearer than this cast no shadow; not given: the median edge of the scan", "mm",
           at_least(0)},
          o.shadow_offset_mm);
}

std::string_view name_of(MaterialKind kind) { return kMaterialKindNames[static_cast<std::size_t>(kind)]; }

UnlightResult empty_result(const UnlightWork& work) {
  return {.albedo = ImageF(work.width, work.height, work.num_channels),
          .stddev = ImageF(work.width, work.height, work.num_channels),
          .normal = ImageF(work.width, work.height, 3),
          .mask = ImageU8(work.width, work.height),
          .samples = ImageU8(work.width, work.height, work.num_lights)};
}

void fit_surface(const UnlightWork& work, UnlightResult& result, const RunControl& control) {
  const TexelFitOptions options = work.fit_options();
  parallel_for(work.height, kFitRowsAChunk, control, [&](std::int64_t begin, std::int64_t end) {
    TexelSamples texel;
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) fit_row(work, options, y, texel, result);
  });
}

double estimate_noise_scale(const UnlightWork& work, const RunControl& control, int max_rounds) {
  constexpr std::int64_t kMaxTexels = 20'000, kChunk = 64;
  // Least noise, and the relative change below which it has settled.
  constexpr double kLeast = 1e-4, kSettled = 0.02;
  const std::vector<std::int64_t> texels = work.spread_texels(kMaxTexels);
  TexelFitOptions options = work.fit_options();
  const RunControl silent = control.silent();
  double scale = 0.0;
  for (int round = 0; round < max_rounds; ++round) {
    std::vector<double> ratios(texels.size(), -1.0);
    // The first round takes every sample, so that it cannot begin too small.
    options.reject = round > 0 && work.options.rejection == Rejection::Robust;
    options.noise_scale = round == 0 ? 1.0 : scale;
    parallel_for(static_cast<std::int64_t>(texels.size()), kChunk, silent, [&](std::int64_t begin, std::int64_t end) {
      TexelSamples texel;
      for (std::int64_t i = begin; i < end; ++i) {
        const std::int64_t at = texels[i];
        work.load(static_cast<int>(at % work.width), static_cast<int>(at / work.width), texel);
        const TexelFit fit = fit_texel(texel, options);
        if (!fit.is_determined || fit.degrees_of_freedom < 1.0) continue;
        // Median of chi-square over its degrees of freedom [Wilson and Hilferty 1931].
        const double dof = fit.degrees_of_freedom, median = std::pow(1.0 - 2.0 / (9.0 * dof), 3.0);
        ratios[i] = fit.chi2 / (dof * median) * options.noise_scale * options.noise_scale;
      }
    });
    std::erase_if(ratios, [](double r) { return r < 0.0; });
    if (ratios.empty()) return round == 0 ? 1.0 : scale;
    const double next = std::max(kLeast, std::sqrt(median(std::move(ratios))));
    const bool is_settled = round > 0 && std::abs(next - scale) < kSettled * scale;
    scale = next;
    if (is_settled || (round == 0 && work.options.rejection == Rejection::None)) break;
  }
  return scale;
}

void find_highlights(UnlightWork& work, UnlightResult& result, const RunControl& control) {
  constexpr int kPasses = 3;  // Passes of fit and noise.
  const bool is_chosen = work.options.specular == SpecularMode::Auto;
  const double share = is_chosen ? 0.9 : 1.0;
  result.specular = ImageF(work.width, work.height, 2);
  work.highlight_base = result.albedo;
  work.highlight_normal = result.normal;
  choose_specular_form(work, control.part(0.0, 0.4));
  for (int pass = 0; pass < kPasses; ++pass) {
    const RunControl part =
        control.part(0.4 + (share - 0.4) * pass / kPasses, 0.4 + (share - 0.4) * (pass + 1) / kPasses);
    fit_highlights(work, result, part.part(0.0, 0.4));
    work.noise_scale = estimate_noise_scale(work, part.part(0.4, 0.5));
    fit_surface(work, result, part.part(0.5, 1.0));
  }
  if (!is_chosen) return;
  const RunControl part = control.part(share, 1.0);
  if (!keep_shared_highlights(work, part.part(0.0, 0.3))) return;
  work.noise_scale = estimate_noise_scale(work, part.part(0.3, 0.4));
  fit_surface(work, result, part.part(0.4, 1.0));
}

void find_material_highlights(UnlightWork& work, UnlightResult& result, const RunControl& control) {
  constexpr int kPasses = 3;  // Rounds of material and surface (docs/algorithms/materials.md, step 5).
  result.specular = ImageF(work.width, work.height, 2);
  work.form = {.tail = 2.0, .is_rendered = true};
  work.highlight_base = result.albedo;
  work.highlight_normal = result.normal;
  const ImageF color = result.albedo;
  for (int pass = 0; pass < kPasses; ++pass) {
    const RunControl part = control.part(1.0 * pass / kPasses, (pass + 1.0) / kPasses);
    const std::vector<TexelEvidence> texels = gather_evidence(work, result, color, part.part(0.0, 0.1));
    result.materials = find_materials(texels, part.part(0.1, 0.15));
    polish_materials(work, texels, result.materials, pass + 1 == kPasses, part.part(0.15, 0.3));
    lay_materials(work, result, color, result.materials, part.part(0.3, 0.55));
    if (pass + 1 == kPasses) work.highlight_freedom = choose_freedom(work, part.part(0.55, 0.6));
    work.noise_scale = estimate_noise_scale(work, part.part(0.6, 0.7));
    fit_surface(work, result, part.part(0.7, 1.0));
  }
  result.tint = work.highlight_tint;
  put_reflectance(work, result, control);
}

/// States what was found, one line a material.
void tell_materials(UnlightResult& result) {
  if (result.specular.empty() || result.materials.empty()) return;
  for (const SurfaceMaterial& m : result.materials) {
    std::string line = "material: " + std::string(name_of(m.kind)) + ", " + fixed_percent_text(m.share) + " of it";
    if (m.kind != MaterialKind::Matt) {
      line += ", roughness " + short_number_text(rounded(m.roughness, 2)) + ", strength " +
              short_number_text(rounded(m.strength[0], 2));
      if (m.kind != MaterialKind::Dielectric)
        line += " " + short_number_text(rounded(m.strength[1], 2)) + " " + short_number_text(rounded(m.strength[2], 2));
      line += "; the predictions of left-out lamps by metal and by a diffuse material differ by " +
              short_number_text(rounded(m.evidence, 2)) + " standard deviations";
    }
    result.notes.push_back(std::move(line));
  }
}

/// Fits again, with the light that the surface throws onto itself as the first fit and the photographs have it.
void take_off_interreflection(UnlightWork& work, LampEstimate& lamps, UnlightResult& result,
                              const RunControl& control) {
  Interreflection found = gather_interreflection(work, result, control.part(0.0, 0.6));
  work.indirect = std::move(found.irradiance);
  result.interreflection = InterreflectionReport{.unseen = found.unseen_share};
  if (work.options.estimate_strengths || work.options.estimate_ambient)
    lamps = estimate_lamps(work, control.part(0.6, 0.7));
  work.noise_scale = estimate_noise_scale(work, control.part(0.7, 0.8));
  fit_surface(work, result, control.part(0.8, 1.0));
}

/// Says how much of the light was the surface's own, and keeps it for those who predict photographs.
void report_interreflection(UnlightWork& work, UnlightResult& result) {
  const double unseen = result.interreflection->unseen;
  result.interreflection = interreflection_shares(work, result);
  result.interreflection->unseen = unseen;
  result.notes.push_back("" + fixed_percent_text(result.interreflection->median) + " of the texels' light (median; " +
                         fixed_percent_text(result.interreflection->p95) +
                         " at the 95th percentile) came from other places of the surface and was subtracted");
  constexpr double kMuch = 0.25;  // Share of the surface.
  if (unseen > kMuch) {
    result.notes.push_back("the camera does not see " + fixed_percent_text(unseen) +
                           " of the surface that its hollows face; this part was given the median albedo");
  }
  result.indirect = std::move(work.indirect);
}

UnlightResult unlight(const UnlightInput& input, const UnlightOptions& options, const RunControl& control) {
  std::vector<std::string> notes;
  UnlightWork work(input, options, control.part(0.0, 0.25));
  check_not_black(work);
  LampEstimate lamps{.is_converged = true};
  if (options.estimate_strengths || options.estimate_ambient) lamps = estimate_lamps(work, control.part(0.25, 0.35));
  if (!lamps.is_converged)
    notes.emplace_back("the lamps' strengths did not settle; the photographs may contradict the lights' positions");
  if (!lamps.is_determined)
    notes.emplace_back(
        "the photographs do not determine some of the lamps' strengths (or the ambient light): the object is too flat, "
        "or there are too few lamps");
  work.noise_scale = estimate_noise_scale(work, control.part(0.3, 0.35));
  UnlightResult result = empty_result(work);
  fit_surface(work, result, control.part(0.35, options.interreflection ? 0.4 : 0.5));
  if (options.interreflection) take_off_interreflection(work, lamps, result, control.part(0.4, 0.5));
  if (options.specular == SpecularMode::Material) {
    find_material_highlights(work, result, control.part(0.5, 0.9));
    result.form = work.form;
  } else if (options.specular != SpecularMode::None) {
    find_highlights(work, result, control.part(0.5, 0.9));
    result.form = work.form;
  }
  result.noise_scale = work.noise_scale;
  result.ambient = work.ambient;
  result.is_converged = lamps.is_converged && lamps.is_determined;
  result.notes = std::move(notes);
  report(work, result, control.part(0.9, 1.0));
  if (options.interreflection) report_interreflection(work, result);
  judge_lights(result);
  tell_materials(result);
  control.report(1.0);
  return result;
}

}  // namespace patinate::capture
