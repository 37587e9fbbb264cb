#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/aruco.hpp>
#include <utility>

#include "capture/project/given_transforms.h"
#include "capture/timelapse/ingest.h"
#include "patinate/image/image_io.h"
#include "tests/capture/handheld/handheld_scene.h"
#include "tests/capture/stability/stability_scene.h"
#include "tests/capture/timelapse/ingest_folder.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate::capture {
namespace {

using namespace testing_support;

constexpr int kSize = 256;
constexpr int kCard = 40;     ///< Side of a gray card.
constexpr int kCardAt = 100;  ///< Its upper left corner, in x and y: every photograph shows the middle.

/// A surface on which bright grains grow, with a gray card that stays.
std::vector<ImageF> known_history(int num_frames) {
  std::vector<ImageF> frames;
  for (int i = 0; i < num_frames; ++i) {
    frames.push_back(render_scene({.size = kSize, .growth = static_cast<double>(i) / num_frames}));
    for (int y = kCardAt; y < kCardAt + kCard; ++y) {
      for (int x = kCardAt; x < kCardAt + kCard; ++x) {
        for (float& v : frames.back().pixel(x, y)) v = 0.35f;
      }
    }
  }
  return frames;
}

constexpr const char* kFromFirst = R"("align": "auto", "align_to": "000.png", )";

Json alignment_of(const std::filesystem::path& history) { return load_json(history / kAlignmentFile); }

Eigen::Matrix3d transform_of(const Json& photo) {
  Eigen::Matrix3d h;
  for (int k = 0; k < 9; ++k) h(k / 3, k % 3) = photo.at("transform").at(static_cast<std::size_t>(k)).get<double>();
  return h;
}

double worst_error_px(const Json& alignment, const std::vector<HandheldPhoto>& truth) {
  double worst = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Matrix3d expected = truth[0].photo_from_frame * truth[i].photo_from_frame.inverse();
    worst = std::max(worst, transform_error_px(transform_of(alignment.at("photos").at(i)), expected, truth[i].width,
                                               truth[i].height));
  }
  return worst;
}

// Half a pixel is what a person sees as blur where frames are averaged.
constexpr double kMaxError_px = 0.5;

TEST(HandheldIngest, TurnedScaledCroppedAndTintedPhotographsLieWithinHalfAPixel) {
  const TempFolder folder;
  const std::vector<HandheldPhoto> truth = write_handheld(
      known_history(8), {.largest_tint = 0.2, .largest_stops = 0.5, .seed = 3}, folder.path(), kFromFirst);
  (void)ingest(folder.path());
  const Json alignment = alignment_of(folder / "out");
  EXPECT_EQ(alignment.at("reference"), "000.png");
  EXPECT_LT(worst_error_px(alignment, truth), kMaxError_px);
  for (const Json& photo : alignment.at("photos")) EXPECT_EQ(photo.at("model"), "similarity");
  EXPECT_EQ(load_json(folder / "out/survey.json").at("alignment").at("photos").size(), truth.size());
}

TEST(HandheldIngest, TiltedPhotographsBecomeHomographies) {
  const TempFolder folder;
  const std::vector<HandheldPhoto> truth =
      write_handheld(known_history(5), {.least_scale = 0.9, .largest_tilt = 0.3, .seed = 4}, folder.path(), kFromFirst);
  (void)ingest(folder.path());
  const Json alignment = alignment_of(folder / "out");
  EXPECT_LT(worst_error_px(alignment, truth), kMaxError_px);
  int num_tilted = 0;
  for (const Json& photo : alignment.at("photos")) num_tilted += photo.at("model") == "homography";
  EXPECT_GE(num_tilted, 3);  // Some are drawn almost without tilt.
}

TEST(HandheldIngest, WhatAPhotographDoesNotShowIsMaskedInItsFrame) {
  const TempFolder folder;
  const std::vector<HandheldPhoto> truth =
      write_handheld(known_history(4), {.least_crop = 0.6, .seed = 5}, folder.path(), kFromFirst);
  const HistoryReader history = ingest(folder.path());
  for (std::size_t i = 1; i < truth.size(); ++i) {
    ASSERT_TRUE(history.manifest().frames[i].mask.has_value());
    const ImageU8 mask = read_mask(folder / "out" / *history.manifest().frames[i].mask);
    std::int64_t num_wrong = 0;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const Eigen::Vector2d p = (truth[i].photo_from_frame * Eigen::Vector3d(x, y, 1.0)).hnormalized();
        const double margin = std::min({p.x(), p.y(), truth[i].width - 1.0 - p.x(), truth[i].height - 1.0 - p.y()});
        // Within two pixels of the photograph's border either is right.
        if (margin > 2.0 && mask.at(x, y) == 0) ++num_wrong;
        if (margin < -2.0 && mask.at(x, y) != 0) ++num_wrong;
      }
    }
    EXPECT_EQ(num_wrong, 0) << i;
  }
}

