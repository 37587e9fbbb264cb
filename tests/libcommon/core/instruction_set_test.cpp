#include "libcommon/core/instruction_set.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/errors.h"

namespace patinate {
namespace {

/// Sets PATINATE_ISA, and puts back what it was.
class Asked {
 public:
  explicit Asked(const char* value) {
    const char* before = std::getenv("PATINATE_ISA");
    had_ = before != nullptr;
    if (had_) before_ = before;
    setenv("PATINATE_ISA", value, 1);
  }
  ~Asked() { had_ ? setenv("PATINATE_ISA", before_.c_str(), 1) : unsetenv("PATINATE_ISA"); }
  Asked(const Asked&) = delete;
  Asked& operator=(const Asked&) = delete;

 private:
  bool had_ = false;
  std::string before_;
};

TEST(InstructionSet, IsTheOneThatIsAskedForAndAnErrorIfItIsNotThere) {
  for (std::size_t i = 0; i < kInstructionSetNames.size(); ++i) {
    const Asked asked(kInstructionSetNames[i].data());
    if (has_instruction_set(static_cast<InstructionSet>(i))) {
      EXPECT_EQ(instruction_set(), static_cast<InstructionSet>(i));
    } else {
      EXPECT_TRUE(testing_support::has(testing_support::error_of([] { (void)instruction_set(); }), "does not have it"));
    }
  }
}

TEST(InstructionSet, NamesWhatThereIs) {
  const Asked asked("avx1");
  EXPECT_EQ(testing_support::error_of([] { (void)instruction_set(); }),
            "PATINATE_ISA is `avx1`; use baseline, avx2 or avx512; did you mean `avx2`?");
}

TEST(InstructionSet, WithoutAWishIsOneOfThisMachine) {
  const Asked asked("");
  EXPECT_TRUE(has_instruction_set(instruction_set()));
}

}  // namespace
}  // namespace patinate
