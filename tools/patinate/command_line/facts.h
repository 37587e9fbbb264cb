/// \file
/// What `patinate info` tells of a path.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "patinate/core/json.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

/// Lines "name: value" that are also members of a JSON object.
class Facts {
 public:
  explicit Facts(const std::string& kind);
  /// @param shown  "" = only in the JSON.
  void add(const std::string& name, const Json& value, const std::string& shown);
  void add(const std::string& name, const std::string& value);
  void add(const std::string& name, std::int64_t value);
  void report(CommandRun& run) const;

 private:
  std::shared_ptr<Json> json_;
  std::string text_;
};

}  // namespace patinate::cli
