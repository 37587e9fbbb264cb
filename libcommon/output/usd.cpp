#include "patinate/output/usd.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <system_error>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/image/image_rows.h"
#include "libcommon/output/usd_text.h"
#include "libcommon/output/usdz_archive.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

void check(const Mesh& mesh, const GlbTiles& tiles, const std::vector<GlbAppearance>& appearance,
           const std::vector<double>& times) {
  if (!mesh.has_uvs()) throw InvalidInput("usd: the mesh has no UVs");
  if (times.empty() || times.size() != appearance.size())
    throw InvalidInput("usd: " + std::to_string(appearance.size()) + " looks for " + std::to_string(times.size()) +
                       " times; expected at least one, and as many");
  if (!std::is_sorted(times.begin(), times.end(), std::less_equal<>())) throw InvalidInput("usd: times must increase");
  const std::size_t n = tiles.names.size();
  if (n > 1 && tiles.triangle_tile.size() != mesh.triangles.size())
    throw InvalidInput("usd: there is not a tile for every triangle");
  for (const GlbAppearance& look : appearance) {
    if (look.base_colors.size() != n || (!look.normals.empty() && look.normals.size() != n) ||
        (!look.speculars.empty() && look.speculars.size() != n) ||
        look.normals.size() != appearance.front().normals.size() ||
        look.speculars.size() != appearance.front().speculars.size())
      throw InvalidInput("usd: expected a texture for every tile, of the same kinds at every time");
  }
}

/// Writes the textures of one kind at one time, and says their names.
std::vector<std::string> write_textures(const fs::path& folder, const std::string& prefix, std::size_t time,
                                        const std::string& kind, const std::vector<GlbTexture>& textures) {
  std::vector<std::string> names;
  for (std::size_t tile = 0; tile < textures.size(); ++tile) {
    const GlbTexture& texture = textures[tile];
    const std::string name =
        kind + "." + zero_padded(time, 4) + (textures.size() > 1 ? "." + std::to_string(tile) : "") + ".png";
    ImageRowWriter out(
        folder / name, texture.width, texture.height,
        {.channels = texture.channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"}});
    texture.make([&](std::span<const std::uint8_t> rows) { out.write(rows); });
    out.finish();
    names.push_back(prefix + name);
  }
  return names;
}

/// A folder beside the output that goes when it is not kept.
class WorkFolder {
 public:
  explicit WorkFolder(fs::path path) : path_(std::move(path)) {
    std::error_code error;
    fs::remove_all(path_, error);
    if (!fs::create_directories(path_, error) || error)
      throw CannotComplete(path_.string() + ": cannot be made; " + error.message());
  }
  ~WorkFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }
  /// Takes the place of `to`.
  void keep_as(const fs::path& to) {
    std::error_code error;
    fs::remove_all(to, error);
    fs::rename(path_, to, error);
    if (error) throw CannotComplete(to.string() + ": cannot be written; " + error.message());
    path_.clear();
  }

 private:
  fs::path path_;
};

}  // namespace

void write_usd(const fs::path& path, const Mesh& mesh, const GlbTiles& tiles,
               const std::vector<GlbAppearance>& appearance, const std::vector<double>& times,
               const UsdOptions& options, const RunControl& control) {
  const bool is_package = path.extension() == ".usdz";
  if (!is_package && path.extension() != ".usda")
    throw ParseError(path.string() + ": USD is written as .usda or .usdz");
  check(mesh, tiles, appearance, times);
  const std::string stem = path.stem().string(), textures = is_package ? "textures" : stem + ".textures";
  WorkFolder work(folder_of(path) / ("." + stem + ".usd.partial"));
  UsdTextureFiles files;
  for (std::size_t i = 0; i < times.size(); ++i) {
    control.throw_if_stopped();
    const GlbAppearance& look = appearance[i];
    const auto written = [&](const std::string& kind, const std::vector<GlbTexture>& of) {
      return write_textures(work.path(), textures + "/", i, kind, of);
    };
    files.base_colors.push_back(written("color", look.base_colors));
    if (!look.normals.empty()) files.normals.push_back(written("normal", look.normals));
    if (!look.speculars.empty()) files.speculars.push_back(written("gloss", look.speculars));
    control.report(0.9 * static_cast<double>(i + 1) / static_cast<double>(times.size()));
  }
  const std::string text = usd_text(mesh, tiles, files, times, options);
  if (is_package) {
    const fs::path stage = work.path() / "stage.usda";
    write_atomically(stage, text);
    write_atomically(path, [&](const fs::path& temporary) {
      UsdzArchive archive(temporary);
      archive.add(stem + ".usda", stage);  // The first file is the one that is opened.
      for (const auto* series : {&files.base_colors, &files.normals, &files.speculars}) {
        for (const std::vector<std::string>& names : *series) {
          for (const std::string& name : names) archive.add(name, work.path() / fs::path(name).filename());
        }
      }
      archive.finish();
    });
  } else {
    work.keep_as(folder_of(path) / textures);
    write_atomically(path, text);
  }
  control.report(1.0);
}

std::string read_usd_key(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw IoError(path.string(), "cannot be read");
  std::string head(4096, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  const std::string before = "string patinate_key = \"";
  const std::size_t at = head.find(before);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + before.size(), end = head.find('"', begin);
  return end == std::string::npos ? "" : head.substr(begin, end - begin);
}

}  // namespace patinate
