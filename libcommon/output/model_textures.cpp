#include "libcommon/output/model_textures.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <utility>

#include "libcommon/core/text.h"
#include "libcommon/image/image_rows.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// The time's number is last, where programs look for that of an image in a sequence.
std::string file_name(const std::string& kind, std::size_t time, std::size_t tile, std::size_t num_tiles,
                      const std::string& extension) {
  return kind + (num_tiles > 1 ? "." + std::to_string(tile) : "") + "." + zero_padded(time, 4) + extension;
}

/// Rows as they come, or their complements: of gloss, roughness.
enum class Codes { AsTheyAre, Complement };

/// Where the files of a time go, and the key that they carry.
struct TexturePlace {
  const fs::path& folder;
  const std::string& prefix;
  std::size_t time;
  const std::string& key;
};

std::vector<std::string> write_codes_of(const TexturePlace& place, const std::string& kind,
                                        const std::vector<GlbTexture>& textures, Codes codes = Codes::AsTheyAre) {
  std::vector<std::string> names;
  for (std::size_t tile = 0; tile < textures.size(); ++tile) {
    const GlbTexture& texture = textures[tile];
    if (texture.width == 0) {
      names.emplace_back();
      continue;
    }
    const std::string name = file_name(kind, place.time, tile, textures.size(), ".png");
    ImageRowWriter out(
        place.folder / name, texture.width, texture.height,
        {.channels = texture.channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"},
         .key = place.key});
    std::vector<std::uint8_t> complement;
    texture.make([&](std::span<const std::uint8_t> rows) {
      if (codes == Codes::AsTheyAre) return out.write(rows);
      complement.assign(rows.begin(), rows.end());
      for (std::uint8_t& code : complement) code = static_cast<std::uint8_t>(255 - code);
      out.write(std::span<const std::uint8_t>(complement));
    });
    out.finish();
    names.push_back(place.prefix + name);
  }
  return names;
}

/// Whether file_name() may have given the name.
bool is_ours(const std::string& name) {
  constexpr std::array<std::string_view, 6> kKinds{"color.",     "normal.", "roughness.",
                                                   "metalness.", "height.", "reflectance."};
  return std::any_of(kKinds.begin(), kKinds.end(), [&](std::string_view kind) { return name.starts_with(kind); });
}

}  // namespace

void write_textures(const fs::path& folder, const std::string& prefix, std::size_t time, const GlbAppearance& look,
                    const std::string& key, TextureFiles& files) {
  const TexturePlace place{folder, prefix, time, key};
  files.base_colors.push_back(write_codes_of(place, "color", look.base_colors));
  if (!look.normals.empty()) files.normals.push_back(write_codes_of(place, "normal", look.normals));
  if (!look.speculars.empty())
    files.roughness.push_back(write_codes_of(place, "roughness", look.speculars, Codes::Complement));
  if (!look.metalness.empty()) files.metalness.push_back(write_codes_of(place, "metalness", look.metalness));
  files.reflectances.push_back(look.reflectance);
  files.reflectance.push_back(write_codes_of(place, "reflectance", look.reflectance_colors));
  if (look.heights.empty()) return;
  std::vector<std::string> names;
  for (std::size_t tile = 0; tile < look.heights.size(); ++tile) {
    if (!look.heights[tile]) {
      names.emplace_back();
      continue;
    }
    names.push_back(file_name("height", time, tile, look.heights.size(), ".exr"));
    write_exr(folder / names.back(), look.heights[tile](), {"Y"}, ExrDepth::Float, key);
    names.back().insert(0, prefix);
  }
  files.heights.push_back(std::move(names));
}

void fill_gaps(TextureFiles& files) {
  for (TextureFiles::Series* series :
       {&files.base_colors, &files.normals, &files.roughness, &files.metalness, &files.heights, &files.reflectance}) {
    for (std::vector<std::string>& names : *series) {
      for (std::size_t tile = 0; tile < names.size(); ++tile) {
        const auto there = std::find_if(series->begin(), series->end(),
                                        [&](const auto& other) { return tile < other.size() && !other[tile].empty(); });
        if (names[tile].empty() && there != series->end()) names[tile] = (*there)[tile];
      }
    }
  }
}

std::string tile_material(const std::string& tile) { return "material" + (tile.empty() ? "" : "_" + tile); }

WorkFolder::WorkFolder(fs::path path) : path_(std::move(path)) {
  std::error_code error;
  fs::remove_all(path_, error);
  if (!fs::create_directories(path_, error) || error)
    throw CannotComplete(path_.string() + ": cannot be made; " + error.message());
}

WorkFolder::~WorkFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

void require_own_textures(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (!is_ours(it->path().filename().string()))
      throw CannotComplete(folder.string() + ": holds " + it->path().filename().string() +
                           ", which is none of our textures; move it, or name another output");
  }
}

void WorkFolder::keep_as(const fs::path& to) {
  require_own_textures(to);
  std::error_code error;
  fs::remove_all(to, error);
  fs::rename(path_, to, error);
  if (error) throw CannotComplete(to.string() + ": cannot be written; " + error.message());
  path_.clear();
}

}  // namespace patinate
