#include "libcommon/image/decoder_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

#include "libcommon/core/file_name.h"
#include "libcommon/core/programs.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/regular_file.h"
#include "libcommon/core/text.h"
#include "libcommon/image/decoder_wire.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr const char* kProgram = "patinate-decode";
constexpr double kPatienceSeconds = 120.0;

constexpr std::array<std::string_view, 18> kMovies{".3g2", ".3gp", ".avi", ".f4v", ".m2v",  ".m4v",
                                                   ".mj2", ".mkv", ".mov", ".mp4", ".mpe",  ".mpeg",
                                                   ".mpg", ".ogv", ".qt",  ".vob", ".webm", ".wmv"};
constexpr std::array<std::string_view, 36> kRaw{".3fr", ".arw", ".bay", ".cap", ".cr2", ".cr3", ".crw", ".dc2", ".dcr",
                                                ".dng", ".dsc", ".erf", ".fff", ".iiq", ".k25", ".kc2", ".kdc", ".mdc",
                                                ".mef", ".mos", ".mrw", ".nef", ".nrw", ".orf", ".pef", ".ptx", ".pxn",
                                                ".raf", ".raw", ".rw2", ".rwl", ".sr2", ".srf", ".srw", ".x3f", ".qtk"};

/// FFmpeg finds formats by content, and some of them are lists of other files, which it would open: playlists,
/// manifests. @throws IoError
void require_container(const fs::path& path) {
  std::string head(12, '\0');
  std::ifstream(path, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
  constexpr std::array<std::string_view, 10> kBoxes{"ftyp", "moov", "mdat", "free", "skip",
                                                    "wide", "pnot", "uuid", "udta", "jP  "};  // MP4, MOV, MJ2.
  const bool is_boxes = std::find(kBoxes.begin(), kBoxes.end(), head.substr(4, 4)) != kBoxes.end();
  const bool is_riff = head.starts_with("RIFF") && head.substr(8, 3) == "AVI";
  const bool is_mpeg = head.starts_with(std::string_view("\0\0\1", 3)) || head.front() == '\x47';
  const bool is_other = head.starts_with("\x1a\x45\xdf\xa3") || head.starts_with("OggS") || head.starts_with("FLV") ||
                        head.starts_with("\x30\x26\xb2\x75");  // MKV and WebM, OGV, F4V, WMV.
  if (!is_boxes && !is_riff && !is_mpeg && !is_other)
    throw IoError(path.string(),
                  "is damaged, or no movie: it does not begin as MP4, MOV, MKV, WebM, AVI, MPEG, OGV or WMV do");
}

/// Where the program is; a bare name is looked up on the PATH.
std::string decoder_program() {
  const char* given = std::getenv("PATINATE_DECODER");
  if (given != nullptr && *given != '\0') return given;
  std::error_code error;
  const fs::path program = programs_folder() / kProgram;
  if (program.has_parent_path() && fs::exists(program, error)) return program;
  return kProgram;
}

double patience_seconds() {
  const char* given = std::getenv("PATINATE_DECODER_SECONDS");
  const auto seconds = given == nullptr ? std::nullopt : parse_number(given);
  return seconds && *seconds > 0.0 && *seconds < 1e6 ? *seconds : kPatienceSeconds;
}

/// Both ends of a connection, closed in the end.
struct Connection {
  int ours = -1;
  int theirs = -1;
  Connection() {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
      throw CannotComplete(std::string(kProgram) + ": cannot be started; " + std::strerror(errno));
    }
    ours = ends[0];
    theirs = ends[1];
  }
  ~Connection() {
    close_theirs();
    ::close(ours);
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void close_theirs() {
    if (theirs >= 0) ::close(theirs);
    theirs = -1;
  }
};

/// Starts the program with its standard input and output connected and its messages nowhere.
pid_t start(const std::string& program, const fs::path& path, int connection) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, connection, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, connection, STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);  // What is open here is not for it.
  std::string program_text = program, path_text = path.string();
  char* arguments[] = {program_text.data(), path_text.data(), nullptr};
  pid_t pid = -1;
  const int error = ::posix_spawnp(&pid, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw CannotComplete(program + ": cannot be started; " + std::strerror(error) +
                         "; it comes with patinate and decodes movies and camera RAW");
  }
  return pid;
}

}  // namespace

