#include "libcommon/core/file_name.h"

#include <gtest/gtest.h>

#include <string>

#include "patinate/core/error.h"

namespace patinate {
namespace {

TEST(FileName, IsOneFileOfItsFolderOnEverySystem) {
  for (const char* name : {"a", "hits", "verdigris.deposited", "a-b_c.9", "_x", "-"})
    EXPECT_TRUE(is_file_name(name)) << name;
  for (const char* name :
       {"", ".", "..", ".hidden", "a/b", "../../evil", "a\\b", "a b", "a\nb", "\xC3\xBC", "con:", "*"})
    EXPECT_FALSE(is_file_name(name)) << name;
  EXPECT_TRUE(is_file_name(std::string(kLongestFileName, 'x')));
  EXPECT_FALSE(is_file_name(std::string(kLongestFileName + 1, 'x')));
  EXPECT_THROW(require_file_name("control", "a/b"), InvalidInput);
}

}  // namespace
}  // namespace patinate
