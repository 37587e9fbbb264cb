#include "transfer/library/library_job.h"

#include <algorithm>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <utility>

#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer_io.h"
#include "transfer/library/library_images.h"

namespace patinate::transfer {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 1;  ///< Raised when the same input gives another library.

JobInputs library_inputs(const OpenLibrary& library) {
  JobInputs inputs("combine", kStageVersion);
  for (const LibrarySource& source : library.sources) inputs.add_content("history", source.manifest.name, source.key);
  for (const LibraryControl& control : library.task.controls) {
    std::string sources;
    for (const std::string& source : control.sources) sources += (sources.empty() ? "" : ",") + source;
    inputs.add_value("--control " + control.name, sources);
  }
  inputs.add_options(option_values(library.task.options));
  return inputs;
}

/// A frame of any history has a mask of its own: then so have all of the library, so that a plan knows its files.
bool has_frame_masks(const OpenLibrary& library) {
  return std::any_of(library.sources.begin(), library.sources.end(), [](const LibrarySource& source) {
    return std::any_of(source.manifest.frames.begin(), source.manifest.frames.end(),
                       [](const HistoryFrame& f) { return f.mask.has_value(); });
  });
}

/// Runs what holds a whole frame of the library. @throws CannotComplete saying how large it is
template <class Work>
void in_memory(const OpenLibrary& library, const Work& work) {
  const LibraryLayout& layout = library.layout;
  const auto too_large = [&] {
    return CannotComplete("side by side the histories are " + size_text(layout.width, layout.height) + " pixels" +
                          (layout.texel_size_mm ? " of " + number_text(*layout.texel_size_mm) + " mm" : "") +
                          ", which do not fit into memory; give a larger --texel-size");
  };
  try {
    work();
  } catch (const std::bad_alloc&) {
    throw too_large();
  } catch (const std::length_error&) {
    throw too_large();
  }
}

void make_frame(const OpenLibrary& library, int index, const fs::path& folder) {
  const LibraryFrame& frame = library.layout.frames[index];
  write_exr(folder / HistoryWriter::frame_file(index), library_frame(library.layout, library.readers, frame),
            {"R", "G", "B"}, ExrDepth::Half);
  for (const std::string& name : library_extras(library.readers)) {
    HistoryWriter::write_frame_extra(folder, index, name, library_extra(library.layout, library.readers, frame, name));
  }
  if (!has_frame_masks(library)) return;
  write_codes(folder / HistoryWriter::frame_mask_file(index),
              library_frame_mask(library.layout, library.readers, frame));
}

JobItem frame_item(const std::shared_ptr<const OpenLibrary>& library, int index) {
  JobItem item{.name = "frame." + std::to_string(index), .outputs = {HistoryWriter::frame_file(index)}, .run = {}};
  if (has_frame_masks(*library)) item.outputs.push_back(HistoryWriter::frame_mask_file(index));
  for (const std::string& name : library_extras(library->readers))
    item.outputs.push_back(HistoryWriter::frame_extra_file(index, name));
  item.run = [library, index](const fs::path& folder, const RunControl&) {
    in_memory(*library, [&] { make_frame(*library, index, folder); });
  };
  return item;
}

/// By index: those of the layout, then the one that says which history a pixel belongs to.
ControlParameter control_parameter(const OpenLibrary& library, std::size_t index) {
  if (index < library.layout.controls.size()) {
    const LibraryControl& c = library.layout.controls[index];
    return {.name = c.name, .file = HistoryWriter::control_file(c.name), .low = c.low, .high = c.high, .unit = c.unit};
  }
  return {.name = kLibraryControl,
          .file = HistoryWriter::control_file(kLibraryControl),
          .low = 0.0,
          .high = static_cast<double>(library.sources.size() - 1),
          .unit = kLibraryControlUnit};
}

void make_control(const OpenLibrary& library, std::size_t index, const fs::path& folder) {
  const ControlParameter parameter = control_parameter(library, index);
  ImageF values;
  if (index < library.layout.controls.size()) {
    values = library_control(library.layout, library.readers, library.layout.controls[index]);
  } else {
    values = library_index_image(library.layout);
    for (float& v : values.values()) v /= static_cast<float>(parameter.high);
  }
  write_scaled_exr(folder / parameter.file, values, {parameter.low, parameter.high, parameter.unit});
}

void make_mask(const OpenLibrary& library, const fs::path& folder) {
  std::vector<ImageU8> masks;
  for (const HistoryReader& reader : library.readers) masks.push_back(reader.read_mask());
  write_codes(folder / HistoryWriter::mask_file(), lay_masks_side_by_side(library.layout, masks));
}

HistoryManifest manifest_of(const OpenLibrary& library, const std::string& key) {
  const LibraryLayout& layout = library.layout;
  HistoryManifest m;
  m.origin = library.sources.front().manifest.origin;
  for (const LibrarySource& source : library.sources) {
    m.name += (m.name.empty() ? "" : " + ") + source.manifest.name;
    for (HistoryWarning warning : source.manifest.warnings) {
      warning.text = source.manifest.name + ": " + warning.text;
      m.warnings.push_back(std::move(warning));
    }
    if (source.manifest.origin != m.origin)
      m.origin = "synthetic";  // Histories of different origin are synthetic as a whole.
  }
  sort_warnings(m.warnings);
  m.width = layout.width;
  m.height = layout.height;
  m.texel_size_mm = layout.texel_size_mm;
  m.time_unit = layout.time_unit;
  const std::vector<std::string> extras = library_extras(library.readers);
  for (int i = 0; i < static_cast<int>(layout.frames.size()); ++i) {
    const LibraryFrame& made = layout.frames[i];
    HistoryFrame frame{
        .time = made.time, .file = HistoryWriter::frame_file(i), .mask = {}, .extras = {}, .is_extrapolated = false};
    if (has_frame_masks(library)) frame.mask = HistoryWriter::frame_mask_file(i);
    for (const std::string& name : extras) frame.extras.push_back({name, HistoryWriter::frame_extra_file(i, name)});
    for (std::size_t p = 0; p < library.sources.size(); ++p) {
      const auto& frames = library.sources[p].manifest.frames;
      const auto first = static_cast<std::size_t>(made.at[p].index);
      frame.is_extrapolated = frame.is_extrapolated || frames[first].is_extrapolated ||
                              (made.at[p].fraction != 0.0 && frames[first + 1].is_extrapolated);
    }
    m.frames.push_back(std::move(frame));
  }
  for (std::size_t c = 0; c <= layout.controls.size(); ++c) m.controls.push_back(control_parameter(library, c));
  m.mask = HistoryWriter::mask_file();
  m.key = key;
  m.parts = layout.parts;
  return m;
}

}  // namespace

