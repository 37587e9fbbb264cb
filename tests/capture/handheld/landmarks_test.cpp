#include "capture/handheld/landmarks.h"

#include <gtest/gtest.h>

#include <string>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "tests/support/temp_folder.h"

namespace patinate::capture {
namespace {

using testing_support::TempFolder;

TEST(Landmarks, ATableIsReadBackAsItWasWritten) {
  const TempFolder folder;
  std::map<std::string, PhotoMarks> marks;
  const double numbers[] = {0.0, -0.5, 1.0 / 3.0, 4095.25, 0.1 + 0.2};
  int k = 0;
  for (const char* photo :
       {"a.jpg", "comma, quote \" and \"\".png", "#1.png", "\"", ",", "\xC3\xA4 \xFF.jpg", "photo"}) {
    for (const char* point : {"1", "10", "rim, left", "\"x\"", "point"})
      marks[photo][point] = {numbers[k % 5], numbers[(k + 2) % 5]}, ++k;
  }
  write_atomically(folder / "points.csv", landmarks_text(marks));
  EXPECT_EQ(read_landmarks(folder / "points.csv"), marks);
}

TEST(Landmarks, NamesThatALineCannotHoldAreRefused) {
  for (const char* name : {"", " a", "a ", "\ta", "a\nb", "a\rb"}) {
    EXPECT_THROW((void)landmarks_text({{name, {{"1", {0.0, 0.0}}}}}), InvalidInput) << name;
    EXPECT_THROW((void)landmarks_text({{"a.jpg", {{name, {0.0, 0.0}}}}}), InvalidInput) << name;
  }
  EXPECT_THROW((void)landmarks_text({}), InvalidInput);
  EXPECT_THROW((void)landmarks_text({{"a.jpg", {}}}), InvalidInput);
}

}  // namespace
}  // namespace patinate::capture
