#include "patinate/history/trim_history.h"

#include <utility>

#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

std::string span_text(const HistoryManifest& history) {
  return short_number_text(history.frames.front().time) + " to " + short_number_text(history.frames.back().time) + " " +
         shown_time_unit(history.time_unit);
}

/// Its files under the names that frame `index` of a history has.
HistoryFrame renamed(HistoryFrame frame, int index, std::vector<TrimmedHistory::File>& files) {
  const auto take = [&](fs::path& file, const fs::path& name) { files.push_back({std::exchange(file, name), name}); };
  take(frame.file, HistoryWriter::frame_file(index));
  if (frame.mask) take(*frame.mask, HistoryWriter::frame_mask_file(index));
  for (HistoryImage& extra : frame.extras) take(extra.file, HistoryWriter::frame_extra_file(index, extra.name));
  if (frame.amounts) take(*frame.amounts, HistoryWriter::frame_amounts_file(index));
  return frame;
}

/// A damaged image is not passed on. @throws IoError naming it.
void require_whole_image(const fs::path& file) {
  if (file.extension() == ".exr" || file.extension() == ".png") (void)read_gray(file);
}

}  // namespace

void describe(OptionVisitor& v, TrimOptions& o) {
  v.visit({"from", "First time that stays, in the history's unit"}, o.from);
  v.visit({"until", "Last time that stays"}, o.until);
  v.visit({"every", "Keep every n-th of these frames, starting with the first", "", at_least(1)}, o.every);
}

TrimmedHistory trim_history(const HistoryManifest& history, const TrimOptions& options) {
  check_ranges(options);
  TrimmedHistory out{.manifest = history, .files = {}};
  out.manifest.frames.clear();
  int num_inside = 0;
  for (const HistoryFrame& frame : history.frames) {
    if ((options.from && frame.time < *options.from) || (options.until && frame.time > *options.until)) continue;
    if (num_inside++ % options.every != 0) continue;
    out.manifest.frames.push_back(renamed(frame, static_cast<int>(out.manifest.frames.size()), out.files));
  }
  if (out.manifest.frames.empty()) {
    throw InvalidInput("no frame is left: " + history.name + " covers " + span_text(history) +
                       "; give --from and --until within it");
  }
  const auto take = [&](fs::path& file, const fs::path& name) {
    out.files.push_back({std::exchange(file, name), name});
  };
  for (ControlParameter& control : out.manifest.controls) {
    take(control.file, HistoryWriter::control_file(control.name));
    if (control.deviation) take(*control.deviation, HistoryWriter::control_deviation_file(control.name));
  }
  for (HistoryMap& map : out.manifest.maps) take(map.file, HistoryWriter::map_file(map.name));
  if (out.manifest.mask) take(*out.manifest.mask, HistoryWriter::mask_file());
  return out;
}

void copy_history_files(const fs::path& from, const std::vector<TrimmedHistory::File>& files, const fs::path& to,
                        const RunControl& control) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    control.throw_if_stopped();
    fs::create_directories((to / files[i].to).parent_path());
    require_whole_image(from / files[i].from);
    fs::copy_file(from / files[i].from, to / files[i].to, fs::copy_options::overwrite_existing);
    control.report(static_cast<double>(i + 1) / static_cast<double>(files.size()));
  }
}

}  // namespace patinate
