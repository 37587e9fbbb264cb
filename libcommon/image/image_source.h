/// \file
/// What decodes and what encodes an image, whoever does it: libpng and OpenEXR for PNG and EXR, which are our own
/// formats, or for all others OpenImageIO in the module `patinate-media` (media_module.h). Inside of image input and
/// output only.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/image/file_words.h"
#include "libcommon/image/image_decoder.h"
#include "patinate/image/image_io.h"

namespace patinate {

/// Meaning of a picture's numbers. Gray counts as RGB.
enum class ColorModel { Rgb, Cmyk, Lab, IccLab };

/// An open image file: ImageDecoder is one whose size is bounded.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  /// Facts of the file, with one frame.
  [[nodiscard]] virtual ImageInfo first_info() const = 0;
  [[nodiscard]] virtual int count_frames() = 0;
  /// @throws IoError if there is no such frame, it is damaged, or of another size than the first.
  [[nodiscard]] virtual CodedImage read(int frame) = 0;
  /// @param begin,end  Rows of the first image, within it. @throws IoError if they are damaged.
  [[nodiscard]] virtual CodedImage read_rows(int begin, int end) = 0;
  /// Meaning of the pixels' channels before they become RGB; of Cmyk and the two of L*a*b* (TIFF's).
  [[nodiscard]] virtual ColorModel color_model() const { return ColorModel::Rgb; }
  /// An ICC profile; "" = none.
  [[nodiscard]] virtual std::string profile() const { return ""; }
  /// Orientation of the stored picture; EXIF's, [1, 8]. The other functions do not turn.
  [[nodiscard]] virtual int orientation() const { return 1; }
};

/// nullptr if it is no such file, or one with something that only OpenImageIO reads as we want it.
[[nodiscard]] std::unique_ptr<ImageSource> open_png(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<ImageSource> open_exr(const std::filesystem::path& path);

/// A file by OpenImageIO, with what read_file_words() finds in it. @throws IoError
[[nodiscard]] std::unique_ptr<ImageSource> open_worded(const std::filesystem::path& path);

/// Where the bytes of an encoder go. It is not told of failures, since libpng would print a line of its own: who writes
/// asks in the end.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// @param offset  From the start of the file; encoders go back (EXR, TIFF).
  virtual void write(std::int64_t offset, const void* bytes, std::size_t size) = 0;
};

/// Bytes in memory.
struct MemorySink final : ByteSink {
  std::string bytes;
  void write(std::int64_t offset, const void* from, std::size_t size) override {
    const std::size_t at = offset;
    if (bytes.size() < at + size) bytes.resize(at + size);
    std::copy_n(static_cast<const char*>(from), size, bytes.begin() + offset);
  }
};

/// Format of the encoded picture.
struct EncodedFormat {
  enum class Values { Codes, Half, Float };
  std::string name;  ///< A file's; its extension says which format. For messages too.
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;  ///< Names in an EXR; their number in other files.
  Values values = Values::Codes;
  bool has_facts = true;  ///< Who wrote it, a date that is none, and the key.
  std::string key = "";
  std::optional<ValueScale> scale = {};  ///< Scale of an EXR with facts.
  std::string unit = "";                 ///< Unit of an EXR with facts whose values are not scaled.
  bool is_srgb = false;                  ///< Says so in a file without facts.
  int png_level = 6;                     ///< PNG level of zlib, [0, 9].
  /// EXR level of zlib. OpenEXR's own 4 takes a fifth more time for a simulation's frames, for 3 % fewer bytes.
  int exr_level = 3;
  int num_threads = 1;  ///< That compress an EXR's rows; > 0. The same bytes.
};

/// A file that is being encoded, row by row.
class ImageEncoder {
 public:
  virtual ~ImageEncoder() = default;
  /// The next rows. @param values  8-bit codes, or floats. @throws CannotComplete
  virtual void write(int num_rows, const void* values) = 0;
  /// After the last row. @throws CannotComplete
  virtual void finish() = 0;
};

/// @param sink  Outlives the encoder. @throws ParseError on an unknown extension; CannotComplete.
[[nodiscard]] std::unique_ptr<ImageEncoder> create_encoder(const EncodedFormat& format, ByteSink& sink);
[[nodiscard]] std::unique_ptr<ImageEncoder> create_png_encoder(const EncodedFormat& format, ByteSink& sink);
[[nodiscard]] std::unique_ptr<ImageEncoder> create_exr_encoder(const EncodedFormat& format, ByteSink& sink);

/// The bytes of a whole file. @param values  8-bit codes, or floats.
[[nodiscard]] std::string encoded(const EncodedFormat& format, const void* values);

/// Date that patinate writes, so that equal images give equal bytes.
inline constexpr const char* kNoImageDate = "1970:01:01 00:00:00";
inline constexpr const char* kImageSoftware = "patinate";
/// Where a content key stands in a file.
inline constexpr const char* kImageKeyAttribute = "patinate:key";
/// Values that 0 and 1 of an EXR stand for.
inline constexpr const char* kImageLowAttribute = "patinate:low";
inline constexpr const char* kImageHighAttribute = "patinate:high";
inline constexpr const char* kImageUnitAttribute = "patinate:unit";
inline constexpr const char* kImageKeyDescription = "patinate key ";

/// Sets what a file's words say of its color and alpha. Takes the last channel away where it is no alpha.
void set_color_words(ImageInfo& info, const FileWords& words);

/// Sets what a file's own words mean for a reader. @param key  Of its attribute. @param description  May hold the key
/// instead.
inline void set_words(ImageInfo& info, std::string key, const std::string& description) {
  info.key = std::move(key);
  const std::string start = kImageKeyDescription;
  if (info.key.empty() && description.starts_with(start)) info.key = description.substr(start.size());
}

}  // namespace patinate
