#include "libcommon/core/printable.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/errors.h"

namespace patinate {
namespace {

using testing_support::has;

TEST(Printable, LeavesPlainTextOfEveryLanguageAsItIs) {
  for (const std::string text : {"", "a b", "Grünspan 緑青 патина", "\xF0\x9F\x8F\xBA"})
    EXPECT_EQ(printable_line(text), text);
}

TEST(Printable, ShowsWhatATerminalWouldObey) {
  EXPECT_EQ(printable_line("a\x1b[31mred\x07"), "a\\x1b[31mred\\x07");
  EXPECT_EQ(printable_line("title \x1b]0;x\x1b\\"), "title \\x1b]0;x\\x1b\\");
  EXPECT_EQ(printable_line("\xC2\x9B"
                           "2J\x7f"),
            "\\xc2\\x9b2J\\x7f");  // CSI as one character of Unicode; delete.
  EXPECT_EQ(printable_line("gnp.\xE2\x80\xAE"
                           "exe"),
            "gnp.\\xe2\\x80\\xaeexe");  // From here on right to left.
  EXPECT_EQ(printable_line("a\nb\r\n\tc"), "a b   c");
  EXPECT_EQ(printable_line(std::string_view("a\0b", 3)), "a\\x00b");
}

TEST(Printable, ShowsBytesThatAreNoUtf8) {
  EXPECT_EQ(printable_line("a\xFF"
                           "b\xC3"),
            "a\\xffb\\xc3");
  EXPECT_EQ(printable_line("\xC0\xAF\xED\xA0\x80"),
            "\\xc0\\xaf\\xed\\xa0\\x80");                                 // Overlong; half of a surrogate pair.
  EXPECT_EQ(printable_line("\xF4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // Beyond Unicode.
}

TEST(Printable, ShortensLongLinesInTheMiddleWithoutTearingCharacters) {
  for (const std::string unit : {"x", "\xC3\xBC", "\xE7\xB7\x91", "\xF0\x9F\x8F\xBA", "\x1b"}) {
    for (const std::size_t count : {99u, 100u, 2001u, 3'000'000u}) {
      std::string text = "FILE: ";
      for (std::size_t i = 0; i < count; ++i) text += unit;
      text += " end";
      const std::string shown = printable_line(text, 300);
      EXPECT_LE(shown.size(), 300u);
      EXPECT_TRUE(shown.starts_with("FILE: ") && shown.ends_with(" end")) << shown;
      const bool is_long = 10 + count * (unit == "\x1b" ? 4 : unit.size()) > 300;
      EXPECT_EQ(has(shown, "(" + std::to_string(text.size()) + " bytes)"), is_long) << shown;
      EXPECT_EQ(has(shown, "\\x"), unit == "\x1b") << shown;
    }
  }
}

TEST(Printable, BoundsEveryLineOfSeveral) {
  EXPECT_EQ(printable_lines("a\nb\x1b\n"), "a\nb\\x1b\n");
  const std::string shown = printable_lines(std::string(5000, 'x') + "\n" + std::string(50, 'y'), 200);
  EXPECT_EQ(shown.find('\n'), shown.size() - 51);
  EXPECT_LE(shown.size(), 251u);
}

}  // namespace
}  // namespace patinate
