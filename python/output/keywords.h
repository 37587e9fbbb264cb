/// \file
/// Keywords and subjects that pictures and models share.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "app/request/times_choice.h"
#include "patinate/transfer/age.h"
#include "python/history/given_history.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

/// Says `time`, `times` and `num_times`.
FunctionText& times_text(FunctionText& text);
[[nodiscard]] app::TimesChoice times_from(Keywords& keywords);

/// What becomes a picture or a model: a folder, or what is in memory only.
struct Subject {
  GivenHistory given = {};  ///< Any folder, not of histories alone.
  std::shared_ptr<const transfer::AgedMesh> aged = nullptr;
};
/// @throws TypeError
[[nodiscard]] Subject subject_from(const std::string& function, const pybind11::object& given);
/// Its folder.
[[nodiscard]] std::filesystem::path place_of(const Subject& subject, Rooms& rooms, const RunControl& control);

}  // namespace patinate::python
