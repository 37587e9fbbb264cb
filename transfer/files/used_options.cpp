#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "libcommon/core/files.h"
#include "patinate/core/json.h"
#include "transfer/files/transfer_files.h"

namespace patinate::transfer {

namespace {

/// Sets options to what members of an object say; those that an earlier version did not write stay as they are.
class MemberReader final : public OptionVisitor {
 public:
  explicit MemberReader(JsonReader& json) : json_(json) {}

  void visit(const OptionInfo& info, double& value) override {
    if (const auto json = given(info)) value = json->number(info.range);
  }
  void visit(const OptionInfo& info, int& value) override {
    if (const auto json = given(info)) value = static_cast<int>(json->integer(info.range));
  }
  void visit(const OptionInfo& info, std::int64_t& value) override {
    if (const auto json = given(info)) value = json->integer(info.range);
  }
  void visit(const OptionInfo& info, bool& value) override {
    if (const auto json = given(info)) value = json->string() == "true";  // As option_values() has it.
  }
  void visit(const OptionInfo& info, std::string& value) override {
    if (const auto json = given(info)) value = json->string();
  }
  void visit(const OptionInfo& info, std::optional<double>& value) override {
    const auto json = given(info);
    if (json && json->is_number()) value = json->number(info.range);
  }
  void visit(const OptionInfo& info, std::span<double> values) override {
    const auto json = given(info);
    if (!json) return;
    const std::vector<double> numbers = json->numbers(values.size(), info.range);
    std::copy(numbers.begin(), numbers.end(), values.begin());
  }
  void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) override {
    if (const auto json = given(info)) index = json->choice(names);
  }

 private:
  [[nodiscard]] std::optional<JsonReader> given(const OptionInfo& info) {
    return json_.has(info.name) ? std::optional(json_.member(info.name)) : std::nullopt;
  }

  JsonReader& json_;
};

}  // namespace

TransferOptions read_used_options(const std::filesystem::path& path) {
  const std::filesystem::path file = manifest_folder(path, "transfer.json") / "transfer.json";
  const Json document = load_json(file);
  JsonReader root(file.string(), document);
  JsonReader options = root.member("options");
  TransferOptions used;
  MemberReader reader(options);
  describe(reader, used);
  return used;
}

}  // namespace patinate::transfer
