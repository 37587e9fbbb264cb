#include <algorithm>

#include "analysis/explanation/explanation_report.h"
#include "libcommon/output/color_ramp.h"
#include "libcommon/output/contact_strip.h"
#include "patinate/atlas/dilate.h"
#include "patinate/output/render.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kShownControls = 3;
constexpr int kGutter = 16;  ///< Texels around charts that get their color.

/// The share of places with a smaller value, at every texel.
ImageF by_rank(const ImageF& values, std::vector<double> at_places, bool is_inverse) {
  std::sort(at_places.begin(), at_places.end());
  ImageF out(values.width(), values.height());
  for (std::size_t i = 0; i < out.values().size(); ++i) {
    const auto v = static_cast<double>(values.values()[i]);
    const auto below = std::lower_bound(at_places.begin(), at_places.end(), v) - at_places.begin();
    const auto upto = std::upper_bound(at_places.begin(), at_places.end(), v) - at_places.begin();
    const auto rank = 0.5F * static_cast<float>(below + upto) / static_cast<float>(at_places.size());
    out.values()[i] = is_inverse ? 1.0F - rank : rank;
  }
  return out;
}

class Views {
 public:
  Views(const TexelMap& map, bool is_z_up, const RunControl& control) : map_(map) {
    RenderOptions options{.width = 300, .height = 400};
    options.up = is_z_up ? UpAxis::Z : UpAxis::Y;
    for (const double azimuth : {30.0, 210.0}) {
      options.azimuth_deg = azimuth;
      views_.emplace_back(map.mesh(), options, control.part(0.5 * static_cast<double>(views_.size()), 1.0));
    }
  }
  [[nodiscard]] ImageF shade(ImageF texture) const {
    dilate(texture, map_.coverage(), kGutter);
    const std::vector<ImageF> sides{views_[0].shade(texture), views_[1].shade(texture)};
    return contact_strip(sides, {}, {.gap_px = 4});
  }
  [[nodiscard]] ImageF shade_ranks(const ImageF& ranks, const ImageU8& mask) const {
    return shade(ramp_picture(ranks, mask, 0.0, 1.0, ColorRamp::Sequential));
  }

 private:
  const TexelMap& map_;
  std::vector<RenderView> views_;
};

ImageF mix_values(const ExplanationReport& report) {
  ImageF out(report.task.map->width(), report.task.map->height());
  for (const MixMember& m : report.found.mix.members) {
    const std::span<const float> own = report.controls[m.candidate].map.values.values();
    const auto weight = static_cast<float>(m.weight);
    for (std::size_t i = 0; i < own.size(); ++i) out.values()[i] += weight * (m.is_inverse ? 1.0F - own[i] : own[i]);
  }
  return out;
}

}  // namespace

std::vector<Picture> explanation_pictures(const ExplanationReport& report, const std::filesystem::path& scratch,
                                          const RunControl& control) {
  const SurfaceReference& reference = report.task.reference;
  const Views views(*report.task.map, report.task.is_z_up, control);
  std::vector<Picture> pictures;
  const auto add = [&](std::string caption, ImageF image) {
    pictures.push_back({.name = "picture" + std::to_string(pictures.size()),
                        .caption = std::move(caption),
                        .image = std::move(image)});
  };
  if (!reference.color.empty()) add("The reference", views.shade(reference.color));
  add("The reference by rank: yellow is most aged; gray is not looked at",
      views.shade_ranks(by_rank(reference.values, report.input.reference, false), reference.mask));
  const ImageU8 everywhere;
  if (report.found.mix.members.size() > 1) {
    ImageF mix = mix_values(report);
    std::vector<double> at_places;
    for (std::size_t i = 0; i < report.input.reference.size(); ++i) {
      double v = 0.0;
      for (const MixMember& m : report.found.mix.members) {
        const double own = report.input.candidates[m.candidate].values[i];
        v += m.weight * (m.is_inverse ? 1.0 - own : own);
      }
      at_places.push_back(v);
    }
    add("The mix " + report.found.mix.expression + ", by rank",
        views.shade_ranks(by_rank(mix, std::move(at_places), false), everywhere));
  }
  std::size_t shown = 0;
  for (const ExplainedCandidate& c : report.found.candidates) {
    if (c.is_even || shown++ >= kShownControls) break;
    const bool is_inverse = c.figures.correlation < 0.0;
    const auto at = static_cast<std::size_t>(std::find_if(report.controls.begin(), report.controls.end(),
                                                          [&](const MadeControl& m) { return m.name == c.name; }) -
                                             report.controls.begin());
    add((is_inverse ? "!" : "") + c.name + ", by rank: yellow should be yellow",
        views.shade_ranks(by_rank(report.controls[at].map.values, report.input.candidates[at].values, is_inverse),
                          everywhere));
  }
  embed_pictures(pictures, scratch);
  return pictures;
}

}  // namespace patinate::analysis
