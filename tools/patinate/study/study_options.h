/// \file
/// Options of a study's commands, by the names that the commands have for them.
#pragma once

#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "tools/patinate/command_line/verbs.h"
#include "tools/patinate/study/study_context.h"
#include "tools/patinate/study/study_ranges.h"

namespace patinate::cli {

/// Reads what a study says to one command.
class StudyOptions {
 public:
  StudyOptions(StudyContext& context, const Verb& verb)
      : context_(context), verb_(verb), command_(declaration_of(verb)) {}
  StudyOptions(StudyContext& context, const std::string& verb);

  /// The words that give one value to an option; what is wrong with it is a problem.
  [[nodiscard]] std::vector<std::string> words(const std::string& key, const JsonReader& value);
  /// The same of a whole object. @param options  Its members are the options.
  [[nodiscard]] std::vector<std::string> all_words(JsonReader options);
  /// The member `options` of a part, if it has it: those with a list of values are varied; and its `seeds`. Values that
  /// do not go together are problems.
  void read_factors(JsonReader& part, std::vector<std::vector<StudyLevel>>& factors);
  /// What the command says of options beside each other. @param json  What is named. @param output  What it makes.
  void check_together(const JsonReader& json, std::vector<std::string> words, const std::string& output);

 private:
  [[nodiscard]] std::vector<StudyLevel> factor_of(const std::string& key, const JsonReader& value);
  void check_together(const JsonReader& json, const std::vector<std::vector<StudyLevel>>& factors);
  void read_seeds(const JsonReader& list, std::vector<std::vector<StudyLevel>>& factors);

  StudyContext& context_;
  const Verb& verb_;
  CommandDeclaration command_;
};

}  // namespace patinate::cli
