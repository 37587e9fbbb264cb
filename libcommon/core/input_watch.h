/// \file
/// What a command reads, noted, so that a file which is replaced meanwhile is found: a result would be mixed of two
/// contents, under the key of the first. All readers call require_regular_file(), which notes the file.
#pragma once

#include <cstddef>
#include <filesystem>

#include "patinate/core/error.h"

namespace patinate {

/// Size, time of change or inode of an input is another than when it was first read.
class InputChanged : public IoError {
 public:
  explicit InputChanged(const std::filesystem::path& path);
};

/// While it lives, this process notes what it reads. One at a time; without one all below does nothing.
class InputWatch {
 public:
  InputWatch();
  ~InputWatch();
  InputWatch(const InputWatch&) = delete;
  InputWatch& operator=(const InputWatch&) = delete;
};

/// Reads of this thread are no input while it lives: an output that is looked at, a cache.
class UnwatchedReads {
 public:
  UnwatchedReads();
  ~UnwatchedReads();
  UnwatchedReads(const UnwatchedReads&) = delete;
  UnwatchedReads& operator=(const UnwatchedReads&) = delete;
};

/// Call before a file is opened for reading. Files of outputs that are being made are left out. Thread-safe, as all
/// below. @throws InputChanged if it is no longer what it was when it was noted first.
void note_input(const std::filesystem::path& path);
/// How often a file was noted so far.
[[nodiscard]] std::size_t num_input_notes();
/// Call when files were read, and before what was made of them counts.
/// @param since  Files that were noted since num_input_notes() said so. @throws InputChanged
void require_unchanged_inputs(std::size_t since = 0);
/// It was noted, under whatever name.
[[nodiscard]] bool is_noted_input(const std::filesystem::path& path);
/// Call when this process replaces a file itself.
void forget_input(const std::filesystem::path& path);

/// While it lives, files that become whole (AtomicFile) are preceded by a look at the inputs noted since it began;
/// else at all inputs.
class InputStep {
 public:
  enum class Look { AtNewInputs, None };
  /// @param look  None where the caller calls require_unchanged_inputs() itself.
  explicit InputStep(Look look = Look::AtNewInputs);
  ~InputStep();
  InputStep(const InputStep&) = delete;
  InputStep& operator=(const InputStep&) = delete;

 private:
  std::size_t before_;
};
/// For AtomicFile.
void require_unchanged_inputs_of_step();

}  // namespace patinate
