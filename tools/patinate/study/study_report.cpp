#include "tools/patinate/study/study_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>

#include "libcommon/core/files.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/html_page.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/study/study_figures.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr int kThumbnail_px = 240;
constexpr std::array<std::string_view, 5> kShown{".png", ".jpg", ".jpeg", ".tif", ".exr"};

/// All that is told of a cell.
struct CellReport {
  std::string status = "done";
  std::string message;                                  ///< Of what failed.
  std::vector<std::pair<std::string, double>> figures;  ///< "STEP: NAME".
  std::vector<HtmlPicture> pictures;
};

/// A picture that is small enough to be part of the page.
HtmlPicture thumbnail(const fs::path& file, const std::string& caption, const fs::path& scratch) {
  const ImageF image = read_color(file);
  const double factor = std::min(1.0, static_cast<double>(kThumbnail_px) / std::max(1, image.height()));
  const auto side = [&](int n) { return std::max(1, static_cast<int>(std::lround(n * factor))); };
  write_srgb8(scratch, downscale_area(image, side(image.width()), side(image.height())));
  HtmlPicture picture{data_uri(scratch), caption};
  fs::remove(scratch);
  return picture;
}

CellReport cell_report(const StudyFolder& study, const PlacedPart& part, const PlacedCell& cell) {
  CellReport report;
  for (const StudyStep& step : part.steps) {
    const StepState state = step_state(study, step, cell);
    if (state.status == StepStatus::Failed && report.status != "failed") {
      report.status = "failed";
      report.message = step.name + ": " + state.message;
    } else if (state.status == StepStatus::NotRun && report.status == "done") {
      report.status = "not run";
    }
    if (state.status != StepStatus::Done) continue;
    const fs::path made = study.path / made_path(step, cell);
    try {
      for (const auto& [name, value] : figures_of(made)) report.figures.emplace_back(step.name + ": " + name, value);
      const bool is_picture = std::find(kShown.begin(), kShown.end(), lower_extension(made)) != kShown.end();
      std::error_code error;
      if (!is_picture || !fs::is_regular_file(made, error)) continue;
      report.pictures.push_back(
          thumbnail(made, cell.name + ": " + step.name, study.path / ("." + cell.name + ".thumbnail.png")));
    } catch (const InputError& e) {
      report.status = "failed";
      report.message = step.name + ": " + e.what();
    } catch (const Json::exception&) {
      report.status = "failed";
      report.message = step.name + ": " + made.string() + " is damaged";
    }
  }
  return report;
}

/// A field of a CSV file [RFC 4180].
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string csv_line(const std::vector<std::string>& fields) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) line += (i == 0 ? "" : ",") + csv_field(fields[i]);
  return line + "\n";
}

