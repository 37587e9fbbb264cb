#include "capture/ingest/ingest.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/error.h"
#include "libcommon/core/hash.h"
#include "libcommon/image/color.h"
#include "libcommon/image/filters.h"
#include "libcommon/image/image_io.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// Raised whenever the same input gives other output.
constexpr std::int64_t kStageVersion = 1;
constexpr const char* kProgressName = "progress";

struct IngestWork {
  CaptureProject project;
  IngestOptions options;
  std::vector<std::string> photo_keys;  ///< Content of every frame's photograph.
  std::string key;
  bool has_progress = false;

  [[nodiscard]] HistoryManifest manifest() const {
    HistoryManifest m;
    m.name = project.name;
    m.origin = "captured";
    m.width = project.width();
    m.height = project.height();
    if (project.texel_size_mm) m.texel_size_mm = *project.texel_size_mm * project.roi.width / project.width();
    m.time_unit = project.time_unit;
    m.key = key;
    return m;
  }
};

/// What a frame depends on besides its photograph.
void add_development(ContentHash& hash, const CaptureProject& project) {
  hash.add(kStageVersion).add(project.response.text());
  for (int v : {project.roi.x, project.roi.y, project.roi.width, project.roi.height}) hash.add(std::int64_t{v});
  hash.add(project.scale);
}

std::string frame_key(const IngestWork& work, std::size_t index) {
  ContentHash hash;
  hash.add("ingest frame").add(work.photo_keys[index]);
  add_development(hash, work.project);
  return hash.hex();
}

std::string content_key(const IngestWork& work) {
  const CaptureProject& project = work.project;
  ContentHash hash;
  hash.add("ingest").add(project.name).add(time_unit_text(project.time_unit)).add(project.texel_size_mm.value_or(0.0));
  add_development(hash, project);
  hash.add(static_cast<std::int64_t>(project.frames.size()));
  for (std::size_t i = 0; i < project.frames.size(); ++i) hash.add(project.frames[i].time).add(work.photo_keys[i]);
  hash.add(project.mask ? "mask" : "no mask");
  if (project.mask) hash.add_file(*project.mask);
  hash.add(static_cast<std::int64_t>(project.controls.size()));
  for (const GivenControl& c : project.controls) hash.add(c.name).add(c.unit).add_file(c.file);
  const auto add_options = [&](const auto& values) {
    for (const auto& [name, value] : values) hash.add(name).add(value);
  };
  if (project.transmission) {
    hash.add("transmission").add_file(project.transmission->photo);
    if (project.transmission->blank) hash.add_file(*project.transmission->blank);
    add_options(option_values(work.options.thickness));
  }
  if (work.has_progress) {
    hash.add(kProgressName);
    add_options(option_values(work.options.progress));
  }
  return hash.hex();
}

void write_given_control(HistoryWriter& writer, const CaptureProject& project, const GivenControl& given,
                         const ImageU8& mask) {
  const ImageF values = to_history_size(read_gray(given.file), project, given.file);
  const Percentiles range = percentiles(values, mask, 0.0, 1.0);
  writer.write_control(given.name, values, static_cast<double>(range.low), static_cast<double>(range.high), given.unit);
}

/// Brightness of a photograph, H x W x 1.
ImageF read_light(const CaptureProject& project, const fs::path& file) {
  const ImageF color = read_photo(project, file);
  ImageF light(color.width(), color.height());
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) light.at(x, y) = luminance(color.pixel(x, y));
  }
  return light;
}

void write_thickness(HistoryWriter& writer, const IngestWork& work, const ImageU8& mask, const RunControl& control) {
  const TransmissionPhotos& photos = *work.project.transmission;
  const ImageF photo = read_light(work.project, photos.photo);
  const ImageF blank = photos.blank ? read_light(work.project, *photos.blank) : ImageF();
  try {
    const ThicknessMap map = thickness_from_transmission(photo, blank, mask, work.options.thickness, control);
    writer.write_control("thickness", map.values, map.low, map.high, "relative");
  } catch (const InvalidInput& e) {
    throw IoError(photos.photo.string(), e.what());
  }
}

/// From the frames that the items have written.
void write_progress(HistoryWriter& writer, const IngestWork& work, const fs::path& folder, const ImageU8& mask,
                    const RunControl& control) {
  std::vector<double> times;
  for (const CapturePhoto& frame : work.project.frames) times.push_back(frame.time);
  const auto read_frame = [&](int i) { return read_color(folder / HistoryWriter::frame_file(i)); };
  const ProgressMap map = progress_from_history(times, read_frame, mask, work.options.progress, control);
  writer.write_control(kProgressName, map.values, map.low, map.high, "relative");
}

void join(const IngestWork& work, const fs::path& folder, const RunControl& control) {
  HistoryWriter writer(folder, work.manifest());
  for (std::size_t i = 0; i < work.project.frames.size(); ++i) {
    writer.add_written_frame(static_cast<int>(i), work.project.frames[i].time);
  }
  const ImageU8 mask = read_capture_mask(work.project, control.part(0.0, 0.2));
  if (!mask.empty()) writer.write_mask(mask);
  for (const GivenControl& given : work.project.controls) write_given_control(writer, work.project, given, mask);
  if (work.project.transmission) write_thickness(writer, work, mask, control.part(0.2, 0.4));
  if (work.has_progress) write_progress(writer, work, folder, mask, control.part(0.4, 1.0));
  writer.finish();
  control.report(1.0);
}

JobItem frame_item(const std::shared_ptr<const IngestWork>& work, int index) {
  const fs::path file = HistoryWriter::frame_file(index);
  JobItem item{.name = "frame-" + file.stem().string(),
               .outputs = {file},
               .run = {},
               .key = frame_key(*work, static_cast<std::size_t>(index))};
  item.run = [work, index](const fs::path& folder, const RunControl& control) {
    const CapturePhoto& frame = work->project.frames[static_cast<std::size_t>(index)];
    const ImageF color = read_photo(work->project, frame.file);
    HistoryWriter(folder, work->manifest()).write_frame(index, frame.time, color);
    control.report(1.0);
  };
  return item;
}

}  // namespace

void describe(OptionVisitor& v, IngestOptions& o) {
  v.visit({"progress", "Make the `progress` control (how early each pixel ages) also beside measured controls"}, o.add_progress);
  describe(v, o.thickness);
  describe(v, o.progress);
}

JobPlan plan_ingest(const CaptureProject& project, const IngestOptions& options, const fs::path& output) {
  check_ranges(options);
  auto work = std::make_shared<IngestWork>(IngestWork{project, options, {}, "", options.add_progress});
  const bool is_measured = project.transmission || !project.controls.empty();
  if (!is_measured && project.frames.size() > 1) work->has_progress = true;
  const bool is_progress_given = std::any_of(project.controls.begin(), project.controls.end(),
                                             [](const GivenControl& c) { return c.name == kProgressName; });
  if (work->has_progress && is_progress_given) {
    throw InvalidInput(project.file.string() +
                       ": a control `progress` is given and another one asked for; rename the given one");
  }
  for (const CapturePhoto& frame : project.frames) work->photo_keys.push_back(hash_file(frame.file));
  work->key = content_key(*work);
  JobPlan plan;
  plan.output = output;
  plan.manifest = kHistoryManifestFile;
  plan.key = work->key;
  for (std::size_t i = 0; i < project.frames.size(); ++i) plan.items.push_back(frame_item(work, static_cast<int>(i)));
  plan.join = [work](const fs::path& folder, const RunControl& control) { join(*work, folder, control); };
  return plan;
}

}  // namespace patinate
