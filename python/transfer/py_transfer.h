/// \file
/// Transfers as the module's functions take them.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "patinate/transfer/age.h"

namespace patinate::python {

struct PyAged {
  std::shared_ptr<const transfer::AgedMesh> value;
  std::string path = "";  ///< Path as it was opened; "" of one that was made here.
};

/// Times that a texture is asked for at: one, several, or one of each texel.
struct AskedTime {
  double one = 0.0;
  std::optional<std::vector<double>> several = std::nullopt;
  std::optional<ImageF> map = std::nullopt;
};
/// @param time  A number, a list of numbers, or H x W numbers. @throws TypeError; InvalidInput for another shape.
[[nodiscard]] AskedTime time_from(const pybind11::object& time);

/// AgeOptions with the seed of the command line.
struct TransferKeywords {
  transfer::AgeOptions age = {};
};
inline void describe(OptionVisitor& v, TransferKeywords& o) {
  describe(v, o.age);
  v.visit({"seed", "Of all random numbers", "", at_least(0)}, o.age.transfer.seed);
}

}  // namespace patinate::python
