/// \file
/// registration.json: what register_jointly() found (docs/schema/registration.schema.json).
#pragma once

#include <string>
#include <vector>

#include "capture/registration/joint_registration.h"
#include "patinate/core/json.h"

namespace patinate::capture {

/// Whether the scan has a place: Converged, or Degenerate, where an unconstrained degree of freedom is held at its
/// start.
[[nodiscard]] bool is_placed(const RegisteredScan& scan);
/// @param names  As many as scans. @param unit  Of all lengths; "" is written as null.
[[nodiscard]] Json registration_json(const JointRegistration& result, const std::vector<std::string>& names,
                                     int reference, const std::string& unit, RegistrationMethod method,
                                     const std::string& key);
/// The table that people read, of a registration.json: one line a scan, one about the loops.
[[nodiscard]] std::vector<std::string> registration_table(const Json& registration);

}  // namespace patinate::capture
