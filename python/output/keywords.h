/// \file
/// Keywords and subjects that pictures and models share.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "app/request/times_choice.h"
#include "libcommon/core/temporary_file.h"
#include "patinate/transfer/age.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

/// Says `time`, `times` and `num_times`.
FunctionText& times_text(FunctionText& text);
[[nodiscard]] app::TimesChoice times_from(Keywords& keywords);

/// Subject of a picture or a model: a folder, or what is in memory.
struct Subject {
  std::filesystem::path folder;
  std::shared_ptr<const transfer::AgedMesh> aged = nullptr;  ///< In memory only.
};
/// @throws InvalidInput for a history in memory; TypeError
[[nodiscard]] Subject subject_from(const std::string& function, const pybind11::object& given);
/// Its folder. @param room  Where what is in memory is saved for the time of the work.
[[nodiscard]] std::filesystem::path place_of(const Subject& subject, std::optional<TemporaryFolder>& room,
                                             const RunControl& control);

}  // namespace patinate::python
