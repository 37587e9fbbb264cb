// Photographs that come into the folder: a new folder of their own, and one file after the other.
#include <mutex>
#include <nlohmann/json.hpp>

#include "capture/project/found_images.h"
#include "libcommon/core/file_name.h"
#include "libcommon/job/result_folder.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tools/studio/outside_json.h"
#include "tools/studio/routes.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxPhotographs = 2000;
constexpr std::uintmax_t kGigabyte = std::uintmax_t{1} << 30, kMaxBytes = 8 * kGigabyte, kLeastFree = kGigabyte;

/// A folder directly in the served one that holds nothing but photographs, with room for one of `num_bytes` more.
void require_room(const ServedFolder& served, const std::string& folder, std::uintmax_t num_bytes) {
  std::error_code error;
  const fs::path path = served.path() / folder;
  if (!is_file_name(folder) || fs::symlink_status(path, error).type() != fs::file_type::directory)
    throw InvalidInput("there is no folder \"" + folder + "\" for photographs; make it first");
  int count = 0;
  std::uintmax_t all_bytes = num_bytes;
  for (fs::directory_iterator it(path, error), end; !error && it != end; it.increment(error), ++count) {
    std::error_code ignored;
    if (it->symlink_status(ignored).type() != fs::file_type::regular || !capture::may_be_photograph(it->path()))
      throw InvalidInput("the folder \"" + folder + "\" holds more than photographs; choose a new name");
    const std::uintmax_t size = it->file_size(ignored);
    all_bytes += ignored ? 0 : size;
  }
  if (error) throw CannotComplete(folder + ": cannot be listed; " + error.message());
  if (count >= kMaxPhotographs || all_bytes > kMaxBytes)
    throw InvalidInput("a folder takes " + std::to_string(kMaxPhotographs) + " photographs and " +
                       std::to_string(kMaxBytes / kGigabyte) +
                       " GB in this way; copy more into it with other programs");
  if (fs::space(path, error).available < kLeastFree + num_bytes)
    throw CannotComplete("less than 1 GB would stay free on the disk; make room first");
}

}  // namespace

HttpResponse make_photograph_folder(const Asked& asked, const std::string& body) {
  const Json json = parse_outside_json(body);
  JsonReader reader("folder", json);
  const std::string name = reader.member("name").string();
  reader.finish();
  require_file_name("folder", name);
  const fs::path path = asked.folder.new_path(name);
  if (!result_around(path).empty()) throw InvalidInput("\"" + name + "\" is the name of an unfinished result");
  std::error_code error;
  if (!fs::create_directory(path, error))
    throw CannotComplete(name + ": cannot be made; " + (error ? error.message() : "it exists by now"));
  return json_response(Json{{"folder", name}});
}

HttpResponse save_photograph(const Asked& asked, const std::string& body) {
  static std::mutex mutex;  // So that two at a time do not both find room for the last.
  const std::string name = asked.target.value("name"), folder = asked.target.value("folder");
  if (!is_file_name(name))
    throw InvalidInput("\"" + name + "\" cannot be the name of a photograph here; use " + file_name_text());
  if (!capture::may_be_photograph(name)) throw InvalidInput("\"" + name + "\" is no photograph and no movie");
  const std::lock_guard lock(mutex);
  require_room(asked.folder, folder, body.size());
  const fs::path path = asked.folder.new_path(folder + "/" + name);
  write_checked(path, name, body, [](const fs::path& temporary) { (void)probe_image(temporary); });
  return json_response(Json{{"path", asked.folder.name_of(path)}});
}

}  // namespace patinate::studio
