// The survey and the masks on real time-lapses. Needs $PATINATE_DATA.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <set>
#include <string_view>
#include <utility>

#include "capture/stability/frame_order.h"
#include "capture/stability/highlights.h"
#include "capture/stability/survey.h"
#include "libcommon/core/files.h"
#include "libcommon/core/random.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tests/support/test_data.h"

namespace patinate::capture {
namespace {

/// Goes through the frames of an animated file: linear color.
void for_each_frame(const std::filesystem::path& file, const std::function<void(int, const ImageF&)>& use) {
  const auto in = OIIO::ImageInput::open(file.string());
  ASSERT_TRUE(in != nullptr);
  for (int i = 0; in->seek_subimage(i, 0); ++i) {
    const OIIO::ImageSpec spec = in->spec();
    ImageF codes(spec.width, spec.height, spec.nchannels), color(spec.width, spec.height, 3);
    ASSERT_TRUE(in->read_image(i, 0, 0, spec.nchannels, OIIO::TypeFloat, codes.data()));
    for (std::int64_t p = 0; p < codes.num_pixels(); ++p) {
      for (int c = 0; c < 3; ++c) color.data()[3 * p + c] = linear_from_srgb(codes.data()[p * spec.nchannels + c]);
    }
    use(i, color);
  }
}

/// Horizontal and vertical differences of the codes.
ImageF gradients(const ImageF& color) {
  ImageF result(color.width(), color.height(), 2), code(color.width(), color.height());
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) code.at(x, y) = srgb_from_linear(luminance(color.pixel(x, y)));
  }
  for (int y = 1; y + 1 < color.height(); ++y) {
    for (int x = 1; x + 1 < color.width(); ++x) {
      result.at(x, y, 0) = code.at(x + 1, y) - code.at(x - 1, y);
      result.at(x, y, 1) = code.at(x, y + 1) - code.at(x, y - 1);
    }
  }
  return result;
}

/// The slow, independent answer: the best whole shift within 6 px by normalized correlation of gradients is not (0, 0).
bool is_moved_by_search(const ImageF& a, const ImageF& b) {
  constexpr int kRange = 6;
  double best = -2.0;
  bool is_moved = false;
  for (int dy = -kRange; dy <= kRange; ++dy) {
    for (int dx = -kRange; dx <= kRange; ++dx) {
      double product = 0.0, aa = 1e-20, bb = 1e-20;
      for (int y = kRange + 1; y < a.height() - kRange - 1; ++y) {
        for (int x = kRange + 1; x < a.width() - kRange - 1; ++x) {
          for (int c = 0; c < 2; ++c) {
            const double p = static_cast<double>(a.at(x, y, c)), q = static_cast<double>(b.at(x + dx, y + dy, c));
            product += p * q;
            aa += p * p;
            bb += q * q;
          }
        }
      }
      const double correlation = product / std::sqrt(aa * bb);
      if (correlation <= best) continue;
      best = correlation;
      is_moved = dx != 0 || dy != 0;
    }
  }
  return is_moved;
}

struct Surveyed {
  std::vector<FrameFinding> findings;
  std::set<int> shifted, named, reference;  ///< Frames, against the ones before.
};

Surveyed survey(const std::filesystem::path& file, bool with_reference) {
  Surveyed result;
  std::vector<FramePair> pairs;
  PreparedFrame before;
  ImageF gradients_before;
  int width = 0, height = 0;
  for_each_frame(file, [&](int i, const ImageF& color) {
    width = color.width();
    height = color.height();
    PreparedFrame now = prepare_frame(color);
    if (i > 0) pairs.push_back(compare_frames(i - 1, before, i, now, false));
    if (with_reference) {
      ImageF gradients_now = gradients(color);
      if (i > 0 && is_moved_by_search(gradients_before, gradients_now)) result.reference.insert(i);
      gradients_before = std::move(gradients_now);
    }
    before = std::move(now);
  });
  result.findings = judge_frames(pairs, width, height);
  for (const FrameFinding& f : result.findings) {
    if (f.is_shifted) result.shifted.insert(f.frame);
    if (f.is_shifted || f.is_jump || f.is_unmatched) result.named.insert(f.frame);
  }
  return result;
}

std::size_t num_common(const std::set<int>& a, const std::set<int>& b) {
  return static_cast<std::size_t>(std::count_if(a.begin(), a.end(), [&](int v) { return b.contains(v); }));
}

/// Prints and returns precision and recall of what is named moved or a jump.
std::pair<double, double> rate(const char* name, const Surveyed& s, const std::set<int>& truth) {
  const double hits = static_cast<double>(num_common(s.named, truth));
  const double precision = hits / static_cast<double>(s.named.size()),
               recall = hits / static_cast<double>(truth.size());
  std::printf("%s: %zu truly moved, %zu named (%zu as moved): precision %.3f, recall %.3f\n", name, truth.size(),
              s.named.size(), s.shifted.size(), precision, recall);
  return {precision, recall};
}

TEST(RealTimelapse, TheMelonsHandRepeatedPhotographsAreAllNamed) {
  PATINATE_REQUIRE_DATA(file, "timelapse/decaying_melon/decaying_melon.webp");
  const Surveyed s = survey(file, true);
  // The catalog counts 34 of 97 pairs by whole-pixel phase correlation; the search agrees.
  ASSERT_EQ(s.reference.size(), 34u);
  const auto [precision, recall] = rate("decaying_melon", s, s.reference);
  EXPECT_EQ(precision, 1.0);
  EXPECT_EQ(recall, 1.0);
  EXPECT_GE(s.shifted.size(), 33u);  // One pair shares too little of the picture for its motion to be measured: a jump.
}

