#include "libcommon/core/regular_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "patinate/core/error.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::TempFolder;

TEST(RegularFile, NothingElseIsEverOpened) {
  const TempFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);  // Opening it would wait for a writer for ever.
  std::filesystem::create_symlink(folder / "pipe", folder / "link");
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string socket_path = folder / "socket";
  ASSERT_LT(socket_path.size(), sizeof address.sun_path);
  socket_path.copy(address.sun_path, socket_path.size());
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::close(fd);
  const auto all_ways = [](const std::filesystem::path& path, const std::string& problem) {
    EXPECT_TRUE(has(error_of<IoError>([&] { require_regular_file(path); }), path.string() + ": " + problem)) << path;
    EXPECT_TRUE(has(error_of<IoError>([&] { (void)read_file(path); }), problem)) << path;
    EXPECT_TRUE(has(error_of<IoError>([&] { (void)hash_file(path); }), problem)) << path;
  };
  all_ways(folder / "pipe", "is a pipe; give a regular file");
  all_ways(folder / "link", "is a pipe");
  all_ways(folder / "socket", "is a socket");
  all_ways("/dev/zero", "is a device");
  all_ways(folder.path(), "is a folder");
  all_ways(folder / "nowhere", "does not exist");
  all_ways(folder / "pipe" / "below", "does not exist");
  std::ofstream(folder / "file") << "text";
  std::filesystem::create_symlink(folder / "file", folder / "good");
  EXPECT_EQ(read_file(folder / "good"), "text");
}

// The file behind the name counts: "patinate ... /dev/stdin < file" and "<(command)".
TEST(RegularFile, StandardInputIsAFileWhenOneIsRedirectedAndNoneWhenItIsAPipe) {
  const TempFolder folder;
  std::ofstream(folder / "file") << "text";
  const int file = ::open((folder / "file").c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(file, 0);
  EXPECT_EQ(read_file("/dev/fd/" + std::to_string(file)), "text");
  ::close(file);
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  EXPECT_TRUE(has(error_of<IoError>([&] { (void)read_file("/dev/fd/" + std::to_string(ends[0])); }), "is a pipe"));
  ::close(ends[0]);
  ::close(ends[1]);
}

}  // namespace
}  // namespace patinate
