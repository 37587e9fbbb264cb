#include "analysis/evaluation/evaluation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/evaluation/coherence.h"
#include "analysis/evaluation/copied_pieces.h"
#include "libcommon/core/hash.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/map_legend.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

void describe(OptionVisitor& v, EvaluationOptions& o) {
  v.visit({"samples", "Patches and texels drawn for distances of distributions", "", between(100, 1000000)},
          o.num_samples);
  v.visit({"directions", "Directions along which they are compared", "", between(1, 1024)}, o.num_directions);
  v.visit({"times", "Times at which colors are compared", "", between(1, 100)}, o.num_times);
  v.visit(
      {"audits", "Texels whose pixel is compared with the best of the whole source; 0 = none", "", between(0, 1000000)},
      o.num_audits);
  v.visit({"source_step", "Source pixels of a texel step; 0 = by the sizes of texel and pixel", "px", between(0, 256)},
          o.source_step);
}

namespace {

constexpr double kSmallControl = 3.0;  // Sigma of M2's P@s3, pixels.
constexpr double kShownError = 0.25;   // At the light end of the map of control errors.
constexpr float kGray = 0.18f;         // Outside the charts.

ImageF gathered(const ImageF& source, const SourceIndices& indices, const TexelMap& surface, float outside) {
  ImageF out(surface.width(), surface.height(), source.channels(), outside);
  const auto channels = static_cast<std::int64_t>(source.channels());
  for (TexelId t = 0; t < surface.num_texels(); ++t) {
    const std::int32_t s = indices.of(t);
    if (s >= 0) std::copy_n(source.data() + s * channels, channels, out.data() + t * channels);
  }
  return out;
}

Figure figure(const std::string& name, const std::string& title, const std::string& unit, std::optional<double> value,
              const std::string& undefined, std::optional<double> split = {}) {
  return {
      .name = name, .title = title, .unit = unit, .value = value, .split = split, .undefined = value ? "" : undefined};
}

struct ErrorSummary {
  double mean = 0.0, p95 = 0.0;
};
ErrorSummary summary_of(const ImageF& error, const ImageU8& coverage) {
  double sum = 0.0;
  std::int64_t n = 0;
  for (std::int64_t i = 0; i < error.num_pixels(); ++i) {
    if (coverage.data()[i] == 0) continue;
    sum += static_cast<double>(error.data()[i]);
    ++n;
  }
  return {n > 0 ? sum / static_cast<double>(n) : 0.0,
          static_cast<double>(percentiles(error, coverage, 0.95, 0.95).low)};
}

ImageF difference(const ImageF& a, const ImageF& b) {
  ImageF out(a.width(), a.height());
  for (std::int64_t i = 0; i < out.num_pixels(); ++i) out.data()[i] = std::abs(a.data()[i] - b.data()[i]);
  return out;
}

/// One evaluation under way: what the parts share.
struct Work {
  const SynthesisSource& source;
  const SynthesizedMap& map;
  const EvaluationOptions& options;
  const RunControl& control;
  std::uint64_t seed;
  const TexelMap& surface;
  SourceIndices indices;
  ImageU8 coverage;
  std::shared_ptr<const FlowFrames> frames;
  SourceScale scale;
  Evaluation out;

  void add(Figure f) { out.figures.push_back(std::move(f)); }
  void picture(const std::string& name, const std::string& caption, ImageF image) {
    out.pictures.push_back({out.name + "_" + name, caption, std::move(image)});
  }

