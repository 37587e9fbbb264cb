#include "libcommon/mesh_files/ply_parser.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "libcommon/core/files.h"
#include "libcommon/core/text_lines.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

using Number = PlyParser::Number;

std::size_t size_of(Number type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

std::optional<Number> number_of(std::string_view name) {
  constexpr std::string_view kNames[] = {"char", "uchar", "short", "ushort", "int",   "uint",   "float",   "double",
                                         "int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};
  const auto* found = std::find(std::begin(kNames), std::end(kNames), name);
  if (found == std::end(kNames)) return std::nullopt;
  return static_cast<Number>((found - std::begin(kNames)) % 8);
}

std::vector<std::string_view> header_words(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(" \t\r\n"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

}  // namespace

int PlyParser::Element::find(std::initializer_list<std::string_view> names) const {
  for (std::string_view wanted : names) {
    for (std::size_t i = 0; i < properties.size(); ++i) {
      if (properties[i].name == wanted) return static_cast<int>(i);
    }
  }
  return -1;
}

PlyParser::PlyParser(const std::filesystem::path& path)
    : file_(path.string()), bytes_(read_file(path)), rest_(without_byte_order_mark(file_, bytes_)) {
  read_header();
}

std::string_view PlyParser::obj_info(std::string_view name) const {
  for (const auto& [key, value] : obj_info_) {
    if (key == name) return value;
  }
  return "";
}

void PlyParser::begin(const Element& element) {
  element_ = &element;
  row_ = ~std::uint64_t{0};  // Before the first.
  const std::uint64_t min_bytes = min_row_bytes();
  // The last ASCII value needs no blank behind it.
  if (min_bytes > 0 && element.count > (rest_.size() + 1) / min_bytes) fail_truncated(0);
}

std::uint64_t PlyParser::min_row_bytes() const {
  std::uint64_t bytes = 0;
  for (const Property& p : element_->properties)
    bytes += form_ == Form::Ascii ? 2 : size_of(p.count_type.value_or(p.type));
  return bytes;
}

void PlyParser::fail(const std::string& problem) const { throw IoError(file_, problem); }
void PlyParser::fail_row(const std::string& problem) const {
  fail((form_ == Form::Ascii ? "line " + std::to_string(line_of(rest_.data())) + ": " : "") + "element `" +
       element_->name + "`, row " + std::to_string(row_) + ": " + problem);
}
void PlyParser::fail_truncated(std::uint64_t row) const {
  fail("truncated: ends in element `" + element_->name + "`, row " + std::to_string(row) + " of " +
       std::to_string(element_->count));
}

std::size_t PlyParser::index(double value, std::size_t size) const {
  if (!(value >= 0.0 && value < static_cast<double>(size))) {
    fail_row("a vertex index is out of range; there are " + std::to_string(size) + " vertices before it");
  }
  return static_cast<std::size_t>(value);
}

std::string_view PlyParser::next_line() {
  const std::size_t end = rest_.find_first_of("\r\n");
  if (end == std::string_view::npos) fail("truncated: the PLY header has no end_header");
  const std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(end + (rest_.substr(end, 2) == "\r\n" ? 2 : 1));
  return line;
}

void PlyParser::read_header() {
  if (rest_.substr(0, 3) != "ply") fail("is not a PLY file; its first line must be `ply`");
  next_line();
  bool has_format = false;
  while (true) {
    const std::vector<std::string_view> words = header_words(next_line());
    if (words.empty()) continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format") {
      read_format(words);
      has_format = true;
    } else if (words[0] == "element") {
      read_element(words);
    } else if (words[0] == "property") {
      read_property(words);
    } else if (words[0] == "obj_info" && words.size() > 2) {
      obj_info_.emplace_back(words[1], words[2]);
    }
  }
  if (!has_format) fail("the PLY header has no `format` line");
}

void PlyParser::read_format(const std::vector<std::string_view>& words) {
  const std::string_view name = words.size() > 1 ? words[1] : "";
  if (name == "ascii") {
    form_ = Form::Ascii;
  } else if (name == "binary_little_endian") {
    form_ = Form::LittleEndian;
  } else if (name == "binary_big_endian") {
    form_ = Form::BigEndian;
  } else {
    fail("PLY format `" + std::string(name) + "` is unknown; use ascii, binary_little_endian or binary_big_endian");
  }
}

void PlyParser::read_element(const std::vector<std::string_view>& words) {
  Element element;
  if (words.size() < 3 ||
      std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count).ec != std::errc()) {
    fail("PLY header: `element` needs a name and a count");
  }
  element.name = words[1];
  elements_.push_back(element);
}

void PlyParser::read_property(const std::vector<std::string_view>& words) {
  const bool is_list = words.size() > 1 && words[1] == "list";
  if (elements_.empty() || words.size() < (is_list ? 5u : 3u)) fail("PLY header: a `property` line is not complete");
  const auto type = number_of(words[is_list ? 3 : 1]);
  const auto count_type = is_list ? number_of(words[2]) : std::nullopt;
  if (!type || (is_list && !count_type))
    fail("PLY header: property `" + std::string(words.back()) + "` has no known type");
  elements_.back().properties.push_back({std::string(words.back()), *type, count_type});
}

double PlyParser::next_value(Number type) {
  if (form_ == Form::Ascii) return next_ascii();
  const std::size_t size = size_of(type);
  if (rest_.size() < size) fail_truncated(row_);
  char raw[8] = {};
  std::memcpy(raw, rest_.data(), size);
  rest_.remove_prefix(size);
  if ((form_ == Form::BigEndian) != (std::endian::native == std::endian::big)) std::reverse(raw, raw + size);
  const auto as = [&raw](auto value) {
    std::memcpy(&value, raw, sizeof(value));
    return static_cast<double>(value);
  };
  switch (type) {
    case Number::I8:
      return as(std::int8_t{});
    case Number::U8:
      return as(std::uint8_t{});
    case Number::I16:
      return as(std::int16_t{});
    case Number::U16:
      return as(std::uint16_t{});
    case Number::I32:
      return as(std::int32_t{});
    case Number::U32:
      return as(std::uint32_t{});
    case Number::F32:
      return as(float{});
    case Number::F64:
      return as(double{});
  }
  return 0.0;
}

/// Counts from 1.
std::size_t PlyParser::line_of(const char* at) const {
  const std::string_view before(bytes_.data(), static_cast<std::size_t>(at - bytes_.data()));
  std::size_t line = 1;
  for (std::size_t i = before.find_first_of("\r\n"); i != std::string_view::npos;
       i = before.find_first_of("\r\n", i + 1)) {
    if (before[i] == '\n' || i + 1 >= bytes_.size() || bytes_[i + 1] != '\n') ++line;
  }
  return line;
}

void PlyParser::begin_ascii_row() {
  const std::size_t begin = rest_.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) fail_truncated(row_);
  rest_.remove_prefix(begin);
}

