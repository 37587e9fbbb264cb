#include "libcommon/media/decoder_server.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>

#include "libcommon/image/decoder_process.h"
#include "libcommon/image/decoder_wire.h"
#include "libcommon/media/movie_decoder.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr rlim_t kSecondsPerFrame = 60;

/// The program that asked is gone, or asks no more.
struct EndOfWork {};

void limit(int resource, rlim_t value) {
  struct rlimit limits {};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &limits) != 0) return;
  limits.rlim_cur = limits.rlim_max == RLIM_INFINITY ? value : std::min(value, limits.rlim_max);
  (void)::setrlimit(static_cast<__rlimit_resource>(resource), &limits);
}

/// One more frame's share of processor time, counted from now.
void renew_time() {
  struct rusage used {};
  (void)::getrusage(RUSAGE_SELF, &used);
  limit(RLIMIT_CPU, static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + kSecondsPerFrame);
}

void set_limits() {
#ifndef PATINATE_IS_SANITIZED  // Sanitizers reserve more addresses than any limit leaves.
  constexpr rlim_t kMemoryLimit = rlim_t{8} << 30;
  limit(RLIMIT_AS, kMemoryLimit);
#endif
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, 0);  // Pipes do not count: a decoder has no file to write.
  renew_time();
}

/// Runs `answer`, and sends its error when it throws. A decoder that is asked again after an error may still answer.
template <class Answer>
bool try_to_answer(const std::filesystem::path& path, const WireWrite& write, const Answer& answer) {
  std::string problem;
  try {
    answer();
    return true;
  } catch (const InputError& e) {
    problem = e.what();
  } catch (const std::bad_alloc&) {
    problem = "needs more memory than its decoder may have (8 GiB)";
  } catch (const std::exception& e) {
    problem = std::string("cannot be decoded (") + e.what() + ")";
  }
  const std::string subject = path.string() + ": ";  // The program that asked names the file itself.
  if (problem.starts_with(subject)) problem.erase(0, subject.size());
  write_number(write, kAnswerError);
  write_text(write, problem);
  return false;
}

/// Opens the file, says what it is, and answers requests for frames until EndOfWork.
template <class Decoder>
void serve(const std::filesystem::path& path, const WireRead& read, const WireWrite& write) {
  std::unique_ptr<Decoder> decoder;
  const bool is_open = try_to_answer(path, write, [&] {
    decoder = std::make_unique<Decoder>(path);
    const ImageInfo info = decoder->info();
    write_number(write, kAnswerOk);
    write_info(write, info);
  });
  while (is_open) {
    const auto frame = read_number<std::int32_t>(read);
    renew_time();
    (void)try_to_answer(path, write, [&] {
      const CodedImage image = decoder->read(frame);
      write_number(write, kAnswerOk);
      write_coded(write, image);
    });
  }
}

}  // namespace

int serve_decoder(const std::filesystem::path& path, int in, int out) {
  const WireRead read = [in](void* to, std::size_t size) {
    for (auto* at = static_cast<std::byte*>(to); size > 0;) {
      const ssize_t count = ::read(in, at, size);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) throw EndOfWork();
      at += count;
      size -= static_cast<std::size_t>(count);
    }
  };
  const WireWrite write = [out](const void* from, std::size_t size) {
    for (const auto* at = static_cast<const std::byte*>(from); size > 0;) {
      const ssize_t count = ::write(out, at, size);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) throw EndOfWork();
      at += count;
      size -= static_cast<std::size_t>(count);
    }
  };
  set_limits();
  try {
    // OpenImageIO's reader of movies knows few containers, loses the frames that a decoder holds back at the end, and
    // miscounts.
    is_movie(path) ? serve<MovieDecoder>(path, read, write) : serve<ImageDecoder>(path, read, write);
  } catch (const EndOfWork&) {
  }
  return 0;
}

}  // namespace patinate
