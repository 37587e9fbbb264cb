#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>
#include <half.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/image/image_source.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// A sink as OpenEXR writes to it.
class SinkStream final : public Imf::OStream {
 public:
  SinkStream(const std::string& name, ByteSink& sink) : OStream(name.c_str()), sink_(sink) {}
  void write(const char bytes[], int size) override {
    sink_.write(static_cast<std::int64_t>(offset_), bytes, static_cast<std::size_t>(size));
    offset_ += static_cast<std::uint64_t>(size);
  }
  std::uint64_t tellp() override { return offset_; }
  void seekp(std::uint64_t offset) override { offset_ = offset; }

 private:
  ByteSink& sink_;
  std::uint64_t offset_ = 0;
};

/// The process has one pool of OpenEXR threads. The pool grows to the largest number that was asked for; each file
/// uses its own number of them.
/// @returns what an OutputFile is told: 0 for the thread that calls.
int threads_of_file(int num_threads) {
  if (num_threads <= 1) return 0;
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  if (Imf::globalThreadCount() < num_threads) Imf::setGlobalThreadCount(num_threads);
  return num_threads;
}

/// The bytes of OpenImageIO's writer, whose settings these are.
class ExrEncoder final : public ImageEncoder {
 public:
  ExrEncoder(const EncodedFormat& format, ByteSink& sink)
      : format_(format),
        type_(format.values == EncodedFormat::Values::Half ? Imf::HALF : Imf::FLOAT),
        stream_(format.name, sink) {
    guarded([&] { file_.emplace(stream_, header(), threads_of_file(format_.num_threads)); });
  }

  void write(int num_rows, const void* values) override {
    const std::size_t row_size = static_cast<std::size_t>(format_.width) * format_.channels.size();
    const auto* from = static_cast<const float*>(values);
    if (type_ == Imf::FLOAT) return put(num_rows, reinterpret_cast<const char*>(from), sizeof(float));
    const int most_rows = std::max(1, static_cast<int>(kBlockValues / row_size));
    for (int done = 0; done < num_rows; done += most_rows) {
      const int rows = std::min(most_rows, num_rows - done);
      const float* block = from + static_cast<std::size_t>(done) * row_size;
      halves_.assign(block, block + static_cast<std::size_t>(rows) * row_size);
      put(rows, reinterpret_cast<const char*>(halves_.data()), sizeof(half));
    }
  }
  void finish() override {
    guarded([&] { file_.reset(); });
  }

 private:
  static constexpr std::size_t kBlockValues = std::size_t{1} << 22;

  template <class Work>
  void guarded(const Work& work) const {
    try {
      work();
    } catch (const std::exception& e) {
      const std::string problem = e.what();
      throw CannotComplete(format_.name + ": cannot be written; " + problem.substr(0, problem.find('\n')));
    }
  }

  [[nodiscard]] Imf::Header header() const {
    const Imath::Box2i window(Imath::V2i(0, 0), Imath::V2i(format_.width - 1, format_.height - 1));
    Imf::Header header(window, window);
    header.compression() = Imf::ZIP_COMPRESSION;
    header.zipCompressionLevel() = format_.exr_level;
    for (const std::string& name : format_.channels) header.channels().insert(name, Imf::Channel(type_));
    if (!format_.has_facts) return header;
    header.insert("capDate", Imf::StringAttribute(kNoImageDate));
    header.insert("Software", Imf::StringAttribute(kImageSoftware));
    if (!format_.key.empty()) {
      header.insert(kImageKeyAttribute, Imf::StringAttribute(format_.key));
      header.insert("comments", Imf::StringAttribute(kImageKeyDescription + format_.key));
    }
    if (format_.scale) {
      header.insert(kImageLowAttribute, Imf::DoubleAttribute(format_.scale->low));
      header.insert(kImageHighAttribute, Imf::DoubleAttribute(format_.scale->high));
      header.insert(kImageUnitAttribute, Imf::StringAttribute(format_.scale->unit));
    }
    if (!format_.unit.empty()) header.insert(kImageUnitAttribute, Imf::StringAttribute(format_.unit));
    return header;
  }

  void put(int num_rows, const char* rows, std::size_t value_size) {
    guarded([&] {
      const std::size_t pixel = format_.channels.size() * value_size,
                        row = pixel * static_cast<std::size_t>(format_.width);
      Imf::FrameBuffer buffer;
      for (std::size_t c = 0; c < format_.channels.size(); ++c) {
        // OpenEXR wants the place of the first row, which may be gone.
        buffer.insert(format_.channels[c], Imf::Slice::Make(type_, rows + c * value_size, Imath::V2i(0, row_),
                                                            format_.width, num_rows, pixel, row));
      }
      file_->setFrameBuffer(buffer);
      file_->writePixels(num_rows);
      row_ += num_rows;
    });
  }

  EncodedFormat format_;
  Imf::PixelType type_;
  SinkStream stream_;
  std::optional<Imf::OutputFile> file_;
  std::vector<half> halves_;
  int row_ = 0;
};

}  // namespace

std::unique_ptr<ImageEncoder> create_exr_encoder(const EncodedFormat& format, ByteSink& sink) {
  return std::make_unique<ExrEncoder>(format, sink);
}

}  // namespace patinate
