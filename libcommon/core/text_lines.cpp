#include "libcommon/core/text_lines.h"

#include "libcommon/core/files.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace

TextLines::TextLines(const std::filesystem::path& path, std::uint64_t max_bytes)
    : file_(path.string()), bytes_(read_file(path, max_bytes)) {
  std::string_view rest = without_byte_order_mark(file_, bytes_);
  if (rest.find('\0') != std::string_view::npos) throw IoError(file_, "is no text file");
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::size_t end = rest.find('\n');
    lines_.push_back({number, trimmed(rest.substr(0, end))});
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
}

void TextLines::fail(const Line& line, const std::string& problem) const {
  throw IoError(file_, "line " + std::to_string(line.number) + ": " + problem);
}

std::string_view without_byte_order_mark(const std::string& file, std::string_view bytes) {
  using namespace std::string_view_literals;
  for (const std::string_view mark : {"\xFF\xFE"sv, "\xFE\xFF"sv, "\0\0\xFE\xFF"sv}) {
    if (bytes.starts_with(mark)) throw IoError(file, "is UTF-16 or UTF-32 text; save it as UTF-8");
  }
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.remove_prefix(3);
  return bytes;
}

std::vector<std::string_view> words_of(std::string_view text, std::size_t max_words) {
  std::vector<std::string_view> words;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    const std::size_t end = words.size() + 1 >= max_words ? std::string_view::npos : text.find_first_of(kBlanks);
    words.push_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end);
  }
  return words;
}

}  // namespace patinate
