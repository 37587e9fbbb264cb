#include "libcommon/document/document.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/file_name.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::size_t kMaxNamed = 10'000;  ///< Members of an object of any names; they are found one by one.

class DocumentReader final : public DocumentVisitor {
 public:
  explicit DocumentReader(JsonReader root) { at_.push_back(std::move(root)); }

  bool is_reading() const override { return true; }
  void require(std::string_view member, bool holds, const std::string& expected) override {
    if (!holds) at_.back().member(member).fail(expected);
  }
  void any_object(const Member& m, const std::function<void(JsonReader)>& read,
                  const std::function<void(Json&)>&) override {
    if (!begin_member(m, true)) return;
    if (!at_.back().is_object()) at_.back().fail("an object");
    read(at_.back());
    end_member();
  }
  void begin_object() override {}
  void end_object() override { at_.back().finish(); }

 private:
  bool begin_member(const Member& m, bool) override {
    if (m.presence != Presence::Required && !at_.back().has(m.name)) return false;
    at_.push_back(at_.back().member(m.name));
    if (!m.is_nullable || !at_.back().is_null()) return true;
    at_.pop_back();
    return false;
  }
  void end_member() override { at_.pop_back(); }

  std::size_t begin_list(const Member& m, std::size_t) override {
    lists_.push_back(at_.back().elements(m.max_size));
    const std::size_t size = lists_.back().size();
    if (size < m.min_size) at_.back().fail("an array of at least " + std::to_string(m.min_size));
    return size;
  }
  void begin_element(std::size_t index) override { at_.push_back(std::move(lists_.back()[index])); }
  void end_element() override { at_.pop_back(); }
  void end_list() override { lists_.pop_back(); }
  std::vector<std::string> begin_named(std::vector<std::string>) override {
    std::vector<std::string> names = at_.back().keys();
    if (names.size() > kMaxNamed) at_.back().fail("an object of at most " + std::to_string(kMaxNamed) + " members");
    return names;
  }
  void begin_named_value(const std::string& name) override { at_.push_back(at_.back().member(name)); }

  void visit(const Member& m, double& value) override { value = at_.back().number(m.range); }
  void visit(const Member& m, std::int64_t& value) override { value = at_.back().integer(m.range); }
  void visit(const Member&, bool& value) override { value = at_.back().boolean(); }
  void visit(const Member& m, std::string& value) override {
    value = at_.back().string();
    if (m.rule != nullptr && !m.rule->holds(value)) at_.back().fail(m.rule->expected);
  }
  void visit(const Member&, std::filesystem::path& value) override {
    (void)at_.back().path();  // Rejects what is no path.
    value = at_.back().string();
  }
  void visit(const Member& m, std::span<double> values) override {
    const std::vector<double> read = at_.back().numbers(values.size(), m.range);
    std::copy(read.begin(), read.end(), values.begin());
  }
  bool visit_null(bool) override { return at_.back().is_null(); }
  void visit_choice(int& index, std::span<const std::string_view> names) override { index = at_.back().choice(names); }

  std::vector<JsonReader> at_;
  std::vector<std::vector<JsonReader>> lists_;
};

/// Whole numbers are written without ".0", as a person would.
Json number_json(double value) {
  if (value == std::floor(value) && std::abs(value) < 1e15) return Json(static_cast<std::int64_t>(value));
  return Json(value);
}

class DocumentWriter final : public DocumentVisitor {
 public:
  DocumentWriter(Json& root, bool has_whole_numbers) : has_whole_numbers_(has_whole_numbers) { at_.push_back(&root); }

  void any_object(const Member& m, const std::function<void(JsonReader)>&,
                  const std::function<void(Json&)>& write) override {
    Json& json = (*at_.back())[m.name];
    json = Json::object();
    write(json);
  }
  void begin_object() override {
    if (at_.back()->is_null()) *at_.back() = Json::object();
  }
  void end_object() override {}

