#include "libcommon/device/arithmetic_check.h"

#include <array>
#include <vector>

#include "libcommon/core/kernel_language.h"
#include "libcommon/core/random.h"

namespace patinate::device {

extern const std::string_view kArithmeticKernel;

namespace {

using namespace kernel_types;
using namespace random_kernel;
#include "libcommon/device/arithmetic_check.inl"

}  // namespace

CheckResult check_arithmetic(const Device& device) {
  constexpr std::uint32_t kNumItems = 4096;
  const std::array<std::string_view, 2> sources{kPhiloxKernel, kArithmeticKernel};
  Kernel kernel = device.build("arithmetic", sources).kernel("check_arithmetic");
  const Buffer<std::uint64_t> results = device.allocate<std::uint64_t>(std::size_t{kNumItems} * kResultsOfItem);
  kernel.run({.num = kNumItems}, results);
  std::vector<std::uint64_t> there(results.size()), here(results.size());
  device.read(results, std::span(there));
  CheckResult check{.num_items = kNumItems};
  for (std::uint32_t item = 0; item < kNumItems; ++item) {
    check_item(item, here.data());
    bool differs = false;
    for (std::size_t k = 0; k < kResultsOfItem; ++k) {
      const std::size_t at = std::size_t{item} * kResultsOfItem + k;
      differs = differs || here[at] != there[at];
    }
    check.num_different += differs ? 1 : 0;
  }
  return check;
}

}  // namespace patinate::device
