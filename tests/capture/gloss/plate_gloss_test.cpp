// Gloss of a plate under one lamp, standing and moving, through the whole of ingest; its truth is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/timelapse/ingest.h"
#include "datasets_synthetic/plate_io.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "tests/capture/gloss/plate_scene.h"
#include "tests/support/temp_folder.h"

namespace patinate::testing_support {
namespace {

constexpr double kForm = 0.05;  // Share of a highlight by which fits allow its form to be off.
constexpr double kSigmas = 4.0;

/// Material with the largest share, at a photograph.
const Json& largest_at(const PlateRun& run, std::size_t frame) {
  return run.gloss.at("materials").at(0).at("at").at(frame);
}

/// Roughness, F0 and albedo of every photograph against truth, in stated deviations.
void expect_truth(const PlateRun& run, const datasets::PlateOptions& o) {
  ASSERT_TRUE(run.gloss.at("materials").at(0).at("is_told").get<bool>());
  for (std::size_t i = 0; i < run.errors.size(); ++i) {
    const PlateErrors& e = run.errors[i];
    const Json& at = largest_at(run, i);
    const double f0_deviation = at.at("f0_deviation").get<double>() / at.at("f0").get<double>();
    // A form that is off by a share of the highlight is off by no more of the roughness, on which its height goes with
    // the fourth power and its width with the second.
    EXPECT_LT(std::abs(e.roughness),
              kSigmas * at.at("roughness_deviation").get<double>() + kForm / 2.0 * at.at("roughness").get<double>())
        << i;
    EXPECT_LT(std::abs(e.f0), kSigmas * f0_deviation + kForm) << i;
    // Part of the highlight that may be left; beside it the grain of the color, which classes do not know, and 8 bits.
    constexpr double kGrain = 0.02;
    EXPECT_LT(e.albedo_near, (kForm + kSigmas * f0_deviation) * e.lambert_near + kGrain) << i;
    EXPECT_LT(e.albedo, e.lambert) << i;
  }
  // Well-known values must be said to be so: at the start all of the plate is polish.
  EXPECT_LT(largest_at(run, 0).at("roughness_deviation").get<double>(), 0.1 * o.roughness);
  EXPECT_LT(largest_at(run, 0).at("f0_deviation").get<double>(), 0.1 * o.specular);
}

TEST(PlateGloss, UnderALampThatStandsRoughnessF0AndAlbedoAreWithinTheirDeviations) {
  const TempFolder temp;
  const datasets::PlateOptions o{.size = 160, .num_frames = 12};
  const PlateRun run = ingested_plate(o, temp.path());
  print_errors("standing", run);
  expect_truth(run, o);
}

TEST(PlateGloss, UnderALampThatMovesTheyAreKnownBetter) {
  const TempFolder temp, other;
  datasets::PlateOptions o{.size = 160, .num_frames = 12, .moving = true};
  const PlateRun moving = ingested_plate(o, temp.path());
  print_errors("moving", moving);
  expect_truth(moving, o);
  o.moving = false;
  const PlateRun standing = ingested_plate(o, other.path());
  for (const std::size_t i : {std::size_t{0}, std::size_t{4}}) {
    for (const char* what : {"roughness_deviation", "f0_deviation"})
      EXPECT_LT(largest_at(moving, i).at(what).get<double>(), largest_at(standing, i).at(what).get<double>()) << what;
  }
}

TEST(PlateGloss, PolishedMetalIsFoundWithItsColor) {
  const TempFolder temp;
  const datasets::PlateOptions o{.size = 160, .num_frames = 12, .metal = true};
  const PlateRun run = ingested_plate(o, temp.path());
  print_errors("metal", run);
  const HistoryReader history(temp / "history");
  const ImageF metalness = *history.read_frame_extra(0, "metalness");
  const ImageU8 mask = history.read_mask();
  double metal = 0.0, count = 0.0;
  for (std::int64_t i = 0; i < metalness.num_pixels(); ++i) {
    if (!mask.empty() && mask.data()[i] == 0) continue;
    count += 1.0;
    metal += static_cast<double>(metalness.data()[i]);
  }
  EXPECT_GT(metal / count, 0.5);  // All of it is bare at the start: most must be called so.
  const Json& materials = run.gloss.at("materials");
  const Json& surest = *std::max_element(materials.begin(), materials.end(), [](const Json& a, const Json& b) {
    return a.at("saved").get<double>() < b.at("saved").get<double>();
  });
  EXPECT_TRUE(surest.at("is_metallic").get<bool>());
  const auto tint = surest.at("tint").get<std::vector<double>>();
  EXPECT_NEAR(tint[1] / tint[0], 0.60 / 0.93, kForm);
  EXPECT_NEAR(tint[2] / tint[0], 0.47 / 0.93, kForm);
  const Json& at = surest.at("at").at(0);
  EXPECT_NEAR(at.at("f0").get<double>(), 2.0 / 3.0, kForm * 2.0 / 3.0 + kSigmas * at.at("f0_deviation").get<double>());
  EXPECT_NEAR(at.at("roughness").get<double>(), o.roughness,
              kForm / 2.0 * o.roughness + kSigmas * at.at("roughness_deviation").get<double>());
}

/// The warning of a history that has a word; "" = none.
std::string warning_of(const PlateRun& run, const std::string& word = "gloss") {
  if (!run.history.contains("warnings")) return "";
  for (const Json& warning : run.history.at("warnings"))
    if (warning.at("text").get<std::string>().find(word) != std::string::npos) return warning.at("text");
  return "";
}

TEST(PlateGloss, ARigThatCannotTellIsRefusedInOneLineAndOnlyTheFallOffIsTakenOut) {
  const datasets::PlateOptions o{.size = 64, .num_frames = 3, .specular = 0.0};
  for (const auto& [lamp_x, side, reason] :
       {std::tuple{-600.0, 128.0, "nearer than"}, std::tuple{-70.0, 20.0, "of one another"}}) {
    const TempFolder temp;
    datasets::PlateOptions beside = o;
    beside.lamp_x_mm = lamp_x;
    beside.lamp_y_mm = lamp_x < -100.0 ? 50.0 : -30.0;
    beside.side_mm = side;
    if (side < 50.0) beside.lamp_x_mm = -20.0, beside.lamp_y_mm = 10.0;
    const PlateRun run = ingested_plate(beside, temp.path());
    EXPECT_NE(warning_of(run).find(reason), std::string::npos) << warning_of(run);
    EXPECT_FALSE(run.history.at("frames").at(0).contains("specular"));
    // Without a lobe the photographs are Lambertian: what is left is noise, grain aside.
    EXPECT_NEAR(run.errors[0].albedo, run.errors[0].lambert, 1e-3);
  }
}

TEST(PlateGloss, WhatIsStatedStaysAndTheHighlightIsTakenOffAllTheSame) {
  const TempFolder temp;
  const PlateRun run = ingested_plate({.size = 96, .num_frames = 6}, temp.path(), [](Json& capture) {
    capture["appearance"] = {{"roughness", 0.3}};
  });
  EXPECT_NE(warning_of(run).find("states"), std::string::npos);
  const HistoryReader history(temp / "history");
  const ImageF specular = history.read_map("specular");
  EXPECT_NEAR(specular.at(40, 40, 1), 0.3f, 0.3f / 1024.0f);  // Half floats.
  EXPECT_LT(run.errors[0].albedo, 0.2 * run.errors[0].lambert);
}

TEST(PlateGloss, WithoutIntensityColorStaysAsBrightAndRoughnessIsTheSame) {
  const TempFolder temp, other;
  const datasets::PlateOptions o{.size = 96, .num_frames = 4};
  const PlateRun with = ingested_plate(o, temp.path());
  const PlateRun without =
      ingested_plate(o, other.path(), [](Json& capture) { capture.at("lights").at(0).erase("intensity"); });
  EXPECT_EQ(warning_of(with, "`intensity`"), "");
  EXPECT_NE(warning_of(without, "`intensity`"), "");
  // The scale is one number, the exposure in the median of the plate: a half of the pixels is as bright as before.
  const double scale = without.gloss.at("materials").at(0).at("at").at(0).at("f0").get<double>() /
                       largest_at(with, 0).at("f0").get<double>();
  EXPECT_GT(scale, 0.3);
  EXPECT_LT(scale, 0.7);
  EXPECT_NEAR(largest_at(without, 0).at("roughness").get<double>(), largest_at(with, 0).at("roughness").get<double>(),
              kForm * 0.35);
}

/// The plate as a mesh of two triangles before a camera whose principal point lies beside the picture's middle, as a
/// plate seen straight from above from beside its middle has it.
TEST(PlateGloss, AScanInPlaceOfThePlateTellsTheSame) {
  const TempFolder temp, other;
  const datasets::PlateOptions o{.size = 96, .num_frames = 3};
  const PlateRun plate = ingested_plate(o, temp.path());
  const datasets::GlossyPlate truth(o);
  const PlateRun scan = ingested_plate(o, other.path(), [&](Json& capture) {
    const double texel = o.side_mm / o.size, middle = 0.5 * (o.size - 1), focal = truth.camera().z() / texel;
    const double cx = middle + truth.camera().x() / texel, cy = middle - truth.camera().y() / texel;
    std::ofstream(other / "plate/plate.obj") << "v -64 -64 0\nv 64 -64 0\nv 64 64 0\nv -64 64 0\nf 1 2 3\nf 1 3 4\n";
    capture.erase("plate");
    capture["scan"] = {{"mesh", "plate.obj"},
                       {"camera",
                        {{"width", o.size},
                         {"height", o.size},
                         {"matrix", {{focal, 0, cx}, {0, focal, cy}, {0, 0, 1}}},
                         {"rotation", {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}},
                         {"translation", {-truth.camera().x(), truth.camera().y(), truth.camera().z()}}}}};
  });
  // Rays meet the mesh where the plate's pixels lie, to the rounding of floats over half a meter.
  for (const char* what : {"roughness", "f0"}) {
    const double expected = largest_at(plate, 0).at(what).get<double>();
    EXPECT_NEAR(largest_at(scan, 0).at(what).get<double>(), expected, 1e-3 * expected) << what;
  }
  EXPECT_NEAR(scan.errors[0].albedo, plate.errors[0].albedo, 1e-3);
}

/// One photograph of another thing: the lights of those after it stay theirs.
TEST(PlateGloss, APhotographThatIsLeftOutTakesItsLightWithIt) {
  const TempFolder temp;
  const datasets::PlateOptions o{.size = 192, .num_frames = 8, .moving = true};
  run_job(datasets::plan_plate(o, temp / "plate"), {}, {});
  ImageU8 other(o.size, o.size, 3);
  for (std::int64_t i = 0; i < 3 * other.num_pixels(); ++i)
    other.data()[i] = static_cast<std::uint8_t>(255.0 * RandomStream(4, static_cast<std::uint64_t>(i), 1).uniform());
  write_codes(temp / "plate/frames/0002.png", other);
  Json json = load_json(temp / "plate/capture.json");
  json["align"] = "features";
  save_json(temp / "plate/capture.json", json);
  const auto project = capture::read_capture_project(temp / "plate/capture.json");
  run_job(capture::plan_ingest(project, {.accept_failed = true}, temp / "history"), {}, {});
  const Json gloss = load_json(temp / "history/gloss.json");
  const Json& at = gloss.at("materials").at(0).at("at");
  ASSERT_EQ(at.size(), 7u);
  for (const std::size_t i : {std::size_t{0}, std::size_t{2}, std::size_t{4}}) {
    const double truth = o.roughness + at.at(i).at("time").get<double>() / 7.0 * (o.roughness_end - o.roughness);
    EXPECT_NEAR(at.at(i).at("roughness").get<double>(), truth,
                kSigmas * at.at(i).at("roughness_deviation").get<double>() + kForm / 2.0 * truth);
  }
}

TEST(PlateGloss, TheSameBytesForAnyNumberOfThreads) {
  const TempFolder temp;
  const datasets::PlateOptions o{.size = 64, .num_frames = 3};
  run_job(datasets::plan_plate(o, temp / "plate"), {}, {});
  const auto project = capture::read_capture_project(temp / "plate/capture.json");
  for (const int threads : {1, 3}) {
    RunControl control;
    control.num_threads = threads;
    run_job(capture::plan_ingest(project, {}, temp / std::to_string(threads)), {}, control);
  }
  const HistoryReader one(temp / "1"), three(temp / "3");
  for (int i = 0; i < o.num_frames; ++i) {
    EXPECT_EQ(one.read_frame(i), three.read_frame(i));
    EXPECT_EQ(one.read_frame_extra(i, "specular"), three.read_frame_extra(i, "specular"));
  }
}

TEST(PlateGloss, AFlatFieldBesideLightsIsRefused) {
  const TempFolder temp;
  run_job(datasets::plan_plate({.size = 32, .num_frames = 2}, temp / "plate"), {}, {});
  const auto project = capture::read_capture_project(temp / "plate/capture.json");
  EXPECT_THROW((void)capture::plan_ingest(project, {.repair = {.flat_field = "estimate"}}, temp / "history"),
               InvalidInput);
}

}  // namespace
}  // namespace patinate::testing_support
