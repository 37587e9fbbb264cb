// Which control explains where an object aged? The artist-made hydrant has a clean and an aged twin on one atlas:
//     PATINATE_DATA=... build/release/bin/control_study OUT_FOLDER [MAP.exr ...]
// prints the tables of docs/studies/hydrant.md and docs/algorithms/accessibility.md and writes the pictures (JPEG).
// Maps of a simulation of the hydrant (controls/rust.final.exr, 1024 x 1024) get rows of their own.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/random.h"
#include "libcommon/metrics/correlation.h"
#include "libcommon/output/contact_strip.h"
#include "patinate/atlas/dilate.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/output/render.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

constexpr int kSize = 1024;
constexpr int kBlock = 64;  // Texels; blocks are drawn again for the confidence intervals.
constexpr int kResamples = 120;
constexpr int kStride = 4;     // Every fourth texel of both axes is looked at: neighbors say the same.
constexpr double kRed = 25.0;  // CIE a* of the clean twin's red paint.
constexpr double kOpen = 0.3;  // Least share of free rays of what can be seen from outside.

/// CIE 1976 L*a*b* of linear Rec.709 under D65.
Vec3 lab(const ImageF& image, int x, int y) {
  const auto p = image.pixel(x, y);
  const double r = static_cast<double>(p[0]), g = static_cast<double>(p[1]), b = static_cast<double>(p[2]);
  const auto f = [](double t) { return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116; };
  const double fx = f((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047),
               fy = f(0.2126729 * r + 0.7151522 * g + 0.0721750 * b),
               fz = f((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
  return {116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)};
}

/// Where the twin differs: the color difference of the albedo (CIE76).
ImageF color_change(const ImageF& clean, const ImageF& aged) {
  ImageF out(clean.width(), clean.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x)
      out.at(x, y) = static_cast<float>((lab(clean, x, y) - lab(aged, x, y)).norm());
  }
  return out;
}

ImageF channel_change(const std::filesystem::path& clean, const std::filesystem::path& aged, const char* channel) {
  ImageF a = read_gray(clean, channel);
  const ImageF b = read_gray(aged, channel);
  for (std::size_t i = 0; i < a.values().size(); ++i) a.values()[i] = b.values()[i] - a.values()[i];
  return a;
}

struct Samples {
  std::vector<TexelId> texels;
  std::vector<std::vector<std::size_t>> blocks;  // Into texels.
};

/// @param counts  Empty, or 0 at texels that are excluded.
Samples sample(const TexelMap& map, const ImageU8& counts = {}) {
  Samples s;
  std::map<int, std::vector<std::size_t>> blocks;
  for (int y = 0; y < map.height(); y += kStride) {
    for (int x = 0; x < map.width(); x += kStride) {
      const TexelId t = TexelId{y} * map.width() + x;
      if (!map.is_covered(t) || !is_inside(counts, x, y)) continue;
      blocks[(y / kBlock) * 1000 + x / kBlock].push_back(s.texels.size());
      s.texels.push_back(t);
    }
  }
  for (auto& [key, block] : blocks) s.blocks.push_back(std::move(block));
  return s;
}

std::vector<double> at_texels(const ImageF& image, const Samples& s) {
  std::vector<double> values;
  for (const TexelId t : s.texels) values.push_back(static_cast<double>(image.values()[static_cast<std::size_t>(t)]));
  return values;
}

struct Interval {
  double rho, low, high;
};

/// Rank correlation and the middle 95 % of what blocks drawn with replacement give.
Interval correlate(const std::vector<double>& a, const std::vector<double>& b, const Samples& s) {
  std::vector<double> drawn;
  for (int k = 0; k < kResamples; ++k) {
    RandomStream random(1, static_cast<std::uint64_t>(k));
    std::vector<double> x, y;
    for (std::size_t n = 0; n < s.blocks.size(); ++n) {
      for (const std::size_t i : s.blocks[random.below(static_cast<std::uint32_t>(s.blocks.size()))]) {
        x.push_back(a[i]);
        y.push_back(b[i]);
      }
    }
    drawn.push_back(rank_correlation(x, y));
  }
  std::sort(drawn.begin(), drawn.end());
  return {rank_correlation(a, b), drawn[kResamples / 40], drawn[kResamples - 1 - kResamples / 40]};
}

/// The same values with its blocks in another order: what chance gives, at the map's own coarseness.
std::vector<double> shuffled(const std::vector<double>& values, const Samples& s) {
  std::vector<double> out(values.size());
  RandomStream random(7, 0);
  for (const auto& block : s.blocks) {
    const auto& other = s.blocks[random.below(static_cast<std::uint32_t>(s.blocks.size()))];
    for (std::size_t i = 0; i < block.size(); ++i) out[block[i]] = values[other[i % other.size()]];
  }
  return out;
}

/// Red paint of the clean twin that can be seen from outside: neither bare metal nor the insides of pipes.
ImageU8 shown_paint(const TexelMap& map, const ImageF& clean) {
  ControlKindOptions options;
  options.ray_share.reach_mm = 1e9;
  const ImageF hidden = make_control("ray_share", map, options).values;
  ImageU8 out(map.width(), map.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const bool is_shown = static_cast<double>(hidden.at(x, y)) < 1.0 - kOpen && lab(clean, x, y).y() > kRed;
      out.at(x, y) = is_shown ? 255 : 0;
    }
  }
  return out;
}

