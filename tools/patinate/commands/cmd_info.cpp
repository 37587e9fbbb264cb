#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/request/output_file.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "libcommon/image/between_pixels.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/transfer/transfer_reader.h"
#include "tools/patinate/command_line/command_run.h"
#include "tools/patinate/command_line/stats.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/info/path_actions.h"

namespace patinate::cli {

namespace {

struct CurvesArgument {
  std::filesystem::path file;   ///< "" = no curves.
  std::string by;               ///< A control of the history; "" = the whole surface.
  std::optional<double> bins;   ///< Bins of `by`; 5.
  std::vector<std::string> at;  ///< "x,y"
  void declare(CommandLine& line);
};

constexpr double kDefaultBins = 5.0, kMostBins = 1000.0;

/// Pixels of the history; of a transfer, one for each texel that shows it.
struct Region {
  std::string name;
  std::vector<std::uint32_t> pixels;
};

std::vector<std::uint32_t> pixels_of(const HistoryReader& history) {
  const ImageU8 mask = history.read_mask();
  std::vector<std::uint32_t> pixels;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] != 0) pixels.push_back(static_cast<std::uint32_t>(i));
  }
  return pixels;
}

/// -1 outside the charts.
std::int64_t pixel_of(const ImageF& coordinates, int width, std::int64_t texel) {
  const float x = coordinates.data()[2 * texel], y = coordinates.data()[2 * texel + 1];
  if (x < 0.0f) return -1;
  const NearestPixel at = nearest_pixel(x, y);
  return std::int64_t{at.y} * width + at.x;
}

std::vector<std::uint32_t> pixels_of(const transfer::TransferReader& transfer) {
  std::vector<std::uint32_t> pixels;
  for (std::int64_t i = 0; i < transfer.coordinates().num_pixels(); ++i) {
    const std::int64_t pixel = pixel_of(transfer.coordinates(), transfer.history().manifest().width, i);
    if (pixel >= 0) pixels.push_back(static_cast<std::uint32_t>(pixel));
  }
  return pixels;
}

/// Bins of equal width over the control's range; empty ones are excluded.
std::vector<Region> bins_of(const HistoryReader& history, const CurvesArgument& curves,
                            const std::vector<std::uint32_t>& pixels) {
  const double bins = curves.bins.value_or(kDefaultBins);
  if (!(bins >= 1.0 && bins <= kMostBins) || bins != std::floor(bins)) {
    throw app::UsageError("--bins: found `" + number_text(bins) + "`; expected an integer [1, 1000]");
  }
  const ControlFacts& control = history.control(curves.by);
  const ImageF values = history.read_control(curves.by);
  const double width = (control.high - control.low) / bins;
  std::vector<Region> regions;
  for (int i = 0; i < static_cast<int>(bins); ++i) {
    regions.push_back({control.name + " " + short_number_text(control.low + i * width) + " to " +
                           short_number_text(control.low + (i + 1) * width),
                       {}});
  }
  for (std::uint32_t pixel : pixels) {
    const double bin = std::min(std::floor(static_cast<double>(values.data()[pixel]) * bins), bins - 1.0);
    regions[static_cast<std::size_t>(bin)].pixels.push_back(pixel);
  }
  std::erase_if(regions, [](const Region& r) { return r.pixels.empty(); });
  return regions;
}

/// The texel or pixel of "x,y".
std::int64_t place_of(const std::string& text, int width, int height) {
  const std::vector<std::string> parts = split(text, ',');
  const std::optional<double> x = parts.size() == 2 ? parse_number(parts[0]) : std::nullopt,
                              y = x ? parse_number(parts[1]) : std::nullopt;
  if (!x || !y || *x != std::floor(*x) || *y != std::floor(*y) || !(*x >= 0 && *x < width && *y >= 0 && *y < height)) {
    throw app::UsageError("--at: found `" + text + "`; expected X,Y in whole pixels inside " +
                          size_text(width, height));
  }
  return static_cast<std::int64_t>(*y) * width + static_cast<std::int64_t>(*x);
}

std::string row_text(double time, const Region& region, const ColorSummary& now, const ColorSummary& first) {
  const auto cell = [](double v) { return "," + number_text(rounded(v, 6)); };
  std::string row = number_text(time) + "," + region.name + "," + std::to_string(now.num_pixels);
  if (now.num_pixels == 0) return row + std::string(25, ',') + "\n";
  row += cell(delta_e(now, first));
  for (const ChannelSummary& c : now.channels) row += cell(c.mean) + cell(c.p05) + cell(c.p50) + cell(c.p95);
  return row + "\n";
}

