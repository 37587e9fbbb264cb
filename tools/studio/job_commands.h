/// \file
/// The commands that a browser may start: a fixed list, what of their arguments may come from a browser, and how a
/// request becomes words of a command line. Nothing of it is read by a shell.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "tools/patinate/command_line/argument.h"
#include "tools/studio/served_folder.h"

namespace patinate::studio {

/// What is wrong is the value of one argument. Answered with 400 and the argument's key.
class WrongArgument : public InvalidInput {
 public:
  WrongArgument(std::string key, const std::string& what) : InvalidInput(what), key_(std::move(key)) {}
  [[nodiscard]] const std::string& key() const { return key_; }

 private:
  std::string key_;
};

/// What a positional argument may be.
struct JobInput {
  std::vector<std::string> kinds;  ///< Of places; "photographs" are folders of them.
  std::string title = {};          ///< Of the button on the page of such a place; "" = there is none.
  bool may_be_library = false;     ///< `library:NAME`, too.
};

struct JobCommand {
  std::string name;   ///< "history compare"
  std::string title;  ///< "Compare"
  std::string brief;
  std::string ending;  ///< Of the output's name: "_aged", ".glb"; "/capture.json" lies in the input.
  std::vector<JobInput> inputs;
  std::vector<cli::ArgumentInfo> arguments;                      ///< All that a browser may give, but for the output.
  std::vector<std::pair<std::string, std::string>> values = {};  ///< Of arguments without a default, to begin with.
};

struct JobRequest {
  std::string command;
  std::vector<std::string> words;  ///< Command line without "patinate"; paths are relative to the served folder.
  std::string output;              ///< Name below the served folder.
  std::string arguments = "{}";    ///< As they were asked for, JSON: to ask again.
};

class JobCommands {
 public:
  /// Says what is wrong with a command line before it opens an input. @throws Error
  using Check = std::function<void(const std::string& command, const std::vector<std::string>& arguments)>;

  JobCommands(std::vector<JobCommand> commands, Check check)
      : commands_(std::move(commands)), check_(std::move(check)) {}

  /// For forms: names, help, defaults and choices of all arguments.
  [[nodiscard]] Json json() const;
  /// {"command", "arguments": {key: text, list of texts or boolean}, "output": name}. Without an output, a name that is
  /// free is taken.
  /// @throws WrongArgument; InvalidInput, IoError
  [[nodiscard]] JobRequest read(const ServedFolder& folder, JsonReader& reader) const;

 private:
  std::vector<JobCommand> commands_;
  Check check_;
};

}  // namespace patinate::studio
