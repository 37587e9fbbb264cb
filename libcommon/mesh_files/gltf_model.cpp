#include "libcommon/mesh_files/gltf_model.h"

#include <tiny_gltf.h>

#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/mesh_files/gltf_compression.h"
#include "libcommon/mesh_files/gltf_json.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

bool ignore_image(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
  return true;
}

/// Reads files that a glTF names as everything else is read; names stand for nothing but themselves.
tinygltf::FsCallbacks files_beside(std::string* outside) {
  tinygltf::FsCallbacks callbacks{};
  callbacks.FileExists = [](const std::string& path, void* kept) {
    std::error_code error;
    if (may_read(path)) return std::filesystem::exists(path, error);
    if (auto& first = *static_cast<std::string*>(kept); first.empty()) first = path;
    return false;
  };
  callbacks.ExpandFilePath = [](const std::string& path, void*) { return path; };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>* out, std::string* problem, const std::string& path, void*) {
    try {
      const std::string bytes = read_file(path, kLargestGltf);
      out->assign(bytes.begin(), bytes.end());
      return true;
    } catch (const IoError& e) {
      *problem = std::string(e.what()).substr(path.size() + 2);
      return false;
    }
  };
  callbacks.user_data = outside;
  return callbacks;
}

/// tinygltf's errors as one line.
std::string one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  for (std::size_t i = text.find('\n'); i != std::string::npos; i = text.find('\n', i)) text.replace(i, 1, "; ");
  return text;
}

}  // namespace

std::unique_ptr<tinygltf::Model> load_gltf_model(const std::filesystem::path& path, Json& document) {
  const std::string file = path.string();
  std::string bytes = read_file(path, kLargestGltf);
  const bool is_binary = bytes.compare(0, 4, "glTF") == 0;
  document = gltf_document(file, bytes);
  if (std::string whole = loadable_gltf(bytes, document); !whole.empty()) bytes = std::move(whole);
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(&ignore_image, nullptr);
  std::string outside;
  loader.SetFsCallbacks(files_beside(&outside));
  auto model = std::make_unique<tinygltf::Model>();
  std::string error, warning;
  const std::string folder = folder_of(path).string();
  const auto size = static_cast<unsigned int>(bytes.size());
  bool ok = false;
  try {
    ok = is_binary ? loader.LoadBinaryFromMemory(model.get(), &error, &warning,
                                                 reinterpret_cast<const unsigned char*>(bytes.data()), size, folder)
                   : loader.LoadASCIIFromString(model.get(), &error, &warning, bytes.data(), size, folder);
  } catch (const std::bad_alloc&) {
    throw IoError(file, "is not valid glTF, or larger than memory");
  } catch (const std::length_error&) {
    throw IoError(file, "is not valid glTF: it gives a size that nothing can have");
  } catch (const std::exception&) {
    throw IoError(file, "is not valid glTF: its JSON does not hold what it should");
  }
  if (!ok && !outside.empty()) check_may_read(outside);
  if (!ok) throw IoError(file, "is not valid glTF: " + one_line(error.empty() ? "its JSON cannot be parsed" : error));
  try {
    decompress_gltf(file, document, *model);
  } catch (const std::bad_alloc&) {
    throw IoError(file, "its compressed geometry is damaged, or larger than memory");
  }
  return model;
}

}  // namespace patinate
