#include "libcommon/output/html_page.h"

#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate {

namespace {

constexpr std::string_view kStyle = R"css(
:root { color-scheme: light dark; --ink: #22252a; --soft: #6a7078; --line: #dcdfe3; }
:root { --paper: #fbfbfa; --card: #ffffff; --accent: #1f6f5c; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e6e3; --soft: #9aa0a6; --line: #3a3d42; --paper: #191a1c; --card: #212327; --accent: #6cc0aa; }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.55 system-ui, sans-serif; }
main { max-width: 68rem; margin: 0 auto; padding: 2.5rem 1.25rem 4rem; }
h1 { font-size: 2rem; line-height: 1.2; margin: 0 0 1.25rem; }
h2 { font-size: 1.3rem; margin: 2.5rem 0 0.75rem; }
p { max-width: 46rem; }
a { color: var(--accent); }
pre { background: var(--card); border: 1px solid var(--line); border-radius: 6px; padding: 0.75rem 1rem; }
pre { overflow-x: auto; white-space: pre-wrap; overflow-wrap: anywhere; font-size: 0.88rem; }
figure { width: fit-content; max-width: 100%; margin: 1.25rem 0; background: var(--card); border: 1px solid var(--line); border-radius: 6px; overflow: hidden; }
figure img { display: block; max-width: 100%; height: auto; }
figcaption { padding: 0.5rem 0.9rem; color: var(--soft); font-size: 0.92rem; }
figure svg { display: block; max-width: 100%; height: auto; }
figure.drawing { display: inline-block; vertical-align: top; width: 31.5rem; margin: 0.5rem 0.75rem 0.5rem 0; }
figure.frame { width: 100%; }
.frame iframe { display: block; width: 100%; height: 44rem; max-height: 85vh; border: 0; }
.grid { display: grid; grid-template-columns: repeat(auto-fit, minmax(15rem, 1fr)); gap: 1rem; }
.grid figure { margin: 0; }
.thumbnails { display: grid; grid-template-columns: repeat(auto-fill, 162px); gap: 0.6rem; margin: 1.25rem 0; }
.thumbnails figure { margin: 0; width: 162px; }
.thumbnails figcaption { padding: 0.3rem 0.5rem; font-size: 0.8rem; line-height: 1.35; }
.thumbnails figcaption { white-space: pre-line; overflow-wrap: anywhere; }
.slider { max-width: 44rem; }
.controls { display: flex; align-items: center; gap: 0.75rem; padding: 0.6rem 0.9rem 0; }
.controls input { flex: 1; accent-color: var(--accent); }
.controls button { font: inherit; border: 1px solid var(--line); border-radius: 4px; background: var(--paper); }
.controls button { color: inherit; padding: 0.1rem 0.8rem; cursor: pointer; }
.controls output { min-width: 5rem; text-align: right; font-variant-numeric: tabular-nums; }
.table { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: 0.35rem 1rem 0.35rem 0; border-bottom: 1px solid var(--line); }
td:last-child { padding-right: 0; min-width: 6rem; }
.wide td:first-child { min-width: 9rem; overflow-wrap: anywhere; }
.wide td:last-child { min-width: 20rem; }
th { color: var(--soft); font-weight: 600; vertical-align: bottom; }
@page { size: A4; margin: 15mm; }
@media print {
  :root { color-scheme: light; --ink: #000000; --soft: #444444; --line: #bbbbbb; --paper: #ffffff; --card: #ffffff; }
  body { font-size: 10pt; }
  main { max-width: none; padding: 0; }
  .table { overflow: visible; }
  th, td { padding-right: 0.5rem; font-size: 8pt; }
  tr, figure { break-inside: avoid; }
  h2 { break-after: avoid; }
}
)css";

constexpr std::string_view kScript = R"js(
for (const figure of document.querySelectorAll("figure.slider")) {
  const frames = JSON.parse(figure.querySelector("script").textContent);
  const image = figure.querySelector("img"), range = figure.querySelector("input");
  const time = figure.querySelector("output"), button = figure.querySelector("button");
  let timer = 0;
  const show = () => {
    const frame = frames[range.valueAsNumber];
    image.src = frame.source;
    image.alt = frame.caption;
    time.textContent = frame.caption;
  };
  const stop = () => { clearInterval(timer); timer = 0; button.textContent = "Play"; };
  range.addEventListener("input", () => { stop(); show(); });
  button.addEventListener("click", () => {
    if (timer) return stop();
    button.textContent = "Stop";
    timer = setInterval(() => { range.valueAsNumber = (range.valueAsNumber + 1) % frames.length; show(); }, 150);
  });
  for (const frame of frames) new Image().src = frame.source;
  show();
}
)js";

// A path as a URL: what is not plain is percent-encoded. data: URIs stay as they are.
std::string url(std::string_view source) {
  if (source.starts_with("data:")) return html_escape(source);
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string out;
  for (const char c : source) {
    const unsigned char u = static_cast<unsigned char>(c);
    const bool is_plain = (u >= '0' && u <= '9') || (u >= 'A' && u <= 'Z') || (u >= 'a' && u <= 'z') ||
                          std::string_view("-._~/").find(c) != std::string_view::npos;
    if (is_plain) {
      out += c;
    } else {
      out += '%';
      out += kHex[u >> 4];
      out += kHex[u & 15];
    }
  }
  // "a:b" would name a scheme; it is "a%3Ab" by now.
  return out;
}

std::string image_tag(const HtmlPicture& picture) {
  return "<img src=\"" + url(picture.source) + "\" alt=\"" + html_escape(picture.caption) + "\">";
}

std::string figure(const HtmlPicture& picture) {
  std::string out = "<figure>" + image_tag(picture);
  if (!picture.caption.empty()) out += "<figcaption>" + html_escape(picture.caption) + "</figcaption>";
  return out + "</figure>\n";
}

std::string figures(const char* style, const std::vector<HtmlPicture>& pictures) {
  std::string out = "<div class=\"" + std::string(style) + "\">\n";
  for (const HtmlPicture& picture : pictures) out += figure(picture);
  return out + "</div>\n";
}

std::string cells(const char* tag, const std::vector<std::string>& row) {
  std::string out = "<tr>";
  for (const std::string& cell : row) out += "<" + std::string(tag) + ">" + html_escape(cell) + "</" + tag + ">";
  return out + "</tr>\n";
}

}  // namespace

std::string html_escape(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t') out += c;
    }
  }
  return out;
}

