#include "capture/unlighting/material_json.h"

#include <nlohmann/json.hpp>

namespace patinate::capture {

Json to_json(const std::vector<SurfaceMaterial>& materials) {
  Json list = Json::array();
  for (const SurfaceMaterial& m : materials) {
    list.push_back({{"kind", std::string(name_of(m.kind))},
                    {"share", m.share},
                    {"roughness", m.roughness},
                    {"strength", {m.strength.x(), m.strength.y(), m.strength.z()}},
                    {"evidence", m.evidence}});
  }
  return list;
}

}  // namespace patinate::capture