std::string csv_of(CommandRun& run, const HistoryReader& history, const std::vector<Region>& regions) {
  std::string text = "time (" + shown_time_unit(history.manifest().time_unit) + "),region,pixels,delta_e";
  for (const char* channel : {"R", "G", "B", "L", "a", "b"}) {
    for (const char* figure : {"mean", "p05", "p50", "p95"}) text += std::string(",") + channel + "_" + figure;
  }
  text += "\n";
  std::vector<ColorSummary> first(regions.size());
  const RunControl control = run.control("curves");
  for (int f = 0; f < history.num_frames(); ++f) {
    control.throw_if_stopped();
    const ImageF frame = history.read_frame(f);
    const HistoryFrame& entry = history.manifest().frames[f];
    const ImageU8 valid = entry.mask ? history.read_frame_mask(f) : ImageU8();
    for (std::size_t r = 0; r < regions.size(); ++r) {
      std::vector<std::uint32_t> pixels = regions[r].pixels;
      if (entry.mask) std::erase_if(pixels, [&](std::uint32_t p) { return valid.data()[p] == 0; });
      const ColorSummary now = summarize_color(frame, pixels);
      if (first[r].num_pixels == 0) first[r] = now;
      text += row_text(entry.time, regions[r], now, first[r]);
    }
    control.report((f + 1.0) / history.num_frames());
  }
  return text;
}

std::vector<Region> regions_of(const CurvesArgument& curves, const HistoryReader& history,
                               const transfer::TransferReader* transfer) {
  const std::vector<std::uint32_t> all = transfer != nullptr ? pixels_of(*transfer) : pixels_of(history);
  std::vector<Region> regions{{"all", all}};
  if (!curves.by.empty()) {
    for (Region& bin : bins_of(history, curves, all)) regions.push_back(std::move(bin));
  }
  for (const std::string& at : curves.at) {
    std::int64_t pixel = 0;
    if (transfer == nullptr) {
      pixel = place_of(at, history.manifest().width, history.manifest().height);
    } else {
      const ImageF& coordinates = transfer->coordinates();
      pixel = pixel_of(coordinates, history.manifest().width, place_of(at, coordinates.width(), coordinates.height()));
      if (pixel < 0) throw app::UsageError("--at: texel " + at + " belongs to no chart");
    }
    regions.push_back({"at " + number_text(parse_number(split(at, ',')[0]).value_or(0)) + " " + split(at, ',')[1],
                       {static_cast<std::uint32_t>(pixel)}});
  }
  return regions;
}

void CurvesArgument::declare(CommandLine& line) {
  line.option("curves", "FILE.csv", "Color over time of a history or transfer, as CSV", file);
  line.written();
  line.option("by", "CONTROL", "Also make curves for bins of a control, of equal width", by);
  line.option("bins", "N", "Bins of --by, [1, 1000]; default 5", bins);
  line.repeated("at", "X,Y", "Curves of this pixel (of a transfer: texel) too", at);
}

/// Writes the CSV: a row for each frame and region. `pixels` of a transfer are its texels.
/// @returns the command's exit code.
int write_curves(CommandRun& run, const CurvesArgument& curves, const std::filesystem::path& subject) {
  app::require_extension(curves.file, {".csv"});
  const app::PathKind kind = app::kind_of(subject);
  if (kind != app::PathKind::History && kind != app::PathKind::Transfer) {
    throw InvalidInput(subject.string() + ": is no history or transfer, and has no curves");
  }
  std::unique_ptr<const transfer::TransferReader> transfer;
  if (kind == app::PathKind::Transfer) transfer = std::make_unique<const transfer::TransferReader>(subject);
  const HistoryReader history(transfer ? transfer->history().folder() : subject,
                              transfer ? transfer->manifest().footprint_px : 1.0);
  const std::string text = csv_of(run, history, regions_of(curves, history, transfer.get()));
  const std::optional<JobStatus> status = run.check_files({app::text_file(curves.file, text)}, app::kSameText);
  if (!status) return 0;
  if (*status == JobStatus::Done) write_atomically(curves.file, text);
  run.report_output(*status, curves.file);
  return 0;
}

}  // namespace

int cmd_info(CommandRun& run) {
  std::filesystem::path path;
  run.line.positional("PATH", path_kinds_text(), path);
  CurvesArgument curves;
  curves.declare(run.line);
  StatsArgument stats;
  stats.declare(run.line);
  run.line.without({"seed", "dry_run"});
  run.line.example("info copper");
  run.line.example("info bust.glb --json");
  run.line.example("info crackle --curves curves.csv --by thickness --bins 4 --at 120,80");
  run.line.example("info crackle --stats --csv crackle.csv");
  run.line.example("info banana --stats --class green=#919e39 --class brown=#5c361f");
  if (!run.parse()) return 0;
  if (!curves.file.empty()) return write_curves(run, curves, path);
  if (!stats.csv.empty() && !stats.is_asked) throw app::UsageError("--csv: is of --stats; give both");
  if (stats.is_asked) return report_stats(run, stats, path);
  facts_of(path).report(run);
  return 0;
}

}  // namespace patinate::cli