TEST(HandheldIngest, AReferencePatchKeepsItsColorThroughTintAndExposure) {
  PATINATE_NIGHTLY_ONLY();
  const TempFolder folder;
  const std::vector<ImageF> frames = known_history(5);
  (void)write_handheld(frames, {.least_crop = 0.999, .largest_tint = 0.2, .largest_stops = 0.5, .seed = 6},
                       folder.path(), std::string(kFromFirst) + R"("reference_patch": [106, 106, 28, 28], )");
  const HistoryReader history = ingest(folder.path());
  for (int i = 0; i < 5; ++i) {
    const ImageF frame = history.read_frame(i);
    std::array<double, 3> sum{}, expected{};
    for (int y = 80; y < 180; ++y) {
      for (int x = 80; x < 180; ++x) {
        for (int c = 0; c < 3; ++c) {
          sum[c] += static_cast<double>(frame.at(x, y, c));
          expected[c] += static_cast<double>(frames[i].at(x, y, c));
        }
      }
    }
    // A code of 8 bits at middle gray is 0.9 % of the light.
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / expected[c], 1.0, 0.01) << i;
  }
  for (const Json& photo : load_json(folder / "out/survey.json").at("reference_patch"))
    EXPECT_LT(photo.at("residual").get<double>(), 0.01);
}

TEST(HandheldIngest, APhotographOfSomethingElseIsNamedWithTheExcludeToPaste) {
  const TempFolder folder;
  std::vector<ImageF> frames = known_history(5);
  frames[3] = ImageF(kSize, kSize, 3);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const float v = 0.3f + 0.2f * static_cast<float>(std::sin(0.31 * x + 0.002 * x * y) * std::cos(0.23 * y));
      for (float& value : frames[3].pixel(x, y)) value = v;
    }
  }
  (void)write_handheld(frames, {.seed = 7}, folder.path(), kFromFirst);
  const std::string said = error_of<CannotComplete>([&] { (void)ingest(folder.path()); });
  EXPECT_TRUE(has(said, "1 of 5 photographs cannot be aligned with the others (003.png)")) << said;
  EXPECT_TRUE(has(said, "\"exclude\": [3]")) << said;

  IngestOptions options;
  options.accept_failed = true;
  const HistoryReader history = ingest(folder.path(), options);
  EXPECT_EQ(history.num_frames(), 4);
  bool is_said = false;
  for (const HistoryWarning& w : history.facts().warnings)
    is_said = is_said || has(w.text, "003.png cannot be aligned with");
  EXPECT_TRUE(is_said);
}

TEST(HandheldIngest, AGivenTransformIsUsedAsItStands) {
  const TempFolder folder;
  const std::vector<ImageF> frames = known_history(2);
  (void)write_handheld(frames,
                       {.largest_turn_deg = 0, .least_scale = 1, .largest_scale = 1, .least_crop = 1, .noise = 0},
                       folder.path(), "");
  std::ofstream(folder / "capture.json")
      << R"({"format": "patinate.capture", "version": 1, "name": "hand", "kind": "fixed", "frames": [
            {"time": 0, "photo": "photos/000.png"},
            {"time": 1, "photo": "photos/001.png", "transform": [0, -1, 255, 1, 0, 0, 0, 0, 1]}]})";
  const HistoryReader history = ingest(folder.path());
  const ImageF frame = history.read_frame(1), photo = read_color(folder / "photos/001.png", Response{});
  // A quarter turn moves whole pixels: values are copied, but for the history's 16-bit floats (11 bits).
  for (int y = 0; y < kSize; y += 5) {
    for (int x = 0; x < kSize; x += 5)
      EXPECT_NEAR(frame.at(255 - y, x, 1), photo.at(x, y, 1), photo.at(x, y, 1) / 1024.0f);
  }
}

TEST(HandheldIngest, LandmarksAloneLayPhotographsWithoutDetail) {
  const TempFolder folder;
  std::vector<ImageF> frames(3, ImageF(kSize, kSize, 3));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (float& v : frames[i].values()) v = 0.2f + 0.1f * static_cast<float>(i);
  }
  const std::vector<HandheldPhoto> truth =
      write_handheld(frames, {.seed = 8}, folder.path(),
                     R"("align": "landmarks", "align_to": "000.png", "landmarks": "points.csv", )");
  std::ofstream csv(folder / "points.csv");
  csv << "photo,point,x,y\n";
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (const auto& [name, x, y] : {std::tuple("rim", 30.0, 40.0), std::tuple("\"stain, left\"", 200.0, 60.0),
                                     std::tuple("foot", 120.0, 220.0)}) {
      const Eigen::Vector2d p = (truth[i].photo_from_frame * Eigen::Vector3d(x, y, 1.0)).hnormalized();
      csv << "00" << i << ".png," << name << "," << p.x() << "," << p.y() << "\n";
    }
  }
  csv.close();
  (void)ingest(folder.path());
  EXPECT_LT(worst_error_px(alignment_of(folder / "out"), truth), 0.01);  // Six digits of exact marks.
}

