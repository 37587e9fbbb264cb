#include "capture/project/given_registration.h"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

RigidTransform matrix_of(const JsonReader& rows, double mm_per_unit) {
  const std::vector<JsonReader> all = rows.elements(4);
  if (all.size() != 4) rows.fail("four rows of four numbers");
  Eigen::Matrix4d matrix;
  for (Eigen::Index r = 0; r < 4; ++r) {
    const std::vector<double> row = all[r].numbers(4);
    for (Eigen::Index c = 0; c < 4; ++c) matrix(r, c) = row[c];
  }
  matrix.topRightCorner<3, 1>() *= mm_per_unit;
  try {
    return rigid_transform(matrix);
  } catch (const InvalidInput& e) {
    rows.fail(std::string("a rotation and a translation (") + e.what() + ")");
  }
}

const GivenScan* find_scan(const std::vector<GivenScan>& scans, const fs::path& file) {
  for (const GivenScan& scan : scans) {
    std::error_code error;
    if (!scan.path.empty() && fs::equivalent(scan.path, file, error)) return &scan;
  }
  const GivenScan* found = nullptr;
  const std::string whole = (file.parent_path().filename() / file.filename()).generic_string();
  for (const GivenScan& scan : scans) {
    if (scan.name != file.filename().string() && scan.name != whole) continue;
    if (found != nullptr) return nullptr;  // Two of the same name tell nothing.
    found = &scan;
  }
  return found;
}

}  // namespace

GivenScans read_given_scans(const fs::path& file, std::optional<double> mm_per_unit) {
  constexpr std::size_t kMaxScans = 100'000;
  const Json document = load_json(file);
  JsonReader json(file.string(), document);
  if (json.member("format").string() != "patinate.registration")
    json.member("format").fail("\"patinate.registration\", a registration.json that `register` wrote");
  GivenScans given;
  if (json.has("unit") && json.member("unit").is_string())
    mm_per_unit = find_mm_per_unit(json.member("unit").string()).value_or(mm_per_unit.value_or(1.0));
  if (!mm_per_unit) throw IoError(file.string(), "does not say the scans' length unit; give --unit um|mm|cm|m");
  given.mm_per_unit = *mm_per_unit;
  if (json.has("reference")) given.reference = json.member("reference").string();
  const JsonReader list = json.member("scans");
  for (JsonReader& entry : list.elements(kMaxScans)) {
    GivenScan scan{.name = entry.member("file").string(), .path = {}, .reference_from_scan = {}};
    if (entry.has("path")) scan.path = entry.member("path").path();
    if (entry.member("matrix").is_array())
      scan.reference_from_scan = matrix_of(entry.member("matrix"), given.mm_per_unit);
    given.scans.push_back(std::move(scan));
  }
  return given;
}

void apply_registration(const fs::path& file, RelitProject& project) {
  const std::vector<GivenScan> scans = read_given_scans(file, project.mm_per_unit).scans;
  const auto pose_of = [&](const RelitStep& step) {
    const GivenScan* scan = find_scan(scans, *step.scan);
    const std::string name = "steps/" + std::to_string(step.number);
    if (scan == nullptr) throw IoError(file.string(), "does not have the scan of " + name + ", " + step.scan->string());
    if (!scan->reference_from_scan)
      throw IoError(file.string(), "has no place for the scan of " + name + ", " + scan->name +
                                       "; give the step a `transform`, or \"exclude\": true");
    return *scan->reference_from_scan;
  };
  if (!project.steps[project.reference].scan) throw IoError(file.string(), "the reference step has no scan");
  const RigidTransform back = pose_of(project.steps[project.reference]).inverse();
  for (RelitStep& step : project.steps) {
    if (!step.scan || step.reference_from_scan) continue;
    if (step.number == project.steps[project.reference].number) continue;
    step.reference_from_scan = back * pose_of(step);
    step.is_from_registration = true;
  }
}

}  // namespace patinate::capture
