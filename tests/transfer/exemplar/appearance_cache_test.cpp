// A kept analysis never shows: every result is the one of an analysis that is regenerated.
#include "transfer/exemplar/appearance_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <limits>
#include <memory>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/exemplar/appearance_io.h"
#include "transfer/library/library_job.h"

namespace patinate::transfer {
namespace {

namespace fs = std::filesystem;
using testing_support::error_of;
using testing_support::has;
using testing_support::TempFolder;

constexpr int kWidth = 30, kHeight = 22, kFrames = 4, kLevels = 3;

bool same(const AppearanceSpace& a, const AppearanceSpace& b) {
  return a.levels == b.levels && a.masks == b.masks && a.variances == b.variances &&
         a.explained_variance == b.explained_variance;
}

/// A history, and where its appearance under its own mask and the default options is kept.
class AppearanceCache : public testing::Test {
 protected:
  void SetUp() override {
    testing_support::write_history(folder_.path(), kWidth, kHeight, kFrames, testing_support::blotches);
    history_ = std::make_shared<const HistoryReader>(folder_.path());
    mask_ = history_->read_mask();
    key_ = appearance_key(*history_, {}, mask_);
    file_ = appearance_file(*history_, key_);
    fresh_ = build_appearance_space(*history_, kLevels);
  }
  [[nodiscard]] AppearanceSpace cached(int num_levels = kLevels, const AppearanceOptions& options = {},
                                       const ImageU8& mask = {}) const {
    return cached_appearance_space(*history_, num_levels, options, {}, mask);
  }
  [[nodiscard]] std::vector<fs::path> kept() const {
    return fs::exists(folder_ / kCacheFolder) ? list_files(folder_ / kCacheFolder, "*.bin") : std::vector<fs::path>();
  }
  /// Puts an appearance that no analysis gives where it is kept, so that a test sees whether it is taken.
  void plant(int num_asked = kLevels) {
    planted_ = fresh_;
    planted_.explained_variance = 0.125;
    fs::create_directories(file_.parent_path());
    write_appearance(file_, {key_, num_asked, planted_});
  }