void PlyParser::end_ascii_row() const {
  const std::string_view line = rest_.substr(0, rest_.find_first_of("\r\n"));
  const std::vector<std::string_view> words = header_words(line);
  if (!words.empty())
    fail_row("has " + std::to_string(words.size()) + " more values than the header declares, from `" +
             std::string(words.front()) + "` on; export it with a header that fits, for example without colors");
}

double PlyParser::next_ascii() {
  rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size()));
  if (rest_.empty()) fail_truncated(row_);
  if (rest_.front() == '\r' || rest_.front() == '\n') fail_row("ends before all values that the header declares");
  const std::string_view word = rest_.substr(0, std::min(rest_.find_first_of(" \t\r\n"), rest_.size()));
  rest_.remove_prefix(word.size());
  const std::string_view digits = word.front() == '+' ? word.substr(1) : word;
  double value = 0.0;
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (result.ec != std::errc() || result.ptr != digits.data() + digits.size()) {
    fail_row("`" + std::string(word) + "` is not a number");
  }
  return value;
}

void PlyParser::read_row() {
  ++row_;
  scalars_.resize(element_->properties.size());
  lists_.resize(element_->properties.size());
  if (form_ == Form::Ascii) begin_ascii_row();
  for (std::size_t i = 0; i < element_->properties.size(); ++i) {
    const Property& p = element_->properties[i];
    if (!p.count_type) {
      scalars_[i] = next_value(p.type);
      continue;
    }
    const double count = next_value(*p.count_type);
    const std::size_t max_count = rest_.size() / (form_ == Form::Ascii ? 1 : size_of(p.type));
    if (!(count >= 0.0) || count != std::floor(count)) fail_row("the length of a list is negative or no whole number");
    if (count > static_cast<double>(max_count)) fail_truncated(row_);
    lists_[i].clear();
    for (double k = 0.0; k < count; ++k) lists_[i].push_back(next_value(p.type));
  }
  if (form_ == Form::Ascii) end_ascii_row();
}

void PlyParser::finish() const {
  const std::size_t more = rest_.find_first_not_of(std::string_view(" \t\r\n\0", 5));
  if (more == std::string_view::npos) return;
  if (form_ == Form::Ascii)
    fail("line " + std::to_string(line_of(rest_.data() + more)) + ": holds more rows than its header declares");
  fail("holds " + std::to_string(rest_.size()) + " bytes more than its header declares: its rows are not what it says");
}

}  // namespace patinate
