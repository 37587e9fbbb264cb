#include "patinate/history/write_history.h"

#include <system_error>

#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"

namespace patinate {

namespace fs = std::filesystem;

void write_history_files(const fs::path& folder, const History& history, const std::string& key,
                         const RunControl& control) {
  const HistoryFacts& facts = history.facts();
  for (const char* part : {"frames", "controls", "masks", "maps"}) fs::create_directories(folder / part);
  HistoryWriter writer(folder, {.name = facts.name,
                                .origin = facts.origin,
                                .width = facts.width,
                                .height = facts.height,
                                .texel_size_mm = facts.texel_size_mm,
                                .time_unit = facts.time_unit,
                                .frames = {},
                                .controls = {},
                                .mask = {},
                                .maps = {},
                                .key = key,
                                .parts = facts.parts});
  for (const ControlFacts& c : facts.controls) {
    ControlParameter named{
        .name = c.name, .file = HistoryWriter::control_file(c.name), .low = c.low, .high = c.high, .unit = c.unit};
    write_scaled_exr(folder / named.file, history.read_control(c.name), {.low = c.low, .high = c.high, .unit = c.unit});
    if (const auto deviation = history.read_control_deviation(c.name)) {
      named.deviation = HistoryWriter::control_deviation_file(c.name);
      write_exr(folder / *named.deviation, *deviation, {"Y"}, ExrDepth::Float);
    }
    writer.add_written_control(named);
  }
  for (int i = 0; i < history.num_frames(); ++i) {
    control.throw_if_stopped();
    const FrameFacts& frame = facts.frames[i];
    writer.write_frame(i, frame.time, history.read_frame(i));
    if (frame.has_mask) {
      write_codes(folder / HistoryWriter::frame_mask_file(i), history.read_frame_mask(i));
      writer.add_written_frame_mask(i);
    }
    for (const std::string& extra : frame.extras) {
      fs::create_directories((folder / HistoryWriter::frame_extra_file(i, extra)).parent_path());
      HistoryWriter::write_frame_extra(folder, i, extra, *history.read_frame_extra(i, extra));
      writer.add_written_frame_extra(i, extra);
    }
    control.report(static_cast<double>(i + 1) / history.num_frames());
  }
  for (const std::string& map : facts.maps) {
    HistoryWriter::write_map(folder, map, history.read_map(map));
    writer.add_written_map(map);
  }
  if (facts.has_mask) writer.write_mask(history.read_mask());
  HistoryManifest manifest = writer.manifest();
  manifest.warnings = facts.warnings;
  manifest.sample = facts.sample;
  for (std::size_t i = 0; i < manifest.frames.size(); ++i)
    manifest.frames[i].is_extrapolated = facts.frames[i].is_extrapolated;
  write_history_manifest(folder / kHistoryManifestFile, manifest);
  for (const char* part : {"frames", "controls", "masks", "maps"}) {
    if (fs::is_empty(folder / part)) fs::remove(folder / part);
  }
}

void write_history(const fs::path& folder, const History& history, const RunControl& control, bool force) {
  const bool is_replaced = force && fs::exists(folder / "history.json");
  if (!is_replaced && fs::exists(folder) && !(fs::is_directory(folder) && fs::is_empty(folder)))
    throw CannotComplete(folder.string() + ": is there already" +
                         (fs::exists(folder / "history.json") ? "; --force replaces it" : ""));
  fs::path partial = folder.has_filename() ? folder : folder.parent_path();
  partial += ".partial";
  if (fs::exists(partial))
    throw CannotComplete(partial.string() + ": is there already, from a run that was interrupted");
  try {
    fs::create_directories(partial);
    write_history_files(partial, history, "", control);
    if (is_replaced) fs::remove_all(folder);
    fs::rename(partial, folder);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(partial, ignored);
    try {
      throw;
    } catch (const fs::filesystem_error& e) {
      throw CannotComplete(folder.string() + ": cannot be written (" + e.code().message() + ")");
    }
  }
}

}  // namespace patinate
