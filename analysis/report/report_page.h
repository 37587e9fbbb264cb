/// \file
/// Sections of figures, curves and pictures on a page for people, and as lists for programs.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/document/document.h"
#include "libcommon/output/html_page.h"
#include "patinate/analysis/report_parts.h"
#include "patinate/core/json.h"

namespace patinate::analysis {

/// Gives pictures as data: URIs (8-bit sRGB PNG) in place of their pixels: sets `source` and empties `image`.
/// @param scratch  A file that is written and removed. @throws CannotComplete
void embed_pictures(std::vector<Picture>& pictures, const std::filesystem::path& scratch);

/// Files of an item's part of a report: the JSON, and in a second file the pictures in it, which may
/// be larger than JSON may.
[[nodiscard]] std::vector<std::filesystem::path> part_files(const std::filesystem::path& file);
/// @param part  With a `source` in every element of `pictures`. @throws CannotComplete
void save_part(const std::filesystem::path& file, Json part);
/// Loads a part that save_part() wrote. @throws IoError
[[nodiscard]] Json load_part(const std::filesystem::path& file);

/// So many figures that are 0 are one sentence on a page, and no rows.
inline constexpr std::size_t kMinZeros = 4;
/// "5 figures are 0 for every pair: TITLE; TITLE; ...". @param of_whom  " for every pair", or "".
[[nodiscard]] std::string zeros_text(const std::vector<std::string>& titles, std::string_view of_whom);

/// Adds a section to the page, and writes its curves to folder/curves/NAME.csv and, drawn, NAME.svg.
/// @param section  With a `source` in every picture. Its numbers are shown as stated (as_stated()).
/// @param baseline_title  Head of the column that shows Figure::split; "" leaves it out.
/// @throws CannotComplete; InvalidInput if a number is not finite.
void add_section(HtmlPage& page, const Section& section, const std::filesystem::path& folder,
                 std::string_view baseline_title);

/// The same for programs: a figure, with the section it is of.
struct ListedFigure {
  Figure figure;
  std::string section;
};
void describe(DocumentVisitor& v, ListedFigure& figure);
[[nodiscard]] std::vector<ListedFigure> listed_figures(std::span<const Section> sections);
/// What add_section() has written of a curve, relative to its folder.
struct ListedCurve {
  std::string file, drawing, title;
};
void describe(DocumentVisitor& v, ListedCurve& curve);
[[nodiscard]] std::vector<ListedCurve> listed_curves(std::span<const Section> sections);
/// How a report was made.
struct ReportOrigin {
  Named<std::string> options;  ///< Those that were in force.
  std::string command, key;
};
/// Members `options`, `command` and `key`, the last of a report.
void describe_origin(DocumentVisitor& v, ReportOrigin& origin);
/// `values` and the seed of random numbers.
[[nodiscard]] Named<std::string> with_seed(Named<std::string> values, std::uint64_t seed);
/// Those that say nothing: `section` and `reason`.
void describe_undefined_sections(DocumentVisitor& v, std::span<const Section> sections);

}  // namespace patinate::analysis
