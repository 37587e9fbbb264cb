#include "libcommon/mesh_files/gltf_json.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/json_text.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate {

namespace {

std::uint32_t little_endian_u32(std::string_view bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[offset + i])) << (8 * i);
  }
  return value;
}

[[noreturn]] void fail_version(const std::string& file, const std::string& version) {
  throw IoError(file, "is glTF " + version + ", which is not read; convert it to glTF 2.0");
}

/// Checks what tinygltf takes on trust: the chunk lengths of a GLB. Gives its JSON.
std::string_view json_of_glb(const std::string& file, std::string_view bytes) {
  if (bytes.size() < 20 || bytes.substr(0, 4) != "glTF")
    throw IoError(file, "is not a GLB file, or truncated in its header");
  if (const std::uint32_t version = little_endian_u32(bytes, 4); version != 2)
    fail_version(file, std::to_string(version));
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

/// @returns the member, or null where there is none.
const Json& member_or_null(const Json& json, const char* name) {
  static const Json kNone;
  return json.is_object() && json.contains(name) ? json[name] : kNone;
}

/// Names in an array of the document; what is no name is left out.
std::vector<std::string> names_in(const Json& document, const char* list) {
  std::vector<std::string> names;
  for (const Json& name : member_or_null(document, list)) {
    if (name.is_string()) names.push_back(name.get<std::string>());
  }
  return names;
}

/// "2.0" of a version that may be a text or, in early files, a number; "" = there is none.
std::string version_text(const Json& version) {
  if (version.is_string()) return version.get<std::string>();
  return version.is_number() ? version.dump() : "";
}

void check_version(const std::string& file, const Json& document) {
  const Json& asset = member_or_null(document, "asset");
  const std::string version = version_text(member_or_null(asset, "version"));
  const std::string least = version_text(member_or_null(asset, "minVersion"));
  if (version.empty()) {
    // Version 1 may do without; it keeps its meshes under names.
    if (member_or_null(document, "meshes").is_object()) fail_version(file, "1.0");
    throw IoError(file, "is not valid glTF: its `asset` says no version");
  }
  if (version != "2" && !version.starts_with("2.")) fail_version(file, version);
  if (!least.empty() && least != "2" && least != "2.0") fail_version(file, least);
}

std::string joined_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

[[noreturn]] void fail_extensions(const std::string& file, const std::vector<std::string>& names) {
  const bool compresses = std::all_of(names.begin(), names.end(), [](const std::string& name) {
    return name.find("compression") != std::string::npos;
  });
  throw IoError(file, std::string("needs the extension") + (names.size() == 1 ? " " : "s ") + joined_names(names) +
                          (names.size() == 1 ? ", which is not supported; export it without "
                                             : ", which are not supported; export it without ") +
                          (compresses          ? "compression"
                           : names.size() == 1 ? "it"
                                               : "them"));
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
  if (bytes.substr(0, 4) == "glTF") return json_of_glb(file, bytes);
  constexpr std::string_view kBlanks = " \t\r\n\xef\xbb\xbf";  // A byte order mark among them.
  const std::size_t begin = bytes.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos || (bytes[begin] != '{' && bytes.find('\0') != std::string_view::npos))
    throw IoError(file, "is neither glTF (JSON) nor GLB; export it again");
  return bytes;
}

Json gltf_document(const std::string& file, std::string_view bytes) {
  Json document = parse_json(file, gltf_json(file, bytes), {.may_have_comments = false});
  if (!document.is_object()) throw IoError(file, "is not valid glTF: its JSON is no object");
  check_version(file, document);
  std::vector<std::string> unknown;
  for (const std::string& name : names_in(document, "extensionsRequired")) {
    if (gltf_extension(name) == GltfExtension::Unknown) unknown.push_back(name);
  }
  if (!unknown.empty()) fail_extensions(file, unknown);
  return document;
}

GltfExtension gltf_extension(std::string_view name) {
  constexpr std::array<std::string_view, 5> kRead{"EXT_mesh_gpu_instancing", "EXT_meshopt_compression",
                                                  "KHR_draco_mesh_compression", "KHR_mesh_quantization",
                                                  "KHR_texture_transform"};
  constexpr std::array<std::string_view, 9> kNotOfSurface{
      "EXT_lights_ies",   "EXT_lights_image_based", "EXT_texture_avif",
      "EXT_texture_webp", "KHR_lights_punctual",    "KHR_texture_basisu",
      "KHR_xmp",          "KHR_xmp_json_ld",        "MSFT_texture_dds"};
  if (std::find(kRead.begin(), kRead.end(), name) != kRead.end()) return GltfExtension::Read;
  const bool is_of_material = name.starts_with("KHR_materials_") || name.starts_with("EXT_materials_");
  return is_of_material || std::find(kNotOfSurface.begin(), kNotOfSurface.end(), name) != kNotOfSurface.end()
             ? GltfExtension::NotOfSurface
             : GltfExtension::Unknown;
}

bool is_gltf_file(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".gltf" || extension == ".glb";
}

MeshFileExtensions mesh_file_extensions(const std::filesystem::path& path) {
  MeshFileExtensions extensions;
  if (!is_gltf_file(path)) return extensions;
  for (const std::string& name :
       names_in(gltf_document(path.string(), read_file(path, kLargestGltf)), "extensionsUsed"))
    (gltf_extension(name) == GltfExtension::Read ? extensions.read : extensions.ignored).push_back(name);
  return extensions;
}

std::vector<std::string> mesh_buffer_files(const std::filesystem::path& path) {
  std::vector<std::string> files;
  if (!is_gltf_file(path)) return files;
  const Json document = gltf_document(path.string(), read_file(path, kLargestGltf));
  for (const Json& buffer : member_or_null(document, "buffers")) {
    const Json& uri = member_or_null(buffer, "uri");
    if (uri.is_string() && !uri.get<std::string>().starts_with("data:"))
      files.push_back(percent_decoded(uri.get<std::string>()));
  }
  return files;
}

}  // namespace patinate
