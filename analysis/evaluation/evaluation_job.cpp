#include "analysis/evaluation/evaluation_job.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/report/analysis_documents.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/text.h"
#include "libcommon/document/document.h"
#include "libcommon/image/filters.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/output/html_page.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 5;  ///< Raised when the same input gives other figures.

constexpr int kLongestSide = 1600;  ///< Longest side of a picture on the page, pixels.

fs::path item_file(std::size_t i) { return fs::path(kJobWorkFolder) / ("map" + std::to_string(i) + ".json"); }

ImageF source_picture(const SynthesisSource& source) {
  ImageF linear = source.frames.back();
  for (float& v : linear.values()) v = linear_from_srgb(v / 255.0f);
  return linear;
}

/// No larger than a page needs; the caption says so.
void limit_size(Picture& picture, const RunControl& control) {
  const int w = picture.image.width(), h = picture.image.height(), longest = std::max(w, h);
  if (longest <= kLongestSide) return;
  const auto limited = [&](int n) { return std::max(1, static_cast<int>(std::int64_t{n} * kLongestSide / longest)); };
  picture.image = downscale_area(picture.image, limited(w), limited(h), control);
  picture.caption += " (" + size_text(w, h) + ", shown at " + size_text(limited(w), limited(h)) + ")";
}

/// Figures of one kind of lines at one threshold.
struct EvaluatedLines {
  LineKind kind = LineKind::Dark;
  double threshold = 0.0;
  std::vector<Figure> figures = {};
};

/// Figures of one map, as its item computes them.
struct EvaluatedMap {
  std::string name, about, hash;  ///< Name and description of the item, and hash of the Evaluation.
  std::vector<Figure> figures;
  std::vector<EvaluatedLines> lines;
  std::vector<Picture> pictures;  ///< With their sources; in the report they are files of the page.
};

constexpr std::array<std::string_view, 2> kLineKindNames{"dark", "bright"};

void describe(DocumentVisitor& v, EvaluatedLines& l) {
  v.choice({"kind"}, l.kind, kLineKindNames);
  v.member({"threshold", "L* by which a line differs from what surrounds it.", above(0)}, l.threshold);
  v.member({"figures"}, l.figures);
}

void describe(DocumentVisitor& v, EvaluatedMap& m) {
  v.member({"name"}, m.name);
  v.member({"about", "File, source and control."}, m.about);
  v.member({"hash", "Of the rounded coordinates, 32 hexadecimal digits."}, m.hash);
  v.member({"figures"}, m.figures);
  v.member({"lines", "What the figures of lines are means of: each kind of lines at each threshold."}, m.lines);
  if (!v.wants_all()) v.member(if_set("pictures"), m.pictures);  // Only items have them.
}

/// evaluation.json.
struct EvaluationDocument {
  std::vector<EvaluatedMap> maps;  ///< Without pictures.
  ReportOrigin origin;
};

void describe(DocumentVisitor& v, EvaluationDocument& d) {
  v.member({.name = "maps", .min_size = 1}, d.maps);
  describe_origin(v, d.origin);
}

constexpr DocumentKind kEvaluationDocument{
    .format = "patinate.evaluation",
    .version = 2,
    .title = "patinate evaluation",
    .about = "evaluation.json of `patinate evaluate`: the figures of the page beside it."};

std::vector<Figure> stated(const std::vector<Figure>& figures) {
  std::vector<Figure> list;
  for (const Figure& f : figures) list.push_back(as_stated(f));
  return list;
}

std::vector<EvaluatedLines> stated(const std::vector<LineFigures>& lines) {
  std::vector<EvaluatedLines> list;
  for (const LineFigures& l : lines) list.push_back({l.kind, l.threshold, stated(l.figures)});
  return list;
}

EvaluatedMap evaluated(const EvaluationItem& item, const EvaluationTask& task, const fs::path& scratch,
                       const RunControl& control) {
  MapToEvaluate opened = item.open(control.part(0.0, 0.5));
  Evaluation made = evaluate(opened.source, opened.map, task.options, task.seed, opened.made ? &*opened.made : nullptr,
                             control.part(0.5, 1.0));
  EvaluatedMap map{
      .name = item.name,
      .about = item.about,
      .hash = std::move(made.hash),
      .figures = std::move(opened.more),
      .lines = stated(made.lines),
      .pictures = {{"source", "The source at the last of the compared times", source_picture(opened.source)}}};
  std::move(made.figures.begin(), made.figures.end(), std::back_inserter(map.figures));
  map.figures = stated(map.figures);
  std::move(made.pictures.begin(), made.pictures.end(), std::back_inserter(map.pictures));
  for (Picture& p : map.pictures) limit_size(p, control);
  embed_pictures(map.pictures, scratch);
  return map;
}

