/// \file
/// Small text helpers: numbers that read back exactly, parsing that never depends on the locale, did-you-mean.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace patinate {

/// The fewest digits that read back to the same double; as in browsers, an exponent only below 1e-6 and from 1e21 on:
/// 100000, never 1e+05.
[[nodiscard]] std::string number_text(double value);
/// The double nearest to `value` written with so many significant digits: 25 * 19.4 becomes 485 with 12.
[[nodiscard]] double rounded(double value, int digits);
/// For people: at most six significant digits, and an exponent only where the number would be very long.
[[nodiscard]] std::string short_number_text(double value);
/// A figure of a report: at most four significant digits; "-" where there is none.
[[nodiscard]] std::string figure_text(double value);
[[nodiscard]] std::string figure_text(const std::optional<double>& value);
/// Labels of a series: at least 3 digits, and as many more as it takes to be within 0.3 % of the smallest gap; values
/// that are all equal as by short_number_text().
[[nodiscard]] std::vector<std::string> short_number_texts(std::span<const double> values);
/// A share for people, with so many significant digits: "12.3 %".
[[nodiscard]] std::string percent_text(double share, int digits = 3);
/// Percent with so many decimals, [0, 6]: "12.3 %", "0 %".
[[nodiscard]] std::string fixed_percent_text(double share, int decimals = 1);
/// Zeros in front, so that names sort as numbers do: 7 with 4 digits is "0007", 12345 stays.
[[nodiscard]] std::string zero_padded(std::uint64_t number, std::size_t digits);
/// A field of an options struct as the command line writes it: "low_percent" is "--low-percent".
[[nodiscard]] std::string dashed(std::string_view name);
/// Bytes as letters [RFC 4648], padded with `=`.
[[nodiscard]] std::string base64(std::string_view bytes);
/// "640 x 480".
[[nodiscard]] std::string size_text(int width, int height);
/// Tells digits of ASCII, whatever the locale.
[[nodiscard]] inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// The whole of `text` as a finite number, or nothing.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);
/// Parts between separators; "a,,b" gives three. Blanks around parts are cut.
[[nodiscard]] std::vector<std::string> split(std::string_view text, char separator);
/// "; did you mean `x`?" for the candidate within edit distance 2 of `word` (or a third of its length), else "".
[[nodiscard]] std::string did_you_mean(std::string_view word, std::span<const std::string> candidates);

}  // namespace patinate
