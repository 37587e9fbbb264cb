/// \file
/// The built-in rules' texts: simulation/rules/assets/*.json, made part of the program by simulation/CMakeLists.txt.
#pragma once

#include <string_view>

namespace patinate::simulation {

extern const std::string_view kRuleRust;
extern const std::string_view kRuleRustConsuming;
extern const std::string_view kRuleDecay;
extern const std::string_view kRuleDecayTwoRates;
extern const std::string_view kRuleGrowth;
extern const std::string_view kRuleEvaporation;
extern const std::string_view kRuleEvaporationConstant;
extern const std::string_view kRulePatina;
extern const std::string_view kRuleDust;
extern const std::string_view kRuleMoss;
extern const std::string_view kRuleFading;
extern const std::string_view kRuleWetting;

}  // namespace patinate::simulation
