#include "libcommon/history/history.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(history) {
  const HistoryManifest manifest = read_history_manifest(fuzz::fuzz_file("history.json", bytes));
  fuzz::require(!manifest.frames.empty(), "a history has a frame");
  for (std::size_t i = 1; i < manifest.frames.size(); ++i) {
    fuzz::require(manifest.frames[i - 1].time < manifest.frames[i].time, "times rise");
  }
  write_history_manifest(fuzz::fuzz_folder() / "copy.json", manifest);
  const HistoryManifest copy = read_history_manifest(fuzz::fuzz_folder() / "copy.json");
  fuzz::require(copy.frames.size() == manifest.frames.size() && copy.width == manifest.width, "what is written can be read");
}
