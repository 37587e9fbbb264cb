#include "capture/report/report_sections.h"

#include <algorithm>
#include <cmath>

#include "capture/project/photo_facts.h"
#include "libcommon/core/median.h"
#include "libcommon/core/printable.h"
#include "libcommon/core/text.h"
#include "libcommon/image/picture_bytes.h"
#include "libcommon/output/map_legend.h"
#include "libcommon/output/svg_chart.h"
#include "patinate/image/color.h"

namespace patinate::capture {

namespace {

namespace fs = std::filesystem;

constexpr int kThumbnailQuality = 82, kMapQuality = 90;  ///< JPEG quality.
using Rgb = std::array<float, 3>;
constexpr Rgb kOutOfViewColor{0.05f, 0.1f, 0.8f},
    kMaskedColor{0.8f, 0.0f, 0.6f};    // Colors as sample_state_color() has them.
constexpr float kMarked = 0.65f;       // How opaque a mark is: what lies below it can be seen.
constexpr float kMaskInside = 0.6f;    // Linear gray that stands out from the page.
constexpr float kOutsideLight = 0.3f;  // Factor that darkens the outside of the mask.

HtmlPicture small_picture(const ImageF& linear, const std::string& caption, int quality) {
  return {data_uri(jpeg_of(srgb8_from_linear(linear), quality), "image/jpeg"), caption};
}

bool is_named(const HistoryWarning& warning, const std::string& frame) {
  return std::find(warning.photos.begin(), warning.photos.end(), frame) != warning.photos.end();
}

/// "3, 7" of the warnings that name a frame, from 1.
std::string warning_numbers(const ReportSeries& series, std::size_t frame) {
  std::string text;
  for (std::size_t k = 0; k < series.warnings.size(); ++k) {
    if (is_named(series.warnings[k], series.names[frame])) text += (text.empty() ? "" : ", ") + std::to_string(k + 1);
  }
  return text;
}

std::string span_text(const PixelSpan& at) {
  return "x " + std::to_string(at.left) + " to " + std::to_string(at.right) + ", y " + std::to_string(at.top) + " to " +
         std::to_string(at.bottom);
}

/// Where what the frames of a warning mask lies; "" where they mask nothing.
std::string masked_place(const ReportSeries& series, const std::vector<std::size_t>& frames) {
  std::optional<PixelSpan> all;
  for (const std::size_t i : frames) {
    const std::optional<PixelSpan>& at = series.look.frames[i].masked_at;
    if (!at) continue;
    if (!all) all = at;
    all = PixelSpan{std::min(all->left, at->left), std::max(all->right, at->right), std::min(all->top, at->top),
                    std::max(all->bottom, at->bottom)};
  }
  return all ? "; marked in the pictures, most of it at " + span_text(*all) + " px" : "";
}

/// Photographs with their times, and of a mask the part of the picture.
std::string place_text(const ReportSeries& series, const HistoryWarning& warning) {
  constexpr std::size_t kMost = 6;
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < series.names.size(); ++i) {
    if (is_named(warning, series.names[i])) frames.push_back(i);
  }
  std::string text;
  for (std::size_t k = 0; k < std::min(kMost, frames.size()); ++k)
    text += (k == 0 ? "" : ", ") + series.names[frames[k]] + " (" + time_text(series, frames[k]) + ")";
  if (frames.size() > kMost) text += " and " + std::to_string(frames.size() - kMost) + " more";
  if (frames.empty() && !warning.photos.empty()) text = "left out of the history";
  if (text.empty()) text = series.names.size() == 1 ? series.names.front() : "all " + series.one + "s";
  if (const auto place = series.places.find(warning.text); place != series.places.end()) text += "; " + place->second;
  if (warning.about == WarningSubject::Control) text += "; the map is below";
  if (warning.about != WarningSubject::Mask) return text;
  if (warning.photos.empty()) {
    for (std::size_t i = 0; i < series.names.size(); ++i) frames.push_back(i);
  }
  return text + masked_place(series, frames);
}

/// Factor of all thumbnails, so that light beyond white shows, and light far below it.
float shown_factor(const std::vector<ReportFrame>& frames) {
  constexpr double kHigh = 0.995;  // Rank of the value that pictures are scaled by.
  // Linear values: pictures beyond 1 or darker than a tenth are scaled for display alone.
  constexpr float kMinBeyond = 1.01f, kWhite = 0.9f, kDark = 0.1f, kShownDark = 0.5f;
  std::vector<float> values;
  for (const ReportFrame& frame : frames) {
    for (int y = 0; y < frame.thumbnail.height(); ++y) {
      for (int x = 0; x < frame.thumbnail.width(); ++x) {
        const auto pixel = frame.thumbnail.pixel(x, y);
        if (frame.marks.at(x, y, 0) < 0.5f) values.push_back(*std::max_element(pixel.begin(), pixel.end()));
      }
    }
  }
  if (values.empty()) return 1.0f;
  const float high = value_at_rank(values, static_cast<std::size_t>(kHigh * static_cast<double>(values.size() - 1)));
  return high > kMinBeyond ? kWhite / high : high > 0.0f && high < kDark ? kShownDark / high : 1.0f;
}

ImageF marked_thumbnail(const ReportFrame& frame, float factor) {
  ImageF picture = frame.thumbnail;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const auto marks = frame.marks.pixel(x, y);
      const float light = factor * (1.0f - (1.0f - kOutsideLight) * marks[0]);
      for (std::size_t c = 0; c < 3; ++c) {
        float& v = picture.at(x, y, static_cast<int>(c));
        v = std::min(1.0f, light * v) * (1.0f - kMarked * (marks[1] + marks[2]));
        v += kMarked * (marks[1] * kOutOfViewColor[c] + marks[2] * kMaskedColor[c]);
      }
    }
  }
  return picture;
}

