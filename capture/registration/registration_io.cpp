#include "capture/registration/registration_io.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"

namespace patinate::capture {

namespace {

template <class Matrix>
Json rows_json(const Matrix& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(row);
  }
  return rows;
}

Json motions_json(const std::vector<UnconstrainedDof>& motions) {
  Json texts = Json::array();
  for (const UnconstrainedDof& m : motions) texts.push_back(text_of(m));
  return texts;
}

Json scan_json(const RegisteredScan& s, const std::string& name, const std::vector<std::string>& names) {
  Json json{{"file", name}, {"status", name_of(s.status)}};
  json["matrix"] = is_placed(s) ? rows_json(s.reference_from_scan.matrix()) : Json();
  json["residual"] = s.rms_residual;
  json["overlap"] = s.overlap;
  json["partner"] = s.partner >= 0 ? Json(names[s.partner]) : Json();
  json["covariance"] = rows_json(s.covariance);
  json["covariance_center"] = {s.center.x(), s.center.y(), s.center.z()};
  json["unconstrained_dofs"] = motions_json(s.unconstrained_dofs);
  json["found_by_search"] = s.is_found_by_search;
  if (s.ambiguous_deg > 0.0) json["ambiguous_deg"] = s.ambiguous_deg;
  return json;
}

Json pair_json(const RegistrationEdge& e, const std::vector<std::string>& names) {
  Json json{{"target", names[e.target]}, {"source", names[e.source]}, {"status", name_of(e.pair.status)}};
  json["overlap"] = e.pair.overlap;
  json["residual"] = e.pair.rms_residual;
  json["in_front"] = e.pair.in_front ? Json(*e.pair.in_front) : Json();
  json["is_in_tree"] = e.is_in_tree;
  json["is_used"] = e.is_used;
  json["closure_deg"] = e.closure_deg;
  json["closure"] = e.closure;
  json["joint_median_residual"] = e.median_residual;
  return json;
}

/// A cell of the table, to the right.
std::string padded(const std::string& text, std::size_t width) {
  return std::string(width > text.size() ? width - text.size() : 0, ' ') + text;
}

std::string with_digits(double value, int digits) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

}  // namespace

bool is_placed(const RegisteredScan& scan) { return is_found(scan.status); }

Json registration_json(const JointRegistration& result, const std::vector<std::string>& names, int reference,
                       const std::string& unit, RegistrationMethod method, const std::string& key) {
  Json json{{"format", "patinate.registration"}, {"version", 2}};
  json["unit"] = unit.empty() ? Json() : Json(unit);
  json["reference"] = names[reference];
  json["method"] = kRegistrationMethodNames[static_cast<std::size_t>(method)];
  json["scans"] = Json::array();
  for (std::size_t k = 0; k < names.size(); ++k) json["scans"].push_back(scan_json(result.scans[k], names[k], names));
  json["pairs"] = Json::array();
  for (const RegistrationEdge& e : result.edges) json["pairs"].push_back(pair_json(e, names));
  json["closure"] = {{"median_deg", result.median_closure_deg},
                     {"median", result.median_closure},
                     {"largest_deg", result.largest_closure_deg},
                     {"largest", result.largest_closure}};
  json["rounds"] = result.num_rounds;
  json["key"] = key;
  return json;
}

std::vector<std::string> registration_table(const Json& registration) {
  const bool has_unit = registration.at("unit").is_string();
  const double mm = has_unit ? find_mm_per_unit(registration.at("unit").get<std::string>()).value_or(1.0) : 1.0;
  std::size_t width = 4;
  for (const Json& s : registration.at("scans")) width = std::max(width, s.at("file").get<std::string>().size());
  const std::string unit = has_unit ? "mm" : "units";
  std::vector<std::string> lines;
  const auto row = [&](const std::string& a, const std::string& b, const std::string& c, const std::string& d,
                       const std::string& e, const std::string& f) {
    lines.push_back(a + std::string(width > a.size() ? width - a.size() : 0, ' ') + padded(b, 17) + padded(c, 9) +
                    padded(d, 16) + padded(e, 12) + padded(f, 14));
  };
  row("scan", "status", "overlap", "residual " + unit, "sd deg", "sd " + unit);
  for (const Json& s : registration.at("scans")) {
    const bool is_reference = s.at("file") == registration.at("reference");
    double turn = 0.0, shift = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      turn += s.at("covariance").at(k).at(k).get<double>();
      shift += s.at("covariance").at(k + 3).at(k + 3).get<double>();
    }
    const bool is_known = !is_reference && !s.at("matrix").is_null();
    row(s.at("file").get<std::string>(), is_reference ? "reference" : s.at("status").get<std::string>(),
        with_digits(s.at("overlap").get<double>(), 2),
        has_unit ? with_digits(mm * s.at("residual").get<double>(), 4)
                 : short_number_text(rounded(s.at("residual").get<double>(), 3)),
        is_known ? with_digits(std::sqrt(turn) * 180.0 / 3.14159265358979323846, 4) : "-",
        !is_known  ? "-"
        : has_unit ? with_digits(mm * std::sqrt(shift), 4)
                   : short_number_text(rounded(std::sqrt(shift), 3)));
    for (const Json& motion : s.at("unconstrained_dofs"))
      lines.push_back("  unconstrained: " + motion.get<std::string>());
    if (const double other = s.value("ambiguous_deg", 0.0); other > 0.0)
      lines.push_back("  warning: it fits nearly as well turned by " + short_number_text(std::round(other)) +
                      " degrees; if registration.png shows it turned, give its pose with --initial FILE.conf");
  }
  const Json& closure = registration.at("closure");
  const auto length = [&](const char* name) {
    return short_number_text(rounded(mm * closure.at(name).get<double>(), 3)) + " " + unit;
  };
  const auto angle = [&](const char* name) {
    return short_number_text(rounded(closure.at(name).get<double>(), 3)) + " deg";
  };
  if (registration.at("scans").size() > 2) {  // Two scans close no loop.
    lines.push_back("loops before the joint solve: median " + angle("median_deg") + ", " + length("median") +
                    "; largest " + angle("largest_deg") + ", " + length("largest"));
  }
  return lines;
}

}  // namespace patinate::capture
