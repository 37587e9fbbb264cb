// Entry of the module `patinate-media` and the library `patinate::media`: see libcommon/image/media_module.h.
#include "libcommon/media/libav.h"
#include "libcommon/media/oiio.h"

namespace patinate::media {

namespace {

class Media final : public MediaModule {
 public:
  [[nodiscard]] std::unique_ptr<ImageSource> open_image(const std::filesystem::path& path,
                                                        const std::filesystem::path& name,
                                                        bool has_raw_color) override {
    configure_image_library();
    return media::open_image(path, name, has_raw_color);
  }
  [[nodiscard]] std::unique_ptr<ImageEncoder> create_encoder(const EncodedFormat& format, ByteSink& sink) override {
    configure_image_library();
    return create_image_encoder(format, sink);
  }
  [[nodiscard]] std::unique_ptr<MovieEncoder> create_movie(const MovieFormat& format) override {
    return media::create_movie(format);
  }
  [[nodiscard]] std::unique_ptr<MovieEncoder> create_gif(const std::string& shown_path, double fps,
                                                         ByteSink& sink) override {
    configure_image_library();
    return media::create_gif(shown_path, fps, sink);
  }
  [[nodiscard]] std::string movie_comment(const std::filesystem::path& path) override {
    return media::movie_comment(path);
  }
};

}  // namespace

}  // namespace patinate::media

extern "C" [[gnu::visibility("default")]] patinate::MediaModule* patinate_media_3() {
  static patinate::media::Media module;
  return &module;
}
