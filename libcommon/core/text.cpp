#include "libcommon/core/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

namespace patinate {

namespace {

/// The fewest digits that read back to the same double.
std::string digits_of(double value, std::chars_format format) {
  std::array<char, 64> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, format);
  return std::string(buffer.data(), result.ptr);
}

}  // namespace

std::string number_text(double value) {
  const double size = std::abs(value);
  const bool is_plain = size == 0.0 || (size >= 1e-6 && size < 1e21);
  return digits_of(value, is_plain ? std::chars_format::fixed : std::chars_format::scientific);
}

double rounded(double value, int digits) {
  std::array<char, 64> buffer{};
  const auto written =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::scientific, digits - 1);
  double result = value;
  std::from_chars(buffer.data(), written.ptr, result);
  return result;
}

namespace {

constexpr int kShortDigits = 6;

std::string plain_number_text(double value, int digits) {
  const double shown = rounded(value, digits);
  const double size = std::abs(shown);
  const bool is_plain = size == 0.0 || (size >= 1e-4 && size < 1e15);
  return digits_of(shown, is_plain ? std::chars_format::fixed : std::chars_format::scientific);
}

/// Between values that differ; infinite when none do.
double smallest_gap(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double gap = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i - 1] < values[i]) gap = std::min(gap, values[i] - values[i - 1]);
  }
  return gap;
}

}  // namespace

std::string short_number_text(double value) { return plain_number_text(value, kShortDigits); }

std::string figure_text(double value) { return short_number_text(rounded(value, 4) + 0.0); }  // No -0.

std::string figure_text(const std::optional<double>& value) { return value ? figure_text(*value) : "-"; }

std::vector<std::string> short_number_texts(std::span<const double> values) {
  const double gap = smallest_gap({values.begin(), values.end()});
  const double tolerance = 0.003 * gap;
  constexpr int kLabelDigits = 3;
  int digits = std::isfinite(gap) ? kLabelDigits : kShortDigits;
  for (double value : values) {
    while (digits < std::numeric_limits<double>::max_digits10 && std::abs(rounded(value, digits) - value) > tolerance)
      ++digits;
  }
  std::vector<std::string> texts;
  for (double value : values) texts.push_back(plain_number_text(value, digits));
  return texts;
}

std::string percent_text(double share, int digits) { return short_number_text(rounded(100.0 * share, digits)) + " %"; }

std::string fixed_percent_text(double share, int decimals) {
  const double steps = std::pow(10.0, decimals);
  return short_number_text(std::round(100.0 * steps * share) / steps) + " %";
}

std::string zero_padded(std::uint64_t number, std::size_t digits) {
  std::string text = std::to_string(number);
  text.insert(0, digits - std::min(digits, text.size()), '0');
  return text;
}

std::string dashed(std::string_view name) {
  std::string text = "--" + std::string(name);
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (k < left ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) out += k <= left ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string size_text(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0.0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    std::string_view part = text.substr(0, end);
    while (!part.empty() && part.front() == ' ') part.remove_prefix(1);
    while (!part.empty() && part.back() == ' ') part.remove_suffix(1);
    parts.emplace_back(part);
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

}  // namespace

std::string did_you_mean(std::string_view word, std::span<const std::string> candidates) {
  const std::string* best = nullptr;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = &candidate;
    }
  }
  return best ? "; did you mean `" + *best + "`?" : "";
}

}  // namespace patinate
