#include <memory>
#include <optional>

#include "app/transfer/destination.h"
#include "app/transfer/transfer_work.h"
#include "patinate/transfer/transfer_reader.h"
#include "python/support/errors.h"
#include "python/transfer/py_transfer.h"

namespace patinate::python {

app::Words collecting(const std::shared_ptr<std::vector<std::string>>& notes) {
  const auto add = [notes](const std::string& text) { notes->push_back(with_keywords(text)); };
  app::Words words;
  words.note = words.warning = add;
  return words;
}

void note_sizes(const transfer::AgingSurface& surface, transfer::ScaleSource source, const app::Words& say) {
  for (const std::string& note : surface.atlas->notes) say.note(note);
  app::note_scale(
      {.mm_per_mesh_unit = surface.mm_per_mesh_unit, .texel_size_mm = surface.texel_size_mm, .source = source},
      surface.atlas->mesh, "mm_per_unit", say);
  app::note_texels(*surface.map, surface.texel_size_mm, surface.atlas->is_unwrapped, say);
}

PySurface surface_of(const transfer::AgedMesh& aged) {
  PySurface surface{aged.surface, aged.surface.unit.has_value()};
  if (!surface.value.map)
    surface.value.map =
        std::make_shared<const TexelMap>(make_texel_map(*surface.value.atlas, aged.folder->manifest().width));
  return surface;
}

std::vector<std::string> notes_of(const PyAged& aged) {
  if (!aged.value->folder) return aged.notes;
  const auto notes = std::make_shared<std::vector<std::string>>();
  const app::Words say = collecting(notes);
  const transfer::TransferManifest& m = aged.value->folder->manifest();
  note_sizes(surface_of(*aged.value).value, m.unit ? transfer::ScaleSource::Known : transfer::ScaleSource::MeshScaled,
             say);
  for (const std::string& note : app::transfer_notes(m, m.measured_with)) say.note(note);
  return *notes;
}

}  // namespace patinate::python
