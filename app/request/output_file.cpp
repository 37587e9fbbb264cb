#include "app/request/output_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <set>
#include <string_view>

#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/input_watch.h"
#include "libcommon/image/whole_file.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/output/glb.h"
#include "patinate/output/movie.h"
#include "patinate/output/usd.h"

namespace patinate::app {

void require_extension(const std::filesystem::path& output, const std::vector<std::string>& extensions) {
  const std::string found = lower_extension(output);
  if (std::find(extensions.begin(), extensions.end(), found) != extensions.end()) return;
  std::string list;
  for (const std::string& e : extensions) list += (list.empty() ? "" : ", ") + e;
  throw UsageError("-o: found `" + output.string() + "`; expected a name that ends in " + list);
}

namespace {

/// Who names such a file does not mean a folder.
constexpr std::array<std::string_view, 34> kFiles{
    ".abc", ".avi",  ".bmp",  ".csv", ".dae", ".exr",  ".fbx",  ".gif",  ".glb",  ".gltf", ".html", ".jpeg",
    ".jpg", ".json", ".m4v",  ".mkv", ".mov", ".mp4",  ".obj",  ".pdf",  ".ply",  ".png",  ".stl",  ".svg",
    ".tif", ".tiff", ".toml", ".txt", ".usd", ".usda", ".usdc", ".usdz", ".webm", ".webp"};

/// "aged/", or a folder that is there: nothing to guess.
bool is_plainly_folder(const std::filesystem::path& output) {
  std::error_code error;
  return !output.has_filename() || std::filesystem::is_directory(output, error);
}

bool is_version(std::string_view suffix) {
  suffix.remove_prefix(suffix.starts_with(".v") ? 2 : 1);
  return std::all_of(suffix.begin(), suffix.end(), [](unsigned char c) { return std::isalpha(c) == 0; });
}

}  // namespace

void require_folder_name(const std::filesystem::path& output, const std::string& expected) {
  const std::string suffix = lower_extension(output);
  if (suffix.empty() || is_version(suffix) || is_plainly_folder(output)) return;
  throw UsageError("-o: found `" + output.string() + "`; expected " + expected);
}

void require_no_file_name(const std::filesystem::path& output) {
  if (is_plainly_folder(output) || std::find(kFiles.begin(), kFiles.end(), lower_extension(output)) == kFiles.end())
    return;
  const std::string plain = std::filesystem::path(output).replace_extension().string();
  throw UsageError("-o: found `" + output.string() +
                   "`, the name of a file; what is made is a folder: expected a name as `" + plain + "`");
}

const std::vector<std::string>& image_extensions() {
  static const std::vector<std::string> extensions{".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr"};
  return extensions;
}

namespace {

/// The first and the last bytes of a file.
struct Ends {
  std::string first, last;
  std::uint64_t size = 0;
};

Ends ends_of(const std::filesystem::path& path) {
  constexpr std::uint64_t kFirst = 4096, kLast = 64;
  std::error_code error;
  Ends ends;
  ends.size = std::filesystem::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  if (error || !in) return {};
  const auto read = [&](std::uint64_t from, std::uint64_t count) {
    std::string bytes(static_cast<std::size_t>(std::min(count, ends.size - from)), '\0');
    in.seekg(static_cast<std::streamoff>(from));
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return bytes;
  };
  ends.first = read(0, kFirst);
  ends.last = read(ends.size - std::min(kLast, ends.size), kLast);
  return ends;
}

/// The key of a text that was written to its end.
std::string text_key(const std::filesystem::path& path, std::string_view before, std::string_view after,
                     std::string_view last) {
  const Ends ends = ends_of(path);
  const std::size_t at = ends.first.find(before);
  if (at == std::string::npos || !ends.last.ends_with(last)) return "";
  const std::size_t begin = at + before.size(), end = ends.first.find_first_of(after, begin);
  return end == std::string::npos ? "" : ends.first.substr(begin, end - begin);
}

std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char c : bytes) value = 256 * value + static_cast<unsigned char>(c);
  return value;
}

std::uint64_t little_endian(std::string_view bytes) {
  const std::string reversed(bytes.rbegin(), bytes.rend());
  return big_endian(reversed);
}

/// WebM: the segment, which is all of the file but its head, says its size.
bool is_whole_webm(const std::filesystem::path& path) {
  const Ends ends = ends_of(path);
  const std::size_t at = ends.first.find("\x18\x53\x80\x67");
  if (at == std::string::npos || at + 12 > ends.first.size() || ends.first[at + 4] != '\x01') return true;
  return ends.size >= at + 12 + big_endian(std::string_view(ends.first).substr(at + 5, 7));
}

bool is_whole_glb(const std::filesystem::path& path) {
  const Ends ends = ends_of(path);
  return ends.first.size() >= 12 && little_endian(std::string_view(ends.first).substr(8, 4)) == ends.size;
}

/// A ZIP ends with its directory's end, of 22 bytes where there is no comment.
bool is_whole_zip(const std::filesystem::path& path) {
  const std::string last = ends_of(path).last;
  return last.size() >= 22 && last.compare(last.size() - 22, 4, "PK\x05\x06") == 0;
}

/// Files that name no length of theirs are decoded.
bool is_whole_image(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".png" || extension == ".jpg" || extension == ".jpeg") return !is_cut_off(path);
  (void)read_gray(path);
  return true;
}

std::string key_by_extension(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".mtl" || extension == ".obj") return text_key(path, "# patinate ", "\n", "\n# end\n");
  if (extension == ".mtlx") return text_key(path, "patinate_key=", ";\"", "</materialx>\n");
  if (extension == ".usda") return text_key(path, "string patinate_key = \"", "\"", "\n}\n");
  if (extension == ".usdz") return is_whole_zip(path) ? read_usd_key(path) : "";
  if (extension == ".glb") return is_whole_glb(path) ? read_glb_key(path) : "";
  if (extension == ".webm" && !is_whole_webm(path)) return "";
  if (extension == ".gif" && !ends_of(path).last.ends_with(';')) return "";
  const std::vector<std::string>& movies = movie_extensions();
  const bool is_movie = std::find(movies.begin(), movies.end(), extension) != movies.end();
  return is_movie ? read_movie_key(path) : image_file_key(path);
}

}  // namespace

std::string image_file_key(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return "";
  const UnwatchedReads of_output;
  try {
    const std::string key = probe_image(path).key;
    return key.empty() || !is_whole_image(path) ? "" : key;
  } catch (const IoError&) {
    return "";  // there is a file, and it is none of ours
  }
}

std::string written_key(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return "";
  const UnwatchedReads of_output;
  try {
    return key_by_extension(path);
  } catch (const IoError&) {
    return "";
  }
}

OutputFile output_file(const std::filesystem::path& path) { return {.path = path, .existing_key = written_key(path)}; }

OutputFile output_folder(const std::filesystem::path& path) {
  OutputFile folder{.path = path, .is_folder = true};
  std::error_code error;
  std::set<std::string> keys;
  for (std::filesystem::directory_iterator it(path, error), end; !error && it != end; it.increment(error))
    keys.insert(image_file_key(it->path()));
  if (keys.size() == 1) folder.existing_key = *keys.begin();
  return folder;
}

OutputFile text_file(const std::filesystem::path& path, const std::string& text) {
  const UnwatchedReads of_output;
  std::error_code error;
  const bool is_same = std::filesystem::is_regular_file(path, error) &&
                       std::filesystem::file_size(path, error) == text.size() && read_file(path) == text;
  return {.path = path, .existing_key = is_same ? kSameText : ""};
}

}  // namespace patinate::app
