#include "libcommon/job/undeclared_output.h"

#include <bit>
#include <system_error>
#include <utility>

#include "libcommon/core/temporary_file.h"
#include "libcommon/job/partial_folder.h"

namespace patinate {

namespace fs = std::filesystem;

UndeclaredSearch::UndeclaredSearch(const JobPlan& plan, fs::path folder, std::size_t num_items)
    : folder_(std::move(folder)), num_items_(num_items) {
  for (const JobItem& item : plan.items) {
    for (const fs::path& file : item.outputs) declared_.insert(file.lexically_normal());
    for (const fs::path& file : item.optional_outputs) declared_.insert(file.lexically_normal());
  }
  for (const fs::path& file : plan.shared_work) declared_.insert(file.lexically_normal());
}

void UndeclaredSearch::finished(const std::string& item, const RunControl& control) {
  const std::size_t count = ++num_finished_;
  if (std::has_single_bit(count) || count == num_items_) search(item, control);
}

void UndeclaredSearch::search(const std::string& item, const RunControl& control) const {
  const fs::path book = fs::path(kJobWorkFolder).parent_path();
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
    control.throw_if_stopped();
    std::error_code ignored;
    if (it->is_directory(ignored)) continue;
    const fs::path relative = it->path().lexically_relative(folder_);
    const bool is_book = *relative.begin() == book && !is_work(relative);
    if (is_book || is_temporary(relative) || declared_.contains(relative)) continue;
    throw UndeclaredOutput(it->path().string() + ": was written by a step that does not declare it (`" + item +
                           "`, or one beside it); this is a fault of patinate, please report it");
  }
}

}  // namespace patinate
