#include "patinate/history/memory_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/history/history_times.h"
#include "libcommon/history/material_range.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// Checks the history that is built: what messages begin with, and its size.
class Checker {
 public:
  Checker(std::string label, int width, int height) : label_(std::move(label)), width_(width), height_(height) {}
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  [[noreturn]] void fail(const std::string& what, const std::string& problem) const {
    throw InvalidInput(label_ + ": " + what + (what.empty() ? "" : " ") + problem);
  }

  template <class T>
  void size(const std::string& what, const Image<T>& image, int channels) const {
    if (image.width() == width_ && image.height() == height_ && image.channels() == channels) return;
    fail(what, "is " + size_text(image.width(), image.height()) + " with " + std::to_string(image.channels()) +
                   " channels; expected " + size_text(width_, height_) + " with " + std::to_string(channels));
  }
  void finite(const std::string& what, const ImageF& image) const {
    for (float v : image.values()) {
      if (!std::isfinite(v)) fail(what, "holds " + number_text(static_cast<double>(v)) + "; expected finite values");
    }
  }
  void named(const std::string& of, const std::vector<NamedImage>& images,
             const std::vector<std::string>& (&channels)(const std::string&)) const {
    for (std::size_t i = 0; i < images.size(); ++i) {
      const NamedImage& image = images[i];
      const std::string what = of + "`" + image.name + "`";
      size(what, image.image, num_channels(image.name, channels));
      finite(what, image.image);
      if (const auto problem = find_material_problem(image.name, image.image)) fail(what, *problem);
      if (i > 0 && images[i - 1].name == image.name) fail(what, "is given twice; names must differ");
    }
  }

 private:
  [[nodiscard]] int num_channels(const std::string& name,
                                 const std::vector<std::string>& (&channels)(const std::string&)) const try {
    return static_cast<int>(channels(name).size());
  } catch (const InvalidInput& e) {
    throw InvalidInput(label_ + ": " + e.what());
  }

  std::string label_;
  int width_, height_;
};

/// 0 / 255.
void make_codes(ImageU8& mask) {
  for (std::uint8_t& m : mask.values()) m = m != 0 ? 255 : 0;
}

/// In the order that files have them.
template <std::size_t kCount>
void sort_by_name(std::vector<NamedImage>& images, const std::array<std::string_view, kCount>& order) {
  const auto place = [&](const NamedImage& image) {
    return std::find(order.begin(), order.end(), image.name) - order.begin();
  };
  std::stable_sort(images.begin(), images.end(),
                   [&](const NamedImage& a, const NamedImage& b) { return place(a) < place(b); });
}

void check_frames(const Checker& check, const std::vector<MemoryFrame>& frames) {
  std::vector<double> times;
  for (const MemoryFrame& frame : frames) times.push_back(frame.time);
  if (const auto problem = find_time_problem(times))
    check.fail("frame " + std::to_string(problem->index) + ":", problem->text);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const MemoryFrame& frame = frames[i];
    const std::string what = "frame " + std::to_string(i);
    check.size(what, frame.color, 3);
    check.finite(what, frame.color);
    if (!frame.mask.empty()) check.size("mask of " + what, frame.mask, 1);
    check.named(what + ": ", frame.extras, frame_extra_channels);
  }
}

void check_controls(const Checker& check, const std::vector<MemoryControl>& controls) {
  for (std::size_t i = 0; i < controls.size(); ++i) {
    const ControlFacts& facts = controls[i].facts;
    const std::string what = "control `" + facts.name + "`";
    if (!is_file_name(facts.name))
      check.fail("control " + std::to_string(i),
                 "has the name `" + facts.name + "`; names consist of " + file_name_text());
    if (std::any_of(controls.begin(), controls.begin() + static_cast<std::ptrdiff_t>(i),
                    [&](const MemoryControl& c) { return c.facts.name == facts.name; }))
      check.fail(what, "is given twice; names must differ");
    if (!(facts.low <= facts.high && facts.low >= -kLargestControl && facts.high <= kLargestControl)) {
      check.fail(what, "has the range [" + number_text(facts.low) + ", " + number_text(facts.high) +
                           "]; expected low <= high, both within -1e30 and 1e30");
    }
    check.size(what, controls[i].values, 1);
    for (float v : controls[i].values.values()) {
      if (!(v >= 0.0f && v <= 1.0f))
        check.fail(what, "holds " + number_text(static_cast<double>(v)) +
                             "; a control is normalized to [0, 1], with its range for physical values");
    }
    if (controls[i].deviation.empty()) continue;
    check.size("deviation of " + what, controls[i].deviation, 1);
    for (float v : controls[i].deviation.values()) {
      if (!(v >= 0.0f && std::isfinite(v)))
        check.fail("deviation of " + what,
                   "holds " + number_text(static_cast<double>(v)) + "; expected finite values, >= 0");
    }
  }
}

