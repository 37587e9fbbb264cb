#include "tools/studio/client/assets.h"

#include <gtest/gtest.h>

#include <regex>
#include <string>

namespace patinate {
namespace {

std::string page() { return std::string(find_studio_asset("/")->bytes); }

TEST(StudioAssets, PageIsThereWhetherOrNotTheClientWasBuilt) {
  ASSERT_NE(find_studio_asset("/"), nullptr);
  EXPECT_TRUE(page().starts_with("<!doctype html>"));
  EXPECT_EQ(find_studio_asset("/nothing.js"), nullptr);
}

TEST(StudioAssets, PageAsksForNothingThatIsNotInTheProgram) {
  const std::string text = page();
  const std::regex reference(R"#((?:src|href)="([^"]+)")#");
  for (std::sregex_iterator it(text.begin(), text.end(), reference); it != std::sregex_iterator(); ++it) {
    const std::string target = (*it)[1];
    if (target.starts_with("data:")) continue;
    EXPECT_NE(find_studio_asset(target), nullptr) << target;
  }
}

TEST(StudioAssets, LicenceOfThreeJsGoesWithItsCode) {
  if (!has_studio_client()) GTEST_SKIP() << "built without the client";
  const std::string_view script = find_studio_asset("/studio.js")->bytes;
  EXPECT_NE(script.substr(0, 4000).find("The above copyright notice and this permission notice shall be included"), std::string_view::npos);
}

}  // namespace
}  // namespace patinate
