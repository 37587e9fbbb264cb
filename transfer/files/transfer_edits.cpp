#include "transfer/files/transfer_edits.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/text.h"
#include "libcommon/document/document.h"
#include "patinate/core/error.h"

namespace patinate::transfer {

namespace {

constexpr DocumentKind kEditsDocument{
    .format = kEditsFormat,
    .title = "patinate transfer edits",
    .about = "Edits of a transfer, in order: strokes that paint its control, and refinements of borders.",
    .has_whole_numbers = true};

constexpr std::size_t kMaxPoints = 10'000;  // Of a stroke.

}  // namespace

void describe(DocumentVisitor& v, TransferEdit& e) {
  v.choice({"kind", "stroke: paints a control; refine: refines the borders of copied pieces where was painted."},
           e.kind, kEditKindNames);
  if (e.kind != EditKind::Stroke && !v.wants_all()) return;
  const Presence presence = v.wants_all() ? Presence::Optional : Presence::Required;
  v.member(
      {"control", "Of the history, one that the transfer follows. It and what follows: of a stroke.", {}, presence},
      e.control);
  v.member({"value", "In the history's values: 0 and 1 are what its control says.", between(0, 1), presence}, e.value);
  v.member({"flow",
            "Share of the way to the value, in the middle of the brush, for each point.",
            {.low = 0.0, .high = 1.0, .is_low_open = true},
            presence},
           e.stroke.flow);
  v.member({"radius_mm", "Of the brush.", above(0), presence}, e.stroke.radius_mm);
  v.member({.name = "points_mm",
            .help = "Where the brush is held, one point after the other: x, y, z as mesh.obj of the transfer has them.",
            .presence = presence,
            .min_size = 1,
            .max_size = kMaxPoints},
           e.stroke.points_mm);
}

void describe(DocumentVisitor& v, TransferEdits& e) {
  v.member({.name = "edits", .help = "In the order in which they are applied.", .max_size = 100'000}, e.edits);
}

TransferEdits edits_from_json(const Json& json, const std::filesystem::path& file) {
  TransferEdits edits;
  read_document(kEditsDocument, file, json, described(edits));
  return edits;
}

TransferEdits read_transfer_edits(const std::filesystem::path& file) { return edits_from_json(load_json(file), file); }

Json edits_json(const TransferEdits& edits) {
  TransferEdits written = edits;
  return document_json(kEditsDocument, described(written));
}

void write_transfer_edits(const std::filesystem::path& file, const TransferEdits& edits) {
  save_json(file, edits_json(edits));
}

void check_edits(const TransferEdits& edits, std::span<const std::string> controls) {
  for (std::size_t i = 0; i < edits.edits.size(); ++i) {
    const TransferEdit& edit = edits.edits[i];
    if (edit.kind == EditKind::Refine && (i == 0 || edits.edits[i - 1].kind == EditKind::Refine))
      throw InvalidInput("edit " + std::to_string(i + 1) + ": there is nothing to refine: no stroke stands before it");
    if (edit.kind != EditKind::Stroke || std::find(controls.begin(), controls.end(), edit.control) != controls.end())
      continue;
    std::string list;
    for (const std::string& name : controls) list += (list.empty() ? "" : ", ") + name;
    throw InvalidInput("edit " + std::to_string(i + 1) + ": control `" + edit.control +
                       "` is none that the transfer follows; expected " + list +
                       did_you_mean(edit.control, {controls.begin(), controls.end()}));
  }
}

Json edits_schema() { return document_schema(kEditsDocument, described<TransferEdits>()); }

}  // namespace patinate::transfer
