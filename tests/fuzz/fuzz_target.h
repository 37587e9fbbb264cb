/// \file
/// A fuzz target is a function of bytes that must end: normally, or with an Error of ours that says something on one
/// line.
///
///     PATINATE_FUZZ_TARGET(obj) { (void)read_mesh(fuzz_file("obj", bytes)); }
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace patinate::fuzz {

using Bytes = std::span<const std::uint8_t>;
using Target = void (*)(Bytes);

[[nodiscard]] inline std::string_view text_of(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Runs a target. Aborts when anything but an Error comes out of it, or an Error without a message.
void run(Target target, Bytes bytes);
/// A folder of this process's own, removed at its end.
[[nodiscard]] const std::filesystem::path& fuzz_folder();
/// A file in it with these bytes; the same one for each name.
std::filesystem::path fuzz_file(const std::string& name, Bytes bytes);
/// Requires what must hold whatever the input is. Aborts unless `holds`.
void require(bool holds, const char* what);

/// Takes values from the input; zeros after its end.
class ByteSource {
 public:
  explicit ByteSource(Bytes bytes) : bytes_(bytes) {}
  [[nodiscard]] bool is_empty() const { return bytes_.empty(); }
  std::uint8_t byte();
  /// [low, high].
  int integer(int low, int high);
  /// Mostly plain numbers in [-2, 2]; now and then huge, tiny, infinite or NaN.
  float number();

 private:
  Bytes bytes_;
};

/// Makes the target known to the replay; used by the macro.
struct Registration {
  Registration(const char* name, Target target);
};

}  // namespace patinate::fuzz

#ifdef PATINATE_LIBFUZZER
#define PATINATE_FUZZ_TARGET(name)                                                    \
  static void fuzz_##name(patinate::fuzz::Bytes bytes);                               \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);  \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { \
    patinate::fuzz::run(fuzz_##name, {data, size});                                   \
    return 0;                                                                         \
  }                                                                                   \
  static void fuzz_##name([[maybe_unused]] patinate::fuzz::Bytes bytes)
#else
#define PATINATE_FUZZ_TARGET(name)                                                      \
  static void fuzz_##name(patinate::fuzz::Bytes bytes);                                 \
  static const patinate::fuzz::Registration registration_of_##name(#name, fuzz_##name); \
  static void fuzz_##name([[maybe_unused]] patinate::fuzz::Bytes bytes)
#endif
