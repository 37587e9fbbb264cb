// Colors that follow the amount, and the printed form of weights that do not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "patinate/image/color.h"
#include "simulation/files/scene_json.h"
#include "tests/simulation/composition/compose_scene.h"
#include "tests/support/errors.h"
#include "tests/support/meshes.h"
#include "tests/support/reference_compose.h"

namespace patinate::simulation {
namespace {

using testing_support::ComposeScene;
using testing_support::error_of;
using testing_support::has;

const std::vector<ColorStop> kRust{
    {.amount = 0.25, .color = {0.5, 0.2, 0.05}, .second_color = Vec3(0.4, 0.1, 0.02)},
    {.amount = 0.75, .color = {0.25, 0.07, 0.02}},
    {.amount = 1.5, .color = {0.05, 0.02, 0.015}, .second_color = Vec3(0.1, 0.03, 0.01)}};

/// Wherever there is some, nothing else is seen.
MaterialAppearance covering(double variation, double grain_mm) {
  MaterialAppearance look;
  look.colors = kRust;
  look.strength = 1000.0;
  look.variation = variation;
  look.grain_mm = grain_mm;
  return look;
}

int code_of(double linear) { return srgb8_from_linear(static_cast<float>(linear)); }

TEST(ColorsByAmount, AreReachedAtTheirAmountsAndHeldBehindThem) {
  ComposeScene scene(testing_support::unit_plane(32.0), 32, {covering(0.0, 0.0)});
  const std::vector<double> amounts{0.1, 0.25, 0.5, 0.75, 1.5, 3.0};
  scene.set(0, [&](int x, int, const Vec3&) { return amounts[x / 8]; });
  const ImageU8 first = [&] {
    Composer composer = scene.composer();
    (void)composer.compose(*scene.atlas, {});
    return composer.color_srgb8();
  }();
  scene.set(0, [&](int x, int, const Vec3&) { return amounts[static_cast<std::size_t>(x / 8) + 2]; });
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  const ImageU8 second = composer.color_srgb8();
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(first.at(3, 9, c), code_of(kRust[0].color[c]));
    EXPECT_EQ(first.at(12, 9, c), code_of(kRust[0].color[c]));
    // Colors are those of their codes, halfway between which a code may round to either side.
    EXPECT_NEAR(first.at(20, 9, c), code_of(0.5 * (kRust[0].color[c] + kRust[1].color[c])), 1);
    EXPECT_EQ(first.at(28, 9, c), code_of(kRust[1].color[c]));
    EXPECT_EQ(second.at(20, 9, c), code_of(kRust[2].color[c]));
    EXPECT_EQ(second.at(28, 9, c), code_of(kRust[2].color[c]));
  }
}

TEST(ColorsByAmount, FastAndSlowVersionsAgreeToACode) {
  for (const double grain_mm : {0.0, 15.0}) {
    ComposeScene scene(testing_support::unit_plane(64.0), 64, {covering(0.6, grain_mm)});
    scene.set(0, [](int x, int y, const Vec3&) { return 0.03 * x + 0.001 * y; });
    Composer composer = scene.composer();
    (void)composer.compose(*scene.atlas, {});
    const std::vector<ReferenceTexel> slow =
        compose_reference(scene.scene, scene.scene_mesh, *scene.atlas, ColorForm::Normalized);
    for (TexelIndex t = 0; t < scene.surface->grid().num_texels(); ++t) {
      if (!scene.surface->is_covered(t)) continue;
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(composer.codes()[t] >> (8 * c) & 255, code_of(slow[t].color[c]), 1) << grain_mm;
    }
  }
}

TEST(ColorsByAmount, WithOneColorAtAllAmountsAreThatColor) {
  MaterialAppearance plain = covering(0.5, 10.0), same = plain;
  plain.colors.clear();
  plain.color.color = {0.3, 0.1, 0.05};
  plain.second_color = Vec3(0.1, 0.2, 0.3);
  for (ColorStop& stop : same.colors) stop.color = plain.color.color, stop.second_color = plain.second_color;
  std::vector<std::vector<std::uint32_t>> codes;
  for (const MaterialAppearance& look : {plain, same}) {
    ComposeScene scene(testing_support::unit_plane(32.0), 32, {look});
    scene.set(0, [](int x, int, const Vec3&) { return 0.06 * x; });
    Composer composer = scene.composer();
    (void)composer.compose(*scene.atlas, {});
    codes.emplace_back(composer.codes().begin(), composer.codes().end());
  }
  EXPECT_EQ(codes[0], codes[1]);
}

class ColorsJson : public ::testing::Test {
 protected:
  MaterialAppearance read(const std::string& text, const MaterialAppearance& defaults = {}) {
    const Json json = Json::parse(text);
    SceneContext context;
    return read_material_appearance(JsonReader("scene.json", json, "/appearance/rust"), defaults, context);
  }
  std::string says(const std::string& text) {
    return error_of([&] { (void)read(text); });
  }
};

TEST_F(ColorsJson, TakeThePlaceOfTheDefaults) {
  const MaterialAppearance curve = read(
      R"({"colors": [{"amount": 0, "color": [0.4, 0.1, 0]}, {"amount": 2, "color": [0.1, 0.1, 0], "second_color": [0, 0, 0]}]})");
  ASSERT_EQ(curve.colors.size(), 2u);
  EXPECT_EQ(curve.colors[1].amount, 2.0);
  EXPECT_EQ(curve.color.color, Vec3(0.1, 0.1, 0));
  EXPECT_TRUE(read(R"({"strength": 0.3})", curve).colors.size() == 2u);
  EXPECT_TRUE(read(R"({"color": [0.3, 0.3, 0.3]})", curve).colors.empty());
  EXPECT_TRUE(read(R"({"second_color": [0.3, 0.3, 0.3]})", curve).colors.empty());
}

TEST_F(ColorsJson, ThatAreWrongSaySo) {
  const std::string a = R"({"amount": 0.5, "color": [0, 0, 0]})";
  EXPECT_TRUE(has(says("{\"colors\": [" + a + "]}"), "2 to 4 colors")) << says("{\"colors\": [" + a + "]}");
  EXPECT_TRUE(has(says("{\"colors\": [" + a + ", " + a + "]}"), "/appearance/rust/colors/1/amount"));
  EXPECT_TRUE(has(says("{\"color\": [0, 0, 0], \"colors\": [" + a + "]}"), "colors"));
  EXPECT_TRUE(has(says(R"({"colors": [{"amount": 0.5}, {"amount": 1}]})"), "color"));
}

TEST(PrintedForm, CoversByStrengthAndNotByAmount) {
  // Two materials of strengths 0.2 and 0.5; the second is there from x = 16 on. Amounts rise along x.
  const Vec3 first(0.8, 0.1, 0.4), second(0.2, 0.9, 0.6), surface(0.5, 0.3, 0.7);
  std::vector<MaterialAppearance> looks(2);
  looks[0].color.color = first;
  looks[0].strength = 0.2;
  looks[1].color.color = second;
  looks[1].strength = 0.5;
  ComposeScene scene(testing_support::unit_plane(32.0), 32, looks,
                     [&](Scene& s) { s.objects[0].preset.color.color = surface; });
  const auto amount = [](int x) { return x / 8.0; };  // Up to 3.9.
  scene.set(0, [&](int x, int, const Vec3&) { return amount(x); });
  scene.set(1, [&](int x, int, const Vec3&) { return x < 16 ? 0.0 : amount(x); });
  Composer composer = scene.composer(ColorForm::Printed);
  (void)composer.compose(*scene.atlas, {});
  const ImageU8 got = composer.color_srgb8();
  for (int x = 0; x < 32; ++x) {
    const double a = x == 0 ? 0.0 : x < 16 ? 0.2 : 0.7;
    for (int c = 0; c < 3; ++c) {
      const double laid = amount(x) * (0.2 * first[c] + (x < 16 ? 0.0 : 0.5 * second[c]));
      const double expected = std::min(1.0, surface[c] * (1.0 - a) + a * laid);
      // Colors are sRGB codes before they are blended, which moves the result by half a code.
      EXPECT_NEAR(got.at(x, 3, c), code_of(expected), 1) << x << " " << c;
    }
  }
}

}  // namespace
}  // namespace patinate::simulation
