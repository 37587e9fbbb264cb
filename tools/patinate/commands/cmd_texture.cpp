#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "app/request/numbered_path.h"
#include "app/request/output_file.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/controls/control_expression.h"
#include "libcommon/controls/image_control.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/input_watch.h"
#include "libcommon/core/text.h"
#include "libcommon/image/image_rows.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/history/history_sampling.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/times_argument.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/commands/tile_files.h"
#include "transfer/lookup/texture_files.h"

namespace patinate::cli {

namespace {

/// Texture that is looked up.
struct LookedUp {
  enum class Map { Color, Normal, Roughness, Specular, Height, Stddev, Metalness, Tint, Base, Orm } map = Map::Color;
};
constexpr std::array<std::string_view, 10> kLookedUpNames{"color",  "normal",    "roughness", "specular", "height",
                                                          "stddev", "metalness", "tint",      "base",     "orm"};
void describe(OptionVisitor& v, LookedUp& o) {
  v.visit_choice(
      {"map",
       "Color, or what the history's frames hold beside it: normal (tangent space, y up), roughness or "
       "strength of the highlight, height in mm (.exr), stddev (deviation of the color, linear, .exr), metalness, "
       "tint (color of the mirror), base (base color of the metallic-roughness model), orm (1, roughness, "
       "metalness packed)"},
      o.map, kLookedUpNames);
}

struct LookupCommand {
  std::filesystem::path transfer;
  std::filesystem::path output;
  TimesArgument times;
  std::string time_map;
  SamplingOptions sampling;
  LookedUp looked_up;
};

/// One time (or time map) and the files of its tiles.
struct Texture {
  double time = 0.0;
  std::vector<std::filesystem::path> files;
  std::string key;
};

ContentHash begin_key(const LookupCommand& command, const transfer::TransferManifest& transfer) {
  ContentHash hash;
  hash.add("lookup 3").add(transfer.key);
  for (const auto& [name, value] : option_values(command.sampling)) hash.add(name).add(value);
  if (command.looked_up.map != LookedUp::Map::Color)
    hash.add(kLookedUpNames[static_cast<std::size_t>(command.looked_up.map)]);
  return hash;
}

/// Checks all before anything is written. @returns those that are to be made; nothing when nothing more is to be done.
std::optional<std::vector<Texture>> unfinished(CommandRun& run, const LookupCommand& command,
                                               const std::vector<Texture>& textures) {
  ContentHash all;
  std::vector<app::OutputPiece> pieces;
  for (const Texture& texture : textures) {
    pieces.push_back({.files = texture.files, .key = texture.key});
    all.add(texture.key);
  }
  const auto todo = unfinished_pieces(run, command.output, all.hex(), pieces);
  if (!todo) return std::nullopt;
  std::vector<Texture> chosen;
  for (const std::size_t i : *todo) chosen.push_back(textures[i]);
  return chosen;
}

void report(CommandRun& run, const LookupCommand& command, const std::vector<Texture>& textures, bool is_done) {
  const JobStatus status = is_done ? JobStatus::Done : JobStatus::UpToDate;
  if (textures.size() == 1)
    return report_tile_files(run, status, command.output, textures.front().files, Json::object());
  Json files = Json::array();
  for (const Texture& texture : textures) {
    for (const auto& file : texture.files) files.push_back(Json{{"time", texture.time}, {"file", file.string()}});
  }
  run.report_output(status, command.output, Json{{"images", files}});
}

transfer::TextureFile texture_file(const HistoryReader& history, const LookupCommand& command, const Texture& texture) {
  const Between between = command.sampling.between;
  if (command.looked_up.map == LookedUp::Map::Color)
    return {texture.files, sample(history, texture.time, between), texture.key};
  if (command.looked_up.map == LookedUp::Map::Base)
    return {texture.files, sample_base_color(history, texture.time, between), texture.key};
  if (command.looked_up.map == LookedUp::Map::Orm)
    return {texture.files, sample_orm(history, texture.time, between), texture.key, transfer::TextureKind::Packed};
  const auto map = static_cast<MaterialMap>(static_cast<int>(command.looked_up.map) - 1);  // Both have the same order.
  const auto kind = map == MaterialMap::Normal                               ? transfer::TextureKind::Normal
                    : map == MaterialMap::Stddev || map == MaterialMap::Tint ? transfer::TextureKind::Color
                                                                             : transfer::TextureKind::Value;
  return {texture.files, sample_material_map(history, map, texture.time, between), texture.key, kind,
          map == MaterialMap::Height ? "mm" : ""};
}

/// In groups: each goes through the coordinates once.
void write_textures(const transfer::TransferFolder& transfer, const LookupCommand& command,
                    const std::vector<Texture>& textures, const RunControl& control) {
  constexpr std::size_t kTogether = 8;
  transfer::TextureWriter writer(transfer, {.with_turns = command.looked_up.map == LookedUp::Map::Normal},
                                 control.part(0.0, 0.2));
  for (std::size_t begin = 0; begin < textures.size(); begin += kTogether) {
    const InputStep step;  // A group looks at the frames that it reads.
    const std::size_t end = std::min(textures.size(), begin + kTogether);
    std::vector<transfer::TextureFile> group;
    for (std::size_t i = begin; i < end; ++i) group.push_back(texture_file(transfer.history(), command, textures[i]));
    const auto share = [&](std::size_t i) {
      return 0.2 + 0.8 * static_cast<double>(i) / static_cast<double>(textures.size());
    };
    writer.write(group, control.part(share(begin), share(end)));
  }
}

/// Checks the command before anything is opened. @throws UsageError
void check_command(const LookupCommand& command) {
  app::require_extension(command.output, app::image_extensions());
  if (command.looked_up.map == LookedUp::Map::Height && is_coded_image(command.output))
    throw app::UsageError("--map height: is in mm; expected an .exr");
  if (command.looked_up.map == LookedUp::Map::Stddev && is_coded_image(command.output))
    throw app::UsageError("--map stddev: is linear and small; expected an .exr");
  if (command.looked_up.map != LookedUp::Map::Color && !command.time_map.empty())
    throw app::UsageError("--map: a time map looks up color; leave one of them out");
  if (command.time_map.empty() && !command.times.is_given())
    throw app::UsageError("--time: is missing; give --time, --times, --num-times or --time-map");
  const double num_times = command.times.count.value_or(static_cast<double>(command.times.times.size()));
  if (command.time_map.empty() && num_times > 1.0 && !app::has_number(command.output)) {
    throw app::UsageError("-o: found `" + command.output.string() + "` for " + number_text(num_times) +
                          " times; expected a name with a number in it, as texture_%04d.png");
  }
}

int lookup_times(CommandRun& run, const LookupCommand& command, const transfer::TransferFolder& transfer) {
  const std::vector<double> times = command.times.resolve(run, transfer.history().manifest(), 0);
  (void)texture_file(transfer.history(), command, {times.front(), {}, {}});  // Said before anything is written.
  std::vector<Texture> textures;
  for (double t : times) {
    const std::filesystem::path file = app::numbered_path(command.output, static_cast<int>(textures.size()));
    textures.push_back(
        {t, tile_files(file, transfer.sheet().names), begin_key(command, transfer.manifest()).add(t).hex()});
  }
  const auto todo = unfinished(run, command, textures);
  if (!todo) return 0;
  if (!todo->empty()) write_textures(transfer, command, *todo, run.control("texture"));
  report(run, command, textures, !todo->empty());
  return 0;
}

/// The times that 0 and 1 of the map stand for.
struct TimeRange {
  double low = 0.0;
  double high = 1.0;
};

TimeRange range_of(const LookupCommand& command, const ControlMap& map, bool is_file, const HistoryManifest& history) {
  if (!command.times.times.empty()) return {command.times.times[0], command.times.times[1]};
  if (is_file && (map.low != 0.0 || map.high != 1.0)) return {map.low, map.high};  // It holds times.
  return {history.frames.front().time, history.frames.back().time};
}

/// A time for every texel, over the sheet. What it takes to know them is gone before anything is looked up.
ImageF times_of(CommandRun& run, const LookupCommand& command, const transfer::TransferFolder& transfer, bool is_file) {
  const RunControl control = run.control("time map");
  const TexelMap texels(sheet_mesh(transfer.read_atlas(), transfer.sheet()), transfer.sheet(), control.part(0.0, 0.2));
  ControlMap map = make_control_expression(command.time_map, texels, {}, control.part(0.2, 1.0));
  const TimeRange range = range_of(command, map, is_file, transfer.history().manifest());
  run.detail("0 of the time map stands for " + short_number_text(range.low) + ", 1 for " +
             short_number_text(range.high));
  for (float& t : map.values.values())
    t = static_cast<float>(range.low + static_cast<double>(t) * (range.high - range.low));
  return std::move(map.values);
}

int lookup_time_map(CommandRun& run, const LookupCommand& command, const transfer::TransferFolder& transfer) {
  if (command.times.time || command.times.count || (!command.times.times.empty() && command.times.times.size() != 2)) {
    throw app::UsageError(
        "--time-map: takes --times LOW,HIGH, the times that 0 and 1 of the map stand for, or nothing");
  }
  const ControlExpression expression(command.time_map, control_kind_names());
  const bool is_file = expression.names().size() == 1 && expression.names()[0].is_file;
  ContentHash hash = begin_key(command, transfer.manifest());
  hash.add("time map").add(command.time_map);
  for (double t : command.times.times) hash.add(t);
  for (const ControlName& name : expression.names()) {
    if (!name.is_file) continue;
    for (const auto& file : tile_map_files(name.text, transfer.sheet().names)) hash.add_file(file);
  }
  const std::vector<Texture> textures{{0.0, tile_files(command.output, transfer.sheet().names), hash.hex()}};
  const auto todo = unfinished(run, command, textures);
  if (!todo) return 0;
  if (!todo->empty()) {
    ImageF at = times_of(run, command, transfer, is_file);
    transfer::write_time_map(transfer, std::move(at), command.sampling.between, textures[0].files, textures[0].key, {},
                             run.control("texture"));
  }
  report(run, command, textures, !todo->empty());
  return 0;
}

}  // namespace

int cmd_texture(CommandRun& run) {
  LookupCommand command;
  run.line.positional("TRANSFER", "A transfer folder", command.transfer);
  run.line.output("IMAGE",
                  "Texture to write: .png, .jpg or .tif in sRGB, .exr linear; texture_%04d.png for several times; with "
                  "tiles one each: "
                  "tex.1001.png, or where the name says <UDIM>",
                  command.output);
  command.times.declare(run.line);
  run.line.options(command.sampling);
  run.line.options(command.looked_up);
  run.line.option(
      "time_map", "MAP",
      "Time of every texel: a map file or an expression of controls; 0 and 1 stand for the two values of --times, "
      "or without --times for the first and last time of the history. A file with values outside [0, 1] "
      "holds times",
      command.time_map);
  run.line.example("texture copper_hydrant --time 120 -o hydrant_120.png");
  run.line.example("texture mold_hydrant --time 120 --map normal -o normal_120.png");
  run.line.example("texture copper_hydrant --num-times 24 -o hydrant_%04d.png");
  run.line.example("texture copper_hydrant --time-map height --times 480,0 -o younger_above.png");
  run.line.checked([&] { check_command(command); });
  if (!run.parse()) return 0;
  app::require_transfer(command.transfer);
  if (command.time_map.empty()) return lookup_times(run, command, transfer::TransferFolder(command.transfer));
  return lookup_time_map(run, command, transfer::TransferFolder(command.transfer));
}

}  // namespace patinate::cli
