// What all maps of a material cost over color alone: ingest, transfer, lookup and an 8k export in strips. Each piece of
// work runs in a process of its own, color and all maps in turn, five times; figures are medians of the pairs' ratios
// of processor time, and of peak memory.
//     build/release/bin/material_benchmark [ingest | relit | transfer | lookup | export]
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/project/relit_project.h"
#include "capture/relit/relit_ingest.h"
#include "capture/timelapse/ingest.h"
#include "datasets_synthetic/mold_io.h"
#include "patinate/core/json.h"
#include "patinate/history/history_sampling.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/benchmarks/child_cost.h"
#include "tests/benchmarks/patch_transfer.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/lookup/texture_files.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;
using benchmarks::ChildCost;
using benchmarks::cost_in_child;
using Work = std::function<void()>;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// @param channels  Of all maps with color, over the three of color.
void compare(const char* name, double channels, const Work& color, const Work& all, int num_pairs = 5) {
  std::vector<double> color_s, ratio, color_mb, memory;
  for (int i = 0; i < num_pairs; ++i) {
    const ChildCost a = cost_in_child(color), b = cost_in_child(all);
    if (a.cpu_s < 0.0 || b.cpu_s < 0.0) {
      std::printf("%s failed\n", name);
      return;
    }
    color_s.push_back(a.cpu_s);
    ratio.push_back(b.cpu_s / a.cpu_s);
    color_mb.push_back(a.peak_mb);
    memory.push_back(b.peak_mb / a.peak_mb);
  }
  std::printf(
      "%s: color %.2f s of processor time, %.0f MB; time %.2f (%.2f to %.2f), memory %.2f times that; channels "
      "%.2f\n",
      name, median(color_s), median(color_mb), median(ratio), *std::min_element(ratio.begin(), ratio.end()),
      *std::max_element(ratio.begin(), ratio.end()), median(memory), channels);
  std::fflush(stdout);
}

void do_in_child(const Work& work) {
  if (cost_in_child(work).cpu_s < 0.0) std::printf("setting up failed\n");
}

/// 24 photographs of 512 x 512; the second project states two materials by color.
void ingest() {
  const testing_support::TempFolder folder;
  do_in_child([&] {
    constexpr int kSide = 512;
    fs::create_directories(folder / "frames");
    for (int i = 0; i < 24; ++i) {
      ImageF photo(kSide, kSide, 3);
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          for (int c = 0; c < 3; ++c) photo.at(x, y, c) = testing_support::blotches(x, y, i, c);
        }
      }
      write_srgb8(folder / "frames" / (std::to_string(100 + i) + ".png"), photo);
    }
    Json json{{"format", "patinate.capture"},
              {"version", 1},
              {"name", "benchmark"},
              {"kind", "fixed"},
              {"frames", {{"pattern", "frames/*.png"}, {"interval", 1}}}};
    save_json(folder / "color.json", json);
    json["appearance"]["materials"] = Json::array(
        {{{"color", "#7b6058"}, {"metalness", 1}, {"roughness", 0.35}, {"specular", 0.04}, {"tint", "#f0ae8c"}},
         {{"color", "#2e5f60"}, {"metalness", 0}, {"roughness", 0.85}, {"specular", 0.03}, {"tint", "#ffffff"}}});
    save_json(folder / "all.json", json);
  });
  const auto work = [&](const char* name) {
    return [&folder, name] {
      const fs::path out = folder / (std::string(name) + "_history");
      fs::remove_all(out);
      (void)run_job(
          capture::plan_ingest(capture::read_capture_project(folder / (std::string(name) + ".json")), {}, out), {}, {});
    };
  };
  compare("ingest, metalness, gloss and tint stated by color", (3.0 + 2 + 1 + 3) / 3.0, work("color"), work("all"));
}

/// Two steps of the metal mold, photographed under eight lamps: color alone, which is highlights rejected and not
/// fitted, against what `ingest` finds by itself, against materials, and against materials with heights.
void ingest_relit() {
  const testing_support::TempFolder folder;
  do_in_child([&] {
    const datasets::MoldOptions mold{.width = 192,
                                     .height = 144,
                                     .num_steps = 2,
                                     .num_lights = 8,
                                     .metal = true,
                                     .relief_mm = 0.8,
                                     .transforms = true};
    (void)run_job(datasets::plan_mold(mold, folder / "mold"), {}, {});
  });
  const auto work = [&](capture::SpecularMode specular, bool heights) {
    return [&folder, specular, heights] {
      const fs::path out = folder / "history";
      fs::remove_all(out);
      capture::RelitOptions options{.heights = heights};
      options.unlight.specular = specular;
      (void)run_job(capture::plan_relit_ingest(capture::read_relit_project(folder / "mold/capture.json"), options, out),
                    {}, {});
    };
  };
  const Work color = work(capture::SpecularMode::None, false);
  compare("relit ingest, gloss (auto)", (3.0 + 2) / 3.0, color, work(capture::SpecularMode::Auto, false));
  compare("relit ingest, heights", (3.0 + 1) / 3.0, color, work(capture::SpecularMode::None, true));
  compare("relit ingest, materials", (3.0 + 2 + 1 + 3) / 3.0, color, work(capture::SpecularMode::Material, false), 3);
  compare("relit ingest, materials and heights", (3.0 + 2 + 1 + 3 + 1) / 3.0, color,
          work(capture::SpecularMode::Material, true), 3);
}

