#include "analysis/evaluation/evaluation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "analysis/evaluation/map_figures.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/map_legend.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

void describe(OptionVisitor& v, EvaluationOptions& o) {
  v.visit({"samples", "Patches and texels drawn for distances of distributions", "", between(100, 1000000)},
          o.num_samples);
  v.visit({"directions", "Number of directions along which distributions are compared", "", between(1, 1024)},
          o.num_directions);
  v.visit({"times", "Times at which colors are compared", "", between(1, 100)}, o.num_times);
  v.visit({"audits", "Number of texels whose source pixel is compared with the best one in the whole source; 0 = none",
           "", between(0, 1000000)},
          o.num_audits);
  v.visit({"source_step", "Source pixels of a texel step; 0 = by the sizes of texel and pixel", "px", between(0, 256)},
          o.source_step);
}

namespace {

constexpr float kGray = 0.18f;  // Outside the charts.

Figure figure(const std::string& name, const std::string& title, const std::string& unit, std::optional<double> value,
              const std::string& undefined, std::optional<double> split = {}) {
  return {
      .name = name, .title = title, .unit = unit, .value = value, .split = split, .undefined = value ? "" : undefined};
}

void add_control_error(const MapSums& sums, std::vector<Figure>& out) {
  const std::string why = "no control was given on both sides";
  const auto mean = [](const ErrorSums& e) {
    return e.counts.total() > 0 ? std::optional(e.sum / static_cast<double>(e.counts.total())) : std::nullopt;
  };
  const auto p95 = [](const ErrorSums& e) -> std::optional<double> {
    if (e.counts.total() == 0) return std::nullopt;
    return e.counts.at_rank(std::lround(0.95 * static_cast<double>(e.counts.total() - 1)));
  };
  out.push_back(figure("control_error_mean", "Control error, mean (M2)", "", mean(sums.error), why));
  out.push_back(figure("control_error_p95", "Control error, 95th percentile (M2)", "", p95(sums.error), why));
  out.push_back(figure("control_error_s3_mean", "Control error after a Gaussian of 3 px, mean (M2)", "",
                       mean(sums.smooth_error), why));
  out.push_back(figure("control_error_s3_p95", "Control error after a Gaussian of 3 px, 95th percentile (M2)", "",
                       p95(sums.smooth_error), why));
}

void add_texture(const SynthesisSource& source, const MapSums& sums, const TextureDistanceOptions& options,
                 const RunControl& control, std::vector<Figure>& out) {
  TextureDistanceOptions again = options;
  ++again.seed;
  std::array<std::vector<double>, 4> values, floors;
  const auto put = [](std::vector<double>& list, const std::optional<double>& v) {
    if (v) list.push_back(*v);
  };
  for (std::size_t i = 0; i < source.frames.size(); ++i) {
    const ImageF& frame = source.frames[i];
    put(values[0], patch_distance(source, frame, &sums.draws, options, control));
    put(floors[0], patch_distance(source, frame, nullptr, again, control));
    put(values[1], gradient_distance(count_gradients(source, frame), sums.frames[i].gradients));
    put(values[2], spectrum_distance(measure_spectrum(source, frame), sums.frames[i].spectrum));
    if (source.control.empty()) continue;
    put(values[3], joint_distance(source, frame, &sums.draws, options, control));
    put(floors[3], joint_distance(source, frame, nullptr, again, control));
  }
  const auto mean = [&](const std::vector<double>& list) {
    double sum = 0.0;
    for (double v : list) sum += v;
    return list.size() == source.frames.size() ? std::optional(sum / static_cast<double>(list.size())) : std::nullopt;
  };
  out.push_back(figure("patch_swd", "Sliced distance of 7 x 7 patches (M4)", "codes", mean(values[0]),
                       "no chart or mask holds a whole patch of 7 x 7", mean(floors[0])));
  out.push_back(figure("gradient_emd", "Distance of gradient lengths (M4)", "codes", mean(values[1]),
                       "no neighbors inside a chart"));
  out.push_back(figure("spectrum", "Log spectrum, mean difference (M4)", "decades", mean(values[2]),
                       "no tile of the picture is covered"));
  out.push_back(figure("joint_swd", "Sliced distance of (R, G, B, control) (M5)", "codes", mean(values[3]),
                       "the source has no control", mean(floors[3])));
}

void add_reuse(const SynthesisSource& source, const MapSums& sums, double pixels_per_texel, std::vector<Figure>& out) {
  std::int64_t usable = std::int64_t{source.width()} * source.height();
  if (!source.mask.empty())
    usable = static_cast<std::int64_t>(source.mask.values().size()) -
             std::count(source.mask.values().begin(), source.mask.values().end(), 0);
  out.push_back(figure("rep64", "Texels whose source shows again 4 to 64 px away (M6)", "", sums.reuse.rep64(), ""));
  out.push_back(figure("used_share", "Source pixels that show anywhere (M6)", "", sums.reuse.used_share(usable), ""));
  out.push_back(figure("rep_all", "Texels whose source is used more than evenly, anywhere (M6)", "",
                       overuse_of(sums.reuse, source.width(), usable, pixels_per_texel), ""));
}

void add_seams_and_scale(const MapSums& sums, std::vector<Figure>& out) {
  const SeamFigures f = sums.seams.figures();
  const std::string why = f.num_pairs == 0 ? "the surface has no seams" : "the source does not vary inside charts";
  out.push_back(
      figure("seam_gradient_ratio", "Gradient over seams against inside charts (M7)", "", f.gradient_ratio, why));
  out.push_back(figure("seam_coherence_ratio", "Coherence over seams against inside charts (M7)", "", f.coherence_ratio,
                       f.num_pairs == 0 ? why : "no neighbors follow the surface"));
  const ForeshorteningFigures scale = foreshortening_of(sums.scale);
  const std::string no_spans = "no copied piece is 8 texels long";
  out.push_back(
      figure("scale_error_median", "Error of scale inside copied pieces, median (M8)", "", scale.median, no_spans));
  out.push_back(
      figure("scale_error_p99", "Error of scale inside copied pieces, 99th percentile (M8)", "", scale.p99, no_spans));
}

}  // namespace

