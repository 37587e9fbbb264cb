#include "transfer/library/library_layout.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/history/history_times.h"
#include "patinate/core/error.h"

namespace patinate::transfer {

void describe(OptionVisitor& v, LibraryOptions& o) {
  v.visit_choice(
      {"clock", "Combine equal times, or equal shares of each history's span (times are then those of the first)"},
      o.clock, kLibraryClockNames);
  v.visit({"texel_size", "Pixel size of the library, and of histories without one; default: the finest", "mm",
           between(kMinTexel_mm, kLargestTexel_mm)},
          o.texel_size_mm);
}

namespace {

void check_sources(std::span<const LibrarySource> sources) {
  if (sources.size() < 2) throw InvalidInput("a library is made of at least two histories");
  if (sources.size() > kMaxLibraryParts)
    throw InvalidInput("a library holds at most " + std::to_string(kMaxLibraryParts) + " histories");
  for (const LibrarySource& source : sources) {
    if (source.is_library)
      throw InvalidInput(source.shown + ": is a library already; give the histories that it was made of");
    for (const ControlParameter& c : source.manifest.controls) {
      if (c.name == kLibraryControl)
        throw InvalidInput(source.shown + ": has a control named `" + c.name +
                           "`, which says in a library what a pixel belongs to; rename it");
    }
  }
}

std::optional<double> common_texel_size(std::span<const LibrarySource> sources, const std::optional<double>& asked) {
  if (asked) return asked;
  const LibrarySource *with = nullptr, *without = nullptr;
  std::optional<double> finest;
  for (const LibrarySource& source : sources) {
    const std::optional<double>& size = source.manifest.texel_size_mm;
    (size ? with : without) = &source;
    if (size) finest = std::min(*size, finest.value_or(*size));
  }
  if (with != nullptr && without != nullptr) {
    throw InvalidInput(without->shown + ": has no texel_size_mm, but " + with->shown + " has one (" +
                       number_text(*with->manifest.texel_size_mm) +
                       "); give --texel-size, and histories that have none are assumed to have that size");
  }
  return finest;
}

/// Pixels along a side of `size` pixels of `from_mm` when they become `to_mm` large.
int resampled_size(const LibrarySource& source, int size, double from_mm, double to_mm) {
  const double resampled = std::round(size * from_mm / to_mm);
  if (!(resampled >= 1.0 && resampled <= 65536.0)) {
    throw InvalidInput(source.shown + ": has pixels of " + number_text(from_mm) + " mm; at " + number_text(to_mm) +
                       " mm it would be " + short_number_text(resampled) +
                       " pixels long; use 1 to 65536 (--texel-size)");
  }
  return static_cast<int>(resampled);
}

void place_parts(std::span<const LibrarySource> sources, LibraryLayout& layout) {
  std::int64_t end = 0;
  for (const LibrarySource& source : sources) {
    const HistoryManifest& m = source.manifest;
    LibraryPart part{.name = m.name, .x = 0, .width = m.width, .height = m.height, .key = source.key};
    if (layout.texel_size_mm && m.texel_size_mm) {
      part.width = resampled_size(source, m.width, *m.texel_size_mm, *layout.texel_size_mm);
      part.height = resampled_size(source, m.height, *m.texel_size_mm, *layout.texel_size_mm);
    }
    if (part.width != m.width || part.height != m.height) {
      layout.notes.push_back(source.shown + ": resampled from " + short_number_text(*m.texel_size_mm) + " to " +
                             short_number_text(*layout.texel_size_mm) + " mm a pixel, " +
                             size_text(part.width, part.height));
    }
    if (end > 0) end = (end + 2 * kLibraryGutter_px - 1) / kLibraryGutter_px * kLibraryGutter_px;
    if (end + part.width > 65536)
      throw InvalidInput(
          source.shown +
          ": side by side the histories would be more than 65536 pixels wide; scale them down, or leave some out");
    part.x = static_cast<int>(end);
    end += part.width;
    layout.height = std::max(layout.height, part.height);
    layout.parts.push_back(std::move(part));
  }
  layout.width = static_cast<int>(end);
  if (end * layout.height > std::numeric_limits<std::int32_t>::max()) {
    throw InvalidInput("side by side the histories would have " + size_text(layout.width, layout.height) +
                       " pixels, more than 2^31 - 1; scale them down");
  }
}

/// A history's times on the library's clock.
std::vector<double> library_times(const HistoryManifest& m, const HistoryManifest& first, LibraryClock clock) {
  std::vector<double> times;
  for (const HistoryFrame& frame : m.frames) times.push_back(frame.time);
  const double begin = times.front(), length = times.back() - begin;
  const double first_begin = first.frames.front().time, first_length = first.frames.back().time - first_begin;
  const auto mapped = [&](double t) {
    if (clock == LibraryClock::Span)
      return length > 0.0 ? first_begin + (t - begin) / length * first_length : first_begin;
    return t * seconds_per(m.time_unit) / seconds_per(first.time_unit);
  };
  if (clock == LibraryClock::Span ? begin == first_begin && length == first_length : m.time_unit == first.time_unit)
    return times;
  std::vector<double> plain;
  for (double& t : times) {
    t = mapped(t);
    plain.push_back(rounded(t, 12));
  }
  // Frames that are nearer to each other than that keep all digits.
  const bool are_apart =
      std::adjacent_find(plain.begin(), plain.end(), [](double a, double b) { return !(a < b); }) == plain.end();
  return are_apart ? plain : times;
}

TimePosition locate_in(const std::vector<double>& times, double time) {
  const auto last = static_cast<int>(times.size()) - 1;
  if (time <= times.front()) return {0, 0.0};
  if (time >= times.back()) return {last, 0.0};
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  return {static_cast<int>(next - times.begin()) - 1, (time - *(next - 1)) / (*next - *(next - 1))};
}

void merge_times(std::span<const LibrarySource> sources, LibraryClock clock, LibraryLayout& layout) {
  const HistoryManifest& first = sources.front().manifest;
  if (clock == LibraryClock::Span && first.frames.size() < 2)
    throw InvalidInput(sources.front().shown +
                       ": has one frame, and so no span that others could be mapped onto; use --clock absolute");
  struct Own {
    double time;
    std::size_t part;
    int frame;
  };
  std::vector<std::vector<double>> times;
  std::vector<Own> all;
  for (std::size_t p = 0; p < sources.size(); ++p) {
    times.push_back(library_times(sources[p].manifest, first, clock));
    for (std::size_t i = 0; i < times[p].size(); ++i) all.push_back({times[p][i], p, static_cast<int>(i)});
  }
  std::sort(all.begin(), all.end(),
            [](const Own& a, const Own& b) { return a.time != b.time ? a.time < b.time : a.part < b.part; });
  const double tolerance = 1e-9 * (all.back().time - all.front().time);
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    std::vector<int> own(sources.size(), -1);
    for (end = begin; end < all.size() && all[end].time - all[begin].time <= tolerance && own[all[end].part] < 0; ++end)
      own[all[end].part] = all[end].frame;
    // The time is that of the earliest history that has a frame there: the first history's times stay as they are.
    const auto named = static_cast<std::size_t>(
        std::find_if(own.begin(), own.end(), [](int frame) { return frame >= 0; }) - own.begin());
    LibraryFrame frame{.time = times[named][own[named]], .at = {}};
    for (std::size_t p = 0; p < sources.size(); ++p)
      frame.at.push_back(own[p] >= 0 ? TimePosition{own[p], 0.0} : locate_in(times[p], frame.time));
    layout.frames.push_back(std::move(frame));
  }
  std::vector<double> merged;
  for (const LibraryFrame& frame : layout.frames) merged.push_back(frame.time);
  if (const auto problem = find_time_problem(merged)) {
    throw InvalidInput(sources.front().shown + ": together with the times of the others its library " + problem->text +
                       (clock == LibraryClock::Span ? "" : "; --clock span maps every span onto its own"));
  }
  for (std::size_t p = 0; p < sources.size(); ++p) {
    const double begin = layout.frames.front().time, end = layout.frames.back().time;
    const double shortfall = std::max(times[p].front() - begin, end - times[p].back());
    if (shortfall <= tolerance) continue;
    layout.notes.push_back(
        sources[p].shown + ": its frames are of " + short_number_text(times[p].front()) + " to " +
        short_number_text(times[p].back()) + " " + shown_time_unit(first.time_unit) +
        "; before and after it stays as it is then (--clock span maps its span onto that of the first)");
  }
}

const ControlParameter* find_control(const HistoryManifest& m, const std::string& name) {
  const auto found =
      std::find_if(m.controls.begin(), m.controls.end(), [&](const ControlParameter& c) { return c.name == name; });
  return found == m.controls.end() ? nullptr : &*found;
}

/// One range for all where the unit is one, else each its own.
void find_range(std::span<const LibrarySource> sources, LibraryControl& control, std::vector<std::string>& notes) {
  double low = 0.0, high = 0.0;
  std::string unit, units;
  for (std::size_t p = 0; p < sources.size(); ++p) {
    const ControlParameter* const c = find_control(sources[p].manifest, control.sources[p]);
    if (c == nullptr) {
      std::vector<std::string> names;
      std::string list;
      for (const ControlParameter& other : sources[p].manifest.controls) {
        names.push_back(other.name);
        list += (list.empty() ? "" : ", ") + other.name;
      }
      throw InvalidInput(sources[p].shown + ": has no control `" + control.sources[p] + "`; there " +
                         (list.empty() ? "are none" : "is: " + list) + did_you_mean(control.sources[p], names));
    }
    control.has_own_ranges = control.has_own_ranges || (p > 0 && c->unit != unit);
    units += (p == 0 ? "`" : ", `") + c->unit + "`";
    low = p == 0 ? c->low : std::min(low, c->low);
    high = p == 0 ? c->high : std::max(high, c->high);
    unit = c->unit;
  }
  if (control.has_own_ranges) {
    notes.push_back("control `" + control.name + "`: its units are " + units +
                    "; it becomes relative, 0 to 1 of each history's own range");
    return;
  }
  control.low = low;
  control.high = high;
  control.unit = unit;
}

void merge_controls(std::span<const LibrarySource> sources, const std::vector<LibraryControl>& asked,
                    LibraryLayout& layout) {
  std::vector<std::string> seen;
  for (const LibraryControl& control : asked) {
    (void)HistoryWriter::control_file(control.name);  // Says which names there can be.
    if (std::find(seen.begin(), seen.end(), control.name) != seen.end())
      throw InvalidInput("control `" + control.name + "`: is given twice; names must differ");
    seen.push_back(control.name);
    if (control.name == kLibraryControl)
      throw InvalidInput("control `" + control.name + "`: says in a library what a pixel belongs to; use another name");
    if (control.sources.size() != sources.size()) {
      throw InvalidInput("control `" + control.name + "`: names " + std::to_string(control.sources.size()) +
                         " controls for " + std::to_string(sources.size()) + " histories; give one each");
    }
    layout.controls.push_back(control);
  }
  for (const LibrarySource& source : sources) {
    for (const ControlParameter& c : source.manifest.controls) {
      if (std::find(seen.begin(), seen.end(), c.name) != seen.end()) continue;
      seen.push_back(c.name);
      const auto lacks = std::find_if(sources.begin(), sources.end(), [&](const LibrarySource& s) {
        return find_control(s.manifest, c.name) == nullptr;
      });
      if (lacks == sources.end()) {
        layout.controls.push_back({.name = c.name, .sources = std::vector<std::string>(sources.size(), c.name)});
      } else if (std::none_of(asked.begin(), asked.end(), [&](const LibraryControl& a) {
                   return std::find(a.sources.begin(), a.sources.end(), c.name) != a.sources.end();
                 })) {
        layout.notes.push_back("control `" + c.name + "` is excluded: " + lacks->shown +
                               " has none; --control NAME=A,B makes one of differently named controls");
      }
    }
  }
  for (LibraryControl& control : layout.controls) find_range(sources, control, layout.notes);
}

}  // namespace

LibraryLayout lay_out_library(std::span<const LibrarySource> sources, const std::vector<LibraryControl>& asked,
                              const LibraryOptions& options) {
  check_ranges(options);
  check_sources(sources);
  LibraryLayout layout;
  layout.texel_size_mm = common_texel_size(sources, options.texel_size_mm);
  layout.time_unit = sources.front().manifest.time_unit;
  place_parts(sources, layout);
  merge_times(sources, options.clock, layout);
  merge_controls(sources, asked, layout);
  return layout;
}

}  // namespace patinate::transfer