/// A history of 512 x 512 onto 262 thousand texels.
void transfer_maps(int num_frames) {
  const testing_support::TempFolder folder;
  do_in_child([&] {
    for (const char* name : {"color", "all"}) {
      fs::create_directory(folder / name);
      testing_support::write_history(folder / name, 512, 512, num_frames, testing_support::blotches);
    }
    benchmarks::add_material_maps(folder / "all");
  });
  const auto work = [&](const char* name) {
    return [&folder, name] {
      constexpr int kAtlas = 724;  // Half of it is covered.
      const auto map = std::make_shared<TexelMap>(testing_support::cut_plane(kAtlas), kAtlas, kAtlas);
      ImageF guide(kAtlas, kAtlas);
      for (TexelId t = 0; t < map->num_texels(); ++t) {
        if (map->is_covered(t)) guide.data()[t] = static_cast<float>(map->position_mm(t).x() / kAtlas);
      }
      (void)transfer::transfer({.history = std::make_shared<const HistoryReader>(folder / name),
                                .map = map,
                                .texel_size_mm = map->median_texel_size_mm(),
                                .controls = {{"x", "gradient", guide, {}, 1.0, transfer::ControlMapping::Rank}}},
                               {});
    };
  };
  compare(("transfer, " + std::to_string(num_frames) + " frames").c_str(), 13.0 / 3.0, work("color"), work("all"));
}

/// Textures of a transfer at one time, all at once.
void write_textures(const fs::path& folder, bool has_maps) {
  const transfer::TransferFolder transfer(folder / "transfer");
  const History& history = transfer.history();
  constexpr double kTime = 0.5;
  std::vector<transfer::TextureFile> files{{{folder / "color.png"}, history.sample(kTime)}};
  const auto add = [&](MaterialMap map, transfer::TextureKind kind) {
    const std::string name(kMaterialMapNames.at(static_cast<std::size_t>(map)));
    files.push_back(
        {{folder / (name + ".png")}, sample_material_map(history, map, kTime, Between::Blend), "", kind, ""});
  };
  if (has_maps) {
    add(MaterialMap::Normal, transfer::TextureKind::Normal);
    add(MaterialMap::Tint, transfer::TextureKind::Color);
    for (const MaterialMap map :
         {MaterialMap::Roughness, MaterialMap::Specular, MaterialMap::Metalness, MaterialMap::Height})
      add(map, transfer::TextureKind::Value);
  }
  transfer::TextureWriter(transfer, {.with_turns = has_maps}).write(files);
}

void lookup() {
  const testing_support::TempFolder folder;
  do_in_child([&] { benchmarks::write_patch_transfer(folder.path(), 4096, true); });
  compare(
      "lookup of 4096 x 4096, seven textures at once", 13.0 / 3.0, [&] { write_textures(folder.path(), false); },
      [&] { write_textures(folder.path(), true); });
}

void export_in_strips() {
  const testing_support::TempFolder folder;
  do_in_child([&] { benchmarks::write_patch_transfer(folder.path(), 8192, true); });
  for (const bool has_maps : {false, true}) {
    const ChildCost cost = cost_in_child([&] { write_textures(folder.path(), has_maps); });
    std::printf("8192 x 8192 in strips, %s: %.1f s of processor time, at most %.0f MB\n",
                has_maps ? "seven textures at once" : "color", cost.cpu_s, cost.peak_mb);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace patinate

int main(int argc, char** argv) {
  const std::string part = argc > 1 ? argv[1] : "";
  if (part.empty() || part == "ingest") patinate::ingest();
  if (part.empty() || part == "relit") patinate::ingest_relit();
  if (part.empty() || part == "transfer") {
    patinate::transfer_maps(12);
    patinate::transfer_maps(100);
  }
  if (part.empty() || part == "lookup") patinate::lookup();
  if (part.empty() || part == "export") patinate::export_in_strips();
}
