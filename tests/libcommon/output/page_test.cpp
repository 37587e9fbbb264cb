#include <gtest/gtest.h>

#include <algorithm>

#include "libcommon/core/files.h"
#include "libcommon/output/contact_strip.h"
#include "libcommon/output/html_page.h"
#include "patinate/core/error.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

constexpr const char* kNasty = "</script><img src=x onerror=alert(1)> \"'&\x01";

TEST(HtmlPage, EscapesEverythingItIsGiven) {
  HtmlPage page(kNasty);
  page.heading(kNasty).paragraph(kNasty).code(kNasty).link(kNasty, kNasty).table({kNasty}, {{kNasty}});
  page.frame(kNasty, kNasty)
      .picture({kNasty, kNasty})
      .pictures({{kNasty, kNasty}})
      .thumbnails({{kNasty, kNasty}})
      .time_slider({{kNasty, kNasty}}, kNasty);
  const std::string text = page.text();
  EXPECT_EQ(text.find("<img src=x"), std::string::npos);
  EXPECT_EQ(text.find('\x01'), std::string::npos);
  // Only our own two scripts end: the data of the slider and its code.
  std::size_t ends = 0;
  for (std::size_t at = text.find("</script>"); at != std::string::npos; at = text.find("</script>", at + 1)) ++ends;
  EXPECT_EQ(ends, 2u);
}

TEST(HtmlPage, PercentEncodesPaths) {
  HtmlPage page("t");
  page.picture({"a b/c#1?.png", "x"});
  EXPECT_NE(page.text().find("src=\"a%20b/c%231%3F.png\""), std::string::npos);
}

TEST(HtmlPage, ClosesEveryElement) {
  HtmlPage page("title");
  page.heading("h").paragraph("p").code("c").frame("a.html", "a").pictures({{"a.png", "a"}, {"b.png", ""}});
  page.thumbnails({{"a.png", "a\nb"}}).table({"a", "b"}, {{"1", "2"}}, true);
  page.table({"a", "b"}, {{"1", "2"}}).time_slider({{"a.png", "0 s"}, {"b.png", "1 s"}}, "over time");
  const std::string text = page.text();
  std::vector<std::string> open;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    if (text[at + 1] == '!') continue;
    const bool is_end = text[at + 1] == '/';
    const std::size_t begin = at + (is_end ? 2 : 1);
    if (!std::isalpha(static_cast<unsigned char>(text[begin]))) continue;  // "<" in a script.
    const std::string name = text.substr(begin, text.find_first_of(" >", begin) - begin);
    if (name == "meta" || name == "img" || name == "input") continue;
    if (!is_end) {
      open.push_back(name);
    } else {
      ASSERT_FALSE(open.empty());
      EXPECT_EQ(open.back(), name);
      open.pop_back();
    }
  }
  EXPECT_TRUE(open.empty());
}

TEST(HtmlPage, RefusesRaggedTablesAndEmptySliders) {
  HtmlPage page("t");
  EXPECT_THROW(page.table({"a", "b"}, {{"1"}}), InvalidInput);
  EXPECT_THROW(page.time_slider({}, ""), InvalidInput);
}

TEST(HtmlPage, DataUriIsBase64) {
  // RFC 4648, section 10.
  const testing_support::TempFolder folder;
  for (const auto& [bytes, code] : std::vector<std::pair<std::string, std::string>>{{"", ""},
                                                                                    {"f", "Zg=="},
                                                                                    {"fo", "Zm8="},
                                                                                    {"foo", "Zm9v"},
                                                                                    {"foob", "Zm9vYg=="},
                                                                                    {"fooba", "Zm9vYmE="},
                                                                                    {"foobar", "Zm9vYmFy"}}) {
    write_atomically(folder / "a.png", bytes);
    EXPECT_EQ(data_uri(folder / "a.png"), "data:image/png;base64," + code);
  }
}

TEST(ContactStrip, PutsPicturesSideBySideUnchanged) {
  const std::vector<ImageF> pictures = {ImageF(40, 30, 3, 0.25f), ImageF(40, 30, 1, 0.5f), ImageF(40, 30, 3, 0.75f)};
  const ImageF strip = contact_strip(pictures, {}, {.gap_px = 4});
  EXPECT_EQ(strip.width(), 3 * 44 + 4);
  EXPECT_EQ(strip.height(), 38);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(strip.at(4 + 44 * i + 20, 20, 2), 0.25f * static_cast<float>(i + 1));
}

TEST(ContactStrip, WritesLabelsUnderPicturesAndNowhereElse) {
  const std::vector<ImageF> pictures(4, ImageF(80, 60, 3, 0.5f));
  const std::vector<std::string> labels = {"0 d", "", "12.5 d",
                                           "a label that is far too long for its picture \xc3\xa9"};
  const ImageF strip = contact_strip(pictures, labels, {.columns = 2, .gap_px = 2, .label_px = 10});
  const auto darkest = [&](int column, int row) {
    float low = 1.0f;
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 80; ++x) low = std::min(low, strip.at(2 + 82 * column + x, 2 + 82 * row + 60 + y, 0));
    }
    return low;
  };
  EXPECT_LT(darkest(0, 0), 0.3f);
  EXPECT_EQ(darkest(1, 0), ContactStripOptions{}.background);
  EXPECT_LT(darkest(0, 1), 0.3f);
  EXPECT_LT(darkest(1, 1), 0.6f);
  for (int y = 2; y < 62; ++y) EXPECT_EQ(strip.at(40, y, 0), 0.5f);
}

TEST(ContactStrip, RefusesWhatDoesNotFitTogether) {
  EXPECT_THROW((void)contact_strip({}, {}), InvalidInput);
  const std::vector<ImageF> pictures = {ImageF(4, 4, 3), ImageF(5, 4, 3)};
  EXPECT_THROW((void)contact_strip(pictures, {}), InvalidInput);
  const std::vector<std::string> labels = {"a", "b"};
  EXPECT_THROW((void)contact_strip({pictures.data(), 1}, labels), InvalidInput);
}

}  // namespace
}  // namespace patinate