TEST(RealTimelapse, TheSaltsThreeEventsAreNamedAndNothingElse) {
  PATINATE_REQUIRE_DATA(file, "timelapse/salt_crystallizing/salt_crystallizing.webp");
  const Surveyed s = survey(file, false);
  const auto [precision, recall] = rate("salt_crystallizing", s, {1, 75, 97});  // Frames as the catalog has them.
  EXPECT_EQ(precision, 1.0);
  EXPECT_EQ(recall, 1.0);
  EXPECT_EQ(s.shifted, (std::set<int>{75, 97}));
}

TEST(RealTimelapse, FixedCamerasRaiseNoShift) {
  for (const char* name : {"copper_patinating", "clay_solidifying"}) {
    PATINATE_REQUIRE_DATA(file, std::string("timelapse/") + name + "/" + name + ".webp");
    const Surveyed s = survey(file, false);
    for (const FrameFinding& f : s.findings) std::printf("%s frame %d: %s\n", name, f.frame, finding_text(f).c_str());
    EXPECT_TRUE(s.shifted.empty()) << name;
  }
  for (const char* name : {"copper_patinating", "clay_solidifying"}) {
    PATINATE_REQUIRE_DATA(folder, std::string("timelapse/") + name + "/frames_every4");
    std::vector<FramePair> pairs;
    PreparedFrame before;
    const auto files = list_files(folder, "*.png");
    for (std::size_t i = 0; i < files.size(); ++i) {
      PreparedFrame now = prepare_frame(read_color(files[i]));
      if (i > 0) pairs.push_back(compare_frames(static_cast<int>(i) - 1, before, static_cast<int>(i), now, false));
      before = std::move(now);
    }
    for (const FrameFinding& f : judge_frames(pairs, 256, 256)) EXPECT_FALSE(f.is_shifted) << name << " " << f.frame;
  }
}

// The melon was laid down anew for every photograph, which hides the order of a third of its shufflings.
TEST(RealTimelapse, AShuffledSeriesIsNamedAndOneInOrderIsNot) {
  for (const char* name : {"copper_patinating", "clay_solidifying", "salt_crystallizing", "decaying_melon"}) {
    PATINATE_REQUIRE_DATA(folder, std::string("timelapse/") + name + "/frames_every4");
    std::vector<FrameLook> looks;
    for (const auto& file : list_files(folder, "*.png")) looks.push_back(frame_look(prepare_frame(read_color(file))));
    ASSERT_GE(looks.size(), 20u);
    EXPECT_FALSE(find_order(looks).is_disordered()) << name;
    if (std::string_view(name) == "decaying_melon") continue;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      std::vector<FrameLook> shuffled = looks;
      RandomStream random(seed, 0);
      for (std::size_t i = shuffled.size() - 1; i > 0; --i)
        std::swap(shuffled[i], shuffled[random.below(static_cast<std::uint32_t>(i + 1))]);
      EXPECT_TRUE(find_order(shuffled).is_disordered()) << name << " " << seed;
    }
  }
}

double share(const ImageU8& mask) {
  const auto values = mask.values();
  return static_cast<double>(std::count(values.begin(), values.end(), 255)) / static_cast<double>(values.size());
}

TEST(RealTimelapse, TheStreakOnTheCopperIsMaskedFromTopToBottom) {
  PATINATE_REQUIRE_DATA(folder, "timelapse/copper_patinating/frames_every4");
  const auto files = list_files(folder, "*.png");
  const ImageU8 found = find_standing_highlight(
      static_cast<int>(files.size()), [&](int i) { return read_color(files[i]); }, 1.0f);
  std::printf("copper_patinating: standing highlight on %.1f %%\n", 100.0 * share(found));
  EXPECT_LT(share(found), 0.25);
  // The streak's core in the first photograph, by eye: brighter than code 235 in every channel.
  const ImageF first = read_color(files[0]);
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      const auto pixel = first.pixel(x, y);
      if (*std::min_element(pixel.begin(), pixel.end()) > linear_from_srgb(235.0f / 255.0f)) {
        ASSERT_EQ(found.at(x, y), 255) << x << " " << y;
      }
    }
  }
  for (int y = 0; y < 256; y += 15) {
    EXPECT_EQ(found.at(30, y), 0);
    EXPECT_EQ(found.at(220, y), 0);
  }
}

TEST(RealTimelapse, WhiteMaterialIsNoHighlight) {
  for (const char* name : {"banana_14_B", "clay_solidifying/frames_every4", "decaying_melon/frames_every4",
                           "salt_crystallizing/frames_every4"}) {
    PATINATE_REQUIRE_DATA(folder, std::string("timelapse/") + name);
    const auto files = list_files(folder, "*.png");
    const auto read_frame = [&](int i) { return read_color(files[i]); };
    const ImageU8 standing = find_standing_highlight(static_cast<int>(files.size()), read_frame, 1.0f);
    double saturated = 0.0;
    const int last = static_cast<int>(files.size()) - 1;
    for (int i : {0, last / 2, last})
      saturated = std::max(saturated, share(find_saturated(read_frame(i), linear_from_srgb(253.5f / 255.0f))));
    std::printf("%s: standing highlight %.2f %%, saturated up to %.2f %%\n", name, 100.0 * share(standing),
                100.0 * saturated);
    // The tray under the salt mirrors the flash; nothing else stands. Crystals, net and background are white.
    EXPECT_LT(share(standing), std::string(name).starts_with("salt") ? 0.09 : 1e-9) << name;
    EXPECT_LT(saturated, 0.01) << name;
  }
}

}  // namespace
}  // namespace patinate::capture
