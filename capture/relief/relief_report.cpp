#include "capture/relief/relief_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_documents.h"
#include "libcommon/history/history_times.h"
#include "libcommon/output/contact_strip.h"
#include "libcommon/output/html_page.h"
#include "libcommon/output/map_legend.h"
#include "libcommon/output/svg_chart.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr double kUm = 1000.0;  ///< In a mm.
constexpr double kIn95 = 1.96;  ///< Standard deviations on either side.
constexpr int kDigits = 6;
/// Less, and what has changed is so much that it may be what stayed: the larger of two parts is taken to have.
constexpr double kMaxStays = 0.75;
constexpr double kMinAgrees = 0.5;    ///< Share of what is said to stay.
constexpr double kMinMeasured = 0.5;  ///< Share of the surface, below which it is warned.
constexpr int kPanel_px = 560;        ///< About the width of a picture on the page.
constexpr int kLabel_px = 13;         ///< Height of a label.
constexpr double kPictured = 0.98;    ///< Quantile of sizes that the pictures' ends stand for.

double stated(double v) { return rounded(v, kDigits) + 0.0; }
std::string shown(double v) { return short_number_text(rounded(v, 3)); }
std::string interval(double v, double stddev) { return shown(v - kIn95 * stddev) + " to " + shown(v + kIn95 * stddev); }

double per_area(double volume, double area) { return area > 0.0 ? volume / area : 0.0; }

Json vector_json(const Vec3& v) { return {stated(v.x()), stated(v.y()), stated(v.z())}; }
Json volume_json(const VolumeChange& v) {
  return {{"mm3", stated(v.mm3)}, {"stddev_mm3", stated(v.stddev_mm3)}, {"area_mm2", stated(v.area_mm2)}};
}

Json matrix_json(const RigidTransform& t) {
  Json rows = Json::array();
  const Eigen::Matrix4d m = t.matrix();
  for (Eigen::Index r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

Json step_json(const ReliefTask& task, std::size_t scan, const ReliefChange* c) {
  Json json{{"scan", task.scans[scan].name}, {"time", task.times[scan]}};
  json["reference"] = c == nullptr;
  if (c == nullptr) return json;
  json.update({{"file", change_file(scan, ".exr").generic_string()},
               {"matrix", matrix_json(c->reference_from_scan)},
               {"moved_um", stated(kUm * c->moved_mm)},
               {"constrained_dofs", c->num_dofs},
               {"stable_share", stated(c->stable_share)},
               {"measured_share", stated(c->measured_share)},
               {"changed_share", stated(c->changed_share)},
               {"mean_change_um", stated(kUm * per_area(c->net.mm3, c->net.area_mm2))},
               {"mean_change_stddev_um", stated(kUm * per_area(c->net.stddev_mm3, c->net.area_mm2))},
               {"net", volume_json(c->net)},
               {"gained", volume_json(c->gained)},
               {"lost", volume_json(c->lost)},
               {"noise_factor", stated(c->noise_factor)},
               {"pose_stddev_um", stated(kUm * c->pose_stddev_mm)},
               {"systematic_um", nullptr}});
  if (c->systematic_mm) json["systematic_um"] = stated(kUm * *c->systematic_mm);
  return json;
}

/// The change of a scan; nothing for the reference.
const ReliefChange* change_of(const ReliefTask& task, const Relief& relief, std::size_t scan) {
  if (scan == task.reference) return nullptr;
  return &relief.changes[scan < task.reference ? scan : scan - 1];
}

/// One end for all steps, so that pictures compare; um.
double pictured_um(const Relief& relief) {
  std::vector<float> sizes;
  for (const ReliefChange& c : relief.changes) {
    for (std::int64_t i = 0; i < c.measured.num_pixels(); ++i) {
      if (c.measured.data()[i] != 0) sizes.push_back(std::abs(c.change_mm.data()[i]));
    }
  }
  if (sizes.empty()) return 1.0;
  const auto at = static_cast<std::ptrdiff_t>(kPictured * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), sizes.begin() + at, sizes.end());
  return std::max(1e-3, rounded(kUm * static_cast<double>(sizes[at]), 2));
}

void write_maps(const fs::path& folder, std::size_t scan, const ReliefChange& c, double end_um) {
  ImageF values(c.change_mm.width(), c.change_mm.height(), 3), um(c.change_mm.width(), c.change_mm.height());
  for (int y = 0; y < um.height(); ++y) {
    for (int x = 0; x < um.width(); ++x) {
      um.at(x, y) = static_cast<float>(kUm) * c.change_mm.at(x, y);
      values.at(x, y, 0) = um.at(x, y);
      values.at(x, y, 1) = static_cast<float>(kUm) * c.stddev_mm.at(x, y);
      values.at(x, y, 2) = c.changed.at(x, y) != 0 ? 1.0f : 0.0f;
    }
  }
  fs::create_directories(folder / "change");
  write_exr(folder / change_file(scan, ".exr"), values, {"change.um", "stddev.um", "significant"}, ExrDepth::Float);
  write_srgb8(folder / change_file(scan, ".png"), ramp_picture(um, c.measured, -end_um, end_um, ColorRamp::Diverging));
}

fs::path page_picture_file(std::size_t scan) { return "pictures" / change_file(scan, ".png").filename(); }

/// Every pixel as a square of so many.
ImageF enlarged(const ImageF& image, int times) {
  ImageF out(times * image.width(), times * image.height(), image.channels());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const auto from = image.pixel(x / times, y / times);
      std::copy(from.begin(), from.end(), out.pixel(x, y).begin());
    }
  }
  return out;
}

