#include <nlohmann/json.hpp>
#include <optional>

#include "libcommon/core/files.h"
#include "libcommon/core/json_options.h"
#include "patinate/core/json.h"
#include "transfer/files/transfer_files.h"

namespace patinate::transfer {

namespace {

/// Options as option_values() writes them: an earlier version did not write all.
class MemberReader final : public JsonOptionReader {
 public:
  explicit MemberReader(JsonReader& json) : json_(json) {}

  using JsonOptionReader::visit;
  void visit(const OptionInfo& info, bool& value) override {
    if (const auto json = given(info)) value = json->string() == "true";
  }
  void visit(const OptionInfo& info, std::optional<double>& value) override {
    const auto json = given(info);
    if (json && json->is_number()) value = json->number(info.range);
  }

 private:
  [[nodiscard]] std::optional<JsonReader> given(const OptionInfo& info) override {
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
