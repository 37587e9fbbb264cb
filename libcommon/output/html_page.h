/// \file
/// One self-describing HTML page: text, pictures, tables, a time slider. Works from file://, needs nothing from a
/// network.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace patinate {

/// Text for HTML: & < > " ' are replaced, control characters dropped.
[[nodiscard]] std::string html_escape(std::string_view text);
/// A file's bytes as a data: URI (png, jpg, svg, json by extension, else octet-stream). @throws IoError
[[nodiscard]] std::string data_uri(const std::filesystem::path& file);

/// Bytes as a data: URI. @param type  "image/png".
[[nodiscard]] std::string data_uri(std::string_view bytes, std::string_view type);

/// A picture of a page.
struct HtmlPicture {
  std::string source;   ///< Path relative to the page, or a data: URI. `/` separates folders; needs no escaping.
  std::string caption;  ///< Also the text for those who cannot see it.
};

/// Builds a page from top to bottom. All text is plain and is escaped.
class HtmlPage {
 public:
  explicit HtmlPage(std::string title);

  HtmlPage& heading(std::string_view text);
  HtmlPage& paragraph(std::string_view text);
  /// Preformatted text, e.g. a command line.
  HtmlPage& code(std::string_view text);
  HtmlPage& picture(const HtmlPicture& picture);
  /// Side by side, as many in a row as fit.
  HtmlPage& pictures(const std::vector<HtmlPicture>& pictures);
  /// Adds small pictures, at most 160 pixels wide, as they are. A caption may have several lines.
  HtmlPage& thumbnails(const std::vector<HtmlPicture>& pictures);
  /// @throws InvalidInput if a row is not as long as the header.
  /// @param is_last_wide  The last column holds sentences: it gets room for them, also beside many others.
  HtmlPage& table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows,
                  bool is_last_wide = false);
  /// A slider that shows one picture of a sequence; captions are the times. Plays on a button. Not empty.
  HtmlPage& time_slider(const std::vector<HtmlPicture>& frames, std::string_view caption);
  /// A drawing that svg_chart() has made, as it is. @throws InvalidInput unless it is an `<svg>` element.
  HtmlPage& drawing(std::string_view svg, std::string_view caption = "");
  /// Another page within this one, as wide as the text, with a link to it alone.
  HtmlPage& frame(std::string_view source, std::string_view caption);
  /// A link to a file beside the page.
  HtmlPage& link(std::string_view target, std::string_view text);

  /// The whole document, valid HTML 5, UTF-8.
  [[nodiscard]] std::string text() const;
  /// Writes atomically. @throws CannotComplete
  void save(const std::filesystem::path& path) const;

 private:
  std::string title_;
  std::string body_;
  int num_sliders_ = 0;
};

}  // namespace patinate
