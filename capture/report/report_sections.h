/// \file
/// What the pages of all kinds of ingest have in common.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "capture/report/report_frames.h"
#include "libcommon/output/html_page.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

/// The file of a history with the page that its ingest wrote.
inline constexpr const char* kIngestPageFile = "report.html";

/// The frames of a history and what is known of each, in order of time.
struct ReportSeries {
  std::string one = "photograph";                      ///< Word for a frame: "photograph", "step".
  std::string masked = "saturated or in a highlight";  ///< Why a place is masked in a frame.
  std::string unseen = "out of view";                  ///< Word for places that its camera did not see; "" = none.
  std::vector<std::string> names = {};                 ///< Names of its photograph, or step.
  std::vector<double> times = {};                      ///< Time of each frame.
  std::vector<std::string> time_labels = {};           ///< The times as people read them.
  std::string unit = {};                               ///< Unit of the times, as people read it.
  std::map<std::string, std::string> places = {};    ///< By the text of a warning: which part of the picture, if known.
  std::vector<HistoryWarning> warnings = {};         ///< The worst first.
  std::vector<std::vector<std::string>> found = {};  ///< Findings of each frame; none, or as many as frames.
  ReportFrames look = {};
};

/// Frames that a warning names.
[[nodiscard]] std::vector<bool> named_by_warnings(const ReportSeries& series);

/// "brightest at the upper left, darkest at the bottom": of ninths of the picture, inside the mask, over all frames
/// that are shown; "" where only one ninth has pixels.
[[nodiscard]] std::string light_place(const ReportSeries& series);

/// "4.85 d".
[[nodiscard]] std::string time_text(const ReportSeries& series, std::size_t frame);

/// Adds the warnings, with where: photographs with their times, and the part of the picture where it is known.
void add_warnings(HtmlPage& page, const ReportSeries& series);
/// Brightness, color, change from the first frame, and how much is masked, over time. Nothing of a single frame.
void add_color_curves(HtmlPage& page, const ReportSeries& series);
/// The mask, how often each place is masked, and small pictures of the frames in which both are marked.
/// @param mask  The history's; may be empty. @param width,height  Of the history.
void add_pictures(HtmlPage& page, const ReportSeries& series, const ImageU8& mask, int width, int height);
/// The controls of a history as maps with their ranges. Nothing where it has none. @throws IoError
void add_controls(HtmlPage& page, const HistoryManifest& history, const std::filesystem::path& folder,
                  const ImageU8& mask);
/// Rows of "what | it says" for what files say of how they are to be seen, and by which photographs otherwise.
[[nodiscard]] std::vector<std::vector<std::string>> fact_rows(
    const std::vector<std::pair<std::string, ImageFacts>>& photos);

/// A column of the table of all frames; left out where no cell says anything.
struct ReportColumn {
  std::string title;
  std::vector<std::string> cells;  ///< One a frame; "" = nothing.
};
/// Brightness, color and change as columns. @param frames  One each.
[[nodiscard]] std::vector<ReportColumn> color_columns(const ReportSeries& series);
/// Every frame in a row: the name, the columns, what was found.
void add_table(HtmlPage& page, const ReportSeries& series, std::vector<ReportColumn> columns);

}  // namespace patinate::capture