  TempFolder folder_;
  std::shared_ptr<const HistoryReader> history_;
  ImageU8 mask_;
  std::string key_;
  fs::path file_;
  AppearanceSpace fresh_, planted_;
};

TEST_F(AppearanceCache, GivesWhatBuildingGives) {
  EXPECT_TRUE(same(cached(), fresh_));
  ASSERT_EQ(kept(), std::vector{file_});
  EXPECT_EQ(fs::file_size(file_), appearance_file_size(kWidth, kHeight, kLevels));
  EXPECT_TRUE(same(cached(), fresh_));
  EXPECT_TRUE(same(read_appearance(file_, key_, kLevels, mask_), fresh_));
  EXPECT_TRUE(fs::exists(folder_ / kCacheFolder / "CACHEDIR.TAG"));
}

TEST_F(AppearanceCache, TakesWhatIsKept) {
  plant();
  EXPECT_TRUE(same(cached(), planted_));
}

TEST_F(AppearanceCache, ProgressEndsAtOneWhereverItComesFrom) {
  for (int run = 0; run < 2; ++run) {
    std::vector<double> seen;
    RunControl control;
    control.on_progress = [&](double f) { seen.push_back(f); };
    (void)cached_appearance_space(*history_, kLevels, {}, control);
    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
    EXPECT_EQ(seen.back(), 1.0);
  }
}

TEST_F(AppearanceCache, DamageAnywhereIsNoticed) {
  plant();
  const std::string whole = read_file(file_);
  ASSERT_EQ(error_of([&] { (void)read_appearance(file_, key_, kLevels, mask_); }), "");
  std::vector<std::string> damaged{"", whole + "x", std::string(whole.size(), '\0')};
  for (std::size_t size = 0; size < whole.size(); size += size < 100 ? 1 : 997)
    damaged.push_back(whole.substr(0, size));
  for (std::size_t at = 0; at < whole.size(); at += at < 100 || at + 40 > whole.size() ? 1 : 313) {
    damaged.push_back(whole);
    damaged.back()[at] = static_cast<char>(damaged.back()[at] ^ (1 << (at % 8)));
  }
  for (std::size_t i = 0; i < damaged.size(); ++i) {
    std::ofstream(file_, std::ios::binary) << damaged[i];
    EXPECT_NE(error_of<IoError>([&] { (void)read_appearance(file_, key_, 1, mask_); }), "") << i;
    if (i % 20 != 0) continue;
    EXPECT_TRUE(same(cached(), fresh_)) << i;
    EXPECT_EQ(error_of([&] { (void)read_appearance(file_, key_, kLevels, mask_); }), "") << "not repaired: " << i;
  }
}

TEST_F(AppearanceCache, ValuesThatCannotBeAreRefusedThoughTheChecksumFits) {
  const auto refused = [&](const AppearanceSpace& space) {
    fs::create_directories(file_.parent_path());
    write_appearance(file_, {key_, kLevels, space});
    EXPECT_NE(error_of<IoError>([&] { (void)read_appearance(file_, key_, kLevels, mask_); }), "");
    EXPECT_TRUE(same(cached(), fresh_));
  };
  AppearanceSpace space = fresh_;
  space.levels[1].at(3, 2, 7) = kAppearanceLimit + 1;
  refused(space);
  space = fresh_;
  space.variances[2] = std::numeric_limits<double>::quiet_NaN();
  refused(space);
  space = fresh_;
  space.explained_variance = 1.5;
  refused(space);
}

TEST_F(AppearanceCache, WhatBelongsToSomethingElseIsRefused) {
  plant();
  const ImageU8 turned(kHeight, kWidth, 1, 255);
  EXPECT_TRUE(has(error_of<IoError>([&] { (void)read_appearance(file_, std::string(32, '0'), kLevels, mask_); }),
                  "something else"));
  EXPECT_NE(error_of<IoError>([&] { (void)read_appearance(file_, key_, kLevels, turned); }), "");
  EXPECT_TRUE(has(error_of<IoError>([&] { (void)read_appearance(file_, key_, kLevels + 1, mask_); }), "fewer levels"));
}

TEST_F(AppearanceCache, AChangedFrameIsAnalyzedAnewThoughTheHistoryKeepsItsKey) {
  (void)cached();
  ImageF frame = history_->read_frame(2);
  frame.at(5, 5, 1) *= 0.5f;
  write_exr(folder_ / history_->manifest().frames[2].file, frame, {"R", "G", "B"}, ExrDepth::Half);
  const HistoryReader changed(folder_.path());
  EXPECT_NE(appearance_key(changed, {}, mask_), key_);
  const AppearanceSpace anew = build_appearance_space(changed, kLevels);
  EXPECT_FALSE(same(anew, fresh_));
  EXPECT_TRUE(same(cached_appearance_space(changed, kLevels), anew));
}

TEST_F(AppearanceCache, OtherMasksAndOptionsAreAnalyzedForThemselves) {
  plant();
  ImageU8 mask = mask_;
  mask.at(0, 0) = 0;
  EXPECT_TRUE(same(cached(kLevels, {}, mask), build_appearance_space(*history_, kLevels, {}, {}, mask)));
  for (const AppearanceOptions& options :
       {AppearanceOptions{.spatial_radius_px = 0}, {.max_frames = 3}, {.num_samples = 100}}) {
    EXPECT_TRUE(same(cached(kLevels, options), build_appearance_space(*history_, kLevels, options)));
  }
  // The history's own mask, given, is no other mask.
  plant();
  EXPECT_TRUE(same(cached(kLevels, {}, mask_), planted_));
}

TEST_F(AppearanceCache, FramesThatAreNotComparedDoNotCount) {
  const AppearanceOptions options{.max_frames = 2};
  const std::string before = appearance_key(*history_, options, mask_);
  ImageF frame = history_->read_frame(1);
  frame.at(5, 5, 1) *= 0.5f;
  write_exr(folder_ / history_->manifest().frames[1].file, frame, {"R", "G", "B"}, ExrDepth::Half);
  EXPECT_EQ(appearance_key(*history_, options, mask_), before);
}

TEST_F(AppearanceCache, FewerLevelsAreTakenFromMoreAndMoreAreMadeAnew) {
  plant();
  const AppearanceSpace two = cached(2);
  ASSERT_EQ(two.levels.size(), 2u);
  EXPECT_EQ(two.masks.size(), 2u);
  EXPECT_EQ(two.variances.size(), 2u);
  EXPECT_EQ(two.explained_variance, planted_.explained_variance);
  EXPECT_TRUE(same(cached(kLevels + 1), build_appearance_space(*history_, kLevels + 1)));
  EXPECT_TRUE(same(cached(kLevels), fresh_)) << "the deeper ones stand where the planted ones were";
  EXPECT_EQ(kept().size(), 1u);
}

TEST_F(AppearanceCache, LevelsThatCannotBeAreNotAskedForTwice) {
  ImageU8 strip(kWidth, kHeight);  // Two rows: nothing is inside two halvings later.
  for (int x = 0; x < kWidth; ++x) strip.at(x, 4) = strip.at(x, 5) = 255;
  const AppearanceSpace fresh = build_appearance_space(*history_, kLevels, {}, {}, strip);
  ASSERT_LT(fresh.levels.size(), static_cast<std::size_t>(kLevels));
  EXPECT_TRUE(same(cached(kLevels, {}, strip), fresh));
  EXPECT_TRUE(same(read_appearance(appearance_file(*history_, appearance_key(*history_, {}, strip)),
                                   appearance_key(*history_, {}, strip), kLevels, strip),
                   fresh));
}

TEST_F(AppearanceCache, KeepsThoseThatWereUsedLast) {
  std::vector<fs::path> files;
  const auto age = [](const fs::path& file, int hours) {
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(hours));
  };
  for (int i = 0; i < kMaxKeptAppearances; ++i) {
    const AppearanceOptions options{.num_samples = 100 + i};
    (void)cached(1, options);
    files.push_back(appearance_file(*history_, appearance_key(*history_, options, mask_)));
    age(files.back(), 10 - i);
  }
  EXPECT_EQ(kept().size(), static_cast<std::size_t>(kMaxKeptAppearances));
  (void)cached(1, {.num_samples = 100});  // The oldest is used again.
  const fs::path half =
      folder_ / kCacheFolder /
      ".appearance-killed.tmp999999999.bin";  // Whose machine is not known: not judged before a week is over.
  std::ofstream(half) << "half";
  age(half, 8 * 24);
  std::ofstream(folder_ / kCacheFolder / "notes.bin") << "of somebody else";
  (void)cached(1);
  EXPECT_EQ(kept().size(), kMaxKeptAppearances + 1u);
  EXPECT_TRUE(fs::exists(file_) && fs::exists(files[0]) && !fs::exists(files[1]) && fs::exists(files[2]) &&
              fs::exists(folder_ / kCacheFolder / "notes.bin"));
  EXPECT_FALSE(fs::exists(half));
}

TEST_F(AppearanceCache, WhereNothingCanBeKeptNothingIsSaid) {
  std::ofstream(folder_ / kCacheFolder) << "a file";
  EXPECT_TRUE(same(cached(), fresh_));
  fs::remove(folder_ / kCacheFolder);
  fs::create_directories(file_);  // A folder where the file should be.
  EXPECT_TRUE(same(cached(), fresh_));
  fs::remove(file_);
  ASSERT_EQ(::mkfifo(file_.c_str(), 0600), 0);  // To open it would wait for ever.
  EXPECT_TRUE(same(cached(), fresh_));
  fs::remove_all(folder_ / kCacheFolder);
  fs::create_directory_symlink(folder_ / "nowhere", folder_ / kCacheFolder);
  EXPECT_TRUE(same(cached(), fresh_));
  EXPECT_FALSE(fs::exists(folder_ / "nowhere"));
}

TEST_F(AppearanceCache, AReadOnlyFolderIsReadFrom) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::permissions(folder_.path(), fs::perms::owner_write, fs::perm_options::remove);
  EXPECT_TRUE(same(cached(), fresh_));
  EXPECT_TRUE(kept().empty());
  fs::permissions(folder_.path(), fs::perms::owner_write, fs::perm_options::add);
  plant();
  fs::permissions(folder_ / kCacheFolder, fs::perms::owner_write, fs::perm_options::remove);
  EXPECT_TRUE(same(cached(), planted_));
  EXPECT_TRUE(same(cached(kLevels + 1), build_appearance_space(*history_, kLevels + 1)));
  fs::permissions(folder_ / kCacheFolder, fs::perms::owner_write, fs::perm_options::add);
}