struct Scene {
  Mesh mesh;
  std::unique_ptr<TexelMap> map;
};

Scene load(const std::filesystem::path& file, const std::string& material) {
  Mesh mesh = with_normals(select_surfaces(read_mesh(file), "", material));
  scale_mesh(mesh, 1000.0);
  auto map = std::make_unique<TexelMap>(mesh, kSize, kSize);
  return {std::move(mesh), std::move(map)};
}

void definitions(const char* name, const TexelMap& map) {
  const Samples s = sample(map);
  std::vector<std::vector<double>> values;
  const std::vector<std::string> kinds{"accessibility", "ray_share", "tangent_sphere", "exposure"};
  for (const std::string& kind : kinds) values.push_back(at_texels(make_control(kind, map).values, s));
  std::printf("\n%s: rank correlation of the definitions\n%16s", name, "");
  for (const std::string& kind : kinds) std::printf("%16s", kind.c_str());
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    std::printf("\n%16s", kinds[i].c_str());
    for (std::size_t j = 0; j < kinds.size(); ++j) std::printf("%16.2f", rank_correlation(values[i], values[j]));
  }
  std::printf("\n");
}

/// As bright as its rank: 0 least, 1 greatest.
ImageF by_rank(const ImageF& image, const TexelMap& map) {
  std::vector<float> sorted;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (map.is_covered(t)) sorted.push_back(image.values()[static_cast<std::size_t>(t)]);
  }
  std::sort(sorted.begin(), sorted.end());
  ImageF out(image.width(), image.height());
  for (std::size_t i = 0; i < out.values().size(); ++i) {
    const auto at = std::lower_bound(sorted.begin(), sorted.end(), image.values()[i]) - sorted.begin();
    out.values()[i] = static_cast<float>(at) / static_cast<float>(sorted.size());
  }
  return out;
}

/// A map in blue (0) to yellow (1), on the mesh.
ImageF portrait(const RenderView& view, const ImageF& map_values, const TexelMap& map) {
  ImageF texture(map.width(), map.height(), 3);
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      const float v = std::clamp(map_values.at(x, y), 0.0F, 1.0F);
      texture.at(x, y, 0) = 0.02F + 0.85F * v * v;
      texture.at(x, y, 1) = 0.03F + 0.60F * v;
      texture.at(x, y, 2) = 0.25F * (1.0F - v) + 0.03F;
    }
  }
  dilate(texture, map.coverage(), 16);
  return view.shade(texture);
}

struct Trial {
  std::string label, expression;
};

std::vector<Trial> trials() {
  return {{"accessibility", "accessibility"},
          {"ray_share", "ray_share"},
          {"tangent_sphere", "tangent_sphere"},
          {"exposure", "exposure"},
          {"sun", "sun"},
          {"facing (up)", "facing"},
          {"height", "height"},
          {"distance from creases", "distance"},
          {"spray (from above, in front)", "spray"},
          {"accessibility + ray_share", "0.5*accessibility + 0.5*ray_share"},
          {"!height + !facing", "0.5*!height + 0.5*!facing"},
          {"ray_share + !height", "0.5*ray_share + 0.5*!height"},
          {"!height + !facing + accessibility", "(!height + !facing + accessibility)/3"},
          {"exposure * height", "exposure*height"}};
}