/// Writes the picture for people: all of the change and the significant part of it side by side, enlarged, with a
/// legend.
void write_page_picture(const fs::path& file, const ReliefChange& c, double end_um) {
  const ImageF& change = c.change_mm;
  ImageF all(change.width(), change.height()), significant(change.width(), change.height());
  for (std::int64_t i = 0; i < change.num_pixels(); ++i) {
    all.data()[i] = static_cast<float>(kUm) * change.data()[i];
    significant.data()[i] = c.changed.data()[i] != 0 ? all.data()[i] : 0.0f;
  }
  const int times = std::max(1, kPanel_px / change.width());
  const auto panel = [&](const ImageF& um) {
    return enlarged(ramp_picture(um, c.measured, -end_um, end_um, ColorRamp::Diverging), times);
  };
  const std::array<ImageF, 2> panels{panel(all), panel(significant)};
  const std::array<std::string, 2> labels{"all of the change", "what is significant of it"};
  const ImageF strip = contact_strip(panels, labels, {.label_px = kLabel_px});
  fs::create_directories(file.parent_path());
  write_srgb8(
      file,
      with_legend(
          strip,
          {.ramp = ColorRamp::Diverging, .low = -end_um, .high = end_um, .unit = "um", .more = "gray: not measured"}));
}

/// Quotes as RFC 4180 has it.
std::string quoted(std::string text) {
  for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2) text.insert(at, 1, '"');
  return '"' + text + '"';
}

std::string table_text(const ReliefTask& task, const Relief& relief) {
  std::ostringstream out;
  out << "scan,time [" << shown_time_unit(task.time_unit)
      << "],mean change [um],standard deviation [um],changed share,net volume [mm3],standard deviation [mm3],"
         "gained [mm3],lost [mm3],stable share,measured share\n";
  for (std::size_t k = 0; k < task.scans.size(); ++k) {
    const ReliefChange* c = change_of(task, relief, k);
    if (c == nullptr) continue;
    out << quoted(task.scans[k].name) << ',' << number_text(task.times[k]);
    for (const double v : {kUm * per_area(c->net.mm3, c->net.area_mm2),
                           kUm * per_area(c->net.stddev_mm3, c->net.area_mm2), c->changed_share, c->net.mm3,
                           c->net.stddev_mm3, c->gained.mm3, c->lost.mm3, c->stable_share, c->measured_share})
      out << ',' << number_text(stated(v));
    out << '\n';
  }
  return out.str();
}

std::string course_chart(const ReliefTask& task, const Relief& relief) {
  ChartSeries mean{.name = "mean change, with 95 % interval"};
  for (std::size_t k = 0; k < task.scans.size(); ++k) {
    const ReliefChange* c = change_of(task, relief, k);
    const double um = c == nullptr ? 0.0 : kUm * per_area(c->net.mm3, c->net.area_mm2);
    const double half = c == nullptr ? 0.0 : kIn95 * kUm * per_area(c->net.stddev_mm3, c->net.area_mm2);
    mean.x.push_back(task.times[k]);
    mean.y.emplace_back(um);
    mean.band.emplace_back(um - half, um + half);
  }
  return svg_chart({.title = "Height over time",
                    .x_label = "time [" + shown_time_unit(task.time_unit) + "]",
                    .y_label = "um",
                    .series = {mean}});
}

