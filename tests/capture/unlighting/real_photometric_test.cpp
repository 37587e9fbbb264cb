// Real photographs under known directions: a diffuse sphere, whose normals are known, and a plaster cat, whose albedo
// should be flat.
#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "capture/unlighting/leave_one_out.h"
#include "capture/unlighting/unlight_step.h"
#include "libcommon/core/files.h"
#include "patinate/image/image_io.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate::capture {
namespace {

namespace fs = std::filesystem;
using testing_support::TempFolder;

double mean_rms(const std::vector<LeaveOneOutError>& errors) {
  double sum = 0.0;
  for (const LeaveOneOutError& e : errors) sum += e.rms / static_cast<double>(errors.size());
  return sum;
}

/// A quarter of the pixels is enough.
void keep_every_other(ImageU8& mask) {
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) mask.at(x, y) = x % 2 == 0 && y % 2 == 0 ? mask.at(x, y) : std::uint8_t{0};
  }
}

/// Mean angle to the normals of the sphere that the mask's box holds, degrees.
double sphere_error_deg(const UnlightResult& result, const ImageU8& mask) {
  int x0 = mask.width(), x1 = -1, y0 = mask.height(), y1 = -1;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask.at(x, y) == 0) continue;
      x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
    }
  }
  const double cx = 0.5 * (x0 + x1), cy = 0.5 * (y0 + y1), radius = 0.25 * (x1 - x0 + y1 - y0 + 2);
  double sum = 0.0, count = 0.0;
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double nx = (x - cx) / radius, ny = -(y - cy) / radius, nz2 = 1.0 - nx * nx - ny * ny;
      if (mask.at(x, y) == 0 || result.mask.at(x, y) == 0 || !(nz2 > 0.0)) continue;
      const auto p = result.normal.pixel(x, y);
      const double cosine =
          nx * static_cast<double>(p[0]) + ny * static_cast<double>(p[1]) + std::sqrt(nz2) * static_cast<double>(p[2]);
      sum += std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi;
      count += 1.0;
    }
  }
  return sum / count;
}

UnlightInput gray_sphere(const fs::path& data) {
  const TempFolder folder;
  std::string photos;
  for (int k = 0; k < 12; ++k)
    photos += (k > 0 ? ", \"" : "\"") + (data / "gray" / ("gray." + std::to_string(k) + ".tga")).string() + "\"";
  write_atomically(folder / "step.json",
                   R"({"format": "patinate.unlight", "version": 1, "response": "linear", "photos": [)" + photos +
                       R"(], "lights": ")" + (data / "lights.txt").string() + R"(", "mask": ")" +
                       (data / "gray/gray.mask.tga").string() + "\"}");
  UnlightScene scene = load_unlight_scene(read_unlight_step(folder / "step.json"));
  return std::move(scene.input);
}

TEST(RealPhotometric, NormalsOfTheGraySphereAreThoseOfASphere) {
  PATINATE_REQUIRE_DATA(data, "photometric/uw_psm");
  UnlightInput input = gray_sphere(data);
  const ImageU8 whole = input.mask;
  keep_every_other(input.mask);
  const UnlightResult plain =
      unlight(input, {.rejection = Rejection::None, .specular = SpecularMode::None, .min_cosine = 0.0});
  const UnlightOptions options{.specular = SpecularMode::None, .min_cosine = 0.0};
  const UnlightResult robust = unlight(input, options);
  const double predicted = mean_rms(leave_one_out(input, options, robust));
  const double plain_deg = sphere_error_deg(plain, whole), robust_deg = sphere_error_deg(robust, whole);
  std::printf("gray sphere: normals %.2f deg (least squares %.2f); photographs predicted %.2f %% off\n", robust_deg,
              plain_deg, 100.0 * predicted);
  // Upside-down photographs, or lights with y down, would be some 40 degrees off.
  EXPECT_NEAR(plain_deg, 5.15, 0.05);  // Measured with another program.
  // What the directions allow: those that the sphere itself asks for are 3.4 degrees from lights.txt's, and with them
  // it is still 4.2.
  EXPECT_LT(robust_deg, 4.8);
  EXPECT_LT(predicted, 0.035);
}

