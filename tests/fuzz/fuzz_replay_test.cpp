// Replays the committed corpus through every fuzz target: as it is, cut off at many lengths, and with bits and bytes
// damaged. A target that crashes ends this program; what must hold is in the targets.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/random.h"
#include "tests/fuzz/fuzz_registry.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;

class Fuzz : public testing::TestWithParam<std::string> {
 protected:
  void replay(const std::string& text) const {
    fuzz::run(fuzz::registry().at(GetParam()), {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  [[nodiscard]] std::vector<std::string> corpus() const {
    std::vector<std::string> texts;
    for (const fs::path& file : list_files(fs::path(PATINATE_FUZZ_CORPUS) / GetParam(), "*"))
      texts.push_back(read_file(file));
    return texts;
  }
};

TEST_P(Fuzz, TakesItsCorpus) {
  const std::vector<std::string> texts = corpus();
  ASSERT_FALSE(texts.empty());
  for (const std::string& text : texts) replay(text);
  replay("");
}

TEST_P(Fuzz, TakesFilesCutOffAnywhere) {
  constexpr std::size_t kMaxCuts = 60;
  for (const std::string& text : corpus()) {
    const std::size_t step = std::max<std::size_t>(1, text.size() / kMaxCuts);
    for (std::size_t size = 0; size < text.size(); size += step) replay(text.substr(0, size));
  }
}

TEST_P(Fuzz, TakesDamagedFiles) {
  constexpr int kDamaged = 40;
  for (const std::string& text : corpus()) {
    for (int i = 0; i < kDamaged && !text.empty(); ++i) {
      RandomStream random(1, static_cast<std::uint64_t>(i), 0);
      std::string damaged = text;
      for (int k = 0; k <= i % 4; ++k) {
        char& byte = damaged[random.below(static_cast<std::uint32_t>(text.size()))];
        byte = i % 2 == 0 ? static_cast<char>(byte ^ (1 << random.below(8))) : static_cast<char>(random.below(256));
      }
      replay(damaged);
    }
  }
}

std::vector<std::string> target_names() {
  std::vector<std::string> names;
  for (const auto& [name, target] : fuzz::registry()) names.push_back(name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Targets, Fuzz, testing::ValuesIn(target_names()),
                         [](const auto& target) { return target.param; });

}  // namespace
}  // namespace patinate