std::optional<double> difference(const ReportSeries& series, std::size_t frame) {
  const auto &first = series.look.frames.front().lab, &now = series.look.frames[frame].lab;
  if (!first || !now) return std::nullopt;
  return std::hypot((*now)[0] - (*first)[0], (*now)[1] - (*first)[1], (*now)[2] - (*first)[2]);
}

std::vector<std::optional<double>> lab_values(const ReportSeries& series, std::size_t channel) {
  std::vector<std::optional<double>> values;
  for (const ReportFrame& frame : series.look.frames)
    values.push_back(frame.lab ? std::optional((*frame.lab)[channel]) : std::nullopt);
  return values;
}

ImageF mask_picture(const ImageU8& mask) {
  ImageF picture(mask.width(), mask.height(), 3);
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    for (int c = 0; c < 3; ++c) picture.data()[3 * i + c] = mask.data()[i] != 0 ? kMaskInside : 0.0f;
  }
  return reduced_to(picture, kReportMapSide_px);
}

double covered_share(const ImageU8& mask) {
  const auto num_inside = mask.num_pixels() - std::count(mask.values().begin(), mask.values().end(), 0);
  return static_cast<double>(num_inside) / static_cast<double>(mask.num_pixels());
}

std::string two_digits(double v) { return short_number_text(std::round(100.0 * v) / 100.0 + 0.0); }

}  // namespace

std::vector<bool> named_by_warnings(const ReportSeries& series) {
  std::vector<bool> named;
  for (std::size_t i = 0; i < series.names.size(); ++i) named.push_back(!warning_numbers(series, i).empty());
  return named;
}

std::string light_place(const ReportSeries& series) {
  constexpr std::array<const char*, 9> kNames{"upper left", "top",        "upper right", "left",       "middle",
                                              "right",      "lower left", "bottom",      "lower right"};
  std::array<double, 9> sums{}, counts{};
  for (const ReportFrame& frame : series.look.frames) {
    for (int y = 0; y < frame.thumbnail.height(); ++y) {
      for (int x = 0; x < frame.thumbnail.width(); ++x) {
        if (frame.marks.at(x, y, 0) >= 0.5f) continue;
        const auto k =
            static_cast<std::size_t>(3 * (3 * y / frame.thumbnail.height()) + 3 * x / frame.thumbnail.width());
        sums[k] += static_cast<double>(luminance(frame.thumbnail.pixel(x, y)));
        counts[k] += 1.0;
      }
    }
  }
  std::optional<std::size_t> bright, dark;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    if (counts[k] == 0.0) continue;
    const auto mean = [&](std::size_t i) { return sums[i] / counts[i]; };
    if (!bright || mean(k) > mean(*bright)) bright = k;
    if (!dark || mean(k) < mean(*dark)) dark = k;
  }
  if (!bright || bright == dark) return "";
  return std::string("brightest at the ") + kNames[*bright] + ", darkest at the " + kNames[*dark];
}