TEST(HandheldIngest, AnAlignmentThatWasFoundIsTakenOverByName) {
  PATINATE_NIGHTLY_ONLY();
  const TempFolder folder;
  (void)write_handheld(known_history(3), {.seed = 9}, folder.path(), kFromFirst);
  (void)ingest(folder.path());
  std::filesystem::copy_file(folder / "out" / kAlignmentFile, folder / kAlignmentFile);
  const ImageF before = HistoryReader(folder / "out").read_frame(2);
  std::filesystem::remove_all(folder / "out");
  std::ofstream(folder / "capture.json")
      << R"({"format": "patinate.capture", "version": 1, "name": "hand", "kind": "fixed", "time_unit": "d",
            "transforms": "alignment.json", "frames": {"pattern": "photos/*.png", "interval": 1}})";
  const ImageF after = ingest(folder.path()).read_frame(2);
  ASSERT_EQ(before.num_pixels(), after.num_pixels());
  EXPECT_TRUE(std::equal(before.values().begin(), before.values().end(), after.values().begin()));
}

TEST(HandheldIngest, PhotographsOfSeveralSizesAreRefusedWithoutAlignAndTheMessageSaysSo) {
  const TempFolder folder;
  (void)write_handheld(known_history(2), {.seed = 10}, folder.path(), "");
  EXPECT_TRUE(has(ingest_error(folder.path()), "--align auto")) << ingest_error(folder.path());
}

/// Surroundings that HandheldScene has beside a frame.
constexpr float kTable = 0.2f;

/// An object whose surface is another one in each frame, before a table. @param radius  Of its outline, by angle.
std::vector<ImageF> changing_object(int num_frames, const std::function<double(double)>& radius) {
  std::vector<ImageF> frames;
  for (int i = 0; i < num_frames; ++i) {
    ImageF frame(kSize, kSize, 3);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const double dx = x - 127.0, dy = y - 131.0;
        const double inside = std::clamp(radius(std::atan2(dy, dx)) - std::hypot(dx, dy) + 0.5, 0.0, 1.0);
        for (int c = 0; c < 3; ++c) {
          const double own = 0.5 + 0.2 * std::sin(0.07 * (i + 1) * x + c) * std::cos(0.05 * (i + 2) * y + 2.0 * i) +
                             0.05 * i * (c == 0 ? 1.0 : -1.0);
          frame.at(x, y, c) = static_cast<float>(inside * own + (1.0 - inside) * static_cast<double>(kTable));
        }
      }
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

double leaf(double angle) {
  return 60.0 + 14.0 * std::cos(angle) + 9.0 * std::cos(2.0 * angle + 1.0) + 7.0 * std::sin(3.0 * angle);
}

TEST(HandheldIngest, TheOutlineOfAnObjectLaysWhatHasNoDetailThatStays) {
  const TempFolder folder;
  const std::vector<HandheldPhoto> truth =
      write_handheld(changing_object(6, leaf), {.least_crop = 0.999, .seed = 11}, folder.path(),
                     R"("align": "outline", "align_to": "000.png", )");
  (void)ingest(folder.path());
  const Json alignment = alignment_of(folder / "out");
  EXPECT_LT(worst_error_px(alignment, truth), kMaxError_px);
  for (const Json& photo : alignment.at("photos")) EXPECT_EQ(photo.at("model"), "similarity");
}

TEST(HandheldIngest, AnOutlineThatIsTheSameAtAnotherTurnIsRefused) {
  PATINATE_NIGHTLY_ONLY();
  const TempFolder folder;
  const auto square = [](double angle) {
    return 50.0 / std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
  };
  const auto rectangle = [](double angle) {
    return std::min(70.0 / std::max(1e-9, std::abs(std::cos(angle))), 45.0 / std::max(1e-9, std::abs(std::sin(angle))));
  };
  const auto ellipse = [](double angle) {
    return 70.0 * 45.0 / std::hypot(45.0 * std::cos(angle), 70.0 * std::sin(angle));
  };
  const std::vector<std::pair<std::string, std::function<double(double)>>> shapes{
      {"disk", [](double) { return 60.0; }},
      {"square", square},
      {"rectangle", rectangle},
      {"ellipse", ellipse},
      {"star_3", [](double angle) { return 60.0 + 14.0 * std::cos(3.0 * angle); }},
      {"star_5", [](double angle) { return 60.0 + 12.0 * std::cos(5.0 * angle); }}};
  for (const auto& [name, radius] : shapes) {
    (void)write_handheld(changing_object(3, radius), {.least_crop = 0.999, .seed = 12}, folder / name,
                         R"("align": "outline", )");
    const std::string why = error_of<CannotComplete>([&] { (void)ingest(folder / name); });
    EXPECT_NE(why.find("none of the 3 photographs"), std::string::npos) << name << ": " << why;
    EXPECT_NE(why.find("a shape that is not round or regular"), std::string::npos) << name << ": " << why;
  }
}

// A plate of steel that rusts: nothing on it stays, and its outline is the same at half a turn.
TEST(HandheldIngest, AHoleTellsTheTurnsOfAPlateApart) {
  const auto plate = [](double angle) {
    return std::min(70.0 / std::max(1e-9, std::abs(std::cos(angle))), 45.0 / std::max(1e-9, std::abs(std::sin(angle))));
  };
  std::vector<ImageF> frames = changing_object(4, plate);
  constexpr double kHoleX = 127.0 - 45.0, kHoleY = 131.0 - 22.0, kRadius = 10.0;
  for (ImageF& frame : frames) {
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const auto share = static_cast<float>(std::clamp(kRadius - std::hypot(x - kHoleX, y - kHoleY) + 0.5, 0.0, 1.0));
        for (float& v : frame.pixel(x, y)) v += share * (kTable - v);
      }
    }
  }
  for (const std::string method : {"outline", "auto"}) {
    const TempFolder folder;
    const std::vector<HandheldPhoto> truth = write_handheld(frames, {.least_crop = 0.999, .seed = 11}, folder.path(),
                                                            R"("align": ")" + method + R"(", "align_to": "000.png", )");
    (void)ingest(folder.path());
    // Half a pixel along the plate's border, 45 px from its middle, is as much more in the photograph's corner.
    const double most_px = 0.5 * std::hypot(kSize / 2.0, kSize / 2.0) / 45.0;
    EXPECT_LT(worst_error_px(alignment_of(folder / "out"), truth), most_px) << method;
  }
}