TEST_F(AppearanceCache, AStopLeavesNothing) {
  std::stop_source source;
  RunControl control;
  control.stop = source.get_token();
  control.on_progress = [&](double done) {
    if (done >= 0.949) source.request_stop();  // Analyzed, not yet kept.
  };
  EXPECT_THROW((void)cached_appearance_space(*history_, kLevels, {}, control), Canceled);
  EXPECT_TRUE(kept().empty());
  fs::create_directories(file_.parent_path());
  EXPECT_THROW(write_appearance(file_, {key_, kLevels, fresh_}, control), Canceled);
  EXPECT_TRUE(fs::is_empty(file_.parent_path()));
  plant();
  EXPECT_THROW((void)cached_appearance_space(*history_, kLevels, {}, control), Canceled);
  EXPECT_TRUE(same(cached(), planted_));
}

TEST_F(AppearanceCache, SeveralAtOnceGiveTheSame) {
  for (int round = 0; round < 5; ++round) {
    fs::remove_all(folder_ / kCacheFolder);
    std::vector<AppearanceSpace> found(4);
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < found.size(); ++i)
      threads.emplace_back([&, i] { found[i] = cached(i % 2 == 0 ? kLevels : 1); });
    for (std::thread& thread : threads) thread.join();
    EXPECT_TRUE(same(found[0], fresh_) && same(found[2], fresh_)) << round;
    EXPECT_TRUE(found[1].levels[0] == fresh_.levels[0] && found[3].levels[0] == fresh_.levels[0]) << round;
    EXPECT_TRUE(same(cached(), fresh_)) << round;
  }
}

