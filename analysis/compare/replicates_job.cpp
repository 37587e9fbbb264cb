#include "analysis/compare/replicates_job.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "analysis/compare/compare_job.h"
#include "analysis/compare/replicates.h"
#include "analysis/compare/replicates_report.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/output/contact_strip.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kReplicatesVersion = 4;  ///< Raised when the same input gives other figures.
constexpr std::size_t kStackBytes = std::size_t{1} << 30;
constexpr int kReplicateSide = 160, kPictureColumns = 6;

const fs::path kLookFile = fs::path(kJobWorkFolder) / "look.json";

/// All replicates, those of A first, brought to one set of times and sizes.
struct Replicates {
  ReplicatesTask task;
  std::vector<SeriesFile> files;
  std::vector<std::string> keys;
  GroupTimes times;
  CommonSizes sizes;

  [[nodiscard]] std::size_t count() const { return files.size(); }
  [[nodiscard]] bool is_a(std::size_t k) const { return k < task.a.size(); }
  [[nodiscard]] int size_of(std::size_t k) const { return is_a(k) ? sizes.a : sizes.b; }
  [[nodiscard]] TimeUnit time_unit() const { return files.front().series.facts().time_unit; }
};

/// Surfaces in memory, as many as fit.
class LoadedStacks {
 public:
  explicit LoadedStacks(std::size_t count) : stacks_(count), used_at_(count, 0) {}

  ColorStack stack(const Replicates& all, std::size_t k, const RunControl& control) {
    const std::scoped_lock lock(mutex_);
    if (!stacks_[k]) {
      stacks_[k] = load_stack(all.files[k].series, all.times.of[k], all.size_of(k), control);
      stacks_[k]->times = all.times.clock;
    }
    used_at_[k] = ++clock_;
    while (bytes() > kStackBytes && drop_oldest_but(k)) continue;
    return *stacks_[k];
  }

 private:
  [[nodiscard]] std::size_t bytes() const {
    std::size_t sum = 0;
    for (const auto& s : stacks_) sum += s ? sizeof(float) * (s->rgb.size() + s->lab.size() + s->deviation.size()) : 0;
    return sum;
  }
  bool drop_oldest_but(std::size_t kept) {
    std::optional<std::size_t> oldest;
    for (std::size_t k = 0; k < stacks_.size(); ++k) {
      if (k != kept && stacks_[k] && (!oldest || used_at_[k] < used_at_[*oldest])) oldest = k;
    }
    if (oldest) stacks_[*oldest].reset();
    return oldest.has_value();
  }

  std::mutex mutex_;
  std::vector<std::optional<ColorStack>> stacks_;
  std::vector<std::uint64_t> used_at_;
  std::uint64_t clock_ = 0;
};

void require_replicates(const Replicates& all) {
  const std::vector<std::string>& names = all.task.names;
  for (std::size_t k = 0; k < all.count(); ++k) {
    for (std::size_t i = 0; i < k; ++i) {
      if (all.keys[i] == all.keys[k])
        throw InvalidInput(names[i] + " and " + names[k] + " are the same history; every replicate is one of its own");
    }
    const std::size_t first = all.is_a(k) ? 0 : all.task.a.size();
    const TextureSeries &one = all.files[first].series, &other = all.files[k].series;
    if (one.width() != other.width() || one.height() != other.height())
      throw InvalidInput(names[k] + " has " + size_text(other.width(), other.height()) + " pixels, " + names[first] +
                         " " + size_text(one.width(), one.height()) + ": the replicates of a side have one size");
  }
}

std::vector<NamedFacts> facts_of(const Replicates& all) {
  std::vector<NamedFacts> facts;
  for (std::size_t k = 0; k < all.count(); ++k) facts.push_back({all.task.names[k], &all.files[k].series.facts()});
  return facts;
}

Replicates opened(ReplicatesTask task) {
  for (const auto& [side, paths] : {std::pair("A", &task.a), std::pair("B", &task.b)}) {
    if (paths->size() < 2)
      throw InvalidInput(std::string(side) + " has " + (paths->empty() ? "no" : "one") +
                         " replicate: two or more are needed to measure chance");
  }
  Replicates all{.task = std::move(task), .files = {}, .keys = {}, .times = {}, .sizes = {}};
  for (const std::vector<fs::path>* paths : {&all.task.a, &all.task.b}) {
    for (const fs::path& path : *paths) {
      all.files.push_back(open_series(path));
      all.keys.push_back(all.files.back().key());
    }
  }
  require_replicates(all);
  all.times = common_times(facts_of(all), all.task.options);
  const auto extent = [&](std::size_t k) {
    const TextureSeries& s = all.files[k].series;
    return SurfaceExtent{s.width(), s.height(), s.pixel_mm()};
  };
  all.sizes = common_sizes(extent(0), extent(all.task.a.size()), all.task.options.size,
                           all.task.options.places == Places::Equal);
  return all;
}

/// Order of two replicates that only their content decides: a distance has no direction.
std::pair<std::size_t, std::size_t> ordered(const Replicates& all, std::size_t i, std::size_t j) {
  return all.keys[i] < all.keys[j] ? std::pair(i, j) : std::pair(j, i);
}