void write_page(const fs::path& folder, const ReliefTask& task, const Relief& relief,
                const std::vector<HistoryWarning>& warnings, double end_um) {
  HtmlPage page("Height change: " + task.name);
  page.paragraph("How much higher or lower the surface stands than in " + task.scans[task.reference].name +
                 ", along its normal. Heights are those of planes through the points within " +
                 shown(relief.window_mm) + " mm; a pixel is " + shown(relief.view.texel) + " mm. Intervals hold " +
                 "95 %: scanner noise, the place of each scan, and what stays on stable surface.");
  for (const HistoryWarning& w : warnings) page.paragraph("Warning: " + warning_text(w));
  std::vector<std::vector<std::string>> rows;
  std::vector<HtmlPicture> pictures;
  for (std::size_t k = 0; k < task.scans.size(); ++k) {
    const ReliefChange* c = change_of(task, relief, k);
    if (c == nullptr) continue;
    const double area = c->net.area_mm2;
    const double mean = kUm * per_area(c->net.mm3, area);
    rows.push_back({task.scans[k].name, number_text(task.times[k]),
                    shown(mean) + " (" + interval(mean, kUm * per_area(c->net.stddev_mm3, area)) + ")",
                    fixed_percent_text(c->changed_share), shown(c->gained.mm3), shown(c->lost.mm3), shown(c->net.mm3),
                    fixed_percent_text(c->stable_share), fixed_percent_text(c->measured_share)});
    pictures.push_back({page_picture_file(k).generic_string(),
                        task.scans[k].name + ": left all of the change, right what is significant of it; blue -" +
                            shown(end_um) + " um, white 0, orange +" + shown(end_um) + " um; gray: not measured"});
  }
  page.table({"scan", "time [" + shown_time_unit(task.time_unit) + "]", "mean [um] (95 %)", "changed", "gained [mm3]",
              "lost [mm3]", "net [mm3]", "stable", "measured"},
             rows);
  page.drawing(course_chart(task, relief));
  page.heading("Where");
  for (const HtmlPicture& picture : pictures) page.picture(picture);
  page.heading("What the columns say");
  page.paragraph("Changed: share of the measured area whose change is significant, at a false discovery rate of " +
                 shown(task.options.false_share) +
                 " [Benjamini, Hochberg 1995]. Gained and lost are volumes over it; " +
                 "net is over all that was measured, and the only one of the three without the bias of having been " +
                 "chosen by size. Stable: share of the surface that agrees on where the scan stands. Heights follow " +
                 "M3C2 [Lague, Brodu, Leroux 2013]; places, FAST-LTS [Rousseeuw, Van Driessen 2006].");
  page.link(kReliefTableFile, kReliefTableFile).link(kReliefFile, kReliefFile);
  page.save(folder / kReliefPageFile);
}

}  // namespace

fs::path change_file(std::size_t scan, const std::string& extension) {
  std::ostringstream name;
  name << std::setw(4) << std::setfill('0') << scan << extension;
  return fs::path("change") / name.str();
}

std::vector<HistoryWarning> relief_warnings(const ReliefChange& change, const std::string& name, bool has_stable) {
  std::vector<HistoryWarning> warnings;
  if (change.stable_share < kMaxStays && !has_stable) {
    warnings.push_back({.about = WarningSubject::Motion,
                        .text = name + ": everything is measured against the " +
                                fixed_percent_text(change.stable_share) +
                                " of the surface that agree on where the scan stands; if they are what changed, the " +
                                "rest is shown as changed in their place",
                        .cure = "give an image of what is known to stay as --stable",
                        .share = 1.0 - change.stable_share,
                        .photos = {name}});
  }
  if (change.stable_share < kMinAgrees && has_stable) {
    warnings.push_back(
        {.about = WarningSubject::Motion,
         .text = name + ": only " + fixed_percent_text(change.stable_share) + " of what --stable marks show no change",
         .cure = "mark less",
         .share = 1.0 - change.stable_share,
         .photos = {name}});
  }
  if (change.measured_share < kMinMeasured) {
    warnings.push_back(
        {.about = WarningSubject::Mask,
         .text = name + ": only " + fixed_percent_text(change.measured_share) + " of the reference's surface is in it",
         .cure = "give a larger --reach-mm where it changed more than that, a larger --window-mm where "
                 "points are sparse",
         .share = 1.0 - change.measured_share,
         .photos = {name}});
  }
  return warnings;
}

void write_relief_report(const fs::path& folder, const ReliefTask& task, const Relief& relief,
                         const std::vector<HistoryWarning>& warnings, const std::string& key) {
  const double end_um = pictured_um(relief);
  Json steps = Json::array();
  for (std::size_t k = 0; k < task.scans.size(); ++k) {
    const ReliefChange* c = change_of(task, relief, k);
    if (c != nullptr) write_maps(folder, k, *c, end_um);
    if (c != nullptr) write_page_picture(folder / page_picture_file(k), *c, end_um);
    steps.push_back(step_json(task, k, c));
  }
  const ReliefView& view = relief.view;
  save_json(folder / kReliefFile, Json{{"format", "patinate.relief"},
                                       {"version", 1},
                                       {"name", task.name},
                                       {"time_unit", time_unit_text(task.time_unit)},
                                       {"window_mm", stated(relief.window_mm)},
                                       {"texel_mm", stated(view.texel)},
                                       {"reach_mm", stated(relief.reach_mm)},
                                       {"false_share", task.options.false_share},
                                       {"view",
                                        {{"right", vector_json(view.right)},
                                         {"up", vector_json(view.up)},
                                         {"toward", vector_json(view.toward)},
                                         {"corner", vector_json(view.corner)}}},
                                       {"steps", steps},
                                       {"warnings", warnings_json(warnings)},
                                       {"key", key}});
  write_atomically(folder / kReliefTableFile, table_text(task, relief));
  write_page(folder, task, relief, warnings, end_um);
}

}  // namespace patinate::capture
