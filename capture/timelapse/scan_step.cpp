#include "capture/timelapse/scan_step.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_key.h"
#include "libcommon/geometry/mesh_repair.h"
#include "libcommon/image/filters.h"
#include "patinate/controls/accessibility.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kScanVersion = 1;
constexpr const char* kCurvatureFile = "scan/curvature.exr";  ///< 1/mm, before it is normalized.
constexpr const char* kScanFile = "scan/scan.json";
constexpr const char* kMaps[] = {"position", "normal", "texel_size"};

PhotoPart photo_part(const CaptureProject& project) {
  const PixelRectangle& roi = project.roi;
  return {.x0 = static_cast<double>(roi.x),
          .y0 = static_cast<double>(roi.y),
          .width = static_cast<double>(roi.width),
          .height = static_cast<double>(roi.height),
          .num_columns = project.width(),
          .num_rows = project.height()};
}

[[noreturn]] void fail_unseen(const IngestWork& work, const std::string& what) {
  const ScanSource& scan = *work.project.scan;
  throw IoError(scan.mesh.string(),
                what + ": " + where_it_lies(*work.scan_mesh, scan.camera_mm) + "; check `unit` and the camera's pose");
}

std::string scan_item_key(const IngestWork& work) {
  ContentHash key;
  key.add("ingest scan").add(kScanVersion);
  key.add(work.scan_key).add(work.project.scan->camera_mm.text());
  const PhotoPart part = photo_part(work.project);
  for (double v : {part.x0, part.y0, part.width, part.height}) key.add(v);
  for (int v : {part.num_columns, part.num_rows}) key.add(std::int64_t{v});
  for (const auto& [name, value] : option_values(work.options.scan)) key.add(name).add(value);
  return key.hex();
}

/// For progress: core seconds.
double scan_weight(const IngestWork& work) {
  const double pixels = static_cast<double>(work.project.width()) * work.project.height();
  return 0.12 + 1.1e-6 * pixels + 6e-6 * static_cast<double>(work.scan_mesh->triangles.size());
}

void run_item(const IngestWork& work, const fs::path& folder, const RunControl& control) {
  const ScanMaps maps =
      scan_maps(*work.scan_mesh, work.project.scan->camera_mm, photo_part(work.project), work.options.scan, control);
  if (maps.num_seen == 0) fail_unseen(work, "the camera does not see the mesh");
  HistoryWriter::write_map(folder, "position", maps.position_mm);
  HistoryWriter::write_map(folder, "normal", maps.normal);
  HistoryWriter::write_map(folder, "texel_size", maps.texel_size_mm);
  fs::create_directories((folder / kCurvatureFile).parent_path());
  write_exr(folder / kCurvatureFile, maps.curvature_per_mm, {"Y"}, ExrDepth::Float);
  save_json(folder / kScanFile, Json{{"scale_mm", maps.scale_mm}, {"pixels", maps.num_seen}});
}

}  // namespace

void load_scan(IngestWork& work) {
  if (!work.project.scan) return;
  const ScanSource& scan = *work.project.scan;
  Mesh mesh = read_mesh(scan.mesh);
  try {
    mesh = repair_mesh(std::move(mesh)).mesh;
  } catch (const InvalidInput& e) {
    throw IoError(scan.mesh.string(), e.what());
  }
  scale_mesh(mesh, scan.mm_per_unit);
  work.scan_key = mesh_content_key(mesh);
  work.scan_mesh = std::make_shared<const Mesh>(std::move(mesh));
}

void add_scan_item(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work) {
  if (!work->project.scan) return;
  JobItem item{.name = "scan",
               .outputs = {kCurvatureFile, kScanFile},
               .run = {},
               .key = scan_item_key(*work),
               .weight = scan_weight(*work)};
  for (const char* name : kMaps) item.outputs.push_back(HistoryWriter::map_file(name));
  item.run = [work](const fs::path& folder, const RunControl& control) { run_item(*work, folder, control); };
  items.push_back(std::move(item));
}

void add_scan_inputs(JobInputs& inputs, const IngestWork& work) {
  if (!work.project.scan) return;
  const ScanSource& scan = *work.project.scan;
  inputs.add_value("version of scan", std::to_string(kScanVersion));
  inputs.add_value("scan " + scan.mesh.filename().string(), work.scan_key);
  inputs.add_value("camera of the scan", ContentHash().add(scan.camera_mm.text()).hex());
  inputs.add_value("unit", number_text(scan.mm_per_unit) + " mm");
  inputs.add_options(option_values(work.options.scan));
}

void keep_scanned(const IngestWork& work, const fs::path& folder, ImageU8& mask) {
  if (!work.project.scan) return;
  if (mask.empty()) mask = ImageU8(work.project.width(), work.project.height(), 1, 255);
  const ImageF texel_size = read_gray(folder / HistoryWriter::map_file("texel_size"));
  bool is_any_left = false;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (!(texel_size.data()[i] > 0.0f)) mask.data()[i] = 0;
    is_any_left = is_any_left || mask.data()[i] != 0;
  }
  if (!is_any_left) fail_unseen(work, "the camera sees nothing of the mesh inside the mask");
}

void write_scan(HistoryWriter& writer, const IngestWork& work, const fs::path& folder, const ImageU8& mask) {
  if (!work.project.scan) return;
  const AccessibilityOptions shares;
  const ImageF curvature = read_gray(folder / kCurvatureFile);
  const Percentiles found = percentiles(curvature, mask, shares.low_percent / 100.0, shares.high_percent / 100.0);
  const fs::path file = folder / kScanFile;
  const Json facts = load_json(file);
  const double scale = JsonReader(file.string(), facts).member("scale_mm").number(above(0));
  const ValueRange range =
      widened_accessibility_range({static_cast<double>(found.low), static_cast<double>(found.high)}, scale);
  writer.write_control(kScanControlName, curvature, range.low, range.high, "1/mm");
  for (const char* name : kMaps) writer.add_written_map(name);
  if (work.project.texel_size_mm) return;
  const ImageF texel_size = read_gray(folder / HistoryWriter::map_file("texel_size"));
  writer.set_texel_size_mm(static_cast<double>(percentiles(texel_size, mask, 0.5, 0.5).low));
}

}  // namespace patinate::capture