  void add_control_error();
  void add_coherence();
  void add_texture();
  void add_reuse();
  void add_seams();
  void add_scale();
  void add_explained(const MadePicture* made);
  void add_lines();
  void add_borders();
};

void Work::add_control_error() {
  const bool has = !source.control.empty() && !map.control.empty();
  const std::string why = "no control was given on both sides";
  std::optional<ErrorSummary> plain, smooth;
  if (has) {
    const ImageF made = gathered(source.control, indices, surface, 0.0f);
    const ImageF error = difference(made, map.control);
    plain = summary_of(error, coverage);
    smooth = summary_of(difference(gaussian_blur(made, coverage, kSmallControl, control),
                                   gaussian_blur(map.control, coverage, kSmallControl, control)),
                        coverage);
    picture("control_error", "Control error |P(s(t)) - Q(t)|: dark 0, light 0.25 and above",
            with_legend(ramp_picture(error, coverage, 0.0, kShownError, ColorRamp::Sequential), {.high = kShownError}));
  }
  const auto value = [&](const std::optional<ErrorSummary>& s, bool mean) {
    return s ? std::optional(mean ? s->mean : s->p95) : std::nullopt;
  };
  add(figure("control_error_mean", "Control error, mean (M2)", "", value(plain, true), why));
  add(figure("control_error_p95", "Control error, 95th percentile (M2)", "", value(plain, false), why));
  add(figure("control_error_s3_mean", "Control error after a Gaussian of 3 px, mean (M2)", "", value(smooth, true),
             why));
  add(figure("control_error_s3_p95", "Control error after a Gaussian of 3 px, 95th percentile (M2)", "",
             value(smooth, false), why));
}

void Work::add_coherence() {
  const CoherenceFigures f = measure_coherence(surface, indices, scale);
  add(figure("coherent_share", "Neighbors that are neighbors in the source (M3)", "", f.coherent_share, ""));
  add(figure("texels_per_piece", "Texels of a copied piece, mean (M3)", "texels", f.texels_per_piece, ""));
}

void Work::add_texture() {
  const TextureDistanceOptions distance{
      .num_samples = options.num_samples, .num_directions = options.num_directions, .seed = seed};
  TextureDistanceOptions again = distance;
  again.seed = seed + 1;
  std::vector<int> chart(static_cast<std::size_t>(surface.num_texels()));
  for (TexelId t = 0; t < surface.num_texels(); ++t)
    chart[static_cast<std::size_t>(t)] = surface.is_covered(t) ? surface.chart(t) : -1;
  const bool has_control = !source.control.empty();
  const ImageF control_made =
      has_control ? (map.control.empty() ? gathered(source.control, indices, surface, 0.0f) : map.control) : ImageF();
  std::array<std::vector<double>, 4> sums, floors;
  const auto put = [](std::vector<double>& list, const std::optional<double>& v) {
    if (v) list.push_back(*v);
  };
  for (const ImageF& frame : source.frames) {
    const ImageF made = gathered(frame, indices, surface, 0.0f);
    const TextureView a{frame, source.mask, {}, has_control ? &source.control : nullptr},
        b{made, coverage, chart, has_control ? &control_made : nullptr};
    put(sums[0], patch_distance(a, b, distance, control));
    put(floors[0], patch_distance(a, a, again, control));
    put(sums[1], gradient_distance(a, b));
    put(sums[2], spectrum_distance(a, b));
    if (!has_control) continue;
    put(sums[3], joint_distance(a, b, distance, control));
    put(floors[3], joint_distance(a, a, again, control));
  }
  const auto mean = [&](const std::vector<double>& list) {
    double sum = 0.0;
    for (double v : list) sum += v;
    return list.size() == source.frames.size() ? std::optional(sum / static_cast<double>(list.size())) : std::nullopt;
  };
  add(figure("patch_swd", "Sliced distance of 7 x 7 patches (M4)", "codes", mean(sums[0]),
             "no chart or mask holds a whole patch of 7 x 7", mean(floors[0])));
  add(figure("gradient_emd", "Distance of gradient lengths (M4)", "codes", mean(sums[1]),
             "no neighbors inside a chart"));
  add(figure("spectrum", "Log spectrum, mean difference (M4)", "decades", mean(sums[2]),
             "no tile of the picture is covered"));
  add(figure("joint_swd", "Sliced distance of (R, G, B, control) (M5)", "codes", mean(sums[3]),
             "the source has no control", mean(floors[3])));
}

void Work::add_reuse() {
  std::int64_t usable = std::int64_t{source.width()} * source.height();
  if (!source.mask.empty())
    usable = static_cast<std::int64_t>(source.mask.values().size()) -
             std::count(source.mask.values().begin(), source.mask.values().end(), 0);
  const ReuseFigures f = measure_reuse(surface, indices, usable);
  add(figure("rep64", "Texels whose source shows again 4 to 64 px away (M6)", "", f.rep64, ""));
  add(figure("used_share", "Source pixels that show anywhere (M6)", "", f.used_share, ""));
  add(figure("rep_all", "Texels whose source is used more than evenly, anywhere (M6)", "",
             measure_overuse(surface, indices, usable, surface.median_texel_size_mm() / scale.pixel_mm), ""));
  ImageF repeated(surface.width(), surface.height());
  for (TexelId t = 0; t < surface.num_texels(); ++t)
    repeated.data()[t] = static_cast<float>(f.is_repeated[static_cast<std::size_t>(t)]);
  picture("repeated", "Light: the same source pixel shows again 4 to 64 texels away",
          ramp_picture(repeated, coverage, 0.0, 1.0, ColorRamp::Sequential));
}

void Work::add_seams() {
  const std::vector<TexelPair> pairs = seam_pairs(surface, *frames, control);
  const SeamFigures f = measure_seams(surface, indices, pairs, source, scale, control);
  const std::string why = f.num_pairs == 0 ? "the surface has no seams" : "the source does not vary inside charts";
  add(figure("seam_gradient_ratio", "Gradient over seams against inside charts (M7)", "", f.gradient_ratio, why));
  add(figure("seam_coherence_ratio", "Coherence over seams against inside charts (M7)", "", f.coherence_ratio,
             f.num_pairs == 0 ? why : "no neighbors follow the surface"));
}

void Work::add_scale() {
  const ForeshorteningFigures f = measure_foreshortening(surface, indices, scale, control);
  const std::string why = "no copied piece is 8 texels long";
  add(figure("scale_error_median", "Error of scale inside copied pieces, median (M8)", "", f.median, why));
  add(figure("scale_error_p99", "Error of scale inside copied pieces, 99th percentile (M8)", "", f.p99, why));
}

void Work::add_explained(const MadePicture* made) {
  std::optional<double> share;
  if (made) {
    if (made->frame >= source.frames.size() || !made->codes.same_size(coverage) || made->codes.channels() != 3)
      throw InvalidInput(map.name + ": its picture has not the size of its coordinate map");
    const ImageF expected = gathered(source.frames[made->frame], indices, surface, 0.0f);
    std::int64_t equal = 0;
    for (TexelId t = 0; t < surface.num_texels(); ++t) {
      if (!surface.is_covered(t)) continue;
      bool same = true;
      for (int c = 0; c < 3; ++c) same &= std::abs(expected.data()[3 * t + c] - made->codes.data()[3 * t + c]) < 0.5f;
      equal += same ? 1 : 0;
    }
    share = static_cast<double>(equal) / static_cast<double>(surface.num_covered());
  }
  add(figure("explained_pixels", "Pixels of the tool's picture that are the source at its coordinates (M9)", "", share,
             "no picture was given"));
}

void Work::add_lines() {
  StructureFigures f =
      measure_lines(source, map, indices, surface.median_texel_size_mm() / scale.pixel_mm, control.part(0.85, 0.95));
  for (Figure& made : f.figures) add(std::move(made));
  for (Picture& p : f.pictures) picture(p.name, p.caption, std::move(p.image));
  out.lines = std::move(f.lines);
}

void Work::add_borders() {
  const BorderFigures f = measure_borders(surface, indices, source, scale, control.part(0.95, 1.0));
  add(figure("border_contrast", "Differences over borders of copied pieces against the source's own (M12)", "",
             f.contrast, "the source is flat where pieces meet"));
}

/// @param wanted  Source pixels of a texel; 0: what sizes say.
SourceScale scale_of(const FlowFrames& frames, double pixel_mm, const TexelMap& surface, int wanted) {
  const double ratio = surface.median_texel_size_mm() / pixel_mm;
  if (wanted > 0) return {frames, surface.median_texel_size_mm() / wanted, static_cast<double>(wanted)};
  const double halved = ratio <= 1.0 ? 1.0 : std::exp2(std::round(std::log2(ratio)));
  return {frames, pixel_mm, std::max(halved, ratio)};
}

void check_source(const SynthesisSource& source, const SynthesizedMap& map) {
  if (source.frames.empty()) throw InvalidInput("the source has no frame");
  for (const ImageF& f : source.frames) {
    if (f.channels() != 3 || !f.same_size(source.frames.front()))
      throw InvalidInput("the source's frames differ in size, or have not 3 channels");
  }
  if (!source.control.empty() && !source.control.same_size(source.frames.front()))
    throw InvalidInput("the source's control has another size than its frames");
  if (!map.control.empty() &&
      (map.control.width() != map.surface->width() || map.control.height() != map.surface->height()))
    throw InvalidInput(map.name + ": its control has another size than its coordinate map");
}

}  // namespace

