#include "tools/patinate/study/study_options.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/usage_error.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostOptionLevels = 100'000;
/// Options with which `simulate` makes something else, or several.
constexpr std::array<std::string_view, 2> kNotOfStudies{"estimate", "replicates"};
/// What a study says by members of its own.
constexpr std::array<std::string_view, 4> kMembers{"control", "vary", "objective", "parameters"};

const Verb& verb_named(std::string_view name) {
  const std::span<const Verb> all = verbs();
  return *std::find_if(all.begin(), all.end(), [&](const Verb& v) { return v.name == name; });
}

bool is_choosable(const ArgumentInfo& a) {
  const auto is_one_of = [key = a.key()](const auto& list) {
    return std::find(list.begin(), list.end(), key) != list.end();
  };
  return !a.is_positional() && !a.is_common && a.name != "-o" && !is_one_of(kMembers) && !is_one_of(kNotOfStudies);
}

std::string text_of(const JsonReader& value) {
  return value.is_string() ? value.string() : number_text(value.number());
}

}  // namespace

StudyOptions::StudyOptions(StudyContext& context, const std::string& verb) : StudyOptions(context, verb_named(verb)) {}

std::vector<std::string> StudyOptions::words(const std::string& key, const JsonReader& value) {
  std::string wanted = key;
  std::replace(wanted.begin(), wanted.end(), '-', '_');
  std::vector<std::string> names;
  for (const ArgumentInfo& a : command_.arguments) {
    if (!is_choosable(a)) continue;
    names.push_back(a.key());
    if (a.key() != wanted) continue;
    if (a.kind == ArgumentKind::Flag) {
      if (value.boolean()) return {a.name};
      return a.has_no_form ? std::vector<std::string>{"--no-" + a.name.substr(2)} : std::vector<std::string>{};
    }
    const std::string text = text_of(value);
    const fs::path path = context_.file().parent_path() / text;  // As elsewhere in the study.
    if (a.type == ValueType::Path) {
      context_.check_place(value, path);
      return {a.name, context_.word_of(path)};
    }
    try {
      check_options(verb_, {a.name, text});
    } catch (const UsageError& e) {
      context_.problem(value, e.what());
    }
    return {a.name, a.type == ValueType::Text && fs::exists(path) ? context_.word_of(path) : text};
  }
  if (std::find(kNotOfStudies.begin(), kNotOfStudies.end(), wanted) != kNotOfStudies.end())
    context_.problem(value, "`" + key + "` is not for studies; each of `seeds` is a cell");
  else
    context_.problem(value,
                     "`" + std::string(verb_.name) + "` has no option `" + key + "`" + did_you_mean(wanted, names));
  return {};
}

std::vector<std::string> StudyOptions::all_words(JsonReader options) {
  std::vector<std::string> all;
  for (const std::string& key : options.keys()) {
    context_.attempt([&] {
      for (std::string& word : words(key, options.member(key))) all.push_back(std::move(word));
    });
  }
  return all;
}

std::vector<StudyLevel> StudyOptions::factor_of(const std::string& key, const JsonReader& value) {
  std::vector<StudyLevel> factor;
  if (!value.is_array()) {
    factor.push_back({.name = "", .shown = {}});
    factor.back().words = words(key, value);
    return factor;
  }
  for (const JsonReader& v : value.elements(kMostOptionLevels)) {
    const std::string text = text_of(v);
    factor.push_back({.name = slug(key + text), .shown = {{key, text}}});
    factor.back().words = words(key, v);
  }
  if (factor.empty()) context_.problem(value, "expected at least one value");
  return factor;
}

void StudyOptions::read_seeds(const JsonReader& list, std::vector<std::vector<StudyLevel>>& factors) {
  std::vector<StudyLevel> seeds;
  for (const JsonReader& seed : list.elements(kMostOptionLevels)) {
    context_.attempt([&] {
      const std::string text = std::to_string(seed.integer(between(0, 9e15)));
      seeds.push_back({.name = "seed" + text, .shown = {{"seed", text}}});
      seeds.back().words = {"--seed", text};
    });
  }
  if (seeds.empty()) context_.problem(list, "expected at least one");
  factors.push_back(std::move(seeds));
}

void StudyOptions::read_factors(JsonReader& part, std::vector<std::vector<StudyLevel>>& factors) {
  if (part.has("options")) {
    const std::size_t num_before = context_.num_problems();
    JsonReader options = part.member("options");
    std::vector<std::vector<StudyLevel>> read;
    for (const std::string& key : options.keys())
      context_.attempt([&] { read.push_back(factor_of(key, options.member(key))); });
    if (context_.num_problems() == num_before) check_together(options, read);
    factors.insert(factors.end(), read.begin(), read.end());
  }
  if (part.has("seeds")) read_seeds(part.member("seeds"), factors);
}

void StudyOptions::check_together(const JsonReader& json, std::vector<std::string> words, const std::string& output) {
  for (const ArgumentInfo& a : command_.arguments) {
    if (a.type != ValueType::Path) continue;
    for (std::size_t i = 0; i + 1 < words.size(); ++i) {
      if (words[i] == a.name) words[i + 1] = ".";  // A place that is there, seen from here.
    }
  }
  try {
    check_arguments(verb_, words, output);
  } catch (const UsageError& e) {
    context_.problem(json, e.what());
  }
}

/// The first of all values, and each other value beside the first of the others: what is wrong with more than that two
/// together is left to the cell.
void StudyOptions::check_together(const JsonReader& json, const std::vector<std::vector<StudyLevel>>& factors) {
  const auto check = [&](std::size_t changed, std::size_t level) {
    std::vector<std::string> words;
    for (std::size_t f = 0; f < factors.size(); ++f) {
      const std::vector<std::string>& own = factors[f][f == changed ? level : 0].words;
      words.insert(words.end(), own.begin(), own.end());
    }
    check_together(json, words, "made");
  };
  const std::size_t num_before = context_.num_problems();
  check(0, 0);
  if (context_.num_problems() > num_before || factors.empty()) return;  // It would be said again of each.
  for (std::size_t f = 0; f < factors.size(); ++f) {
    for (std::size_t level = 1; level < factors[f].size(); ++level) check(f, level);
  }
}

}  // namespace patinate::cli