std::string time_text(const ReportSeries& series, std::size_t frame) {
  return series.time_labels[frame] + " " + series.unit;
}

void add_warnings(HtmlPage& page, const ReportSeries& series) {
  page.heading("Warnings");
  if (series.warnings.empty()) {
    page.paragraph("None.");
    return;
  }
  std::vector<std::vector<std::string>> rows;
  for (std::size_t k = 0; k < series.warnings.size(); ++k)
    rows.push_back({std::to_string(k + 1) + ". " + printable_line(warning_text(series.warnings[k])),
                    printable_line(place_text(series, series.warnings[k]))});
  page.table({"what was found, and what helps", "where"}, rows);
}

void add_color_curves(HtmlPage& page, const ReportSeries& series) {
  if (series.names.size() < 2) return;
  page.heading("Over time");
  page.paragraph(
      "The mean color inside the mask, without what a frame's own mask leaves out. A difference of 2.3 is "
      "just noticeable.");
  const auto add = [&](const std::string& title, const std::string& y_label, bool from_zero,
                       std::vector<ChartSeries> curves) {
    for (ChartSeries& curve : curves) curve.x = series.times;
    page.drawing(svg_chart({.title = title,
                            .x_label = "time (" + series.unit + ")",
                            .y_label = y_label,
                            .from_zero = from_zero,
                            .series = std::move(curves)}));
  };
  add("Brightness", "L*", false, {{.name = "L*", .y = lab_values(series, 0)}});
  add("Color", "a*, b*", false,
      {{.name = "a*", .y = lab_values(series, 1)}, {.name = "b*", .y = lab_values(series, 2)}});
  ChartSeries change{.name = "difference"}, masked{.name = "masked"};
  double most_masked = 0.0;
  for (std::size_t i = 0; i < series.names.size(); ++i) {
    change.y.push_back(difference(series, i));
    masked.y.push_back(100.0 * series.look.frames[i].masked_share);
    most_masked = std::max(most_masked, series.look.frames[i].masked_share);
  }
  add("Difference from the first " + series.one, "Delta E (CIE 1976)", true, {change});
  if (most_masked > 0.0) add("Masked in a " + series.one, "% of the picture", true, {masked});
}

void add_pictures(HtmlPage& page, const ReportSeries& series, const ImageU8& mask, int width, int height) {
  page.heading("Mask");
  const bool is_whole = mask.empty() || covered_share(mask) == 1.0;
  page.paragraph(is_whole ? "The whole picture is inside the mask."
                          : percent_text(covered_share(mask)) +
                                " of the picture are inside the mask. Nothing outside "
                                "of it is transferred.");
  std::vector<HtmlPicture> maps;
  if (!is_whole)
    maps.push_back(small_picture(mask_picture(mask), "The mask: black outside; " + size_text(width, height) + " pixels",
                                 kMapQuality));
  if (!series.look.masked.empty()) {
    const ImageF map = ramp_picture(series.look.masked, {}, 0.0, 1.0, ColorRamp::Sequential);
    maps.push_back(small_picture(with_legend(map, {.ramp = ColorRamp::Sequential, .high = 100.0, .unit = "%"}),
                                 "In how many " + series.one + "s a place is " + series.masked +
                                     (series.unseen.empty() ? "" : ", or " + series.unseen),
                                 kMapQuality));
  }
  if (!maps.empty()) page.pictures(maps);
  const auto is_shown = [](const ReportFrame& frame) { return !frame.thumbnail.empty(); };
  const auto num_shown = std::count_if(series.look.frames.begin(), series.look.frames.end(), is_shown);
  page.heading(series.one == "step" ? "Steps" : "Photographs");
  const float factor = shown_factor(series.look.frames);
  std::string text = "As the history has them";
  if (static_cast<std::size_t>(num_shown) < series.names.size())
    text +=
        "; " + std::to_string(num_shown) + " of " + std::to_string(series.names.size()) + ", the rest is in the table";
  if (factor != 1.0f) text += "; their light is shown times " + figure_text(static_cast<double>(factor));
  if (!is_whole) text += ". Dark: outside of the mask";
  if (!series.look.masked.empty())
    text += ". Magenta: " + series.masked + (series.unseen.empty() ? "" : ". Blue: " + series.unseen);
  page.paragraph(text + ".");
  std::vector<HtmlPicture> thumbnails;
  for (std::size_t i = 0; i < series.names.size(); ++i) {
    if (!is_shown(series.look.frames[i])) continue;
    std::string caption = time_text(series, i) + "\n" + printable_line(series.names[i]);
    if (const std::string numbers = warning_numbers(series, i); !numbers.empty())
      caption += "\n" + std::string(numbers.find(',') == std::string::npos ? "warning " : "warnings ") + numbers;
    thumbnails.push_back(small_picture(marked_thumbnail(series.look.frames[i], factor), caption, kThumbnailQuality));
  }
  page.thumbnails(thumbnails);
}