Evaluation MapFigures::conclude(MapSums sums, bool has_made, const RunControl& control) const {
  Evaluation out;
  out.name = map_.name;
  add_control_error(sums, out.figures);
  out.figures.push_back(figure("coherent_share", "Neighbors that are neighbors in the source (M3)", "",
                               sums.coherence.coherent_share(), ""));
  out.figures.push_back(figure("texels_per_piece", "Texels of a copied piece, mean (M3)", "texels",
                               sums.coherence.texels_per_piece(), ""));
  add_texture(source_, sums, draw_options(), control, out.figures);
  add_reuse(source_, sums, map_.surface->median_texel_size_mm() / scale_.pixel_mm, out.figures);
  add_seams_and_scale(sums, out.figures);
  const auto covered = static_cast<double>(map_.surface->num_covered());
  out.figures.push_back(figure(
      "explained_pixels", "Pixels of the tool's picture that are the source at its coordinates (M9)", "",
      has_made ? std::optional(static_cast<double>(sums.explained) / covered) : std::nullopt, "no picture was given"));
  StructureFigures lines = structure_.figures(sums.structure, map_.surface->median_texel_size_mm());
  std::move(lines.figures.begin(), lines.figures.end(), std::back_inserter(out.figures));
  out.lines = std::move(lines.lines);
  out.figures.push_back(figure("border_contrast",
                               "Differences over borders of copied pieces against the source's own (M12)", "",
                               sums.borders.contrast(), "the source is flat where pieces meet"));
  out.pictures = sheet_pictures(std::move(sums.pictures), map_.surface->sheet());
  for (Picture& p : out.pictures) {
    if (p.name == "control") p.image = with_legend(p.image, {});
    if (p.name == "control_error") p.image = with_legend(p.image, {.high = kShownControlError});
    p.name = out.name + "_" + p.name;
  }
  out.hash = sums.hashes.front();
  if (sums.hashes.size() > 1) {
    ContentHash all;
    for (const std::string& hash : sums.hashes) all.add(hash);
    out.hash = all.hex();
  }
  control.report(1.0);
  return out;
}

ImageF coordinate_picture(const MapPart& part, int source_width, int source_height) {
  ImageF out(part.rect.width(), part.rect.height(), 3, kGray);
  part.for_each_covered([&](TexelId t, std::int64_t i) {
    const int x = part.indices.x(t), y = part.indices.y(t);
    const auto p = out.data() + 3 * i;
    p[0] = linear_from_srgb(static_cast<float>(x + 1) / static_cast<float>(source_width));
    p[1] = linear_from_srgb(static_cast<float>(y + 1) / static_cast<float>(source_height));
    p[2] = ((x / 16 + y / 16) & 1) != 0 ? 0.5f : 0.1f;
  });
  return out;
}

Evaluation evaluate(const SynthesisSource& source, const SynthesizedMap& map, const EvaluationOptions& options,
                    std::uint64_t seed, const MadePicture* made, const RunControl& control) {
  const TexelMap& surface = *map.surface;
  if (map.coordinates.channels() != 2 || map.coordinates.width() != surface.width() ||
      map.coordinates.height() != surface.height()) {
    throw InvalidInput(map.name + ": the coordinate map is " +
                       size_text(map.coordinates.width(), map.coordinates.height()) + " with " +
                       std::to_string(map.coordinates.channels()) + " channels; expected " +
                       size_text(surface.width(), surface.height()) + " with 2");
  }
  if (!map.control.empty() && (map.control.width() != surface.width() || map.control.height() != surface.height()))
    throw InvalidInput(map.name + ": its control has another size than its coordinate map");
  if (made && (made->frame >= source.frames.size() || !made->codes.same_size(map.coordinates) ||
               made->codes.channels() != 3 || surface.sheet().num_tiles() > 1))
    throw InvalidInput(map.name + ": its picture has not the size of its coordinate map");
  const auto frames = map.frames ? map.frames : std::make_shared<const FlowFrames>(uv_frames(surface));
  if (frames->size() != surface.mesh().triangles.size())
    throw InvalidInput(map.name + ": expected one frame a triangle");
  const MapFigures figures(source, {map.name, map.surface, frames, !map.control.empty(), map.turns}, options, seed,
                           control);
  const Sheet& sheet = surface.sheet();
  std::vector<PartCounts> before{{}};
  for (int tile = 0; tile < sheet.num_tiles(); ++tile) {
    before.push_back(before.back());
    before.back().add(count_part(surface, cell_of(sheet, tile)));
  }
  MapSums sums;
  for (int tile = 0; tile < sheet.num_tiles(); ++tile) {
    const TexelRect cell = cell_of(sheet, tile);
    ImageF wanted;
    if (!map.control.empty()) wanted = crop(map.control, cell.x0, cell.y0, cell.width(), cell.height());
    sums.add(figures.measure(tile, reader_of(map.coordinates), std::move(wanted), before[tile], before.back(), made,
                             control.part(0.8 * tile / sheet.num_tiles(), 0.8 * (tile + 1) / sheet.num_tiles())));
  }
  return figures.conclude(std::move(sums), made != nullptr, control.part(0.8, 1.0));
}

}  // namespace patinate::analysis
