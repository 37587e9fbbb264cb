#include "patinate/patinate.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/text.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate {

std::shared_ptr<const History> read_history(const std::filesystem::path& path) {
  return std::make_shared<const HistoryReader>(path);
}

ControlMap control(const AgingSurface& surface, std::string_view expression, const RunControl& run) {
  return make_control_expression(expression, *surface.map, {}, run);
}

AgedMesh age(const std::shared_ptr<const History>& history, const AgingSurface& surface,
             const std::vector<ControlPair>& controls, const transfer::TransferOptions& options,
             const RunControl& run) {
  std::vector<transfer::TransferControl> pairs;
  for (const auto& [source, map] : controls) {
    if (map.values.width() != surface.map->width() || map.values.height() != surface.map->height())
      throw InvalidInput("the control `" + source + "` is " + size_text(map.values.width(), map.values.height()) +
                         "; the surface has " + size_text(surface.map->width(), surface.map->height()) + " texels");
    const transfer::ControlSpec spec{.source = source, .destination = "map"};
    pairs.push_back(transfer::make_transfer_control(
        *history, {.source = transfer::source_control(*history, spec), .destination = spec.destination}, map,
        surface.map->coverage()));
  }
  return transfer::age_surface(history, surface, std::move(pairs), {.transfer = options}, run);
}

}  // namespace patinate