std::string cell(const Figure& figure) {
  if (!figure.value) return "-";
  std::string text = short_number_text(rounded(*figure.value, 3));
  if (figure.split) text += " (" + short_number_text(rounded(*figure.split, 3)) + ")";
  return text;
}

/// A row for each figure that any map has, a column for each map.
void add_table(HtmlPage& page, const std::vector<EvaluatedMap>& maps) {
  std::vector<std::string> header{"figure"};
  for (const EvaluatedMap& m : maps) header.push_back(m.name);
  header.emplace_back("unit");
  std::vector<std::vector<std::string>> rows;
  std::set<std::string> seen;
  for (const EvaluatedMap& map : maps) {
    for (const Figure& figure : map.figures) {
      if (!seen.insert(figure.name).second) continue;
      std::vector<std::string> row{figure.title};
      for (const EvaluatedMap& other : maps) {
        std::string text;
        for (const Figure& f : other.figures) {
          if (f.name == figure.name) text = cell(f);
        }
        row.push_back(text);
      }
      row.push_back(figure.unit);
      rows.push_back(std::move(row));
    }
  }
  page.table(header, rows);
}

void write_report(const fs::path& folder, const EvaluationTask& task, const std::string& key,
                  const std::vector<EvaluatedMap>& maps) {
  HtmlPage page("How good is the texture?");
  page.paragraph(
      "Every texel of a result copies a pixel of the source. These figures measure how well the transfer follows its "
      "control, how well neighboring texels agree, and how similar its statistics are to the source's. In brackets: "
      "the value for the source itself (M4, M5: for two samples of it, the best possible). Less is better, with these "
      "exceptions: for M3, M6 (share used), M7 (seams) and M12 (borders of pieces) 1 is best; for M11 (lines) the "
      "source's value is best. M1 says how close the search came to the least energy, not how good the texture looks: "
      "the least energy is smooth and repeats.");
  add_table(page, maps);
  for (const EvaluatedMap& map : maps) {
    page.heading(map.name);
    page.paragraph(map.about);
    std::vector<HtmlPicture> pictures;
    for (const Picture& p : map.pictures) pictures.push_back({p.source, p.caption});
    page.pictures(pictures);
    for (const Figure& f : map.figures) {
      if (!f.value) page.paragraph(f.title + ": undefined, " + f.undefined + ".");
    }
  }
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(task.command);
  page.link(kEvaluationFile, "The figures as JSON");
  page.save(folder / kEvaluationPageFile);
  EvaluationDocument document{.maps = maps,
                              .origin = {with_seed(option_values(task.options), task.seed), task.command, key}};
  for (EvaluatedMap& map : document.maps) map.pictures.clear();
  save_json(folder / kEvaluationFile, document_json(kEvaluationDocument, described(document)));
}

}  // namespace

void check_evaluation(const std::filesystem::path& file) {
  check_document<EvaluationDocument>(kEvaluationDocument, file);
}

Json evaluation_schema() { return document_schema(kEvaluationDocument, described<EvaluationDocument>()); }

JobPlan plan_evaluation(EvaluationTask task, const fs::path& output) {
  check_ranges(task.options);
  if (task.maps.empty()) throw InvalidInput("there is no coordinate map to evaluate");
  JobInputs inputs("evaluate", kStageVersion);
  std::set<std::string> names;
  for (const EvaluationItem& map : task.maps) {
    if (!names.insert(map.name).second) throw InvalidInput("two maps are called `" + map.name + "`; give other names");
    inputs.add_content("map", map.name, map.key + " " + map.name);
  }
  inputs.add_options(option_values(task.options));
  inputs.add_value("--seed", std::to_string(task.seed));
  JobPlan plan = inputs.plan(output, kEvaluationFile);
  plan.parallel_items = false;
  const auto shared = std::make_shared<const EvaluationTask>(std::move(task));
  for (std::size_t i = 0; i < shared->maps.size(); ++i) {
    const std::string scratch = "map" + std::to_string(i) + ".png";
    plan.items.push_back({.name = "map" + std::to_string(i),
                          .outputs = part_files(item_file(i)),
                          .run = [=](const fs::path& folder, const RunControl& control) {
                            fs::create_directories(folder / kJobWorkFolder);
                            EvaluatedMap made =
                                evaluated(shared->maps[i], *shared, folder / kJobWorkFolder / scratch, control);
                            save_part(folder / item_file(i), object_json(described(made)));
                          }});
  }
  plan.join = [shared, key = plan.key](const fs::path& folder, const RunControl&) {
    std::vector<EvaluatedMap> maps;
    for (std::size_t i = 0; i < shared->maps.size(); ++i)
      read_object(load_part(folder / item_file(i)), described(maps.emplace_back()));
    write_report(folder, *shared, key, maps);
  };
  return plan;
}

}  // namespace patinate::analysis
