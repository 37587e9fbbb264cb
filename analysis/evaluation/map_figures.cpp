#include "analysis/evaluation/map_figures.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <type_traits>
#include <utility>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/color_ramp.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

namespace {

constexpr std::int64_t kPieceChunk = 16384;
constexpr int kFeatures = 5;  ///< R, G, B and the two differences of luma.
constexpr std::pair<int, int> kBeside[] = {{1, 0}, {0, 1}};

/// Codes and the central differences of luma (one-sided at the border).
ImageF features_of(const ImageF& codes) {
  const int w = codes.width(), h = codes.height();
  const auto luma = [&](int x, int y) {
    return luminance(codes.pixel(std::clamp(x, 0, w - 1), std::clamp(y, 0, h - 1)));
  };
  ImageF out(w, h, kFeatures);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      std::copy_n(codes.pixel(x, y).data(), 3, out.pixel(x, y).data());
      out.at(x, y, 3) = (luma(x + 1, y) - luma(x - 1, y)) / 2.0f;
      out.at(x, y, 4) = (luma(x, y + 1) - luma(x, y - 1)) / 2.0f;
    }
  }
  return out;
}

struct PixelStep {
  int x = 0, y = 0;
};

/// The step in whole source pixels, at least one.
PixelStep whole_step(const Vec2& step_px) {
  const PixelStep step{static_cast<int>(std::lround(step_px.x())), static_cast<int>(std::lround(step_px.y()))};
  if (step.x != 0 || step.y != 0) return step;
  if (std::abs(step_px.x()) >= std::abs(step_px.y())) return {step_px.x() < 0.0 ? -1 : 1, 0};
  return {0, step_px.y() < 0.0 ? -1 : 1};
}

class SourceFeatures {
 public:
  explicit SourceFeatures(const SynthesisSource& source) : source_(source) {
    for (const ImageF& frame : source.frames) frames_.push_back(features_of(frame));
  }

  [[nodiscard]] bool contains(PixelStep p) const {
    return frames_.front().contains(p.x, p.y) && is_inside(source_.mask, p.x, p.y);
  }
  /// Sum over frames.
  [[nodiscard]] double difference(PixelStep a, PixelStep b) const {
    double sum = 0.0;
    for (const ImageF& frame : frames_) {
      double squares = 0.0;
      for (int c = 0; c < kFeatures; ++c) {
        const double d = static_cast<double>(frame.at(a.x, a.y, c)) - static_cast<double>(frame.at(b.x, b.y, c));
        squares += d * d;
      }
      sum += std::sqrt(squares);
    }
    return sum;
  }
  /// Difference that the source has at a step `d` from a and to b; nothing where it has neither.
  [[nodiscard]] std::optional<double> own_difference(PixelStep a, PixelStep b, PixelStep d) const {
    const PixelStep after{a.x + d.x, a.y + d.y}, before{b.x - d.x, b.y - d.y};
    const bool has_after = contains(after), has_before = contains(before);
    if (!has_after && !has_before) return std::nullopt;
    return ((has_after ? difference(a, after) : 0.0) + (has_before ? difference(before, b) : 0.0)) /
           (has_after && has_before ? 2.0 : 1.0);
  }

 private:
  const SynthesisSource& source_;
  std::vector<ImageF> frames_;
};

constexpr double kSmallControl = 3.0;  // Sigma of M2's P@s3, pixels.

/// @param wanted  Source pixels of a texel; 0: what sizes say.
SourceScale scale_of(const SourceAxes& axes, double pixel_mm, const TexelMap& surface, int wanted) {
  const double ratio = surface.median_texel_size_mm() / pixel_mm;
  if (wanted > 0) return {axes, surface.median_texel_size_mm() / wanted, static_cast<double>(wanted)};
  const double halved = ratio <= 1.0 ? 1.0 : std::exp2(std::round(std::log2(ratio)));
  return {axes, pixel_mm, std::max(halved, ratio)};
}

const SynthesisSource& checked(const SynthesisSource& source) {
  if (source.frames.empty()) throw InvalidInput("the source has no frame");
  for (const ImageF& f : source.frames) {
    if (f.channels() != 3 || !f.same_size(source.frames.front()))
      throw InvalidInput("the source's frames differ in size, or have not 3 channels");
  }
  if (!source.control.empty() && !source.control.same_size(source.frames.front()))
    throw InvalidInput("the source's control has another size than its frames");
  return source;
}

ImageF difference(const ImageF& a, const ImageF& b) {
  ImageF out(a.width(), a.height());
  for (std::int64_t i = 0; i < out.num_pixels(); ++i) out.data()[i] = std::abs(a.data()[i] - b.data()[i]);
  return out;
}

