/// \file
/// What analyses say, as Python has it.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>

#include "patinate/analysis/report_parts.h"
#include "patinate/core/options.h"

namespace patinate::python {

/// One number, a chart, a picture: dicts as reports' JSON has them; of a picture also `image`, H x W x 3, linear.
[[nodiscard]] pybind11::dict figures_of(const std::vector<analysis::Figure>& figures);
[[nodiscard]] pybind11::list pictures_of(std::vector<analysis::Picture> pictures);

/// Options of an analysis with the seed that the command line gives by default.
template <class Options>
struct Seeded {
  Options options = {};
  std::int64_t seed;
};
template <class Options>
void describe(OptionVisitor& v, Seeded<Options>& o) {
  describe(v, o.options);
  v.visit({"seed", "Of all random numbers", "", at_least(0)}, o.seed);
}
/// Default of the commands' --seed.
inline constexpr std::int64_t kDefaultSeed = 1;

}  // namespace patinate::python