std::shared_ptr<const OpenLibrary> open_library(LibraryTask task) {
  auto library = std::make_shared<OpenLibrary>();
  for (const fs::path& path : task.histories) {
    library->readers.emplace_back(path);
    library->sources.push_back({.manifest = library->readers.back().manifest(),
                                .shown = path.string(),
                                .key = history_content_key(library->readers.back()),
                                .is_library = !library->readers.back().facts().parts.empty()});
  }
  library->layout = lay_out_library(library->sources, task.controls, task.options);
  library->task = std::move(task);
  return library;
}

JobPlan plan_library(const std::shared_ptr<const OpenLibrary>& library, const fs::path& output) {
  JobPlan plan = library_inputs(*library).plan(output, kHistoryManifestFile);
  for (int i = 0; i < static_cast<int>(library->layout.frames.size()); ++i) {
    plan.items.push_back(frame_item(library, i));
  }
  for (std::size_t c = 0; c <= library->layout.controls.size(); ++c) {
    const ControlParameter parameter = control_parameter(*library, c);
    plan.items.push_back({.name = "control." + parameter.name,
                          .outputs = {parameter.file},
                          .run = [library, c](const fs::path& folder, const RunControl&) {
                            in_memory(*library, [&] { make_control(*library, c, folder); });
                          }});
  }
  plan.items.push_back({.name = "mask",
                        .outputs = {HistoryWriter::mask_file()},
                        .run = [library](const fs::path& folder, const RunControl&) {
                          in_memory(*library, [&] { make_mask(*library, folder); });
                        }});
  plan.join = [library, key = plan.key](const fs::path& folder, const RunControl&) {
    write_history_manifest(folder / kHistoryManifestFile, manifest_of(*library, key));
  };
  return plan;
}

}  // namespace patinate::transfer