ImageF coordinate_picture(const TexelMap& surface, const SourceIndices& indices, int source_width, int source_height) {
  ImageF out(surface.width(), surface.height(), 3, kGray);
  for (TexelId t = 0; t < surface.num_texels(); ++t) {
    if (indices.of(t) < 0) continue;
    const int x = indices.x(t), y = indices.y(t);
    const auto p = out.data() + 3 * t;
    p[0] = linear_from_srgb(static_cast<float>(x + 1) / static_cast<float>(source_width));
    p[1] = linear_from_srgb(static_cast<float>(y + 1) / static_cast<float>(source_height));
    p[2] = ((x / 16 + y / 16) & 1) != 0 ? 0.5f : 0.1f;
  }
  return out;
}

Evaluation evaluate(const SynthesisSource& source, const SynthesizedMap& map, const EvaluationOptions& options,
                    std::uint64_t seed, const MadePicture* made, const RunControl& control) {
  check_source(source, map);
  const auto frames = map.frames ? map.frames : std::make_shared<const FlowFrames>(uv_frames(*map.surface));
  if (frames->size() != map.surface->mesh().triangles.size())
    throw InvalidInput(map.name + ": expected one frame a triangle");
  Work work{.source = source,
            .map = map,
            .options = options,
            .control = control,
            .seed = seed,
            .surface = *map.surface,
            .indices = SourceIndices(map, source),
            .coverage = map.surface->coverage(),
            .frames = frames,
            .scale = scale_of(*frames, source.pixel_mm, *map.surface, options.source_step),
            .out = {.name = map.name, .figures = {}, .pictures = {}, .lines = {}, .hash = {}}};
  const std::vector<std::int32_t>& all = work.indices.all();
  work.out.hash = ContentHash().add(std::as_bytes(std::span(all))).hex();
  ImageF shown = gathered(source.frames.back(), work.indices, *map.surface, 0.0f);
  for (float& v : shown.values()) v = linear_from_srgb(v / 255.0f);
  work.picture("result", "The last of the compared times through the coordinates", std::move(shown));
  work.picture("coordinates",
               "Where each texel comes from: red along x, green along y, a checker of 16 source pixels in blue",
               coordinate_picture(*map.surface, work.indices, source.width(), source.height()));
  if (!map.control.empty())
    work.picture("control", "The wanted control, in the source's values",
                 with_legend(ramp_picture(map.control, work.coverage, 0.0, 1.0, ColorRamp::Sequential), {}));
  work.add_control_error();
  work.add_coherence();
  control.report(0.2);
  work.add_texture();
  control.report(0.8);
  work.add_reuse();
  work.add_seams();
  work.add_scale();
  work.add_explained(made);
  work.add_lines();
  work.add_borders();
  control.report(1.0);
  return std::move(work.out);
}

}  // namespace patinate::analysis
