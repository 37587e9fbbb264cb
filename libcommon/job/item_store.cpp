#include "libcommon/job/item_store.h"

#include <cstdint>
#include <system_error>

#include "libcommon/core/files.h"
#include "libcommon/core/temporary_file.h"
#include "libcommon/job/output_state.h"
#include "libcommon/job/partial_folder.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr const char* kMarker = ".job/item";
constexpr std::uint64_t kMaxOfMarker = 1 << 26;

/// "a/b/" and "a/b" are the same folder.
fs::path items_path(const fs::path& output) {
  return (output.has_filename() || !output.has_parent_path() ? output : output.parent_path()).string() + ".items";
}

}  // namespace

ItemStore::ItemStore(const JobPlan& plan) : plan_(plan), path_(items_path(plan.output)) {}

std::string ItemStore::name_of(const JobItem& item) const { return item.name + "-" + item_key(plan_, item); }

void ItemStore::open() const {
  std::error_code error;
  fs::create_directory(path_, error);
  if (error) throw CannotComplete(path_.string() + ": cannot be made; " + error.message());
  for (const auto& entry : fs::directory_iterator(path_)) {
    if (is_temporary(entry.path()) || fs::exists(entry.path() / kMarker, error)) continue;
    throw CannotComplete(path_.string() +
                         ": holds files that patinate did not write; move them or give another output");
  }
}

void ItemStore::refresh() {
  names_.clear();
  std::error_code error;
  for (fs::directory_iterator it(path_, error), end; !error && it != end; it.increment(error))
    names_.insert(it->path().filename().string());
}

bool ItemStore::has(const JobItem& item) const { return names_.contains(name_of(item)); }

DoneItem ItemStore::read(const JobItem& item) const {
  const fs::path place = path_ / name_of(item);
  try {
    DoneItem done = parse_marker(read_file(place / kMarker, kMaxOfMarker));
    if (done.key == item_key(plan_, item)) return done;
  } catch (const IoError&) {
    // Told below, as what is missing.
  }
  throw CannotComplete(place.string() + ": is damaged, or was removed meanwhile; remove it and try again");
}

void ItemStore::take(const JobItem& item, const fs::path& folder) const {
  const fs::path place = path_ / name_of(item);
  for (const auto& [file, key] : read(item).files) {
    try {
      link_or_copy(place / file, folder / file);
    } catch (const fs::filesystem_error& e) {
      throw CannotComplete((place / file).string() + ": cannot be read; " + e.code().message());
    }
  }
  for (const fs::path& file : plan_.shared_work) {
    std::error_code error;
    if (!fs::exists(place / file, error)) continue;
    try {
      link_or_copy(place / file, folder / file);
    } catch (const fs::filesystem_error&) {
      // Dropped just now: whoever finds none begins anew.
    }
  }
}

void ItemStore::add(const JobItem& item, const fs::path& folder, const RunControl& control) const {
  const DoneItem done = finish_item(folder, item, item_key(plan_, item), control);
  TemporaryFolder kept(path_, item.name);
  for (const auto& [file, key] : done.files) link_or_copy(folder / file, kept.path() / file);
  for (const fs::path& file : plan_.shared_work) {
    if (fs::exists(folder / file)) link_or_copy(folder / file, kept.path() / file);
  }
  fs::create_directories((kept.path() / kMarker).parent_path());
  write_atomically(kept.path() / kMarker, marker_text(done));
  if (kept.move_to(path_ / name_of(item))) sync_path(path_);
}

void ItemStore::drop_shared_work(const JobItem& item) const {
  std::error_code error;
  for (const fs::path& file : plan_.shared_work) fs::remove(path_ / name_of(item) / file, error);
}

void ItemStore::remove_all() const {
  std::error_code error;
  for (const JobItem& item : plan_.items) fs::remove_all(path_ / name_of(item), error);
  remove_abandoned(path_, "");
  fs::remove(path_, error);
}

}  // namespace patinate