 private:
  bool begin_member(const Member& m, bool is_value_set) override {
    if (m.presence == Presence::IfSet && !is_value_set) return false;
    Json& json = (*at_.back())[m.name];
    if (m.is_nullable && !is_value_set) return false;  // It is null now.
    at_.push_back(&json);
    return true;
  }
  void end_member() override { at_.pop_back(); }

  std::size_t begin_list(const Member&, std::size_t size) override {
    *at_.back() = Json(Json::array_t(size));
    return size;
  }
  void begin_element(std::size_t index) override { at_.push_back(&(*at_.back())[index]); }
  void end_element() override { at_.pop_back(); }
  void end_list() override {}
  std::vector<std::string> begin_named(std::vector<std::string> names) override {
    *at_.back() = Json::object();
    return names;
  }
  void begin_named_value(const std::string& name) override { at_.push_back(&(*at_.back())[name]); }

  void visit(const Member&, double& value) override { *at_.back() = number(value); }
  void visit(const Member&, std::int64_t& value) override { *at_.back() = value; }
  void visit(const Member&, bool& value) override { *at_.back() = value; }
  void visit(const Member&, std::string& value) override { *at_.back() = value; }
  void visit(const Member&, std::filesystem::path& value) override { *at_.back() = value.generic_string(); }
  void visit(const Member&, std::span<double> values) override {
    *at_.back() = Json::array();
    for (const double value : values) at_.back()->push_back(number(value));
  }
  bool visit_null(bool is_value_set) override { return !is_value_set; }  // Elements begin as null.
  void visit_choice(int& index, std::span<const std::string_view> names) override { *at_.back() = names[index]; }

  [[nodiscard]] Json number(double value) const { return has_whole_numbers_ ? number_json(value) : Json(value); }

  std::vector<Json*> at_;
  bool has_whole_numbers_;
};

class SchemaWriter final : public DocumentVisitor {
 public:
  explicit SchemaWriter(Json& root) { at_.push_back(&root); }

  bool wants_all() const override { return true; }
  void one_of(std::initializer_list<std::string_view> members) override {
    for (const std::string_view member : members)
      (*at_.back())["oneOf"].push_back({{"required", Json::array({member})}});
  }
  void any_object(const Member& m, const std::function<void(JsonReader)>&, const std::function<void(Json&)>&) override {
    (void)begin_member(m, true);
    (*at_.back())["type"] = "object";
    end_member();
  }
  void begin_object() override {
    Json& json = *at_.back();
    json["type"] = json.value("type", Json()) == "null" ? Json::array({"object", "null"}) : Json("object");
    if (!json.contains("properties")) json["properties"] = Json::object();
    if (!json.contains("required")) json["required"] = Json::array();
    json["additionalProperties"] = false;
  }
  void end_object() override {}

 private:
  bool begin_member(const Member& m, bool) override {
    Json& object = *at_.back();
    if (m.presence == Presence::Required) object["required"].push_back(m.name);
    Json& json = object["properties"][m.name];
    json = Json::object();
    if (!m.help.empty()) json["description"] = m.help;
    if (m.is_nullable) json["type"] = "null";  // The visited member adds its own type.
    at_.push_back(&json);
    return true;
  }
  void end_member() override { at_.pop_back(); }

  std::size_t begin_list(const Member& m, std::size_t) override {
    Json& json = *at_.back();
    json["type"] = json.value("type", Json()) == "null" ? Json::array({"array", "null"}) : Json("array");
    if (m.min_size > 0) json["minItems"] = m.min_size;
    json["maxItems"] = m.max_size;
    json["items"] = Json::object();
    return 1;
  }
  void begin_element(std::size_t) override { at_.push_back(&(*at_.back())["items"]); }
  void end_element() override { at_.pop_back(); }
  void end_list() override {}
  std::vector<std::string> begin_named(std::vector<std::string>) override {
    (*at_.back())["type"] = "object";
    return {""};
  }
  void begin_named_value(const std::string&) override {
    at_.push_back(&((*at_.back())["additionalProperties"] = Json::object()));
  }

