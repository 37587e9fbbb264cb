#include "libcommon/core/printable.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace patinate {

namespace {

/// Length of the UTF-8 character at the beginning of `text` and its code; 0 when there is none.
std::size_t character(std::string_view text, std::uint32_t& code) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  const std::uint32_t first = byte(0);
  if (first < 0x80) return code = first, 1;
  const std::size_t length = first >= 0xF5 ? 0 : first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC2 ? 2 : 0;
  if (length == 0 || text.size() < length) return 0;
  code = first & (0xFFu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0u) != 0x80u) return 0;
    code = code << 6 | (byte(i) & 0x3Fu);
  }
  const std::uint32_t least = length == 2 ? 0x80 : length == 3 ? 0x800 : 0x10000;
  return code < least || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000) ? 0 : length;
}

/// Moves the cursor, ends a line, or makes text read in another order than it is written.
bool is_commanding(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x61C || (code >= 0x200E && code <= 0x200F) ||
         (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069) || code == 0xFEFF;
}

/// Each character as it is shown.
std::vector<std::string> shown_characters(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::vector<std::string> out;
  while (!text.empty()) {
    std::uint32_t code = 0;
    const std::size_t length = character(text, code);
    const std::string_view bytes = text.substr(0, std::max<std::size_t>(length, 1));
    std::string shown;
    if (length == 1 && (code == '\n' || code == '\r' || code == '\t')) {
      shown = " ";
    } else if (length == 0 || is_commanding(code)) {
      for (const char c : bytes) {
        const auto byte = static_cast<unsigned char>(c);
        shown += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
      }
    } else {
      shown = bytes;
    }
    out.push_back(std::move(shown));
    text.remove_prefix(bytes.size());
  }
  return out;
}

std::string joined(const std::vector<std::string>& characters) {
  std::string out;
  for (const std::string& c : characters) out += c;
  return out;
}

/// Drops characters from the end until no more than `most` bytes are left.
void shorten(std::vector<std::string>& characters, std::size_t most) {
  std::size_t size = joined(characters).size();
  for (; size > most; characters.pop_back()) size -= characters.back().size();
}

}  // namespace

std::string printable_line(std::string_view text, std::size_t max_bytes) {
  if (text.size() <= max_bytes) {
    std::string whole = joined(shown_characters(text));
    if (whole.size() <= max_bytes) return whole;
  }
  // Shown text is never shorter than the original: no more than both ends have to be looked at, of gigabytes too.
  constexpr std::size_t kLongestCharacter = 4;
  const std::string middle = " ... (" + std::to_string(text.size()) + " bytes) ... ";
  const std::size_t side = (max_bytes - std::min(max_bytes, middle.size())) / 2,
                    looked_at = std::min(text.size(), side + kLongestCharacter);
  std::vector<std::string> first = shown_characters(text.substr(0, looked_at));
  shorten(first, side);
  std::string_view end = text.substr(text.size() - looked_at);
  for (std::size_t i = 1;
       i < kLongestCharacter && !end.empty() && (static_cast<unsigned char>(end.front()) & 0xC0u) == 0x80u; ++i)
    end.remove_prefix(1);
  std::vector<std::string> last = shown_characters(end);
  std::reverse(last.begin(), last.end());
  shorten(last, side);
  std::reverse(last.begin(), last.end());
  return joined(first) + middle + joined(last);
}

std::string printable_lines(std::string_view text, std::size_t max_bytes) {
  std::string out;
  while (true) {
    const std::size_t end = text.find('\n');
    out += printable_line(text.substr(0, end), max_bytes);
    if (end == std::string_view::npos) return out;
    out += '\n';
    text.remove_prefix(end + 1);
  }
}

}  // namespace patinate
