#include "tests/fuzz/fuzz_target.h"

#include <sys/stat.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>

#include "patinate/core/error.h"
#include "tests/fuzz/fuzz_registry.h"
#include "tests/support/temp_folder.h"

namespace patinate::fuzz {

std::map<std::string, Target>& registry() {
  static std::map<std::string, Target> targets;
  return targets;
}

Registration::Registration(const char* name, Target target) { registry()[name] = target; }

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

void run(Target target, Bytes bytes) {
  try {
    target(bytes);
  } catch (const Error& e) {
    require(!std::string_view(e.what()).empty(), "an error has a message");
  }
}

const std::filesystem::path& fuzz_folder() {
  static const testing_support::TempFolder folder;
  // Files that a file may name beside itself, and that must never be opened.
  static const bool has_pipe = ::mkfifo((folder / "pipe").c_str(), 0600) == 0;
  (void)has_pipe;
  return folder.path();
}

std::filesystem::path fuzz_file(const std::string& name, Bytes bytes) {
  const std::filesystem::path path = fuzz_folder() / name;
  std::ofstream out(path, std::ios::binary);
  out.write(text_of(bytes).data(), static_cast<std::streamsize>(bytes.size()));
  return path;
}

std::uint8_t ByteSource::byte() {
  if (bytes_.empty()) return 0;
  const std::uint8_t value = bytes_.front();
  bytes_ = bytes_.subspan(1);
  return value;
}

int ByteSource::integer(int low, int high) {
  const unsigned value = byte() * 256u + byte();
  return low + static_cast<int>(value % static_cast<unsigned>(high - low + 1));
}

float ByteSource::number() {
  constexpr float kOdd[] = {
      0.0f, 1e30f, -1e30f, 1e-30f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()};
  const int code = byte();
  if (code < 250) return static_cast<float>(code - 125) / 62.5f;
  return kOdd[code - 250];
}

}  // namespace patinate::fuzz
