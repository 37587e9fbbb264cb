#include "patinate/output/usd.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/output/materialx.h"
#include "libcommon/output/model_textures.h"
#include "libcommon/output/usd_text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// Writes files one after the other. No dates: equal files give equal bytes.
class UsdzArchive {
 public:
  /// @throws CannotComplete
  explicit UsdzArchive(const std::filesystem::path& path);
  /// @param name  Within the package. @throws CannotComplete if the package would pass 4 GiB, or on a full disk;
  /// IoError.
  void add(const std::string& name, const std::filesystem::path& file);
  /// After the last one. @throws CannotComplete
  void finish();

 private:
  struct Entry {
    std::string name;
    std::uint32_t crc = 0, size = 0, offset = 0;
  };
  void write(const std::string& bytes);

  std::filesystem::path path_;
  std::ofstream out_;
  std::uint64_t position_ = 0;
  std::vector<Entry> entries_;
};

constexpr std::uint64_t kAlignment = 64;  // Alignment that USDZ asks for.
constexpr std::uint64_t kLargest = 0xFFFFFFFFu;
constexpr std::uint32_t kFirstDay = 0x0021;  // 1980-01-01: zip knows no "none".

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xFF);
}

UsdzArchive::UsdzArchive(const std::filesystem::path& path) : path_(path), out_(path, std::ios::binary) {
  if (!out_) throw CannotComplete(path.string() + ": cannot be written");
}

void UsdzArchive::write(const std::string& bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out_) throw CannotComplete(path_.string() + ": cannot be written; is the disk full?");
  position_ += bytes.size();
}

void UsdzArchive::add(const std::string& name, const std::filesystem::path& file) {
  const std::string bytes = read_file(file);
  if (position_ + bytes.size() + name.size() + 256 > kLargest)
    throw CannotComplete(path_.string() + ": would hold more than 4 GiB; export fewer times, or .usda");
  const auto crc = static_cast<std::uint32_t>(
      crc32_z(crc32(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
  const Entry entry{name, crc, static_cast<std::uint32_t>(bytes.size()), static_cast<std::uint32_t>(position_)};
  constexpr std::uint64_t kHeader = 30, kExtraHeader = 4;
  // An extra field fills up to where the file may begin.
  const std::uint64_t begin = position_ + kHeader + name.size();
  std::uint64_t extra = (kAlignment - begin % kAlignment) % kAlignment;
  if (extra != 0 && extra < kExtraHeader) extra += kAlignment;
  std::string head;
  put(head, 0x04034b50, 4);
  put(head, 20, 2);  // Version that is needed,
  put(head, 0, 2);   // no flags,
  put(head, 0, 2);   // not compressed.
  put(head, 0, 2);
  put(head, kFirstDay, 2);
  put(head, crc, 4);
  put(head, entry.size, 4);
  put(head, entry.size, 4);
  put(head, name.size(), 2);
  put(head, extra, 2);
  head += name;
  if (extra != 0) {
    put(head, 0x1986, 2);  // Field of USD's own writer.
    put(head, extra - kExtraHeader, 2);
    head.append(extra - kExtraHeader, '\0');
  }
  write(head);
  write(bytes);
  entries_.push_back(entry);
}

void UsdzArchive::finish() {
  const std::uint64_t begin = position_;
  for (const Entry& entry : entries_) {
    std::string head;
    put(head, 0x02014b50, 4);
    put(head, 20, 2);
    put(head, 20, 2);
    put(head, 0, 2);
    put(head, 0, 2);
    put(head, 0, 2);
    put(head, kFirstDay, 2);
    put(head, entry.crc, 4);
    put(head, entry.size, 4);
    put(head, entry.size, 4);
    put(head, entry.name.size(), 2);
    put(head, 0, 2 + 2 + 2 + 2);  // No extra field, comment, other disk, attributes,
    put(head, 0, 4);
    put(head, entry.offset, 4);
    write(head + entry.name);
  }
  const std::uint64_t size = position_ - begin;
  std::string end;
  put(end, 0x06054b50, 4);
  put(end, 0, 4);
  put(end, entries_.size(), 2);
  put(end, entries_.size(), 2);
  put(end, size, 4);
  put(end, begin, 4);
  put(end, 0, 2);
  write(end);
  out_.close();
  if (!out_) throw CannotComplete(path_.string() + ": cannot be written; is the disk full?");
}

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
      look.reflectance_colors.clear();  // A package has no MaterialX.
    }
    write_textures(work.path(), textures + "/", i, look, is_package ? "" : options.key, files);
    control.report(0.9 * static_cast<double>(i + 1) / static_cast<double>(times.size()));
  }
  fill_gaps(files);
  const std::string text = usd_text(mesh, tiles, files, times, options);
  if (is_package) {
    const fs::path stage = work.path() / "stage.usda";
    write_atomically(stage, text);
    write_atomically(path, [&](const fs::path& temporary) {
      UsdzArchive archive(temporary);
      archive.add(stem + ".usda", stage);  // The first file is the one that is opened.
      std::set<std::string> added;
      for (const TextureFiles::Series* series : files.all()) {
        for (const std::vector<std::string>& names : *series) {
          for (const std::string& name : names) {
            if (added.insert(name).second) archive.add(name, work.path() / fs::path(name).filename());
          }
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