TEST_F(AppearanceCache, ABrokenFrameIsNamedAsWithoutIt) {
  const fs::path frame = folder_ / history_->manifest().frames[1].file;
  const std::string whole = read_file(frame);
  std::ofstream(frame, std::ios::binary) << whole.substr(0, whole.size() / 2);
  const auto with = error_of<IoError>([&] { (void)cached(); }),
             without = error_of<IoError>([&] { (void)build_appearance_space(*history_, kLevels); });
  EXPECT_FALSE(with.empty());
  EXPECT_EQ(with, without);
  fs::remove(frame);
  EXPECT_EQ(error_of<IoError>([&] { (void)cached(); }),
            error_of<IoError>([&] { (void)build_appearance_space(*history_, kLevels); }));
  EXPECT_TRUE(kept().empty());
}

// Transfers: the same coordinates and figures, kept or not, however large texels are and whatever is searched.
TEST_F(AppearanceCache, ATransferIsTheSameWithAndWithoutIt) {
  constexpr int kSide = 40;
  const auto map = std::make_shared<TexelMap>(testing_support::unit_plane(kSide), kSide, kSide);
  TransferControl guide{"x", "x", ImageF(kSide, kSide), {}, 1.0, ControlMapping::Rank};
  for (TexelId t = 0; t < map->num_texels(); ++t)
    guide.values.data()[t] = static_cast<float>(t % kSide + t / kSide) / (2.0f * kSide);
  for (TransferMethod method : {TransferMethod::Fast, TransferMethod::Reference}) {
    for (double pixel_per_texel : {1.0, 0.5}) {
      const TransferOptions options{.method = method, .neighborhood_radius_px = 2, .reference = {.num_passes = 1}};
      const double pixel_mm = pixel_per_texel * map->median_texel_size_mm();
      const auto run = [&](const AppearanceSource& source) {
        return transfer(
            {.history = history_, .map = map, .texel_size_mm = pixel_mm, .controls = {guide}, .appearance = source},
            options);
      };
      const TransferResult without = run({});
      for (int time = 0; time < 2; ++time) {
        const TransferResult with = run(appearance_source(*history_, {.cache = true}));
        EXPECT_EQ(with.coordinates, without.coordinates);
        EXPECT_EQ(with.energy.energy, without.energy.energy);
        EXPECT_EQ(with.explained_variance, without.explained_variance);
      }
    }
  }
}

TEST_F(AppearanceCache, ALibraryHasOneOfItsOwn) {
  testing_support::write_history(folder_ / "other", 24, 24, 3, testing_support::blotches);
  (void)run_job(plan_library(open_library({{folder_.path(), folder_ / "other"}}), folder_ / "library"), {}, {});
  const HistoryReader library(folder_ / "library");
  const AppearanceSpace fresh = build_appearance_space(library, kLevels);
  for (int run = 0; run < 2; ++run) EXPECT_TRUE(same(cached_appearance_space(library, kLevels), fresh));
  EXPECT_TRUE(kept().empty());
  EXPECT_EQ(list_files(folder_ / "library" / kCacheFolder, "*.bin").size(), 1u);
}

// A stored result, as nothing else can tell that an analysis has changed while its version has not: integers do
// not depend on threads or instruction set. Where this fails, raise kAppearanceVersion, so that what earlier programs
// kept is regenerated, and write the new digits here.
TEST_F(AppearanceCache, AChangedAnalysisNeedsANewVersion) {
  ContentHash hash;
  for (std::size_t l = 0; l < fresh_.levels.size(); ++l)
    hash.add(std::as_bytes(fresh_.levels[l].values())).add(std::as_bytes(fresh_.masks[l].values()));
  EXPECT_EQ(std::pair(kAppearanceVersion, hash.hex()), std::pair(3, std::string("22b87df3b0d5e1f7799596d1026e1f97")));
}

}  // namespace
}  // namespace patinate::transfer