/// The cat under its twelve lamps, whose strengths are to be found; the mask is what some lamp makes bright.
UnlightInput plaster_cat(const fs::path& data) {
  const TempFolder folder;
  write_atomically(folder / "step.json",
                   R"({"format": "patinate.unlight", "version": 1, "response": "linear", "photos": {"pattern": ")" +
                       (data / "Objects/Image_*.png").string() + R"("}, "lights": ")" +
                       (data / "light_directions.txt").string() + "\"}");
  UnlightScene scene = load_unlight_scene(read_unlight_step(folder / "step.json"));
  scene.input.mask = ImageU8(scene.input.photos[0].width(), scene.input.photos[0].height());
  for (const ImageF& photo : scene.input.photos) {
    for (std::int64_t i = 0; i < photo.num_pixels(); ++i) {
      if (photo.data()[i] > 0.25f) scene.input.mask.data()[i] = 255;
    }
  }
  return std::move(scene.input);
}

/// Half the distance of the 16th and 84th percentile of the albedo, over its median.
double flatness(const UnlightResult& result) {
  std::vector<float> albedo;
  for (std::int64_t i = 0; i < result.mask.num_pixels(); ++i) {
    if (result.mask.data()[i] != 0) albedo.push_back(result.albedo.data()[i]);
  }
  std::sort(albedo.begin(), albedo.end());
  const auto rank = [&](double share) {
    return static_cast<double>(albedo[static_cast<std::size_t>(share * static_cast<double>(albedo.size() - 1))]);
  };
  return 0.5 * (rank(0.84) - rank(0.16)) / rank(0.5);
}

TEST(RealPhotometric, ThePlasterCatIsFlatAndItsLampsAreUnequal) {
  PATINATE_REQUIRE_DATA(data, "photometric/psbox_cat");
  UnlightInput input = plaster_cat(data);
  keep_every_other(input.mask);
  const UnlightOptions options{.specular = SpecularMode::None, .estimate_strengths = true};
  const UnlightResult result = unlight(input, options);
  const double evenness = flatness(result), predicted = mean_rms(leave_one_out(input, options, result));
  double least = 10.0, most = 0.0;
  for (const LightReport& light : result.lights)
    least = std::min(least, light.strength[0]), most = std::max(most, light.strength[0]);
  std::printf(
      "plaster cat: albedo even to %.2f %%; strengths %.3f to %.3f; residual %.2f %%; photographs predicted %.2f %% "
      "off\n",
      100.0 * evenness, least, most, 100.0 * result.residual, 100.0 * predicted);
  EXPECT_TRUE(result.is_converged);
  EXPECT_NEAR(least, 0.57, 0.02);  // Measured before, with another program: 0.57 to 1.29.
  EXPECT_NEAR(most, 1.29, 0.04);
  EXPECT_LT(evenness, 0.065);  // Its folds light each other, which no lamp's model knows.
  EXPECT_LT(predicted, 0.035);
}

/// One pixel of every 2 x 2.
template <typename Image>
Image halved(const Image& in) {
  Image out(in.width() / 2, in.height() / 2, in.channels());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x)
      std::copy_n(in.pixel(2 * x, 2 * y).begin(), in.channels(), out.pixel(x, y).begin());
  }
  return out;
}

void halve(UnlightInput& input) {
  for (ImageF& photo : input.photos) photo = halved(photo);
  for (ImageU8& valid : input.valid) valid = halved(valid);
  input.mask = halved(input.mask);
}

double mean_metalness(const UnlightResult& result) {
  double sum = 0.0, count = 0.0;
  for (std::int64_t i = 0; i < result.mask.num_pixels(); ++i) {
    if (result.mask.data()[i] == 0) continue;
    sum += static_cast<double>(result.metalness.data()[i]);
    count += 1.0;
  }
  return sum / count;
}

/// Photographs of lamps, each predicted by the others, with Lambert's model, today's lobes and materials.
void compare_models(const char* name, const UnlightInput& input, UnlightOptions options) {
  options.specular = SpecularMode::None;
  const double matt = mean_rms(leave_one_out(input, options, unlight(input, options)));
  options.specular = SpecularMode::Auto;
  const double today = mean_rms(leave_one_out(input, options, unlight(input, options)));
  options.specular = SpecularMode::Material;
  const UnlightResult result = unlight(input, options);
  const double materials = mean_rms(leave_one_out(input, options, result));
  std::printf("%s: photographs predicted %.2f %% off as matt, %.2f %% with tiles' lobes, %.2f %% with materials\n",
              name, 100.0 * matt, 100.0 * today, 100.0 * materials);
  for (const std::string& note : result.notes) std::printf("  %s\n", note.c_str());
  ASSERT_FALSE(result.materials.empty());
  EXPECT_LT(mean_metalness(result), 0.05);  // Metal is told at two standard deviations.
}

