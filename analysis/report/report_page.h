/// \file
/// Sections of figures, curves and pictures on a page for people, and as lists for programs.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/output/html_page.h"
#include "patinate/analysis/report_parts.h"
#include "patinate/core/json.h"

namespace patinate::analysis {

/// A picture as a data: URI (8-bit sRGB PNG). @param scratch  A file that is written and removed.
[[nodiscard]] std::string picture_uri(const ImageF& image, const std::filesystem::path& scratch);

/// What an item of a job leaves of its part of a report: the JSON, and in a second file the pictures in it, which may
/// be larger than JSON may.
[[nodiscard]] std::vector<std::filesystem::path> part_files(const std::filesystem::path& file);
/// @param part  With a `source` in every element of `pictures`. @throws CannotComplete
void save_part(const std::filesystem::path& file, Json part);
/// What save_part() was given. @throws IoError
[[nodiscard]] Json load_part(const std::filesystem::path& file);

/// Adds a section to the page and to the report, and writes its curves to folder/curves/NAME.csv.
/// @param json  section_json() with a `source` (a data: URI) in every picture.
/// @param baseline_title  Head of the column that shows Figure::split; "" leaves it out.
/// @param report  Has the arrays `figures` (figure_json() and `section`), `curves` (`file`, `title`) and
/// `undefined_sections` (`section`, `reason`), to which is appended. @throws CannotComplete
void add_section(HtmlPage& page, const Json& json, const std::filesystem::path& folder, std::string_view baseline_title,
                 Json& report);

}  // namespace patinate::analysis