ErrorSums sums_of(const ImageF& error, const MapPart& part) {
  ErrorSums sums;
  part.for_each_covered([&](TexelId, std::int64_t i) {
    sums.sum += static_cast<double>(error.data()[i]);
    sums.counts.add(static_cast<double>(error.data()[i]));
  });
  return sums;
}

std::string hash_of(const MapPart& part) {
  std::vector<std::int32_t> all(static_cast<std::size_t>(part.num_texels()), -1);
  part.for_each_covered([&](TexelId t, std::int64_t i) { all[i] = part.indices.of(t); });
  return ContentHash().add(std::as_bytes(std::span<const std::int32_t>(all))).hex();
}

std::int64_t count_explained(const MapPart& part, const SynthesisSource& source, const MadePicture& made) {
  const ImageF& frame = source.frames[made.frame];
  std::int64_t equal = 0;
  part.for_each_covered([&](TexelId t, std::int64_t i) {
    bool same = true;
    for (int c = 0; c < 3; ++c)
      same &= std::abs(frame.data()[3 * std::int64_t{part.indices.of(t)} + c] - made.codes.data()[3 * i + c]) < 0.5f;
    equal += same ? 1 : 0;
  });
  return equal;
}

}  // namespace

void BorderSums::add(const BorderSums& other) { count += other.count, shown += other.shown, own += other.own; }

std::optional<double> BorderSums::contrast() const {
  if (count == 0) return 1.0;
  return own > 0.0 ? std::optional(shown / own) : std::nullopt;
}

BorderSums measure_borders(const MapPart& part, const SynthesisSource& frames, const SourceScale& scale,
                           const RunControl& control) {
  const SourceFeatures features(frames);
  const SourceIndices& source = part.indices;
  return parallel_reduce(
      part.num_texels(), kPieceChunk, control, BorderSums{},
      [&](std::int64_t begin, std::int64_t end) {
        BorderSums sums;
        for (std::int64_t i = begin; i < end; ++i) {
          const TexelId t = part.texel(i);
          if (!part.surface.is_covered(t)) continue;
          for (const auto& [dx, dy] : kBeside) {
            const auto pair = interior_pair(part.surface, scale.axes, t, dx, dy);
            if (!pair || follows_surface(source, *pair, scale)) continue;
            const PixelStep a{source.x(pair->first), source.y(pair->first)},
                b{source.x(pair->second), source.y(pair->second)};
            const auto own = features.own_difference(a, b, whole_step(pair->offset_mm / scale.pixel_mm));
            if (!own) continue;
            ++sums.count;
            sums.shown += features.difference(a, b);
            sums.own += *own;
          }
        }
        return sums;
      },
      [](BorderSums a, const BorderSums& b) {
        a.add(b);
        return a;
      });
}

double overuse_of(const ReuseSums& reuse, int width, std::int64_t num_usable, double pixels_per_texel) {
  if (reuse.texels == 0) return 0.0;
  const auto side = std::max(1, static_cast<int>(std::lround(pixels_per_texel)));
  const double area = static_cast<double>(side) * side,
               num_places = std::max(1.0, static_cast<double>(num_usable) / area),
               once = std::max(1.0, std::ceil(area / (pixels_per_texel * pixels_per_texel) - 1e-6));
  const std::int64_t columns = (width + side - 1) / side;
  std::vector<std::int64_t> places;
  for (std::size_t i = 0; i < reuse.uses.size(); ++i) {
    const auto x = static_cast<std::int64_t>(i) % width, y = static_cast<std::int64_t>(i) / width;
    const auto place = static_cast<std::size_t>(y / side * columns + x / side);
    if (place >= places.size()) places.resize(place + 1);
    places[place] += reuse.uses[i];
  }
  const double texels = static_cast<double>(reuse.texels), even = texels / num_places, most = std::max(once, even),
               part = even - std::floor(even);
  double beyond = 0.0;
  for (const std::int64_t uses : places) beyond += uses > 0 ? std::max(0.0, static_cast<double>(uses) - most) : 0.0;
  // Whole uses cannot be even to a fraction.
  if (even > once) beyond -= num_places * part * (1.0 - part);
  return std::max(0.0, beyond) / texels;
}

void ErrorSums::add(const ErrorSums& other) {
  sum += other.sum;
  counts.add(other.counts);
}

void FrameSums::add(const FrameSums& other) {
  gradients.add(other.gradients);
  spectrum.add(other.spectrum);
}

void MapSums::add(MapSums o) {
  std::move(o.hashes.begin(), o.hashes.end(), std::back_inserter(hashes));
  error.add(o.error), smooth_error.add(o.smooth_error), coherence.add(o.coherence);
  if (frames.size() < o.frames.size()) frames.resize(o.frames.size());
  for (std::size_t i = 0; i < o.frames.size(); ++i) frames[i].add(o.frames[i]);
  draws.add(o.draws), reuse.add(o.reuse), seams.add(o.seams), scale.add(o.scale);
  explained += o.explained;
  structure.add(o.structure), borders.add(o.borders);
  std::move(o.pictures.begin(), o.pictures.end(), std::back_inserter(pictures));
}

