#include "libcommon/core/regular_file.h"

#include <string>
#include <system_error>

#include "libcommon/core/input_watch.h"
#include "patinate/core/error.h"

namespace patinate {

void require_regular_file(const std::filesystem::path& path) {
  using Type = std::filesystem::file_type;
  constexpr const char* kInstead = "; give a regular file (save what it gives to one first)";
  std::error_code error;
  switch (std::filesystem::status(path, error).type()) {
    case Type::regular:
      return note_input(path);
    case Type::not_found:
      throw IoError(path.string(), "does not exist");
    case Type::directory:
      throw IoError(path.string(), "is a folder; give a file");
    case Type::fifo:
      throw IoError(path.string(), std::string("is a pipe") + kInstead);
    case Type::socket:
      throw IoError(path.string(), std::string("is a socket") + kInstead);
    case Type::character:
    case Type::block:
      throw IoError(path.string(), std::string("is a device") + kInstead);
    default:
      throw IoError(path.string(),
                    "cannot be read; " + (error ? error.message() : std::string("it is no regular file")));
  }
}

}  // namespace patinate
