#include "tools/studio/http.h"

#include <optional>

#include "patinate/core/error.h"

namespace patinate::studio {

namespace {

std::optional<int> hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return std::nullopt;
}

std::string decoded(std::string_view text, bool is_query) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      const auto high = i + 2 < text.size() ? hex_digit(text[i + 1]) : std::nullopt;
      const auto low = high ? hex_digit(text[i + 2]) : std::nullopt;
      if (!low) throw InvalidInput("the address has a % that two hexadecimal digits do not follow");
      c = static_cast<char>(*high * 16 + *low);
      i += 2;
    } else if (is_query && c == '+') {
      c = ' ';
    }
    if (c == '\0') throw InvalidInput("the address holds a NUL");
    out += c;
  }
  return out;
}

}  // namespace

RequestTarget parse_target(std::string_view target) {
  if (target.empty() || target.front() != '/') throw InvalidInput("the address does not begin with /");
  target = target.substr(0, target.find('#'));
  const std::size_t question = target.find('?');
  RequestTarget result{decoded(target.substr(0, question), false), {}};
  std::string_view rest = question == std::string_view::npos ? std::string_view() : target.substr(question + 1);
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    rest.remove_prefix(pair.size() < rest.size() ? pair.size() + 1 : rest.size());
    const std::size_t equals = pair.find('=');
    std::string name = decoded(pair.substr(0, equals), true);
    result.query.try_emplace(std::move(name),
                             equals == std::string_view::npos ? std::string() : decoded(pair.substr(equals + 1), true));
  }
  return result;
}

std::string percent_encoded(std::string_view text) {
  static constexpr std::string_view kHex = "0123456789ABCDEF", kPlain = "-_.~/";
  std::string out;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                          kPlain.find(c) != std::string_view::npos;
    if (is_plain) {
      out += c;
      continue;
    }
    const auto code = static_cast<unsigned char>(c);
    out += {'%', kHex[code / 16], kHex[code % 16]};
  }
  return out;
}

}  // namespace patinate::studio
