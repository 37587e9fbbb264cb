#include <algorithm>

#include "libcommon/core/printable.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

/// Anything at all as a line of a terminal.
PATINATE_FUZZ_TARGET(printable) {
  for (const std::size_t most : {std::size_t{100}, kLongestLine}) {
    const std::string line = printable_line(fuzz::text_of(bytes), most);
    fuzz::require(line.size() <= most, "a line is bounded");
    fuzz::require(std::all_of(line.begin(), line.end(),
                              [](char c) { return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f; }),
                  "a line holds no control characters");
    fuzz::require(printable_line(line, most) == line, "what is printable stays as it is");
  }
}
