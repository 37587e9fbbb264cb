#include "analysis/report/report_page.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/output/svg_chart.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

std::string number(const std::optional<double>& v) { return v ? short_number_text(rounded(*v, 3) + 0.0) : "-"; }

std::string svg_of(const Curve& curve) {
  Chart chart{.title = curve.title,
              .x_label = curve.x_name,
              .y_label = curve.y_name,
              .from_zero = curve.from_zero && !curve.is_logarithmic,
              .log_x = curve.is_logarithmic,
              .log_y = curve.is_logarithmic};
  for (const CurveColumn& c : curve.columns)
    chart.series.push_back({c.name, curve.x, c.values, c.band, c.is_reference});
  return svg_chart(chart);
}

/// Row that a reader should look at first: value next to what equal would look like.
std::vector<std::string> figure_row(const Figure& f, bool has_baseline) {
  const std::string interval = f.low && f.high ? number(f.low) + " to " + number(f.high) : "";
  const std::string value = f.after && f.before ? "between " + number(f.after) + " and " + number(f.before)
                            : f.value           ? number(f.value)
                                                : "undefined: " + f.undefined;
  std::vector<std::string> row{f.title, value, f.value ? interval : "", f.unit};
  if (has_baseline) row.insert(row.begin() + 3, f.split ? number(f.split) : "");
  return row;
}

bool is_zero(const Figure& f) { return f.value == 0.0 && f.low.value_or(0.0) == 0.0 && f.high.value_or(0.0) == 0.0; }

void add_figures(HtmlPage& page, const std::vector<Figure>& all, std::string_view baseline_title) {
  std::vector<Figure> figures;
  std::vector<std::string> zeros;
  for (const Figure& f : all) {
    if (is_zero(f)) zeros.push_back(f.title);
  }
  const bool are_told_at_once = zeros.size() >= kMinZeros;
  if (are_told_at_once) page.paragraph(zeros_text(zeros, ""));
  std::copy_if(all.begin(), all.end(), std::back_inserter(figures),
               [&](const Figure& f) { return !are_told_at_once || !is_zero(f); });
  if (figures.empty()) return;
  const bool has_baseline = !baseline_title.empty();
  std::vector<std::string> header{"figure", "value", "95 % interval", "unit"};
  if (has_baseline) header.insert(header.begin() + 3, std::string(baseline_title));
  std::vector<std::vector<std::string>> rows;
  for (const Figure& f : figures) rows.push_back(figure_row(as_stated(f), has_baseline));
  page.table(header, rows);
}

constexpr std::uint64_t kMaxOfPictures = std::uint64_t{1} << 34;

/// Relative to the page's folder.
fs::path curve_file(const Curve& curve, const char* extension) { return fs::path("curves") / (curve.name + extension); }

fs::path pictures_of(const fs::path& file) { return file.string() + ".pictures"; }

}  // namespace

std::string zeros_text(const std::vector<std::string>& titles, std::string_view of_whom) {
  std::string text = std::to_string(titles.size()) + " figures are 0" + std::string(of_whom) + ": ";
  for (std::size_t i = 0; i < titles.size(); ++i) text += (i == 0 ? "" : "; ") + titles[i];
  return text + ".";
}

void embed_pictures(std::vector<Picture>& pictures, const fs::path& scratch) {
  if (pictures.empty()) return;
  fs::create_directories(scratch.parent_path());
  for (Picture& picture : pictures) {
    write_srgb8(scratch, std::exchange(picture.image, ImageF()));
    picture.source = data_uri(scratch);
    fs::remove(scratch);
  }
}

std::vector<fs::path> part_files(const fs::path& file) { return {file, pictures_of(file)}; }

void save_part(const fs::path& file, Json part) {
  std::string lines;  // A data: URI holds no end of line.
  for (Json& picture : part.at("pictures")) {
    lines += picture.at("source").get_ref<const std::string&>() + "\n";
    picture.erase("source");
  }
  write_atomically(pictures_of(file), lines);
  save_json(file, part);
}

Json load_part(const fs::path& file) {
  Json part = load_json(file);
  std::istringstream lines(read_file(pictures_of(file), kMaxOfPictures));
  for (Json& picture : part.at("pictures")) {
    std::string source;
    if (!std::getline(lines, source)) throw IoError(pictures_of(file).string(), "lacks a picture");
    picture["source"] = std::move(source);
  }
  return part;
}

void add_section(HtmlPage& page, const Section& section, const fs::path& folder, std::string_view baseline_title) {
  page.heading(section.title);
  if (!section.undefined.empty()) page.paragraph("Undefined: " + section.undefined + ".");
  for (const std::string& text : section.paragraphs) page.paragraph(text);
  add_figures(page, section.figures, baseline_title);
  for (const Picture& picture : section.pictures) page.picture({picture.source, picture.caption});
  for (const Curve& unrounded : section.curves) {
    const Curve curve = as_stated(unrounded);
    const fs::path table = folder / curve_file(curve, ".csv");
    fs::create_directories(table.parent_path());
    write_atomically(table, curve_csv(curve));
    const std::string drawing = svg_of(curve);
    write_atomically(folder / curve_file(curve, ".svg"), svg_document(drawing));
    page.drawing(drawing);
  }
}

void describe(DocumentVisitor& v, ListedFigure& f) {
  describe(v, f.figure);
  v.member({"section"}, f.section);
}

void describe(DocumentVisitor& v, ListedCurve& c) {
  v.member({"file", "A table, relative to this file."}, c.file);
  v.member({"drawing", "The same as SVG."}, c.drawing);
  v.member({"title"}, c.title);
}

namespace {

struct UndefinedSection {
  std::string section, reason;
};

void describe(DocumentVisitor& v, UndefinedSection& s) {
  v.member({"section"}, s.section);
  v.member({"reason"}, s.reason);
}

}  // namespace

std::vector<ListedFigure> listed_figures(std::span<const Section> sections) {
  std::vector<ListedFigure> list;
  for (const Section& section : sections) {
    for (const Figure& f : section.figures) list.push_back({as_stated(f), section.name});
  }
  return list;
}

std::vector<ListedCurve> listed_curves(std::span<const Section> sections) {
  std::vector<ListedCurve> list;
  for (const Section& section : sections) {
    for (const Curve& curve : section.curves)
      list.push_back(
          {curve_file(curve, ".csv").generic_string(), curve_file(curve, ".svg").generic_string(), curve.title});
  }
  return list;
}

void describe_origin(DocumentVisitor& v, ReportOrigin& o) {
  v.member({"options", "Those that were in force, as text."}, o.options);
  v.member({"command", "What repeats it, byte for byte."}, o.command);
  v.member({"key", "Content key of inputs, options and versions."}, o.key);
}

Named<std::string> with_seed(Named<std::string> values, std::uint64_t seed) {
  values.emplace_back("seed", std::to_string(seed));
  return values;
}

void describe_undefined_sections(DocumentVisitor& v, std::span<const Section> sections) {
  std::vector<UndefinedSection> list;
  for (const Section& section : sections) {
    if (!section.undefined.empty()) list.push_back({section.name, section.undefined});
  }
  v.member({"undefined_sections"}, list);
}

}  // namespace patinate::analysis
