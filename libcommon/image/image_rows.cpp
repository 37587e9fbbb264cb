#include "libcommon/image/image_rows.h"

#include <algorithm>
#include <new>
#include <utility>

#include "libcommon/image/decoded_image.h"
#include "libcommon/image/decoder_process.h"
#include "libcommon/image/image_decoder.h"
#include "patinate/core/error.h"

namespace patinate {

struct ImageRowReader::Impl {
  std::filesystem::path path;
  ImageDecoder decoder;
  ImageInfo info;
  std::vector<std::size_t> channels;

  explicit Impl(std::filesystem::path file) : path(std::move(file)), decoder(path), info(decoder.first_info()) {}
};

ImageRowReader::ImageRowReader(std::filesystem::path path, const std::vector<std::string>& channels) {
  if (is_decoded_apart(path)) throw IoError(path.string(), "is a movie or camera RAW; expected an image");
  impl_ = std::make_unique<Impl>(std::move(path));
  for (const std::string& name : channels) {
    const auto found = std::find(impl_->info.channels.begin(), impl_->info.channels.end(), name);
    if (found == impl_->info.channels.end()) {
      std::string there;
      for (const std::string& known : impl_->info.channels) there += " " + known;
      throw IoError(impl_->path.string(), "has no channel `" + name + "`; there are:" + there);
    }
    impl_->channels.push_back(static_cast<std::size_t>(found - impl_->info.channels.begin()));
  }
}

ImageRowReader::~ImageRowReader() = default;

int ImageRowReader::width() const { return impl_->info.width; }
int ImageRowReader::height() const { return impl_->info.height; }

ImageF ImageRowReader::read(int begin, int end) try {
  DecodedImage rows = decoded(impl_->decoder.read_rows(begin, end), impl_->info, impl_->path);
  const std::size_t num_stored = static_cast<std::size_t>(rows.values.channels()), num_asked = impl_->channels.size();
  ImageF picked(rows.values.width(), rows.values.height(), static_cast<int>(num_asked));
  const float* from = rows.values.data();
  float* to = picked.data();
  for (std::int64_t i = 0; i < picked.num_pixels(); ++i, from += num_stored, to += num_asked) {
    for (std::size_t c = 0; c < num_asked; ++c) to[c] = from[impl_->channels[c]];
  }
  return picked;
} catch (const std::bad_alloc&) {  // An interlaced PNG is decoded as a whole.
  throw CannotComplete(impl_->path.string() + ": does not fit into memory; use a smaller image, or fewer threads");
}

}  // namespace patinate