  void set_type(const Member& m, const char* type) {
    Json& json = *at_.back();
    json["type"] = m.has_nulls || json.value("type", Json()) == "null" ? Json::array({type, "null"}) : Json(type);
  }
  static void set_range(const Range& range, Json& json) {
    if (std::isfinite(range.low)) json[range.is_low_open ? "exclusiveMinimum" : "minimum"] = number_json(range.low);
    if (std::isfinite(range.high)) json["maximum"] = number_json(range.high);
  }
  void visit(const Member& m, double&) override {
    set_type(m, "number");
    set_range(m.range, *at_.back());
  }
  void visit(const Member& m, std::int64_t&) override {
    set_type(m, "integer");
    set_range(m.range, *at_.back());
  }
  void visit(const Member& m, bool&) override { set_type(m, "boolean"); }
  void visit(const Member& m, std::string&) override {
    set_type(m, "string");
    if (m.rule == nullptr) return;
    (*at_.back())["pattern"] = m.rule->pattern;
    (*at_.back())["maxLength"] = m.rule->max_length;
  }
  void visit(const Member& m, std::filesystem::path&) override {
    set_type(m, "string");
    (*at_.back())["minLength"] = 1;
    Json& help = (*at_.back())["description"];
    help = (help.is_string() ? help.get<std::string>() + " " : std::string()) + "Relative to this file.";
  }
  void visit(const Member& m, std::span<double> values) override {
    Json& json = *at_.back();
    json["type"] = "array";
    json["items"] = {{"type", "number"}};
    set_range(m.range, json["items"]);
    json["minItems"] = json["maxItems"] = values.size();
  }
  bool visit_null(bool) override { return false; }
  void visit_choice(int&, std::span<const std::string_view> names) override { (*at_.back())["enum"] = names; }

  std::vector<Json*> at_;
};

}  // namespace

const TextRule& file_name_rule() {
  static const TextRule rule{.pattern = "^[A-Za-z0-9_-][A-Za-z0-9._-]*$",
                             .max_length = static_cast<int>(kLongestFileName),
                             .expected = "a name of " + file_name_text(),
                             .holds = is_file_name};
  return rule;
}

void read_document(const DocumentKind& kind, const std::filesystem::path& file, const DescribeDocument& describe_it) {
  read_document(kind, file, load_json(file), describe_it);
}

void read_document(const DocumentKind& kind, const std::filesystem::path& file, const Json& root,
                   const DescribeDocument& describe_it) {
  JsonReader json(file.string(), root);
  json.expect_format(kind.format, kind.version);
  DocumentReader reader(std::move(json));
  reader.begin_object();
  describe_it(reader);
  reader.end_object();
}

void read_object(const Json& json, const DescribeDocument& describe_it) {
  DocumentReader reader(JsonReader("a part", json));
  describe_it(reader);
  reader.end_object();
}

Json document_json(const DocumentKind& kind, const DescribeDocument& describe_it) {
  Json root = {{"format", kind.format}, {"version", kind.version}};
  DocumentWriter writer(root, kind.has_whole_numbers);
  describe_it(writer);
  return root;
}

Json object_json(const DescribeDocument& describe_it) {
  Json object = Json::object();
  DocumentWriter writer(object, false);
  describe_it(writer);
  return object;
}

Json document_schema(const DocumentKind& kind, const DescribeDocument& describe_it) {
  Json root = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
               {"title", kind.title},
               {"description", kind.about},
               {"type", "object"},
               {"properties", {{"format", {{"const", kind.format}}}, {"version", {{"const", kind.version}}}}},
               {"required", {"format", "version"}}};
  SchemaWriter writer(root);
  writer.begin_object();
  describe_it(writer);
  return root;
}

}  // namespace patinate
