#include "libcommon/image/whole_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "libcommon/core/files.h"
#include "libcommon/core/random.h"
#include "patinate/image/image_io.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

void write(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

ImageF noise_square(int side) {
  ImageF image(side, side, 3);
  for (std::int64_t i = 0; i < 3 * image.num_pixels(); ++i)
    image.data()[i] = static_cast<float>(RandomStream(1, static_cast<std::uint64_t>(i), 0).uniform());
  return image;
}

TEST(WholeFile, APictureIsCutOffAtAnyLengthButItsOwn) {
  const testing_support::TempFolder temp;
  for (const char* name : {"a.png", "a.jpg"}) {
    const std::filesystem::path file = temp / name;
    write_srgb8(file, noise_square(24));
    const std::string whole = read_file(file, 1 << 20);
    EXPECT_FALSE(is_cut_off(file)) << name;
    for (std::size_t length = 12; length < whole.size(); length += 7) {
      write(file, whole.substr(0, length));
      EXPECT_TRUE(is_cut_off(file)) << name << ' ' << length;
    }
    write(file, whole + std::string(100, 'x'));  // Cameras append what is theirs.
    EXPECT_FALSE(is_cut_off(file)) << name;
  }
}

/// A thumbnail ends, the picture behind it does not; and a picture of several blocks.
TEST(WholeFile, TheEndOfAThumbnailIsNotThePictures) {
  const testing_support::TempFolder temp;
  const std::filesystem::path file = temp / "a.jpg";
  write_srgb8(file, noise_square(1600));
  const std::string picture = read_file(file, 1 << 24), thumbnail = "\xff\xd8 small \xff\xd9";
  ASSERT_GT(picture.size(), std::size_t{1} << 21);
  const std::string length{'\0', static_cast<char>(thumbnail.size() + 2)};
  const std::string whole = "\xff\xd8\xff\xe1" + length + thumbnail + picture.substr(2);
  write(file, whole);
  EXPECT_FALSE(is_cut_off(file));
  write(file, whole + std::string(100, 'x'));
  EXPECT_FALSE(is_cut_off(file));
  write(file, whole.substr(0, whole.size() - 40));
  EXPECT_TRUE(is_cut_off(file));
}

TEST(WholeFile, OfOtherFormatsNothingIsSaid) {
  const testing_support::TempFolder temp;
  write(temp / "a.txt", "no picture");
  EXPECT_FALSE(is_cut_off(temp / "a.txt"));
  EXPECT_FALSE(is_cut_off(temp / "missing.png"));
}

}  // namespace
}  // namespace patinate