TEST(RealPhotometric, PlasterAndMattPaintAreNoMetal) {
  PATINATE_REQUIRE_DATA(cat, "photometric/psbox_cat");
  PATINATE_REQUIRE_DATA(sphere, "photometric/uw_psm");
  UnlightInput input = plaster_cat(cat);
  halve(input);
  compare_models("plaster cat", input, {.estimate_strengths = true});
  input = gray_sphere(sphere);
  halve(input);
  compare_models("gray sphere", input, {.min_cosine = 0.0});
}

/// Heights, in pixels, whose slopes are nearest to those of the normals, seen from far away; and the mesh of them.
void integrate_normals(const UnlightResult& result, UnlightInput& input, Mesh& mesh) {
  const int width = result.mask.width(), height = result.mask.height();
  std::vector<int> number(static_cast<std::size_t>(result.mask.num_pixels()), -1);
  int count = 0;
  for (std::int64_t i = 0; i < result.mask.num_pixels(); ++i) {
    if (result.mask.data()[i] != 0) number[i] = count++;
  }
  const auto at = [&](int x, int y) { return number[y * width + x]; };
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  for (int i = 0; i < count; ++i) entries.emplace_back(i, i, 1e-8);
  const auto slope = [&](int x, int y, int axis) {  // Per pixel to the right, or down.
    constexpr double kLeast = 0.15;
    const double z = std::max(kLeast, static_cast<double>(result.normal.at(x, y, 2)));
    return (axis == 0 ? -1.0 : 1.0) * static_cast<double>(result.normal.at(x, y, axis)) / z;
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int axis = 0; axis < 2; ++axis) {
        const int nx = x + (axis == 0 ? 1 : 0), ny = y + (axis == 1 ? 1 : 0);
        if (nx >= width || ny >= height || at(x, y) < 0 || at(nx, ny) < 0) continue;
        const int a = at(x, y), b = at(nx, ny);
        const double step = 0.5 * (slope(x, y, axis) + slope(nx, ny, axis));
        for (const int i : {a, b}) entries.emplace_back(i, i, 1.0);
        entries.emplace_back(a, b, -1.0), entries.emplace_back(b, a, -1.0);
        right[a] -= step, right[b] += step;
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd heights = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
  input.position_mm = ImageF(width, height, 3);
  input.normal = result.normal;
  input.mask = result.mask;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (at(x, y) < 0) continue;
      mesh.positions.emplace_back(x, -y, heights[at(x, y)]);
      for (int c = 0; c < 3; ++c) input.position_mm.at(x, y, c) = static_cast<float>(mesh.positions.back()[c]);
      if (x + 1 >= width || y + 1 >= height || at(x + 1, y) < 0 || at(x, y + 1) < 0 || at(x + 1, y + 1) < 0) continue;
      mesh.triangles.push_back({at(x, y), at(x, y + 1), at(x + 1, y)});
      mesh.triangles.push_back({at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)});
    }
  }
}

TEST(RealPhotometric, ThePlasterCatIsFlatterWithoutTheLightOfItsFolds) {
  PATINATE_REQUIRE_DATA(data, "photometric/psbox_cat");
  UnlightInput input = plaster_cat(data);
  halve(input);
  UnlightOptions options{.specular = SpecularMode::None, .estimate_strengths = true};
  const UnlightResult first = unlight(input, options);
  Mesh shape;
  integrate_normals(first, input, shape);
  input.blockers = &shape;
  const UnlightResult before = unlight(input, options);
  options.interreflection = true;
  const UnlightResult after = unlight(input, options);
  std::printf(
      "plaster cat with the shape of its normals: albedo even to %.2f %%, without the light of its folds %.2f %%; "
      "taken off %.1f %% (p95 %.1f %%); residual %.2f %%, %.2f %%\n",
      100.0 * flatness(before), 100.0 * flatness(after), 100.0 * after.interreflection->median,
      100.0 * after.interreflection->p95, 100.0 * before.residual, 100.0 * after.residual);
  EXPECT_LT(flatness(after), flatness(before));
}

}  // namespace
}  // namespace patinate::capture