/// Names in the order in which they first come.
template <class Lists, class NamesOf>
std::vector<std::string> all_names(const Lists& lists, NamesOf&& names_of) {
  std::vector<std::string> names;
  for (const auto& list : lists) {
    for (const auto& [name, value] : names_of(list)) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

template <class Pairs>
auto value_of(const Pairs& pairs, const std::string& name) {
  return std::find_if(pairs.begin(), pairs.end(), [&](const auto& p) { return p.first == name; });
}

struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

Table table_of(const PlacedPart& part, const std::vector<CellReport>& reports, bool is_for_people) {
  const std::vector<std::string> factors = all_names(part.cells, [](const PlacedCell& c) { return c.factors; });
  const std::vector<std::string> figures = all_names(reports, [](const CellReport& r) { return r.figures; });
  Table table{{"cell"}, {}};
  table.header.insert(table.header.end(), factors.begin(), factors.end());
  table.header.insert(table.header.end(), {"status", "message"});
  table.header.insert(table.header.end(), figures.begin(), figures.end());
  for (std::size_t i = 0; i < part.cells.size(); ++i) {
    std::vector<std::string>& row = table.rows.emplace_back(std::vector{part.cells[i].name});
    for (const std::string& name : factors) {
      const auto found = value_of(part.cells[i].factors, name);
      row.push_back(found == part.cells[i].factors.end() ? "" : found->second);
    }
    row.push_back(reports[i].status);
    row.push_back(reports[i].message);
    for (const std::string& name : figures) {
      const auto found = value_of(reports[i].figures, name);
      row.push_back(found == reports[i].figures.end() ? ""
                    : is_for_people                   ? short_number_text(rounded(found->second, 4))
                                                      : number_text(found->second));
    }
  }
  return table;
}

void add_part(HtmlPage& page, const PlacedPart& part, const std::vector<CellReport>& reports) {
  page.heading(part.name);
  std::vector<HtmlPicture> pictures;
  for (const CellReport& report : reports)
    pictures.insert(pictures.end(), report.pictures.begin(), report.pictures.end());
  if (!pictures.empty()) page.pictures(pictures);
  const Table table = table_of(part, reports, true);
  page.table(table.header, table.rows);
  page.link(part.name + ".csv", "The table as CSV");
  std::string commands;
  for (const PlacedCell& cell : part.cells) {
    commands += (commands.empty() ? "# " : "\n# ") + cell.name + "\n";
    for (const std::string& command : cell.commands) commands += "patinate " + command + "\n";
  }
  page.heading(part.name + ": the commands");
  page.paragraph("In the study's folder, each makes one of the results above again.");
  page.code(commands);
}

Json cell_json(const PlacedPart& part, const PlacedCell& cell, const CellReport& report) {
  Json factors = Json::object(), figures = Json::object(), made = Json::object(), commands = Json::object();
  for (const auto& [name, value] : cell.factors) factors[name] = value;
  for (const auto& [name, value] : report.figures) figures[name] = value;
  for (std::size_t s = 0; s < part.steps.size(); ++s) {
    made[part.steps[s].name] = made_path(part.steps[s], cell).generic_string();
    commands[part.steps[s].name] = "patinate " + cell.commands[s];
  }
  return {{"part", part.name},         {"cell", cell.name},  {"factors", factors}, {"status", report.status},
          {"message", report.message}, {"figures", figures}, {"made", made},       {"commands", commands}};
}

}  // namespace

StudyReport write_study_report(const StudyFolder& study, const RunControl& control) {
  StudyReport result;
  HtmlPage page(study.name);
  std::size_t num_cells = 0, num_seen = 0;
  for (const PlacedPart& part : study.parts) num_cells += part.cells.size();
  Json cells = Json::array();
  std::vector<std::vector<CellReport>> all;
  for (const PlacedPart& part : study.parts) {
    std::vector<CellReport>& reports = all.emplace_back(part.cells.size());
    for (std::size_t i = 0; i < part.cells.size(); ++i) {
      control.throw_if_stopped();
      reports[i] = cell_report(study, part, part.cells[i]);
      cells.push_back(cell_json(part, part.cells[i], reports[i]));
      ++(reports[i].status == "done"     ? result.num_done
         : reports[i].status == "failed" ? result.num_failed
                                         : result.num_open);
      control.report(static_cast<double>(++num_seen) / static_cast<double>(num_cells + 1));
    }
  }
  page.paragraph(std::to_string(num_cells) + " cells: " + std::to_string(result.num_done) + " done, " +
                 std::to_string(result.num_failed) + " failed, " + std::to_string(result.num_open) + " not run.");
  for (std::size_t p = 0; p < study.parts.size(); ++p) {
    const PlacedPart& part = study.parts[p];
    add_part(page, part, all[p]);
    const Table table = table_of(part, all[p], false);
    std::string csv = csv_line(table.header);
    for (const auto& row : table.rows) csv += csv_line(row);
    write_atomically(study.path / (part.name + ".csv"), csv);
  }
  page.save(study.path / "report.html");
  save_json(study.path / "report.json",
            Json{{"format", "patinate.study_report"}, {"version", 1}, {"name", study.name}, {"cells", cells}});
  control.report(1.0);
  return result;
}

}  // namespace patinate::cli
