/// \file
/// One description per document, from which its reader, its writer and its JSON Schema are made. A document's struct
/// has one function beside it:
///
///     void describe(DocumentVisitor& v, HistoryCard& card) {
///       v.member({.name = "title", .help = "For people."}, card.title);
///       v.member({.name = "about", .help = "What is seen.", .presence = Presence::IfSet}, card.about);
///     }
///
/// Members are read and written in the order in which they are described.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "patinate/core/json.h"

namespace patinate {

/// When a member stands in a file.
enum class Presence {
  Required,  ///< Always.
  Optional,  ///< A file may leave it out; it is always written.
  IfSet      ///< A file may leave it out; it is written unless it is empty, false or not given.
};

/// A text that not every text is.
struct TextRule {
  std::string_view pattern;  ///< Pattern as a regular expression of JSON Schema.
  int max_length;            ///< In characters.
  std::string expected;      ///< "a name of ...": for error messages.
  bool (*holds)(std::string_view text);
};

struct Member {
  std::string_view name;
  std::string_view help = "";
  Range range = {};
  Presence presence = Presence::Required;
  bool is_nullable = false;          ///< `null` stands for "not given", and is written for it.
  bool has_nulls = false;            ///< Elements of a list may be null.
  const TextRule* rule = nullptr;    ///< Rule of a text, or of each text of a list.
  std::size_t min_size = 0;          ///< Least size of a list.
  std::size_t max_size = 1'000'000;  ///< Largest size of a list.
};
/// Members with one thing beside name, help and range.
[[nodiscard]] constexpr Member if_set(std::string_view name, std::string_view help = "", Range range = {}) {
  return {.name = name, .help = help, .range = range, .presence = Presence::IfSet};
}
[[nodiscard]] constexpr Member or_null(std::string_view name, std::string_view help = "", Range range = {}) {
  return {.name = name, .help = help, .range = range, .is_nullable = true};
}

/// Values by name, in their order: an object whose members are not known before.
template <class T>
using Named = std::vector<std::pair<std::string, T>>;

/// Visits every member of a document, for reading, writing or describing it.
class DocumentVisitor {
 public:
  virtual ~DocumentVisitor() = default;

  /// Values are to be filled; else they are only looked at.
  [[nodiscard]] virtual bool is_reading() const { return false; }
  /// Every member is to be visited, whatever the values are: of a schema.
  [[nodiscard]] virtual bool wants_all() const { return false; }
  /// Exactly one of these members stands in a file: for the schema. What describes them says it to readers by which one
  /// it visits.
  virtual void one_of([[maybe_unused]] std::initializer_list<std::string_view> members) {}
  /// Call after the member was visited. A reader throws IoError, naming the member, unless `holds`.
  virtual void require([[maybe_unused]] std::string_view member, [[maybe_unused]] bool holds,
                       [[maybe_unused]] const std::string& expected) {}

  template <class T>
  void member(const Member& m, T& value) {
    if (!begin_member(m, is_set(value))) return;
    visit(m, value);
    end_member();
  }
  /// `names[i]` is the name of the enumerator with value i.
  template <class Enum, std::size_t N>
  void choice(const Member& m, Enum& value, const std::array<std::string_view, N>& names) {
    if (!begin_member(m, true)) return;
    int index = static_cast<int>(value);
    visit_choice(index, names);
    value = static_cast<Enum>(index);
    end_member();
  }
  template <class Enum, std::size_t N>
  void choice(const Member& m, std::optional<Enum>& value, const std::array<std::string_view, N>& names) {
    if (!begin_member(m, value.has_value())) return;
    int index = value ? static_cast<int>(*value) : 0;
    visit_choice(index, names);
    value = static_cast<Enum>(index);
    end_member();
  }
  /// An object within the object. @param describe_members  Describes what is in it.
  void object(const Member& m, bool is_object_set, const std::function<void()>& describe_members) {
    if (!begin_member(m, is_object_set)) return;
    begin_object();
    describe_members();
    end_object();
    end_member();
  }

  /// A list of objects whose type has no describe() of its own.
  template <class T, class Describe>
  void list(const Member& m, std::vector<T>& values, const Describe& describe_element) {
    if (!begin_member(m, !values.empty())) return;
    values.resize(begin_list(m, values.size()));
    for (std::size_t i = 0; i < values.size(); ++i) {
      begin_element(i);
      begin_object();
      describe_element(values[i]);
      end_object();
      end_element();
    }
    end_list();
    end_member();
  }
  /// An object of any members, which the document's owner reads and writes itself.
  virtual void any_object(const Member& m, const std::function<void(JsonReader)>& read,
                          const std::function<void(Json&)>& write) = 0;

  virtual void begin_object() = 0;
  virtual void end_object() = 0;

