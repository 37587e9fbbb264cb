#include "tools/studio/client/assets.h"

#include <algorithm>
#include <array>

namespace patinate::studio {

#ifdef PATINATE_STUDIO_CLIENT
extern const std::string_view kStudioIndex;
extern const std::string_view kStudioScript;
extern const std::string_view kStudioStyle;

bool has_studio_client() { return true; }

std::span<const StudioAsset> studio_assets() {
  static const std::array<StudioAsset, 3> kAssets{{{"/", "text/html; charset=utf-8", kStudioIndex},
                                                   {"/studio.js", "text/javascript; charset=utf-8", kStudioScript},
                                                   {"/studio.css", "text/css; charset=utf-8", kStudioStyle}}};
  return kAssets;
}
#else
bool has_studio_client() { return false; }

std::span<const StudioAsset> studio_assets() {
  static constexpr std::string_view kPage =
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>patinate studio</title>"
      "<body style=\"font:16px/1.5 sans-serif;max-width:40em;margin:4em auto\"><h1>patinate studio</h1>"
      "<p>This patinate was built without its browser client, because npm was missing. Install nodejs and npm "
      "(<code>tools/setup</code> does), "
      "then build again.</p></body></html>\n";
  static constexpr std::array<StudioAsset, 1> kAssets{{{"/", "text/html; charset=utf-8", kPage}}};
  return kAssets;
}
#endif

const StudioAsset* find_studio_asset(std::string_view path) {
  const std::span<const StudioAsset> assets = studio_assets();
  const auto found =
      std::find_if(assets.begin(), assets.end(), [path](const StudioAsset& a) { return a.path == path; });
  return found == assets.end() ? nullptr : &*found;
}

}  // namespace patinate::studio
