#include <nlohmann/json.hpp>

#include "capture/calibration/calibrate.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

/// The first byte chooses the kind; photographs that are named do not exist.
PATINATE_FUZZ_TARGET(calibrate) {
  if (bytes.empty()) return;
  const auto kind = static_cast<capture::CalibrationKind>(bytes[0] % 4);
  const std::filesystem::path file = fuzz::fuzz_file("description.json", bytes.subspan(1));
  const Json content = load_json(file);
  const capture::CalibrationOutput output = capture::calibrate(kind, JsonReader(file.string(), content));
  for (const Light& light : output.lights)
    fuzz::require(light.position.allFinite() && light.direction.allFinite(), "lights stand somewhere");
}
