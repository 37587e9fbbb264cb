#include "capture/timelapse/photo_series.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/background/background.h"
#include "capture/handheld/printed_markers.h"
#include "capture/project/given_transforms.h"
#include "capture/timelapse/frame_photo.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace {

/// Marks of every frame, by the names that the table and the project have for it. @throws IoError
std::vector<PhotoMarks> marks_of(const CaptureProject& project) {
  std::vector<PhotoMarks> marks;
  const AlignMethod method = project.align.method;
  if (method != AlignMethod::Landmarks && method != AlignMethod::Auto) return marks;
  if (!project.align.landmarks) {
    if (method == AlignMethod::Auto) return marks;
    throw IoError(project.file.string(),
                  "is to be aligned by landmarks and names none; give \"landmarks\": \"points.csv\", a table of "
                  "photo,point,x,y");
  }
  marks.resize(project.frames.size());
  for (const auto& [name, of_photo] : read_landmarks(*project.align.landmarks)) {
    const std::vector<int>& excluded = project.excluded;
    const bool is_unknown = std::none_of(project.frames.begin(), project.frames.end(), [&](const CapturePhoto& p) {
      return p.name() == name || p.file.filename().string() == name;
    });
    if (is_unknown && !excluded.empty()) continue;  // The photograph is left out.
    marks[find_photo(project, name, "a landmark of " + project.align.landmarks->string())] = of_photo;
  }
  return marks;
}

/// Mask of the reference's pixels that show the object: the project's mask, where it is as large.
ImageU8 object_mask(const CaptureProject& project) {
  if (!project.mask) return {};
  ImageU8 mask = read_mask(*project.mask);
  return mask.width() == project.photo_width && mask.height() == project.photo_height ? mask : ImageU8();
}

/// Marks that nobody needed to make. @throws CannotComplete where no photograph has any.
std::vector<PhotoMarks> markers_of(const CaptureProject& project, const RunControl& control) {
  std::vector<std::vector<PhotoMarks>> found(project.frames.size());
  parallel_for(static_cast<std::int64_t>(found.size()), 1, control, [&](std::int64_t begin, std::int64_t) {
    const auto i = static_cast<std::size_t>(begin);
    found[i] = find_markers(read_whole_photo(project, project.frames[i]));
  });
  std::vector<PhotoMarks> marks = of_one_dictionary(found);
  if (std::all_of(marks.begin(), marks.end(), [](const PhotoMarks& of_photo) { return of_photo.empty(); })) {
    throw CannotComplete(project.file.string() +
                         ": --align markers: no photograph shows an ArUco or AprilTag marker; print one beside the "
                         "object, or use features, outline or landmarks");
  }
  return marks;
}

/// 0 = background: by alpha, by the color that --mask-background gives, or because it is plain.
ImageU8 object_of(const IngestWork& work, const CapturePhoto& photo) {
  ImageU8 opaque = opaque_part(photo);
  const double factor = std::min(1.0, static_cast<double>(kBackgroundSide) / std::max(photo.width, photo.height));
  const auto reduced = [&](int side) { return std::max(1, static_cast<int>(std::lround(factor * side))); };
  if (std::any_of(opaque.values().begin(), opaque.values().end(), [](std::uint8_t v) { return v == 0; })) {
    ImageF shares(opaque.width(), opaque.height());
    std::transform(opaque.values().begin(), opaque.values().end(), shares.values().begin(),
                   [](std::uint8_t v) { return v != 0 ? 1.0F : 0.0F; });
    shares = downscale_area(shares, reduced(photo.width), reduced(photo.height));
    ImageU8 object(shares.width(), shares.height());
    std::transform(shares.values().begin(), shares.values().end(), object.values().begin(),
                   [](float share) { return static_cast<std::uint8_t>(share >= 0.5F ? 255 : 0); });
    return object;
  }
  ImageF codes = downscale_area(read_whole_photo(work.project, photo), reduced(photo.width), reduced(photo.height));
  std::transform(codes.values().begin(), codes.values().end(), codes.values().begin(), srgb_from_linear);
  const BackgroundRule rule = background_rule(work.options.background.mask_background);
  if (rule.kind != BackgroundRule::Kind::Color) {
    PlainBackground plain = plain_background(codes, {});
    return plain.is_plain() ? std::move(plain.clear) : ImageU8(codes.width(), codes.height());
  }
  ImageU8 object = keyed_background(codes, rule.color);
  for (std::uint8_t& v : object.values()) v = static_cast<std::uint8_t>(255 - v);
  return object;
}

}  // namespace

PhotoSeries photo_series(const IngestWork& work, const RunControl& control) {
  const CaptureProject& project = work.project;
  PhotoSeries series;
  series.reference = project.reference;
  series.model = project.align.model;
  const AlignMethod method = project.align.method;
  series.marks = method == AlignMethod::Markers ? markers_of(project, control) : marks_of(project);
  series.are_marks_exact = method == AlignMethod::Markers;
  for (const CapturePhoto& photo : project.frames) {
    series.sizes.push_back({photo.width, photo.height});
    series.given.push_back(photo.transform);
  }
  if (method == AlignMethod::Landmarks || method == AlignMethod::Markers) return series;
  if (method == AlignMethod::Outline || method == AlignMethod::Auto) {
    series.outlines = [&work](int index) {
      const CapturePhoto& photo = work.project.frames[index];
      return find_outline(object_of(work, photo), photo.width, photo.height);
    };
  }
  if (method == AlignMethod::Outline) {
    series.model = AlignModel::Similarity;
    return series;
  }
  series.features = [&project](int index) {
    const CapturePhoto& photo = project.frames[index];
    ImageU8 shown = opaque_part(photo);
    if (shown.empty() && index == project.reference) shown = object_mask(project);
    return find_features(read_whole_photo(project, photo), shown);
  };
  return series;
}

}  // namespace patinate::capture
