/// \file
/// Sections of figures, curves and pictures on a page for people, and as lists for programs.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "analysis/report/report_parts.h"
#include "libcommon/core/json.h"
#include "libcommon/output/html_page.h"

namespace patinate {

/// A picture as a data: URI (8-bit sRGB PNG). @param scratch  A file that is written and removed.
[[nodiscard]] std::string picture_uri(const ImageF& image, const std::filesystem::path& scratch);

/// Adds a section to the page and to the report, and writes its curves to folder/curves/NAME.csv.
/// @param json  section_json() with a `source` (a data: URI) in every picture.
/// @param baseline_title  Head of the column that shows Figure::split; "" leaves it out.
/// @param report  Has the arrays `figures` (figure_json() and `section`), `curves` (`file`, `title`) and `undefined_sections` (`section`, `reason`),
/// to which is appended. @throws CannotComplete
void add_section(HtmlPage& page, const Json& json, const std::filesystem::path& folder, std::string_view baseline_title, Json& report);

}  // namespace patinate