 protected:
  /// @returns whether the member is to be visited.
  [[nodiscard]] virtual bool begin_member(const Member& m, bool is_value_set) = 0;
  virtual void end_member() = 0;
  /// @returns how many elements are to be visited.
  [[nodiscard]] virtual std::size_t begin_list(const Member& m, std::size_t size) = 0;
  virtual void begin_element(std::size_t index) = 0;
  virtual void end_element() = 0;
  virtual void end_list() = 0;
  /// The same of Named values. @param names  Of those there are. @returns of those to be visited.
  [[nodiscard]] virtual std::vector<std::string> begin_named(std::vector<std::string> names) = 0;
  virtual void begin_named_value(const std::string& name) = 0;

  virtual void visit(const Member& m, double& value) = 0;
  virtual void visit(const Member& m, std::int64_t& value) = 0;
  virtual void visit(const Member& m, bool& value) = 0;
  virtual void visit(const Member& m, std::string& value) = 0;
  /// A path as it stands in the document, to which it is relative.
  virtual void visit(const Member& m, std::filesystem::path& value) = 0;
  /// A list of any number of numbers.
  virtual void visit(const Member& m, std::span<double> values) = 0;
  /// @returns whether this element is null.
  virtual bool visit_null(bool is_value_set) = 0;
  virtual void visit_choice(int& index, std::span<const std::string_view> names) = 0;

  void visit(const Member& m, int& value) {
    auto wide = std::int64_t{value};
    visit(m, wide);
    value = static_cast<int>(wide);
  }
  void visit(const Member& m, std::size_t& value) {
    auto wide = static_cast<std::int64_t>(value);
    visit(m, wide);
    value = static_cast<std::size_t>(wide);
  }
  template <std::size_t N>
  void visit(const Member& m, std::array<double, N>& values) {
    visit(m, std::span<double>(values));
  }
  template <class T>
  void visit(const Member& m, std::optional<T>& value) {
    if (m.has_nulls && visit_null(value.has_value())) {
      value.reset();
      return;
    }
    if (!value) value.emplace();
    visit(m, *value);
  }
  void visit(const Member& m, std::pair<double, double>& values) {
    std::array<double, 2> ends{values.first, values.second};
    visit(m, std::span<double>(ends));
    values = {ends[0], ends[1]};
  }
  template <class T>
  void visit(const Member& m, std::vector<T>& values) {
    values.resize(begin_list(m, values.size()));
    for (std::size_t i = 0; i < values.size(); ++i) {
      begin_element(i);
      visit(m, values[i]);
      end_element();
    }
    end_list();
  }
  template <class T>
  void visit(const Member& m, Named<T>& values) {
    std::vector<std::string> names;
    for (const auto& value : values) names.push_back(value.first);
    names = begin_named(std::move(names));
    values.resize(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      begin_named_value(values[i].first = names[i]);
      visit(m, values[i].second);
      end_element();
    }
  }
  template <class T>
  requires std::is_class_v<T>
  void visit(const Member&, T& value) {
    begin_object();
    describe(*this, value);
    end_object();
  }

 private:
  template <class T>
  [[nodiscard]] static bool is_set(const T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      return value;
    } else if constexpr (requires { value.has_value(); }) {
      return value.has_value();
    } else if constexpr (requires { value.empty(); }) {
      return !value.empty();
    } else {
      return true;
    }
  }
};

/// A text that is_file_name().
[[nodiscard]] const TextRule& file_name_rule();

/// Description of a kind of document.
struct DocumentKind {
  std::string_view format;  ///< "patinate.history"
  int version = 1;
  std::string_view title;  ///< Title of its schema.
  std::string_view about;
  bool has_whole_numbers = false;  ///< 1.0 is written as 1, as a person would.
};

/// A described document seen without its type.
using DescribeDocument = std::function<void(DocumentVisitor&)>;
/// @param document  Must outlive what is returned.
template <class T>
[[nodiscard]] DescribeDocument described(T& document) {
  return [&document](DocumentVisitor& v) { describe(v, document); };
}
/// Nothing is in it: for a schema.
template <class T>
[[nodiscard]] DescribeDocument described() {
  return [](DocumentVisitor& v) {
    T any{};
    describe(v, any);
  };
}

/// @throws IoError: FILE: POINTER: found X; expected Y; names members that nobody knows.
void read_document(const DocumentKind& kind, const std::filesystem::path& file, const DescribeDocument& describe_it);
/// Reads what load_json() and update_spelling() made of the file.
void read_document(const DocumentKind& kind, const std::filesystem::path& file, const Json& root,
                   const DescribeDocument& describe_it);
[[nodiscard]] Json document_json(const DocumentKind& kind, const DescribeDocument& describe_it);
/// Reads it for its errors alone. @throws IoError
template <class T>
void check_document(const DocumentKind& kind, const std::filesystem::path& file) {
  T document{};
  read_document(kind, file, described(document));
}
/// Without format and version: a part of a document, as object_json() has made it. For files of our own only.
void read_object(const Json& json, const DescribeDocument& describe_it);
/// Writes an object.
[[nodiscard]] Json object_json(const DescribeDocument& describe_it);
/// JSON Schema, draft 2020-12.
[[nodiscard]] Json document_schema(const DocumentKind& kind, const DescribeDocument& describe_it);

}  // namespace patinate