bool is_movie(const fs::path& path) {
  return std::find(kMovies.begin(), kMovies.end(), lower_extension(path)) != kMovies.end();
}

bool is_decoded_apart(const fs::path& path) {
  return is_movie(path) || std::find(kRaw.begin(), kRaw.end(), lower_extension(path)) != kRaw.end();
}

struct DecoderProcess::Impl {
  fs::path path;
  Connection connection;
  pid_t pid = -1;
  double patience = patience_seconds();

  ~Impl() { (void)end(); }

  /// Ends the process; its status as waitpid() tells it.
  int end() {
    if (pid < 0) return 0;
    ::kill(pid, SIGKILL);
    int status = 0;
    while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
    }
    pid = -1;
    return status;
  }

  [[noreturn]] void fail(const std::string& problem) {
    (void)end();
    throw IoError(path.string(), problem);
  }

  /// The pipe has ended: says how the process died.
  [[noreturn]] void fail_dead() {
    int status = 0;
    while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
    }
    pid = -1;
    const bool is_killed = WIFSIGNALED(status);
    if (is_killed && WTERMSIG(status) == SIGXCPU) {
      throw IoError(path.string(), "cannot be decoded; its decoder did not finish in its time. Is it damaged?");
    }
    throw IoError(path.string(),
                  std::string("cannot be decoded; its decoder ") +
                      (is_killed ? std::string("crashed (") + ::strsignal(WTERMSIG(status)) + ")"
                                 : "ended early (exit code " + std::to_string(WEXITSTATUS(status)) + ")") +
                      ". Is it damaged?");
  }

  void read(void* to, std::size_t size) {
    for (auto* at = static_cast<std::byte*>(to); size > 0;) {
      struct pollfd waiting {
        connection.ours, POLLIN, 0
      };
      const int ready = ::poll(&waiting, 1, static_cast<int>(std::min(1e9, patience * 1000.0)));
      if (ready < 0 && errno == EINTR) continue;
      if (ready == 0) {
        fail("cannot be decoded; its decoder gave nothing for " + short_number_text(patience) + " s. Is it damaged?");
      }
      const ssize_t count = ::read(connection.ours, at, size);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) fail_dead();
      at += count;
      size -= static_cast<std::size_t>(count);
    }
  }

  /// The head of an answer. @throws IoError with the process's own words.
  WireRead answer() {
    WireRead reader = [this](void* to, std::size_t size) { read(to, size); };
    const auto kind = read_number<std::uint32_t>(reader);
    if (kind == kAnswerOk) return reader;
    if (kind != kAnswerError) fail("its decoder answered with what makes no sense");
    const std::string problem = read_text(reader);
    throw IoError(path.string(), problem);
  }
};

DecoderProcess::DecoderProcess(fs::path path) : impl_(std::make_unique<Impl>()) {
  impl_->path = std::move(path);
  check_may_read(impl_->path);
  require_regular_file(impl_->path);
  if (is_movie(impl_->path)) require_container(impl_->path);
  impl_->pid = start(decoder_program(), impl_->path, impl_->connection.theirs);
  impl_->connection.close_theirs();
  try {
    info_ = read_info(impl_->answer());
  } catch (const InvalidInput& e) {
    impl_->fail(e.what());
  }
}

DecoderProcess::~DecoderProcess() = default;

CodedImage DecoderProcess::read(int frame) {
  const std::int32_t number = frame;
  // When it is dead, its answer shows it.
  (void)::send(impl_->connection.ours, &number, sizeof number, MSG_NOSIGNAL);
  try {
    CodedImage image = read_coded(impl_->answer());
    const bool is_expected = image.width == info_.width && image.height == info_.height &&
                             image.channels == static_cast<int>(info_.channels.size());
    if (!is_expected) impl_->fail("image " + std::to_string(frame) + " differs from the first one in size or channels");
    return image;
  } catch (const InvalidInput& e) {
    impl_->fail(e.what());
  }
}

}  // namespace patinate