std::string data_uri(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  return data_uri(read_file(file), extension == ".png"    ? "image/png"
                                   : extension == ".jpg"  ? "image/jpeg"
                                   : extension == ".svg"  ? "image/svg+xml"
                                   : extension == ".json" ? "application/json"
                                                          : "application/octet-stream");
}

std::string data_uri(std::string_view bytes, std::string_view type) {
  return "data:" + std::string(type) + ";base64," + base64(bytes);
}

HtmlPage::HtmlPage(std::string title) : title_(std::move(title)) {}

HtmlPage& HtmlPage::heading(std::string_view text) {
  body_ += "<h2>" + html_escape(text) + "</h2>\n";
  return *this;
}

HtmlPage& HtmlPage::paragraph(std::string_view text) {
  body_ += "<p>" + html_escape(text) + "</p>\n";
  return *this;
}

HtmlPage& HtmlPage::code(std::string_view text) {
  body_ += "<pre><code>" + html_escape(text) + "</code></pre>\n";
  return *this;
}

HtmlPage& HtmlPage::picture(const HtmlPicture& picture) {
  body_ += figure(picture);
  return *this;
}

HtmlPage& HtmlPage::pictures(const std::vector<HtmlPicture>& pictures) {
  body_ += figures("grid", pictures);
  return *this;
}

HtmlPage& HtmlPage::thumbnails(const std::vector<HtmlPicture>& pictures) {
  body_ += figures("thumbnails", pictures);
  return *this;
}

HtmlPage& HtmlPage::table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows,
                          bool is_last_wide) {
  body_ += std::string("<div class=\"table\"><table") + (is_last_wide ? " class=\"wide\"" : "") + ">\n<thead>" +
           cells("th", header) + "</thead>\n<tbody>\n";
  for (const std::vector<std::string>& row : rows) {
    if (row.size() != header.size()) {
      throw InvalidInput("html table: a row has " + std::to_string(row.size()) + " cells; the header has " +
                         std::to_string(header.size()));
    }
    body_ += cells("td", row);
  }
  body_ += "</tbody>\n</table></div>\n";
  return *this;
}

HtmlPage& HtmlPage::time_slider(const std::vector<HtmlPicture>& frames, std::string_view caption) {
  if (frames.empty()) throw InvalidInput("html time slider: there is no frame");
  Json list = Json::array();
  for (const HtmlPicture& frame : frames) {
    const bool is_data = frame.source.starts_with("data:");
    list.push_back({{"source", is_data ? frame.source : url(frame.source)}, {"caption", frame.caption}});
  }
  // "</script>" in a name would end the element; JSON may write "<" as an escape.
  std::string json;
  for (const char c : list.dump(-1, ' ', false, Json::error_handler_t::replace))
    json += c == '<' ? std::string("\\u003c") : std::string(1, c);
  const std::string last = std::to_string(frames.size() - 1);
  body_ += "<figure class=\"slider\">" + image_tag(frames.back()) +
           "<div class=\"controls\"><button type=\"button\">Play</button>" + "<input type=\"range\" min=\"0\" max=\"" +
           last + "\" value=\"" + last + "\" aria-label=\"Time\"><output>" + html_escape(frames.back().caption) +
           "</output></div><script type=\"application/json\">" + json + "</script><figcaption>" + html_escape(caption) +
           "</figcaption></figure>\n";
  ++num_sliders_;
  return *this;
}

HtmlPage& HtmlPage::drawing(std::string_view svg, std::string_view caption) {
  if (!svg.starts_with("<svg")) throw InvalidInput("html drawing: an <svg> element is needed");
  body_ += "<figure class=\"drawing\">" + std::string(svg);
  if (!caption.empty()) body_ += "<figcaption>" + html_escape(caption) + "</figcaption>";
  body_ += "</figure>\n";
  return *this;
}

HtmlPage& HtmlPage::frame(std::string_view source, std::string_view caption) {
  body_ += "<figure class=\"frame\"><iframe src=\"" + url(source) + "\" title=\"" + html_escape(caption) +
           "\"></iframe><figcaption><a href=\"" + url(source) + "\">" + html_escape(caption) +
           "</a></figcaption></figure>\n";
  return *this;
}

HtmlPage& HtmlPage::link(std::string_view target, std::string_view text) {
  body_ += "<p><a href=\"" + url(target) + "\">" + html_escape(text) + "</a></p>\n";
  return *this;
}

std::string HtmlPage::text() const {
  const std::string title = html_escape(title_);
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n" +
                    std::string("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>") +
                    title + "</title>\n<style>" + std::string(kStyle) + "</style>\n</head>\n<body>\n<main>\n<h1>" +
                    title + "</h1>\n" + body_ + "</main>\n";
  if (num_sliders_ > 0) out += "<script>" + std::string(kScript) + "</script>\n";
  return out + "</body>\n</html>\n";
}

void HtmlPage::save(const std::filesystem::path& path) const { write_atomically(path, text()); }

}  // namespace patinate
