#include "capture/project/given_transforms.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "capture/project/frame_sources.h"
#include "libcommon/document/document.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr DocumentKind kAlignmentDocument{
    .format = "patinate.alignment",
    .title = "patinate alignment",
    .about =
        "alignment.json of a history whose photographs were laid over one another; a capture project may name it "
        "as `transforms`."};

}  // namespace

void describe(DocumentVisitor& v, PlacedPhoto& p) {
  std::optional<std::array<double, 9>> numbers;
  using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  if (p.reference_from_photo) Eigen::Map<Rows>(numbers.emplace().data()) = *p.reference_from_photo;
  v.member({"photo"}, p.photo);
  v.member(if_set("number", "As `exclude` counts.", at_least(0)), p.number);
  v.member(if_set("time"), p.time);
  v.member(if_set("status", "reference, given, aligned, aligned through another, or failed."), p.status);
  v.member(if_set("pairs", "Photographs that it was matched with and that hold it.", at_least(0)), p.num_pairs);
  v.member(if_set("transform",
                  "3 x 3, row by row: the reference's pixels from this photograph's, pixel centers. Not of one that "
                  "failed."),
           numbers);
  if (v.is_reading() && numbers) {
    p.reference_from_photo = transform_of_numbers(*numbers);
    v.require("transform", p.reference_from_photo.has_value(), kTransformText);
  }
  v.member(if_set("model", "similarity or homography."), p.model);
  v.member(
      if_set("residual_px", "Root mean square disagreement of its matches, in the reference's pixels.", at_least(0)),
      p.residual_px);
  v.member(if_set("pixels_per_reference_pixel", "Below 1 the photograph is coarser.", above(0)),
           p.pixels_per_reference_pixel);
  v.member(if_set("shown_share", "Of the reference's frame, or its roi.", between(0, 1)), p.shown_share);
  v.member(if_set("through", "The photograph next to it on the way to the reference."), p.through);
}

void describe(DocumentVisitor& v, MatchedPhotos& m) {
  v.member({.name = "photos", .min_size = 2, .max_size = 2}, m.photos);
  v.member({"accepted"}, m.is_accepted);
  v.member({"matches", "", at_least(0)}, m.num_matches);
  v.member({"agreeing", "", at_least(0)}, m.num_agreeing);
}

void describe(DocumentVisitor& v, Alignment& a) {
  v.member(if_set("key", "Content of all that it was made from."), a.key);
  v.member(if_set("method", "What was matched."), a.method);
  v.member({"reference", "Photograph that the others are laid over."}, a.reference);
  v.member({"photos", "By rising time."}, a.photos);
  v.member({.name = "pairs", .presence = Presence::Optional}, a.pairs);
}

Alignment read_alignment(const std::filesystem::path& file) {
  Alignment alignment;
  read_document(kAlignmentDocument, file, described(alignment));
  return alignment;
}

void save_alignment(const std::filesystem::path& file, Alignment alignment) {
  save_json(file, document_json(kAlignmentDocument, described(alignment)));
}

Json alignment_schema() { return document_schema(kAlignmentDocument, described<Alignment>()); }

int find_photo(const CaptureProject& project, const std::string& name, const std::string& what) {
  const std::vector<std::string> names = photo_names(project.frames);
  int found = -1;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return static_cast<int>(i);
    if (project.frames[i].file.filename().string() != name) continue;
    if (found >= 0)
      throw IoError(project.file.string(),
                    what + " names " + name + ", which several photographs are; give one as " + names[i]);
    found = static_cast<int>(i);
  }
  if (found < 0)
    throw IoError(project.file.string(), what + " names " + name + ", which is none of its photographs (" +
                                             names.front() + (names.size() > 1 ? ", " + names[1] + " ..." : "") + ")");
  return found;
}

void read_transforms(const std::filesystem::path& file, CaptureProject& project) {
  const Alignment alignment = read_alignment(file);
  const std::vector<std::string> names = photo_names(project.frames);
  if (project.align.to.empty()) project.align.to = alignment.reference;
  if (alignment.reference != project.align.to)
    throw IoError(file.string(), "/reference: found \"" + alignment.reference +
                                     "\"; expected the project's `align_to`, " + project.align.to);
  for (const PlacedPhoto& placed : alignment.photos) {
    const auto i = static_cast<std::size_t>(std::find(names.begin(), names.end(), placed.photo) - names.begin());
    if (i == names.size() || project.frames[i].transform || !placed.reference_from_photo) continue;
    project.frames[i].transform = placed.reference_from_photo;
  }
}

}  // namespace patinate::capture
