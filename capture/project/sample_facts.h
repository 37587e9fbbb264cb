/// \file
/// What a project says of its sample for reports: `"sample": {"coating": "epoxy, 120 um", "exposure": "ISO 9227 NSS"}`.
#pragma once

#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

/// In the order of the file. @param project  May have `sample`. @throws IoError
[[nodiscard]] std::vector<SampleFact> read_sample(JsonReader& project);
/// For keys: "coating=epoxy, 120 um" and so on, a line each.
[[nodiscard]] std::string sample_text(const std::vector<SampleFact>& sample);

}  // namespace patinate::capture
