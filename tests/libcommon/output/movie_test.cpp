#include "patinate/output/movie.h"

#include <gtest/gtest.h>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tests/support/errors.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::TempFolder;

/// A bright square that moves to the right; odd sizes.
ImageF picture(int i) {
  ImageF image(63, 41, 3, 0.1f);
  for (int y = 10; y < 25; ++y) {
    for (int x = 3 * i; x < 3 * i + 15; ++x) image.at(x, y, 0) = 0.8f;
  }
  return image;
}

class Movie : public testing::TestWithParam<const char*> {};

TEST_P(Movie, EqualPicturesGiveEqualBytesForAnyNumberOfThreads) {
  const TempFolder temp;
  const auto first = temp / (std::string("a") + GetParam()), second = temp / (std::string("b") + GetParam());
  RunControl one;
  one.num_threads = 1;
  write_movie(first, 12, picture, {.fps = 12.5}, "0123");
  write_movie(second, 12, picture, {.fps = 12.5}, "0123", one);
  EXPECT_EQ(read_file(first), read_file(second));
  EXPECT_GT(read_file(first).size(), 500u);
}

TEST_P(Movie, KeepsItsKey) {
  const TempFolder temp;
  const auto file = temp / (std::string("a") + GetParam());
  EXPECT_EQ(read_movie_key(file), "");
  write_movie(file, 3, picture, {}, "0123456789abcdef0123456789abcdef");
  EXPECT_EQ(read_movie_key(file), "0123456789abcdef0123456789abcdef");
}

TEST_P(Movie, IsWholeOrAbsent) {
  const TempFolder temp;
  const auto file = temp / (std::string("a") + GetParam());
  const auto changes_size = [](int i) { return i < 2 ? picture(i) : ImageF(40, 40, 3); };
  EXPECT_THROW(write_movie(file, 5, changes_size), InvalidInput);
  EXPECT_THROW(write_movie(file, 0, picture), InvalidInput);
  EXPECT_THROW(write_movie(file, 5, picture, {.fps = 0.0}), InvalidInput);
  EXPECT_THROW(write_movie(temp / "nowhere" / file.filename(), 2, picture), CannotComplete);
  EXPECT_TRUE(std::filesystem::is_empty(temp.path()));
}

// At the first byte, in the middle, and where only the end is missing.
TEST_P(Movie, IsAbsentAndNamedWhereTheDiskIsFull) {
  const TempFolder temp;
  const auto file = temp / (std::string("a") + GetParam());
  write_movie(file, 12, picture, {.fps = 12.5}, "0123");
  const auto size = std::filesystem::file_size(file);
  for (const auto limit : {std::uintmax_t{0}, size / 2, size - 1}) {
    std::filesystem::remove(file);
    std::string said;
    {
      const testing_support::FileSizeLimit full(limit);
      said = testing_support::error_of<CannotComplete>([&] { write_movie(file, 12, picture, {.fps = 12.5}, "0123"); });
    }
    EXPECT_TRUE(said.starts_with(file.string() + ": cannot be written")) << limit << " of " << size << ": " << said;
    EXPECT_TRUE(std::filesystem::is_empty(temp.path()));
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, Movie, testing::Values(".mp4", ".webm", ".gif"));

TEST(MovieFile, GifHoldsEveryPicture) {
  const TempFolder temp;
  write_movie(temp / "a.gif", 7, picture);
  EXPECT_EQ(probe_image(temp / "a.gif").num_frames, 7);
}

TEST(MovieFile, RefusesOtherExtensions) {
  const TempFolder temp;
  EXPECT_THROW(write_movie(temp / "a.avi", 2, picture), ParseError);
}

}  // namespace
}  // namespace patinate
