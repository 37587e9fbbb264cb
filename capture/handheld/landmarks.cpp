#include "capture/handheld/landmarks.h"

#include <algorithm>
#include <optional>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

std::string trimmed(const std::string& text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  const auto begin = std::find_if_not(text.begin(), text.end(), is_blank);
  const auto end = std::find_if_not(text.rbegin(), text.rend(), is_blank).base();
  return begin < end ? std::string(begin, end) : "";
}

/// Fields of a line; commas inside of double quotes separate nothing, and "" inside of them is one quote.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && is_quoted && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += line[++i];
    } else if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  for (std::string& field : fields) field = trimmed(field);
  return fields;
}

/// A field that fields_of() and trimmed() give back as it is. @throws InvalidInput
std::string quoted(const std::string& field) {
  if (field.find_first_of("\r\n") != std::string::npos || trimmed(field) != field || field.empty())
    throw InvalidInput("the name \"" + field +
                       "\" cannot stand in a table of landmarks: it is empty, has a line break, or a blank at an end; "
                       "rename it");
  if (field.find_first_of(",\"#") == std::string::npos) return field;
  std::string text = "\"";
  for (const char c : field) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

}  // namespace

std::string landmarks_text(const std::map<std::string, PhotoMarks>& marks) {
  std::string text = "photo,point,x,y\n";
  bool is_any = false;
  for (const auto& [photo, points] : marks) {
    for (const auto& [point, at] : points) {
      text += quoted(photo) + "," + quoted(point) + "," + number_text(at.x()) + "," + number_text(at.y()) + "\n";
      is_any = true;
    }
  }
  if (!is_any) throw InvalidInput("no point is marked; a table of landmarks has one or more");
  return text;
}

std::map<std::string, PhotoMarks> read_landmarks(const std::filesystem::path& file) {
  constexpr double kFarthest = 1e6;  // px; input beyond is a mistake.
  const std::vector<std::string> header{"photo", "point", "x", "y"};
  std::map<std::string, PhotoMarks> marks;
  std::size_t number = 0;
  for (const std::string& text : split(read_file(file), '\n')) {
    ++number;
    const std::string line = trimmed(text);
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string> fields = fields_of(line);
    if (fields == header) continue;
    const std::string where = "line " + std::to_string(number) + ": ";
    if (fields.size() != header.size())
      throw IoError(file.string(),
                    where + "found " + std::to_string(fields.size()) + " fields; expected photo,point,x,y");
    const std::optional<double> x = parse_number(fields[2]), y = parse_number(fields[3]);
    if (!x || !y || !(std::abs(*x) < kFarthest) || !(std::abs(*y) < kFarthest))
      throw IoError(file.string(),
                    where + "x and y must be pixels of the photograph; found " + fields[2] + ", " + fields[3]);
    if (!marks[fields[0]].emplace(fields[1], Eigen::Vector2d(*x, *y)).second)
      throw IoError(file.string(), where + "the point " + fields[1] + " is marked twice in " + fields[0]);
  }
  if (marks.empty()) throw IoError(file.string(), "marks no point; expected lines of photo,point,x,y");
  return marks;
}

std::vector<PointMatch> shared_marks(const PhotoMarks& a, const PhotoMarks& b) {
  std::vector<PointMatch> matches;
  for (const auto& [name, in_a] : a) {
    const auto found = b.find(name);
    if (found != b.end()) matches.push_back({in_a, found->second});
  }
  return matches;
}

double mark_error_px(int side) { return std::max(1.0, side / 800.0); }

}  // namespace patinate::capture
