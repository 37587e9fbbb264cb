#include "analysis/report/report_page.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

using testing_support::TempFolder;

// JSON files are read up to 64 MB; the pictures of a map of 4096 x 4096 texels are more.
TEST(ReportPart, IsReadBackHoweverLargeItsPicturesAre) {
  const TempFolder folder;
  const std::string large = "data:image/png;base64," + std::string(std::size_t{70} << 20, 'A');
  Json part{{"name", "map"},
            {"figures", {1, 2}},
            {"pictures",
             Json::array({Json{{"name", "source"}, {"source", "data:,"}}, Json{{"name", "made"}, {"source", large}}})}};
  save_part(folder / "map.json", part);
  EXPECT_LT(std::filesystem::file_size(folder / "map.json"), 1000u);
  EXPECT_TRUE(load_part(folder / "map.json") == part);
  for (const auto& file : part_files(folder / "map.json")) EXPECT_TRUE(std::filesystem::exists(file));
  EXPECT_EQ(list_files(folder.path(), "*").size(), part_files(folder / "map.json").size());
}

TEST(ReportPart, LacksNoPicture) {
  const TempFolder folder;
  save_part(folder / "map.json", Json{{"pictures", Json::array({Json{{"source", "data:,"}}})}});
  write_atomically(part_files(folder / "map.json")[1], "");
  EXPECT_THROW((void)load_part(folder / "map.json"), IoError);
}

/// With numbers of more digits than are stated.
Section long_numbers() {
  Section s{.name = "colors", .title = "Colors", .paragraphs = {"A & B"}, .undefined = "why not"};
  // Three digits, as a page shows them, of all digits are 10.7; of the nine that a file keeps, 10.75, they are 10.8.
  s.figures.push_back(
      {.name = "f", .title = "F", .unit = "mm", .value = 10.7499999999, .low = -1e-300, .high = 1.0 / 3.0});
  s.figures.push_back({.name = "g", .title = "G", .split = 2.0 / 3.0});
  s.figures.push_back({.name = "h", .title = "H", .value = -0.0, .undefined = "said in vain"});
  s.curves.push_back(
      {.name = "c",
       .title = "C",
       .x_name = "x",
       .y_name = "y",
       .x = {0.1, 1.0 / 3.0, 1e9 / 7.0},
       .columns = {{"one", {1e6 / 3.0, std::nullopt, -0.0}, {{-1e-9 / 3.0, 2.0 / 3.0}, {0.0, 1.0}, {-0.0, 5e10 / 3.0}}},
                   {"two", {1e-5 / 3.0, 2e-5 / 3.0, 4e-5 / 3.0}}}});
  s.pictures = {{.name = "p", .caption = "P", .source = "data:,p"}, {.name = "q", .caption = "Q", .source = "q.png"}};
  return s;
}

struct Shown {
  std::string page, csv, lists;
};

/// Figures as a report lists them.
Json listed(std::span<const Section> sections) {
  return object_json([&](DocumentVisitor& v) {
    std::vector<ListedFigure> figures = listed_figures(sections);
    v.member({"figures"}, figures);
    std::vector<ListedCurve> curves = listed_curves(sections);
    v.member({"curves"}, curves);
    describe_undefined_sections(v, sections);
  });
}

Shown shown(const Section& section) {
  const TempFolder folder;
  HtmlPage page("Title");
  add_section(page, section, folder.path(), "A split in two");
  const std::span<const Section> all(&section, 1);
  return {page.text(), read_file(folder / "curves/c.csv"), listed(all).dump()};
}

TEST(ReportPage, IsTheSameWhetherItsSectionWentThroughAFileOrNot) {
  const TempFolder folder;
  const Section section = long_numbers();
  save_part(folder / "part.json", section_json(section));
  const Shown direct = shown(section), from_file = shown(section_from_json(load_part(folder / "part.json")));
  EXPECT_EQ(direct.page, from_file.page);
  EXPECT_EQ(direct.csv, from_file.csv);
  EXPECT_EQ(direct.lists, from_file.lists);
  EXPECT_NE(direct.page.find("<td>10.8</td>"), std::string::npos);
  EXPECT_NE(direct.page.find("src=\"data:,p\""), std::string::npos);
  EXPECT_NE(direct.page.find("src=\"q.png\""), std::string::npos);
}

