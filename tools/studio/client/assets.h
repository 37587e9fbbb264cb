/// \file
/// The browser client as part of the program: the files that the server hands out.
#pragma once

#include <span>
#include <string_view>

namespace patinate::studio {

struct StudioAsset {
  std::string_view path;  ///< "/", "/studio.js", "/studio.css".
  std::string_view type;  ///< For Content-Type.
  std::string_view bytes;
};

/// False where the program was built without npm: "/" is then a page that says so, and the only asset.
[[nodiscard]] bool has_studio_client();
/// All assets. They live as long as the program.
[[nodiscard]] std::span<const StudioAsset> studio_assets();
/// @return nullptr for a path that is none of them.
[[nodiscard]] const StudioAsset* find_studio_asset(std::string_view path);

}  // namespace patinate::studio
