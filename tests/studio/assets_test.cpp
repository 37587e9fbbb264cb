#include "tools/studio/client/assets.h"

#include <gtest/gtest.h>

#include <string>

namespace patinate {
namespace {

std::string page() { return std::string(studio::find_studio_asset("/")->bytes); }

TEST(StudioAssets, PageIsThereWhetherOrNotTheClientWasBuilt) {
  ASSERT_NE(studio::find_studio_asset("/"), nullptr);
  EXPECT_TRUE(page().starts_with("<!doctype html>"));
  EXPECT_EQ(studio::find_studio_asset("/nothing.js"), nullptr);
}

TEST(StudioAssets, PageAsksForNothingThatIsNotInTheProgram) {
  const std::string text = page();
  for (const std::string attribute : {"src=\"", "href=\""}) {
    for (std::size_t at = text.find(attribute); at != std::string::npos; at = text.find(attribute, at + 1)) {
      const std::size_t begin = at + attribute.size();
      const std::string target = text.substr(begin, text.find('"', begin) - begin);
      if (target.starts_with("data:")) continue;
      EXPECT_NE(studio::find_studio_asset(target), nullptr) << target;
    }
  }
}

TEST(StudioAssets, LicenseOfThreeJsGoesWithItsCode) {
  if (!studio::has_studio_client()) GTEST_SKIP() << "built without the client";
  const std::string_view script = studio::find_studio_asset("/studio.js")->bytes;
  EXPECT_NE(script.substr(0, 4000).find("The above copyright notice and this permission notice shall be included"),
            std::string_view::npos);
}

}  // namespace
}  // namespace patinate
