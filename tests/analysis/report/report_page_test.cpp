#include "analysis/report/report_page.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace patinate::analysis
