#include "patinate/output/usd.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <system_error>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/output/materialx.h"
#include "libcommon/output/model_textures.h"
#include "libcommon/output/usd_text.h"
#include "libcommon/output/usdz_archive.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

void check_usd(const Mesh& mesh, const GlbTiles& tiles, const std::vector<GlbAppearance>& appearance,
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
        look.speculars.size() != appearance.front().speculars.size() ||
        (!look.metalness.empty() && look.metalness.size() != n) ||
        (!look.heights.empty() && look.heights.size() != n) ||
        look.metalness.size() != appearance.front().metalness.size() ||
        (!look.reflectance_colors.empty() && look.reflectance_colors.size() != n) ||
        look.heights.size() != appearance.front().heights.size())
      throw InvalidInput("usd: expected a texture for every tile, of the same kinds at every time");
  }
}

}  // namespace

void write_usd(const fs::path& path, const Mesh& mesh, const GlbTiles& tiles,
               const std::vector<GlbAppearance>& appearance, const std::vector<double>& times,
               const UsdOptions& options, const RunControl& control) {
  const bool is_package = path.extension() == ".usdz";
  if (!is_package && path.extension() != ".usda")
    throw ParseError(path.string() + ": USD is written as .usda or .usdz");
  check_usd(mesh, tiles, appearance, times);
  const std::string stem = path.stem().string(), textures = is_package ? "textures" : stem + ".textures";
  WorkFolder work(folder_of(path) / ("." + stem + ".usd.partial"));
  TextureFiles files;
  for (std::size_t i = 0; i < times.size(); ++i) {
    control.throw_if_stopped();
    GlbAppearance look = appearance[i];
    if (is_package) {
      look.heights.clear();             // A package holds PNG and JPEG.
      look.reflectance_colors.clear();  // Of MaterialX, which a package has not.
    }
    write_textures(work.path(), textures + "/", i, look, is_package ? "" : options.key, files);
    control.report(0.9 * static_cast<double>(i + 1) / static_cast<double>(times.size()));
  }
  const std::string text = usd_text(mesh, tiles, files, times, options);
  if (is_package) {
    const fs::path stage = work.path() / "stage.usda";
    write_atomically(stage, text);
    write_atomically(path, [&](const fs::path& temporary) {
      UsdzArchive archive(temporary);
      archive.add(stem + ".usda", stage);  // The first file is the one that is opened.
      for (const TextureFiles::Series* series : files.all()) {
        for (const std::vector<std::string>& names : *series) {
          for (const std::string& name : names) archive.add(name, work.path() / fs::path(name).filename());
        }
      }
      archive.finish();
    });
  } else {
    work.keep_as(folder_of(path) / textures);
    std::vector<std::string> names;
    for (const GlbAppearance& look : appearance) names.push_back(look.name);
    write_atomically(fs::path(path).replace_extension(".mtlx"),
                     materialx_text(tiles.names, files,
                                    {.time_names = names,
                                     .geometries = usd_geometries(mesh, tiles, options),
                                     .roughness = options.roughness,
                                     .key = options.key,
                                     .credits = options.credits}));
    write_atomically(path, text);
  }
  control.report(1.0);
}

std::string read_usd_key(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw IoError(path.string(), "cannot be read");
  std::string head(4096, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(in.gcount());
  const std::string before = "string patinate_key = \"";
  const std::size_t at = head.find(before);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + before.size(), end = head.find('"', begin);
  return end == std::string::npos ? "" : head.substr(begin, end - begin);
}

}  // namespace patinate
