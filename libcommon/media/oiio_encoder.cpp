#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <string>
#include <utility>

#include "libcommon/media/oiio.h"
#include "patinate/core/error.h"

namespace patinate::media {

namespace {

constexpr int kJpegQuality =
    92;  ///< JPEG quality of pictures in files, [1, 100]; those in pages have less (picture_bytes.h).

/// A sink as OpenImageIO writes to it.
class SinkProxy final : public OIIO::Filesystem::IOProxy {
 public:
  SinkProxy(const std::string& name, ByteSink& sink) : IOProxy(name, Write), sink_(sink) {}
  [[nodiscard]] const char* proxytype() const override { return "patinate"; }
  bool seek(int64_t offset) override {
    m_pos = offset;
    return true;
  }
  size_t write(const void* bytes, size_t size) override {
    const size_t written = pwrite(bytes, size, m_pos);
    m_pos += static_cast<int64_t>(written);
    return written;
  }
  size_t pwrite(const void* bytes, size_t size, int64_t offset) override {
    sink_.write(offset, bytes, size);
    size_ = std::max(size_, offset + static_cast<int64_t>(size));
    return size;
  }
  [[nodiscard]] size_t size() const override { return static_cast<size_t>(size_); }

 private:
  ByteSink& sink_;
  int64_t size_ = 0;
};

OIIO::TypeDesc stored_type(EncodedFormat::Values values) {
  if (values == EncodedFormat::Values::Codes) return OIIO::TypeDesc::UINT8;
  return values == EncodedFormat::Values::Half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT;
}

OIIO::ImageSpec spec_of(const EncodedFormat& format) {
  const bool is_coded = format.values == EncodedFormat::Values::Codes;
  OIIO::ImageSpec spec(format.width, format.height, static_cast<int>(format.channels.size()),
                       stored_type(format.values));
  if (format.has_facts) {
    spec.attribute("DateTime", kNoImageDate);
    spec.attribute("Software", kImageSoftware);
    if (!format.key.empty()) {
      spec.attribute(kImageKeyAttribute, format.key);                         // EXR and PNG keep it,
      spec.attribute("ImageDescription", kImageKeyDescription + format.key);  // JPEG and TIFF this.
    }
    if (is_coded) spec.attribute("CompressionQuality", kJpegQuality);
  } else {
    if (format.is_srgb) spec.attribute("oiio:ColorSpace", "sRGB");
    if (format.name.ends_with(".png")) spec.attribute("png:compressionLevel", format.png_level);
  }
  if (is_coded) {
    spec.attribute("oiio:UnassociatedAlpha", 1);
  } else {
    spec.channelnames = format.channels;
    const bool is_exr = format.name.ends_with(".exr");
    spec.attribute("compression", is_exr ? "zip:" + std::to_string(format.exr_level) : "zip");
  }
  return spec;
}

class OiioEncoder final : public ImageEncoder {
 public:
  OiioEncoder(const EncodedFormat& format, ByteSink& sink)
      : name_(format.name), is_coded_(format.values == EncodedFormat::Values::Codes), proxy_(format.name, sink) {
    output_ = OIIO::ImageOutput::create(name_);
    if (!output_ || !output_->supports("ioproxy")) {
      (void)OIIO::geterror();
      throw ParseError(name_ + ": unknown image format; use .png, .jpg, .tif or .exr");
    }
    check(output_->set_ioproxy(&proxy_) && output_->open(name_, spec_of(format)));
  }

  void write(int num_rows, const void* values) override {
    check(output_->write_scanlines(row_, row_ + num_rows, 0, is_coded_ ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT,
                                   values));
    row_ += num_rows;
  }
  void finish() override { check(output_->close()); }

 private:
  void check(bool is_good) {
    if (!is_good) throw CannotComplete(name_ + ": cannot be written; " + one_line(output_->geterror()));
  }

  std::string name_;
  bool is_coded_;
  SinkProxy proxy_;
  std::unique_ptr<OIIO::ImageOutput> output_;
  int row_ = 0;
};

/// Animated GIF, whose palettes follow each picture.
class Gif final : public MovieEncoder {
 public:
  Gif(std::string shown_path, double fps, ByteSink& sink)
      : shown_path_(std::move(shown_path)), fps_(static_cast<float>(fps)), proxy_("movie.gif", sink) {}

  void add(const ImageU8& codes) override {
    OIIO::ImageSpec spec(codes.width(), codes.height(), 3, OIIO::TypeDesc::UINT8);
    spec.attribute("FramesPerSecond", fps_);
    if (!file_) {
      file_ = OIIO::ImageOutput::create("gif");
      spec_ = spec;
      check(file_ && file_->set_ioproxy(&proxy_) && file_->open("movie.gif", spec, OIIO::ImageOutput::Create));
    } else {
      if (spec.width != spec_.width || spec.height != spec_.height)
        throw InvalidInput(shown_path_ + ": a picture of a movie differs from the first in size");
      check(file_->open("movie.gif", spec, OIIO::ImageOutput::AppendSubimage));
    }
    check(file_->write_image(OIIO::TypeDesc::UINT8, codes.data()));
  }
  void finish() override { check(file_ && file_->close()); }

 private:
  void check(bool is_good) const {
    if (!is_good) throw CannotComplete(shown_path_ + ": cannot be written; is the disk full?");
  }

  std::string shown_path_;
  float fps_;
  SinkProxy proxy_;
  OIIO::ImageSpec spec_;
  std::unique_ptr<OIIO::ImageOutput> file_;
};

}  // namespace

std::unique_ptr<ImageEncoder> create_image_encoder(const EncodedFormat& format, ByteSink& sink) {
  return std::make_unique<OiioEncoder>(format, sink);
}

std::unique_ptr<MovieEncoder> create_gif(const std::string& shown_path, double fps, ByteSink& sink) {
  return std::make_unique<Gif>(shown_path, fps, sink);
}

}  // namespace patinate::media
