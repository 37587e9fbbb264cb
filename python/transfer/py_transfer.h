/// \file
/// Transfers as the module's functions take them.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/request/words.h"
#include "patinate/transfer/age.h"
#include "python/surface/py_surface.h"
#include "transfer/guidance/scale.h"

namespace patinate::python {

struct PyAged {
  std::shared_ptr<const transfer::AgedMesh> value;
  std::string path = "";                ///< As it was opened; "" of one that was made here.
  std::vector<std::string> notes = {};  ///< Of one that was made here: what the command would say.
};

/// Keeps what work says, with keywords in place of options.
[[nodiscard]] app::Words collecting(const std::shared_ptr<std::vector<std::string>>& notes);
/// Says what the command says of a destination.
void note_sizes(const transfer::AgingSurface& surface, transfer::ScaleSource source, const app::Words& say);
/// Where its texels lie; of one that was read made when it is asked for.
[[nodiscard]] PySurface surface_of(const transfer::AgedMesh& aged);
/// What is to be known of a transfer: of its sizes, its controls, and what it found in the history.
[[nodiscard]] std::vector<std::string> notes_of(const PyAged& aged);

/// What a texture is asked for at: one time, several, or one of each texel.
struct AskedTime {
  double one = 0.0;
  std::optional<std::vector<double>> several = std::nullopt;
  std::optional<ImageF> map = std::nullopt;
};
/// @param time  A number, a list of numbers, or H x W numbers. @throws TypeError; InvalidInput for another shape.
[[nodiscard]] AskedTime time_from(const std::string& function, const pybind11::object& time);

/// AgeOptions with the seed of the command line.
struct TransferKeywords {
  transfer::AgeOptions age = {};
};
inline void describe(OptionVisitor& v, TransferKeywords& o) {
  describe(v, o.age);
  v.visit({"seed", "Of all random numbers", "", at_least(0)}, o.age.transfer.seed);
}

}  // namespace patinate::python