void check_images(const Checker& check, const MemoryHistoryImages& images) {
  if (std::find(kHistoryOriginNames.begin(), kHistoryOriginNames.end(), images.origin) == kHistoryOriginNames.end()) {
    check.fail("", "has the unknown origin `" + images.origin + "`; use captured, simulated or synthetic");
  }
  if (check.width() < 1 || check.height() < 1 || check.width() > kMaxHistorySide_px ||
      check.height() > kMaxHistorySide_px) {
    check.fail("", "a size of " + size_text(check.width(), check.height()) + " is out of range; use 1 to " +
                       std::to_string(kMaxHistorySide_px));
  }
  if (images.texel_size_mm && !(*images.texel_size_mm >= kMinTexel_mm && *images.texel_size_mm <= kLargestTexel_mm))
    check.fail("", "texel_size_mm must be within 1e-9 and 1e9");
  check_frames(check, images.frames);
  check_controls(check, images.controls);
  check.named("map ", images.maps, history_map_channels);
  if (images.mask.empty()) return;
  check.size("mask", images.mask, 1);
  const auto values = images.mask.values();
  if (std::all_of(values.begin(), values.end(), [](std::uint8_t v) { return v == 0; }))
    check.fail("mask", "is 0 everywhere; a mask must leave something inside (not 0)");
}

HistoryFacts facts_in_memory(const MemoryHistoryImages& images) {
  HistoryFacts facts{.name = images.name,
                     .origin = images.origin,
                     .width = images.frames[0].color.width(),
                     .height = images.frames[0].color.height(),
                     .texel_size_mm = images.texel_size_mm,
                     .time_unit = images.time_unit,
                     .frames = {},
                     .controls = {},
                     .has_mask = !images.mask.empty(),
                     .maps = {},
                     .parts = images.parts,
                     .warnings = images.warnings};
  for (const MemoryFrame& f : images.frames) {
    FrameFacts frame{.time = f.time, .has_mask = !f.mask.empty(), .extras = {}, .is_extrapolated = f.is_extrapolated};
    for (const NamedImage& extra : f.extras) frame.extras.push_back(extra.name);
    facts.frames.push_back(std::move(frame));
  }
  for (const MemoryControl& c : images.controls) {
    facts.controls.push_back(c.facts);
    facts.controls.back().has_deviation = !c.deviation.empty();
  }
  for (const NamedImage& map : images.maps) facts.maps.push_back(map.name);
  return facts;
}

}  // namespace

MemoryHistory::MemoryHistory(MemoryHistoryImages images)
    : images_(std::move(images)), label_("history " + images_.name) {
  if (images_.frames.empty()) throw InvalidInput(label_ + ": has no frames; give at least one");
  sort_by_name(images_.maps, kHistoryMapNames);
  make_codes(images_.mask);
  for (MemoryFrame& frame : images_.frames) {
    sort_by_name(frame.extras, kFrameExtraNames);
    make_codes(frame.mask);
  }
  check_images(Checker(label_, images_.frames[0].color.width(), images_.frames[0].color.height()), images_);
  facts_ = facts_in_memory(images_);
  try {
    check_material_maps(facts_);
    check_library_parts(facts_);
  } catch (const InvalidInput& e) {
    throw InvalidInput(label_ + ": " + e.what());
  }
}

MemoryHistory read_into_memory(const History& history, const RunControl& control) {
  const HistoryFacts& facts = history.facts();
  MemoryHistoryImages images{.name = facts.name,
                             .origin = facts.origin,
                             .texel_size_mm = facts.texel_size_mm,
                             .time_unit = facts.time_unit,
                             .frames = {},
                             .controls = {},
                             .mask = {},
                             .maps = {},
                             .parts = facts.parts,
                             .warnings = facts.warnings};
  for (int i = 0; i < history.num_frames(); ++i) {
    control.throw_if_stopped();
    const FrameFacts& f = facts.frames[i];
    MemoryFrame frame{
        .time = f.time, .color = history.read_frame(i), .mask = {}, .extras = {}, .is_extrapolated = f.is_extrapolated};
    if (f.has_mask) frame.mask = history.read_frame_mask(i);
    for (const std::string& name : f.extras) frame.extras.push_back({name, *history.read_frame_extra(i, name)});
    images.frames.push_back(std::move(frame));
    control.report(static_cast<double>(i + 1) / history.num_frames());
  }
  for (const ControlFacts& c : facts.controls) {
    images.controls.push_back(
        {c, history.read_control(c.name), history.read_control_deviation(c.name).value_or(ImageF())});
  }
  if (facts.has_mask) images.mask = history.read_mask();
  for (const std::string& name : facts.maps) images.maps.push_back({name, history.read_map(name)});
  return MemoryHistory(std::move(images));
}

}  // namespace patinate