MapFigures::MapFigures(const SynthesisSource& source, MapFacts map, const EvaluationOptions& options,
                       std::uint64_t seed, const RunControl& control)
    : source_(checked(source)),
      map_(std::move(map)),
      options_(options),
      seed_(seed),
      scale_(scale_of({*map_.frames, map_.turns}, source.pixel_mm, *map_.surface, options.source_step)),
      structure_(source, map_.surface->median_texel_size_mm() / scale_.pixel_mm, map_.has_control, control) {}

TextureDistanceOptions MapFigures::draw_options() const {
  return {.num_samples = options_.num_samples, .num_directions = options_.num_directions, .seed = seed_};
}

void MapFigures::add_pictures(const MapPart& part, MapSums& sums) const {
  ImageF shown = part.gathered(source_.frames.back());
  for (float& v : shown.values()) v = linear_from_srgb(v / 255.0f);
  std::vector<Picture> pictures{{"result", "The last of the compared times through the coordinates", std::move(shown)},
                                {"coordinates",
                                 "Where each texel comes from: red along x, green along y, a checker of 16 source "
                                 "pixels in blue",
                                 coordinate_picture(part, source_.width(), source_.height())}};
  if (!part.control.empty())
    pictures.push_back({"control", "The wanted control, in the source's values",
                        ramp_picture(part.control, part.coverage(), 0.0, 1.0, ColorRamp::Sequential)});
  sums.pictures.push_back(std::move(pictures));
}

void MapFigures::measure_control(const MapPart& part, MapSums& sums, const RunControl& control) const {
  if (source_.control.empty() || part.control.empty()) return;
  const ImageU8 coverage = part.coverage();
  const ImageF made = part.gathered(source_.control), error = difference(made, part.control);
  sums.error = sums_of(error, part);
  sums.pictures.front().push_back({"control_error", "Control error |P(s(t)) - Q(t)|: dark 0, light 0.25 and above",
                                   ramp_picture(error, coverage, 0.0, kShownControlError, ColorRamp::Sequential)});
  sums.smooth_error = sums_of(difference(gaussian_blur(made, coverage, kSmallControl, control),
                                         gaussian_blur(part.control, coverage, kSmallControl, control)),
                              part);
}

MapSums MapFigures::measure(int tile, const CoordinateReader& coordinates, ImageF wanted, const PartCounts& before,
                            const PartCounts& all, const MadePicture* made, const RunControl& control) const {
  const TexelMap& surface = *map_.surface;
  MapPart part{.surface = surface,
               .frames = *map_.frames,
               .rect = cell_of(surface.sheet(), tile),
               .indices = SourceIndices(map_.name, surface.num_texels(), source_.width(), source_.height()),
               .control = std::move(wanted)};
  part.indices.read(surface, part.rect, coordinates);
  const std::vector<TexelPair> seams = seam_pairs(surface, scale_.axes, part.rect, control);
  std::vector<TexelId> over_seams;
  for (const TexelPair& pair : seams) over_seams.push_back(pair.second);
  part.indices.read(surface, std::move(over_seams), coordinates);
  MapSums sums;
  sums.hashes = {hash_of(part)};
  add_pictures(part, sums);
  measure_control(part, sums, control);
  sums.coherence = measure_coherence(part, scale_);
  control.report(0.2);
  for (const ImageF& frame : source_.frames)
    sums.frames.push_back({count_gradients(part, frame), measure_spectrum(part, frame)});
  sums.draws = draw_texture(part, source_.control, before, all, draw_options());
  control.report(0.5);
  ImageF repeated;
  sums.reuse = measure_reuse(part, std::int64_t{source_.width()} * source_.height(), repeated);
  sums.pictures.front().push_back({"repeated", "Light: the same source pixel shows again 4 to 64 texels away",
                                   ramp_picture(repeated, part.coverage(), 0.0, 1.0, ColorRamp::Sequential)});
  repeated = {};
  sums.seams = measure_seams(part, seams, source_, scale_, control.part(0.5, 0.6));
  sums.scale = measure_foreshortening(part, scale_, control.part(0.6, 0.7));
  if (made) sums.explained = count_explained(part, source_, *made);
  sums.structure = structure_.measure(part, before, all, sums.pictures.front(), control.part(0.7, 0.9));
  sums.borders = measure_borders(part, source_, scale_, control.part(0.9, 1.0));
  for (Picture& p : sums.pictures.front()) p.image = tile_picture(std::move(p.image), surface.sheet(), control);
  control.report(1.0);
  return sums;
}

}  // namespace patinate::analysis