void hydrant(const std::filesystem::path& data, const std::filesystem::path& out,
             const std::vector<std::string>& given_maps) {
  const std::filesystem::path textures = data / "textures";
  const Scene scene = load(data / "fire_hydrant_1k.gltf", "fire_hydrant");
  const TexelMap& map = *scene.map;
  const ImageF clean = read_color(textures / "fire_hydrant_diff_1k.jpg"),
               aged = read_color(textures / "fire_hydrant_aged_diff_1k.jpg");
  const auto arm = [&](const char* channel) {
    return channel_change(textures / "fire_hydrant_arm_1k.jpg", textures / "fire_hydrant_aged_arm_1k.jpg", channel);
  };
  const ImageF change = color_change(clean, aged);
  const Samples all = sample(map), s = sample(map, shown_paint(map, clean));
  const ImageF rougher = arm("G"), metal = arm("B");
  const std::array<std::vector<double>, 3> aging{at_texels(change, s), at_texels(rougher, s), at_texels(metal, s)};
  const std::vector<double> all_change = at_texels(change, all);
  std::printf("hydrant: %zu texels in %zu blocks, of which %zu in %zu blocks are red paint that shows\n",
              all.texels.size(), all.blocks.size(), s.texels.size(), s.blocks.size());
  std::printf("%-32s%26s%26s%26s%26s\n", "control", "all: color (dE)", "paint: color (dE)", "paint: rougher",
              "paint: more metal");
  ControlKindOptions options;
  options.distance_from = "creases";
  std::map<std::string, ControlMap> maps;
  std::vector<std::pair<double, std::string>> order;
  const auto print = [](const Interval& c) { std::printf("    %5.2f [%5.2f, %5.2f]", c.rho, c.low, c.high); };
  const auto row = [&](const std::string& label, const std::vector<double>& values,
                       const std::vector<double>& all_values) {
    std::printf("%-32s", label.c_str());
    print(correlate(all_values, all_change, all));
    for (const auto& a : aging) print(correlate(values, a, s));
    std::printf("\n");
    std::fflush(stdout);
  };
  std::vector<Trial> all_trials = trials();
  for (const std::string& path : given_maps)
    all_trials.push_back({std::filesystem::path(path).filename().string(), '"' + path + '"'});
  for (const Trial& trial : all_trials) {
    ControlMap control = make_control_expression(trial.expression, map, options);
    const std::vector<double> values = at_texels(control.values, s);
    row(trial.label, values, at_texels(control.values, all));
    order.emplace_back(-std::abs(rank_correlation(values, aging[0])), trial.label);
    maps.emplace(trial.label, std::move(control));
  }
  row("ray_share, blocks shuffled", shuffled(at_texels(maps.at("ray_share").values, s), s),
      shuffled(at_texels(maps.at("ray_share").values, all), all));
  for (std::size_t i = trials().size(); i < all_trials.size(); ++i) {
    const ImageF& values = maps.at(all_trials[i].label).values;
    row(all_trials[i].label + ", shuffled", shuffled(at_texels(values, s), s), shuffled(at_texels(values, all), all));
  }
  std::sort(order.begin(), order.end());

  const RenderView view(scene.mesh, {.width = 360, .height = 480, .azimuth_deg = 25.0});
  std::vector<ImageF> pictures{view.shade(clean), view.shade(aged), portrait(view, by_rank(change, map), map)};
  std::vector<std::string> labels{"clean", "aged", "where it changed"};
  for (std::size_t i = 0; i < 3; ++i) {
    ImageF ranks = by_rank(maps.at(order[i].second).values, map);
    const bool is_inverse = rank_correlation(at_texels(ranks, s), aging[0]) < 0.0;
    if (is_inverse) {
      for (float& v : ranks.values()) v = 1.0F - v;
    }
    pictures.push_back(portrait(view, ranks, map));
    labels.push_back((is_inverse ? "not " : "") + order[i].second);
  }
  write_srgb8(out / "hydrant_study.jpg", contact_strip(pictures, labels, {.columns = 3}));
}

}  // namespace
}  // namespace patinate

int main(int argc, char** argv) {
  using namespace patinate;
  const auto hydrant_data = testing_support::real_data("meshes/fire_hydrant");
  const auto bust_data = testing_support::real_data("meshes/marble_bust");
  if (argc < 2 || !hydrant_data || !bust_data) {
    std::fprintf(stderr, "usage: PATINATE_DATA=FOLDER control_study OUT_FOLDER [MAP.exr ...]\n");
    return 2;
  }
  try {
    std::filesystem::create_directories(argv[1]);
    hydrant(*hydrant_data, argv[1], std::vector<std::string>(argv + 2, argv + argc));
    definitions("hydrant", *load(*hydrant_data / "fire_hydrant_1k.gltf", "fire_hydrant").map);
    definitions("bust", *load(*bust_data / "marble_bust_01_1k.gltf", "").map);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "control_study: %s\n", e.what());
    return 1;
  }
}