TEST(ReportPage, ListsFiguresCurvesAndWhatIsUndefinedBySection) {
  const std::array<Section, 2> sections{long_numbers(),
                                        Section{.name = "look", .figures = {{.name = "k", .value = 1.0}}}};
  const Json lists = listed(sections), figures = lists["figures"];
  ASSERT_EQ(figures.size(), 4u);
  EXPECT_EQ(
      figures[0].dump(),
      R"({"name":"f","title":"F","unit":"mm","value":10.75,"low":-1e-300,"high":0.333333333,"section":"colors"})");
  EXPECT_EQ(figures[1]["undefined"], "not defined for this input");
  EXPECT_EQ(figures[2].dump(), R"({"name":"h","title":"H","unit":"","value":0.0,"section":"colors"})");
  EXPECT_EQ(figures[3]["section"], "look");
  EXPECT_EQ(lists["curves"].dump(), R"([{"file":"curves/c.csv","drawing":"curves/c.svg","title":"C"}])");
  EXPECT_EQ(lists["undefined_sections"].dump(), R"([{"section":"colors","reason":"why not"}])");
}

TEST(ReportPage, FourFiguresThatAreZeroAreASentenceAndNoRowsThreeAreRows) {
  for (const std::size_t count : {kMinZeros - 1, kMinZeros}) {
    const TempFolder folder;
    Section section{.name = "places", .title = "Places", .figures = {{.name = "one", .title = "One", .value = 1.0}}};
    for (std::size_t i = 0; i < count; ++i)
      section.figures.push_back({.name = "z", .title = "Z" + std::to_string(i), .value = 0.0, .split = 0.5});
    section.figures.push_back({.name = "w", .title = "Wide", .value = 0.0, .low = 0.0, .high = 2.0});
    HtmlPage page("Title");
    add_section(page, section, folder.path(), "A split in two");
    EXPECT_EQ(page.text().find("<td>Z0</td>") != std::string::npos, count < kMinZeros);
    EXPECT_EQ(page.text().find("4 figures are 0: Z0; Z1; Z2; Z3.") != std::string::npos, count == kMinZeros);
    EXPECT_NE(page.text().find("<td>One</td>"), std::string::npos);
    EXPECT_NE(page.text().find("<td>Wide</td>"), std::string::npos);
    EXPECT_EQ(listed(std::span<const Section>(&section, 1))["figures"].size(), count + 2);
  }
}

TEST(ReportPage, RefusesNumbersThatAreNone) {
  const TempFolder folder;
  Section section = long_numbers();
  section.curves[0].columns[0].band[1].second = std::numeric_limits<double>::infinity();
  HtmlPage page("Title");
  EXPECT_THROW(add_section(page, section, folder.path(), ""), InvalidInput);
  section = long_numbers();
  section.figures[0].low = std::nan("");
  EXPECT_THROW(add_section(page, section, folder.path(), ""), InvalidInput);
}

TEST(ReportPage, EmbedsPicturesInPlaceOfTheirPixels) {
  const TempFolder folder;
  std::vector<Picture> pictures{{.name = "a", .caption = "A", .image = ImageF(2, 2, 3)},
                                {.name = "b", .caption = "B", .image = ImageF(3, 1, 3)}};
  embed_pictures(pictures, folder / "work/scratch.png");
  for (const Picture& picture : pictures) {
    EXPECT_TRUE(picture.image.empty());
    EXPECT_TRUE(picture.source.starts_with("data:image/png;base64,"));
  }
  EXPECT_NE(pictures[0].source, pictures[1].source);
  EXPECT_FALSE(std::filesystem::exists(folder / "work/scratch.png"));
}

}  // namespace
}  // namespace patinate::analysis
