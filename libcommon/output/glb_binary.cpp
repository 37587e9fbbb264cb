#include "libcommon/output/glb_binary.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "patinate/core/error.h"

namespace patinate {

namespace {

/// What an encoder writes, in order, is passed on to a function. It is not told of failures: libpng would print a line
/// of its own.
class Pipe : public OIIO::Filesystem::IOProxy {
 public:
  explicit Pipe(std::function<bool(const void*, std::size_t)> append)
      : IOProxy("picture.png", Write), append_(std::move(append)) {}
  [[nodiscard]] const char* proxytype() const override { return "patinate"; }
  size_t write(const void* bytes, size_t size) override {
    is_good_ = is_good_ && append_(bytes, size);
    m_pos += static_cast<int64_t>(size);
    return size;
  }
  [[nodiscard]] size_t size() const override { return static_cast<size_t>(m_pos); }
  [[nodiscard]] bool is_good() const { return is_good_; }

 private:
  std::function<bool(const void*, std::size_t)> append_;
  bool is_good_ = true;
};

}  // namespace

GlbBinary::GlbBinary(const std::filesystem::path& glb)
    : shown_path_(glb.string()),
      place_(glb.parent_path() / (glb.stem().string() + ".textures")),
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
  const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create("picture.png", &pipe);
  OIIO::ImageSpec spec(texture.width, texture.height, texture.channels, OIIO::TypeDesc::UINT8);
  if (is_color) spec.attribute("oiio:ColorSpace", "sRGB");
  const auto check = [&](bool is_good) {
    if (!is_good || !pipe.is_good()) fail("a texture could not be written; is the disk full?");
  };
  check(out && out->open("picture.png", spec));
  int row = 0;
  texture.make([&](std::span<const std::uint8_t> codes) {
    const auto row_size = static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.channels);
    const std::size_t num_rows = codes.size() / row_size;
    if (codes.size() % row_size != 0 || num_rows > static_cast<std::size_t>(texture.height - row))
      throw InvalidInput("glb: a texture makes other rows than it has");
    const int end = row + static_cast<int>(num_rows);
    check(out->write_scanlines(row, end, 0, OIIO::TypeDesc::UINT8, codes.data()));
    row = end;
  });
  if (row != texture.height) throw InvalidInput("glb: a texture makes other rows than it has");
  check(out->close());
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
