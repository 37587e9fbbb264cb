#include "libcommon/image/image_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libcommon/core/files.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::TempFolder;

ImageF noise_beyond_codes(int width, int height) {
  ImageF image(width, height, 3);
  RandomStream random(4, 0);
  for (float& v : image.values()) v = static_cast<float>(random.uniform()) * 1.2f - 0.1f;
  return image;
}

TEST(ImageRows, WrittenByRowsIsWhatIsWrittenAtOnceToTheByte) {
  const TempFolder folder;
  const ImageF image = noise_beyond_codes(67, 150);
  const ImageU8 codes = srgb8_from_linear(image);
  for (const char* extension : {".png", ".jpg", ".tif", ".exr"}) {
    write_color(folder / (std::string("whole") + extension), image, "a key");
    const std::filesystem::path file = folder / (std::string("rows") + extension);
    ImageRowWriter writer(file, image.width(), image.height(), {.key = "a key"});
    for (int y = 0; y < image.height(); y += 16) {
      const std::size_t count = static_cast<std::size_t>(std::min(16, image.height() - y)) * image.row(0).size();
      if (writer.takes_codes()) {
        writer.write(std::span(codes.row(y).data(), count));
      } else {
        writer.write(std::span(image.row(y).data(), count));
      }
      EXPECT_FALSE(std::filesystem::exists(file));
    }
    writer.finish();
    EXPECT_EQ(read_file(file), read_file(folder / (std::string("whole") + extension))) << extension;
  }
}

// Chunks that are compressed at the same time are written in their order. Rows that end in the middle of one, too.
TEST(ImageRows, AnyNumberOfThreadsWritesTheSameExr) {
  const TempFolder folder;
  const ImageF image = noise_beyond_codes(129, 1000);
  for (const ExrDepth depth : {ExrDepth::Half, ExrDepth::Float}) {
    std::string alone;
    for (const int threads : {1, 2, 4, 3}) {
      for (const int rows_at_once : {1000, 8 * threads * kExrChunkRows, 100}) {
        ImageRowWriter writer(folder / "a.exr", image.width(), image.height(),
                              {.depth = depth, .num_threads = threads});
        for (int y = 0; y < image.height(); y += rows_at_once) {
          const int rows = std::min(rows_at_once, image.height() - y);
          writer.write(std::span(image.row(y).data(), static_cast<std::size_t>(rows) * image.row(0).size()));
        }
        writer.finish();
        const std::string written = read_file(folder / "a.exr");
        if (alone.empty()) alone = written;
        EXPECT_EQ(written, alone) << threads << " threads, " << rows_at_once << " rows";
      }
    }
  }
}

// Jobs have items that write at the same time.
TEST(ImageRows, FilesThatAreWrittenAtOnceShareThreads) {
  const TempFolder folder;
  const ImageF image = noise_beyond_codes(61, 300);
  constexpr int kFiles = 8;
  parallel_for(kFiles, 1, {.on_progress = {}, .stop = {}, .num_threads = 4}, [&](std::int64_t file, std::int64_t) {
    ImageRowWriter writer(folder / (std::to_string(file) + ".exr"), image.width(), image.height(),
                          {.num_threads = 1 + static_cast<int>(file % 4)});
    writer.write(image.values());
    writer.finish();
  });
  for (int file = 1; file < kFiles; ++file)
    EXPECT_EQ(read_file(folder / (std::to_string(file) + ".exr")), read_file(folder / "0.exr")) << file;
}

TEST(ImageRows, ReadByRowsIsWhatIsReadAtOnce) {
  const TempFolder folder;
  const ImageF image = noise_beyond_codes(40, 90);
  write_exr(folder / "a.exr", image, {"source.x", "source.y", "angle"}, ExrDepth::Float);
  write_color(folder / "a.png", image);
  for (const auto& [name, channels] :
       {std::pair<std::string, std::vector<std::string>>{"a.exr", {"source.y", "source.x"}}, {"a.png", {"B", "R"}}}) {
    const ImageF whole = read_channels(folder / name, channels);
    ImageRowReader reader(folder / name, channels);
    ASSERT_EQ(reader.height(), 90);
    for (const auto& [begin, end] : {std::pair{0, 16}, {16, 17}, {80, 90}, {3, 70}}) {
      const ImageF rows = reader.read(begin, end);
      for (int y = begin; y < end; ++y)
        EXPECT_TRUE(std::ranges::equal(rows.row(y - begin), whole.row(y))) << name << ' ' << y;
    }
    EXPECT_THROW((void)reader.read(80, 91), IoError);
    EXPECT_THROW((void)reader.read(5, 5), IoError);
  }
  EXPECT_THROW(ImageRowReader(folder / "a.exr", {"source.z"}), IoError);
  EXPECT_THROW(ImageRowReader(folder / "b.exr", {"source.x"}), IoError);
}

TEST(ImageRows, NothingIsLeftOfAFileThatWasNotFinished) {
  const TempFolder folder;
  {
    ImageRowWriter writer(folder / "a.png", 8, 8);
    writer.write(std::vector<std::uint8_t>(24 * 3));
    EXPECT_THROW(writer.finish(), InvalidInput);
  }
  {
    ImageRowWriter writer(folder / "a.exr", 8, 8);
    EXPECT_THROW(writer.write(std::vector<float>(24, NAN)), InvalidInput);
    EXPECT_THROW(writer.write(std::vector<float>(23)), InvalidInput);
    EXPECT_THROW(writer.write(std::vector<float>(24 * 9)), InvalidInput);
    EXPECT_THROW(writer.write(std::vector<std::uint8_t>(24)), InvalidInput);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  EXPECT_THROW(ImageRowWriter(folder / "a.bmp", 8, 8), ParseError);
  EXPECT_THROW(ImageRowWriter(folder / "none" / "a.png", 8, 8), CannotComplete);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

// A TIFF is several strips here; some readers of OpenImageIO say that rows are missing, and count them as read.
TEST(ImageRows, MissingRowsAreAnError) {
  const TempFolder folder;
  for (const char* name : {"a.tif", "a.png", "a.exr", "a.jpg"}) {
    write_color(folder / name, noise_beyond_codes(64, 256));
    const std::string whole = read_file(folder / name);
    for (const double share : {0.5, 0.9}) {
      write_atomically(folder / name, std::string_view(whole).substr(
                                          0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
      EXPECT_THROW(
          {
            ImageRowReader rows(folder / name, {"R", "G", "B"});
            for (int y = 0; y < 256; y += 64) (void)rows.read(y, y + 64);
          },
          IoError)
          << name << " " << share;
    }
  }
}

// No file may grow: what a full disk does, and as EFBIG instead of ENOSPC.
TEST(ImageRows, AFullDiskIsNoticed) {
  const testing_support::FileSizeLimit limit(0);
  for (const char* extension : {".png", ".tif", ".exr", ".jpg"}) {
    const TempFolder folder;
    const auto write = [&] {
      ImageRowWriter writer(folder / (std::string("a") + extension), 256, 256);
      for (int y = 0; y < 256; y += 64) {
        if (writer.takes_codes()) {
          writer.write(std::vector<std::uint8_t>(64 * 256 * 3, 7));
        } else {
          writer.write(std::vector<float>(64 * 256 * 3, 0.3f));
        }
      }
      writer.finish();
    };
    EXPECT_THROW(write(), CannotComplete) << extension;
    EXPECT_FALSE(std::filesystem::exists(folder / (std::string("a") + extension)));
  }
}

}  // namespace
}  // namespace patinate