std::string pair_name(const Replicates& all, std::size_t i, std::size_t j) {
  const auto [one, other] = ordered(all, i, j);
  constexpr std::size_t kDigits = 16;
  return "pair_" + all.keys[one].substr(0, kDigits) + "_" + all.keys[other].substr(0, kDigits);
}
fs::path pair_file(const std::string& name) { return fs::path(kJobWorkFolder) / (name + ".json"); }

std::string pair_key(const Replicates& all, std::size_t i, std::size_t j) {
  const auto [one, other] = ordered(all, i, j);
  ContentHash hash;
  hash.add("compare_pair").add(kReplicatesVersion);
  for (const auto& [name, value] : option_values(all.task.options)) hash.add(name).add(value);
  hash.add(std::to_string(all.task.options.seed)).add(time_unit_text(all.time_unit()));
  for (const double t : all.times.clock) hash.add(t);
  for (const std::size_t k : {one, other}) {
    hash.add(all.keys[k]).add(std::int64_t{all.size_of(k)});
    for (const double t : all.times.of[k]) hash.add(t);
  }
  return hash.hex();
}

JobItem pair_item(const std::shared_ptr<const Replicates>& all, const std::shared_ptr<LoadedStacks>& stacks,
                  std::size_t i, std::size_t j) {
  const std::string name = pair_name(*all, i, j);
  JobItem item{.name = name, .outputs = {pair_file(name)}, .run = {}, .key = pair_key(*all, i, j)};
  item.run = [all, stacks, name, pair = ordered(*all, i, j)](const fs::path& folder, const RunControl& control) {
    const auto [one, other] = pair;
    ColorStack a = stacks->stack(*all, one, control.part(0.0, 0.2)),
               b = stacks->stack(*all, other, control.part(0.2, 0.4));
    const ComparedPair compared = joined_pair(all->files[one].series, all->files[other].series, std::move(a),
                                              std::move(b), all->time_unit(), all->task.options);
    Json list = Json::array();
    for (const PairDistance& d : pair_distances(compared, all->task.options, control.part(0.4, 1.0)))
      list.push_back(pair_distance_json(d));
    fs::create_directories(folder / kJobWorkFolder);
    save_json(folder / pair_file(name), list);
  };
  return item;
}

/// Every replicate at the last common time.
Section looks(const Replicates& all, const RunControl& control) {
  Section section{.name = "look", .title = "How they look at the last common time"};
  for (const bool is_a : {true, false}) {
    std::vector<ImageF> images;
    std::vector<std::string> labels;
    for (std::size_t k = 0; k < all.count(); ++k) {
      if (all.is_a(k) != is_a) continue;
      images.push_back(load_stack(all.files[k].series, {all.times.of[k].back()}, kReplicateSide, control).rgb_image(0));
      labels.push_back(all.task.names[k]);
    }
    section.pictures.push_back({is_a ? "a" : "b", is_a ? "A" : "B",
                                contact_strip(images, labels, {.columns = kPictureColumns, .label_px = 13})});
  }
  return section;
}

JobItem look_item(const std::shared_ptr<const Replicates>& all) {
  return {.name = "look",
          .outputs = part_files(kLookFile),
          .run = [all](const fs::path& folder, const RunControl& control) {
            Section section = looks(*all, control);
            embed_pictures(section.pictures, folder / kJobWorkFolder / "look.png");
            save_part(folder / kLookFile, section_json(section));
          }};
}

JobInputs replicates_inputs(const Replicates& all) {
  JobInputs inputs("compare_replicates", kReplicatesVersion);
  for (std::size_t k = 0; k < all.count(); ++k) {
    inputs.add_content(all.is_a(k) ? "a" : "b", all.task.names[k], all.keys[k]);
    inputs.add_value((all.is_a(k) ? "A: " : "B: ") + std::to_string(k), all.task.names[k]);
  }
  inputs.add_options(option_values(all.task.options));
  inputs.add_value("--seed", std::to_string(all.task.options.seed));
  return inputs;
}

}  // namespace

JobPlan plan_replicates(ReplicatesTask task, const fs::path& output) {
  check_ranges(task.options);
  const auto all = std::make_shared<const Replicates>(opened(std::move(task)));
  const auto stacks = std::make_shared<LoadedStacks>(all->count());
  JobPlan plan = replicates_inputs(*all).plan(output, kCompareReportFile);
  plan.parallel_items = false;
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < all->count(); ++i) {
    for (std::size_t j = i + 1; j < all->count(); ++j) {
      plan.items.push_back(pair_item(all, stacks, i, j));
      files.push_back(plan.items.back().outputs.front());
    }
  }
  plan.items.push_back(look_item(all));
  plan.join = [all, files, key = plan.key](const fs::path& folder, const RunControl&) {
    std::vector<std::vector<PairDistance>> pairs;
    for (const fs::path& file : files) {
      std::vector<PairDistance>& list = pairs.emplace_back();
      for (const Json& d : load_json(folder / file)) list.push_back(pair_distance_from_json(d));
    }
    const ReplicatesTask& t = all->task;
    write_replicates_report(folder,
                            {.files = all->files,
                             .names = t.names,
                             .clock = all->times.clock,
                             .warnings = time_warnings(facts_of(*all), t.options),
                             .options = t.options,
                             .command = t.command,
                             .key = key},
                            compare_replicates(pairs, t.a.size(), t.b.size(), t.options.seed),
                            section_from_json(load_part(folder / kLookFile)));
  };
  return plan;
}

}  // namespace patinate::analysis
