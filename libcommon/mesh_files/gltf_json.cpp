#include "libcommon/mesh_files/gltf_json.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate {

namespace {

constexpr int kMaxJsonDepth = 128;

std::uint32_t little_endian_u32(std::string_view bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[offset + i])) << (8 * i);
  }
  return value;
}

/// Checks what tinygltf takes on trust: the chunk lengths of a GLB. Gives its JSON.
std::string_view json_of_glb(const std::string& file, std::string_view bytes) {
  if (bytes.size() < 20 || bytes.substr(0, 4) != "glTF")
    throw IoError(file, "is not a GLB file, or truncated in its header");
  const std::uint64_t length = little_endian_u32(bytes, 8), json_length = little_endian_u32(bytes, 12);
  if (length > bytes.size()) {
    throw IoError(file,
                  "truncated: holds " + std::to_string(bytes.size()) + " of " + std::to_string(length) + " bytes");
  }
  if (20 + json_length > length || bytes.substr(16, 4) != "JSON")
    throw IoError(file, "its first chunk is not valid JSON");
  const std::uint64_t binary = 20 + json_length;
  if (binary != length && (binary + 8 > length || binary + 8 + little_endian_u32(bytes, binary) > length)) {
    throw IoError(file, "truncated: its binary chunk is longer than the file");
  }
  return bytes.substr(20, json_length);
}

void check_depth(const std::string& file, std::string_view json) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string && c == '\\') {
      ++i;
    } else if (c == '"') {
      in_string = !in_string;
    } else if (!in_string && (c == '{' || c == '[')) {
      if (++depth > kMaxJsonDepth)
        throw IoError(file, "its JSON is nested more than " + std::to_string(kMaxJsonDepth) + " deep");
    } else if (!in_string && (c == '}' || c == ']')) {
      --depth;
    }
  }
}

/// Broken escapes stay as they are, as tinygltf leaves them.
std::string percent_decoded(const std::string& uri) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned code = 0;
    const char* digits = uri.data() + i + 1;
    const bool is_escape =
        uri[i] == '%' && i + 2 < uri.size() && std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2;
    out += is_escape ? static_cast<char>(code) : uri[i];
    if (is_escape) i += 2;
  }
  return out;
}

}  // namespace

std::string_view gltf_json(const std::string& file, std::string_view bytes) {
  const std::string_view json = bytes.substr(0, 4) == "glTF" ? json_of_glb(file, bytes) : bytes;
  check_depth(file, json);
  return json;
}

std::vector<std::string> mesh_buffer_files(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".gltf" && extension != ".glb") return {};
  const std::string bytes = read_file(path, kLargestGltf);
  const Json root = Json::parse(gltf_json(path.string(), bytes), nullptr, /*allow_exceptions=*/false);
  std::vector<std::string> files;
  if (!root.is_object() || !root.contains("buffers") || !root["buffers"].is_array()) return files;
  for (const Json& buffer : root["buffers"]) {
    if (!buffer.is_object() || !buffer.contains("uri") || !buffer["uri"].is_string()) continue;
    const std::string uri = buffer["uri"].get<std::string>();
    if (!uri.starts_with("data:")) files.push_back(percent_decoded(uri));
  }
  return files;
}

}  // namespace patinate