void add_controls(HtmlPage& page, const HistoryManifest& history, const fs::path& folder, const ImageU8& mask) {
  if (history.controls.empty()) return;
  page.heading("Controls");
  std::vector<HtmlPicture> maps;
  for (const ControlParameter& control : history.controls) {
    const ImageF values = read_gray(folder / control.file);
    ImageF picture = reduced_to(ramp_picture(values, mask, 0.0, 1.0, ColorRamp::Sequential), kReportMapSide_px);
    picture = with_legend(picture, {.ramp = ColorRamp::Sequential,
                                    .low = control.low,
                                    .high = control.high,
                                    .more = mask.empty() ? "" : "gray: outside"});
    maps.push_back(
        small_picture(picture, control.name + (control.unit.empty() ? "" : " (" + control.unit + ")"), kMapQuality));
  }
  page.pictures(maps);
}

std::vector<std::vector<std::string>> fact_rows(const std::vector<std::pair<std::string, ImageFacts>>& photos) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& line : series_facts(photos)) {
    const std::size_t colon = line.find(": ");
    rows.push_back({line.substr(0, colon), printable_line(line.substr(colon + 2))});
  }
  return rows;
}

std::vector<ReportColumn> color_columns(const ReportSeries& series) {
  std::vector<ReportColumn> columns{{"L*", {}}, {"a*", {}}, {"b*", {}}, {"Delta E from the first", {}}, {"masked", {}}};
  for (std::size_t i = 0; i < series.names.size(); ++i) {
    const ReportFrame& frame = series.look.frames[i];
    for (std::size_t c = 0; c < 3; ++c) columns[c].cells.push_back(frame.lab ? two_digits((*frame.lab)[c]) : "");
    const std::optional<double> change = difference(series, i);
    columns[3].cells.push_back(change ? two_digits(*change) : "");
    columns[4].cells.push_back(
        frame.masked_at ? fixed_percent_text(frame.masked_share) + " at " + span_text(*frame.masked_at) : "");
  }
  return columns;
}

void add_table(HtmlPage& page, const ReportSeries& series, std::vector<ReportColumn> columns) {
  ReportColumn found{"found", {}};
  for (const std::vector<std::string>& of_frame : series.found) {
    std::string text;
    for (const std::string& what : of_frame) text += (text.empty() ? "" : "; ") + what;
    found.cells.push_back(text);
  }
  columns.push_back(std::move(found));
  std::vector<std::string> header{series.one};
  std::vector<std::vector<std::string>> rows;
  for (const std::string& name : series.names) rows.push_back({printable_line(name)});
  for (const ReportColumn& column : columns) {
    if (std::all_of(column.cells.begin(), column.cells.end(), [](const std::string& cell) { return cell.empty(); }))
      continue;
    header.push_back(column.title);
    for (std::size_t i = 0; i < rows.size(); ++i)
      rows[i].push_back(column.cells[i].empty() ? "-" : printable_line(column.cells[i]));
  }
  page.heading("All " + series.one + "s");
  page.table(header, rows, header.back() == "found");
}

}  // namespace patinate::capture