/// Prints markers on what changes. @param places  Upper left corners.
std::vector<ImageF> with_markers(std::vector<ImageF> frames, const std::vector<std::pair<int, int>>& places) {
  for (ImageF& frame : frames) {
    int id = 3;
    for (const auto& [x0, y0] : places) {
      cv::Mat marker;
      cv::aruco::drawMarker(cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50), id++, 30, marker);
      for (int y = -4; y < 34; ++y) {
        for (int x = -4; x < 34; ++x) {
          const bool is_paper = x < 0 || y < 0 || x >= 30 || y >= 30 || marker.at<std::uint8_t>(y, x) != 0;
          for (float& v : frame.pixel(x0 + x, y0 + y)) v = is_paper ? 0.8f : 0.03f;
        }
      }
    }
  }
  return frames;
}

TEST(HandheldIngest, PrintedMarkersLayPhotographsAlsoTiltedOnes) {
  const TempFolder folder;
  const auto everywhere = [](double) { return 1000.0; };
  const std::vector<HandheldPhoto> truth =
      write_handheld(with_markers(changing_object(6, everywhere), {{54, 60}, {168, 66}, {110, 170}}),
                     {.least_scale = 0.9, .least_crop = 0.999, .largest_tilt = 0.3, .largest_tint = 0.1, .seed = 13},
                     folder.path(), R"("align": "markers", "align_to": "000.png", )");
  (void)ingest(folder.path());
  EXPECT_LT(worst_error_px(alignment_of(folder / "out"), truth), kMaxError_px);
}

TEST(HandheldIngest, ASmallMarkerDoesNotCarryATiltedPhotographOver) {
  const TempFolder folder;
  const auto everywhere = [](double) { return 1000.0; };
  (void)write_handheld(with_markers(changing_object(3, everywhere), {{110, 110}}),
                       {.least_scale = 0.9, .least_crop = 0.999, .largest_tilt = 0.5, .seed = 15}, folder.path(),
                       R"("align": "markers", "align_model": "homography", )");
  const std::string why = error_of<CannotComplete>([&] { (void)ingest(folder.path()); });
  EXPECT_NE(why.find("sharp markers far apart"), std::string::npos) << why;
}

TEST(HandheldIngest, PhotographsWithoutMarkersAreRefusedInOneLine) {
  const TempFolder folder;
  (void)write_handheld(known_history(3), {.seed = 14}, folder.path(), R"("align": "markers", )");
  const std::string why = error_of<CannotComplete>([&] { (void)ingest(folder.path()); });
  EXPECT_NE(why.find("no photograph shows an ArUco or AprilTag marker"), std::string::npos) << why;
}

}  // namespace
}  // namespace patinate::capture
