#include "libcommon/output/glb_binary.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "libcommon/image/image_source.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// Passes an encoder's output, in order, to a function.
class Pipe final : public ByteSink {
 public:
  explicit Pipe(std::function<bool(const void*, std::size_t)> append) : append_(std::move(append)) {}
  void write(std::int64_t /*offset*/, const void* bytes, std::size_t size) override {
    is_good_ = is_good_ && append_(bytes, size);
  }
  [[nodiscard]] bool is_good() const { return is_good_; }

 private:
  std::function<bool(const void*, std::size_t)> append_;
  bool is_good_ = true;
};

}  // namespace

GlbBinary::GlbBinary(const std::filesystem::path& glb)
    : shown_path_(glb.string()),
      place_(glb.parent_path() / (glb.filename().string() + ".pieces")),
      file_(std::fopen(place_.temporary().c_str(), "w+b")) {
  if (file_ == nullptr) fail("cannot be written; is the folder writable?");
}

void GlbBinary::fail(const std::string& problem) const { throw CannotComplete(shown_path_ + ": " + problem); }

GlbBinary::~GlbBinary() { (void)std::fclose(file_); }

void GlbBinary::append(const void* data, std::size_t size) {
  if (size > 0 && std::fwrite(data, 1, size, file_) != size) fail("cannot be written; is the disk full?");
  size_ += size;
}

void GlbBinary::begin_piece() {
  constexpr std::array<char, 3> kZeros{};
  append(kZeros.data(), (4 - size_ % 4) % 4);
  views_.push_back({.offset = size_});
}

int GlbBinary::add(const void* data, std::size_t size, int target) {
  begin_piece();
  append(data, size);
  views_.back().size = size;
  views_.back().target = target;
  return static_cast<int>(views_.size()) - 1;
}

int GlbBinary::add_png(const GlbTexture& texture, bool is_color) {
  begin_piece();
  Pipe pipe([&](const void* data, std::size_t size) {
    size_ += size;
    return std::fwrite(data, 1, size, file_) == size;
  });
  const EncodedFormat format{.name = shown_path_,
                             .width = texture.width,
                             .height = texture.height,
                             .channels = std::vector<std::string>(static_cast<std::size_t>(texture.channels)),
                             .has_facts = false,
                             .is_srgb = is_color};
  const std::unique_ptr<ImageEncoder> out = create_png_encoder(format, pipe);
  const auto check_disk = [&] {
    if (!pipe.is_good()) fail("a texture could not be written; is the disk full?");
  };
  int row = 0;
  texture.make([&](std::span<const std::uint8_t> codes) {
    const auto row_size = static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.channels);
    const std::size_t num_rows = codes.size() / row_size;
    if (codes.size() % row_size != 0 || num_rows > static_cast<std::size_t>(texture.height - row))
      throw InvalidInput("glb: a texture makes other rows than it has");
    out->write(static_cast<int>(num_rows), codes.data());
    check_disk();
    row += static_cast<int>(num_rows);
  });
  if (row != texture.height) throw InvalidInput("glb: a texture makes other rows than it has");
  out->finish();
  check_disk();
  views_.back().size = size_ - views_.back().offset;
  return static_cast<int>(views_.size()) - 1;
}

void GlbBinary::copy_to(std::ostream& out) {
  std::vector<char> block(std::size_t{1} << 20);
  std::rewind(file_);
  for (std::uint64_t done = 0; done < size_;) {
    const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), size_ - done));
    if (std::fread(block.data(), 1, size, file_) != size) fail("cannot be written; is the disk full?");
    out.write(block.data(), static_cast<std::streamsize>(size));
    done += size;
  }
  constexpr std::array<char, 3> kZeros{};
  out.write(kZeros.data(), static_cast<std::streamsize>((4 - size_ % 4) % 4));
}

}  // namespace patinate
