/// \file
/// Transfers as the module's functions take them.
#pragma once

#include <memory>

#include "patinate/transfer/age.h"
#include "patinate/transfer/transfer_reader.h"

namespace patinate::python {

struct PyAged {
  std::shared_ptr<const transfer::AgedMesh> value;
};

struct PyTransfer {
  std::shared_ptr<const transfer::TransferReader> value;
};

/// AgeOptions with the seed of the command line.
struct TransferKeywords {
  transfer::AgeOptions age = {};
};
inline void describe(OptionVisitor& v, TransferKeywords& o) {
  describe(v, o.age);
  v.visit({"seed", "Of all random numbers", "", at_least(0)}, o.age.transfer.seed);
}

}  // namespace patinate::python
