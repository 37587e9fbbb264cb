#include "libcommon/image/media_module.h"

#include "libcommon/core/module.h"

/// There when the program links `patinate::media`.
extern "C" [[gnu::weak]] patinate::MediaModule* patinate_media_3();

namespace patinate {

MediaModule& media_module() {
  using Entry = MediaModule* (*)();
  static MediaModule& module = [&]() -> MediaModule& {
    if (&patinate_media_3 != nullptr) return *patinate_media_3();
    return *reinterpret_cast<Entry>(module_function("patinate-media", kMediaEntry))();
  }();
  return module;
}

}  // namespace patinate
