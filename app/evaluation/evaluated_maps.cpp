#include "app/evaluation/evaluated_maps.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "app/request/path_kind.h"
#include "app/request/repeating_command.h"
#include "app/request/usage_error.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "transfer/files/flow_io.h"
#include "transfer/synthesis/map_audit.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::app {

namespace fs = std::filesystem;

namespace {

ImageF codes_of(const ImageF& linear) {
  const ImageU8 codes = srgb8_from_linear(linear);
  ImageF out(codes.width(), codes.height(), codes.channels());
  std::copy(codes.values().begin(), codes.values().end(), out.values().begin());
  return out;
}

/// Evenly spread frames, the last among them.
std::vector<int> frames_to_compare(int num_frames, int num_times) {
  std::vector<int> out;
  const int n = std::min(num_frames, num_times);
  for (int i = 0; i < n; ++i) out.push_back(n == 1 ? num_frames - 1 : i * (num_frames - 1) / (n - 1));
  return out;
}

}  // namespace

analysis::SynthesisSource evaluated_source(const History& history, const std::string& control, double pixel_mm,
                                           int num_times) {
  analysis::SynthesisSource source;
  for (int frame : frames_to_compare(history.num_frames(), num_times))
    source.frames.push_back(codes_of(history.read_frame(frame)));
  source.mask = history.read_mask();
  if (!control.empty()) source.control = history.read_control(control);
  source.pixel_mm = pixel_mm;
  return source;
}

namespace {

analysis::Figure energy_figure(const char* name, const char* title, std::optional<double> value,
                               const std::string& undefined = {}) {
  return {.name = name, .title = title, .unit = "", .value = value, .undefined = value ? "" : undefined};
}

std::vector<analysis::Figure> energy_figures(const transfer::EnergyReport& energy) {
  return {energy_figure("energy", "Energy (M1)", energy.energy),
          energy_figure("energy_coherence", "Energy, part of coherence (M1)", energy.coherence),
          energy_figure("energy_control", "Energy, part of control (M1)", energy.control_mismatch)};
}

/// @param why  Why nothing was audited; "" when it was tried.
void add_audit(std::vector<analysis::Figure>& figures, const transfer::OptimumAudit& audit,
               const std::string& why = {}) {
  const bool has = audit.num_audited > 0;
  const std::string none =
      why.empty() ? "no audited texel shows a pixel whose whole neighborhood lies in the source" : why;
  const std::string undefined = has ? "the least energy is 0" : none;
  const auto drawn = static_cast<double>(audit.num_audited + audit.num_excluded);
  const auto known = [](bool is_known, double value) { return is_known ? std::optional(value) : std::nullopt; };
  figures.push_back(
      energy_figure("audit_ratio", "Energy over the optimum, neighbors held fixed (M1)", audit.ratio, undefined));
  figures.push_back(
      energy_figure("audit_ratio_median", "The same texel by texel, median (M1)", audit.median_ratio, undefined));
  figures.push_back(energy_figure("audit_optimal_share", "Texels that no other pixel serves better (M1)",
                                  known(has, audit.optimal_share), none));
  figures.push_back(energy_figure("audit_energy", "Energy of the audited texels (M1)", known(has, audit.energy), none));
  figures.push_back(energy_figure("audit_excluded", "Not audited: their pixel lies too near the source's border (M1)",
                                  known(drawn > 0.0, static_cast<double>(audit.num_excluded) / std::max(1.0, drawn)),
                                  none));
}

}  // namespace

std::vector<analysis::Figure> transfer_figures(const transfer::TransferManifest& manifest,
                                               const std::optional<transfer::OptimumAudit>& audit) {
  std::vector<analysis::Figure> figures = energy_figures(manifest.energy);
  if (audit) add_audit(figures, *audit);
  return figures;
}

namespace {

ImageF read_nnf(const fs::path& file, int width, int height) {
  const std::string bytes = read_file(file);
  const std::size_t expected = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 8;
  if (bytes.size() != expected) {
    throw IoError(file.string(), "has " + std::to_string(bytes.size()) + " bytes; expected " +
                                     std::to_string(expected) + ": a pair of int32 for each of " +
                                     size_text(width, height) + " texels");
  }
  static_assert(std::endian::native == std::endian::little);
  std::vector<std::int32_t> values(bytes.size() / 4);
  std::memcpy(values.data(), bytes.data(), bytes.size());
  ImageF out(width, height, 2);
  std::transform(values.begin(), values.end(), out.values().begin(),
                 [](std::int32_t v) { return static_cast<float>(v); });
  return out;
}

/// @param size  Of an image that says how large the map is, where the file does not.
ImageF read_coordinates(const fs::path& file, const ImageF& size) {
  const std::string extension = lower_extension(file);
  if (extension == ".nnf") {
    if (size.empty()) throw IoError(file.string(), "does not say its size; give --control or --picture");
    return read_nnf(file, size.width(), size.height());
  }
  const ImageInfo info = probe_image(file);
  const auto has = [&](const char* name) {
    return std::find(info.channels.begin(), info.channels.end(), name) != info.channels.end();
  };
  if (has(transfer::kCoordinateChannels[0]) && has(transfer::kCoordinateChannels[1]))
    return read_channels(file, {transfer::kCoordinateChannels[0], transfer::kCoordinateChannels[1]});
  if (info.channels.size() < 2) throw IoError(file.string(), "has one channel; a coordinate map has x and y");
  ImageF out = read_channels(file, {info.channels[0], info.channels[1]});
  if (extension == ".png") {  // Codes, not shares of 65535.
    for (float& v : out.values()) v = std::round(v * 65535.0f);
  }
  return out;
}

/// Facts that an audit needs beside the map itself.
struct AuditedMaking {
  const History& history;  ///< Its pixels, as the maker compared them.
  double pixel_mm = 1.0;
  std::vector<transfer::FollowedControl> controls;
  ImageU8 source_mask = {};
  transfer::TransferOptions options = {};
  transfer::AppearanceSource appearance = {};
};

/// The one way from a map, wherever it comes from, to the figures of its audit.
void audit(analysis::MapToEvaluate& of, AuditedMaking making, const analysis::EvaluationOptions& options,
           std::uint64_t seed, const RunControl& control) {
  if (options.num_audits == 0) return;
  const transfer::MapToAudit made{.surface = of.map.surface,
                                  .coordinates = of.map.coordinates,
                                  .pixel_mm = making.pixel_mm,
                                  .controls = std::move(making.controls),
                                  .frames = of.map.frames,
                                  .turns = of.map.turns,
                                  .source_mask = std::move(making.source_mask)};
  add_audit(of.more, transfer::audit_map(making.history, made, making.options, options.num_audits, seed, control,
                                         making.appearance));
}

}  // namespace

analysis::EvaluationItem transfer_item(const fs::path& transfer, const analysis::EvaluationOptions& options,
                                       std::uint64_t seed, const transfer::CacheOptions& cache) {
  const transfer::TransferManifest manifest = transfer::read_transfer_manifest(transfer);
  const std::string name = input_name(transfer);
  std::string about = "transfer " + name + ", history " + input_name(manifest.history);
  for (const transfer::RecordedControl& c : manifest.controls) about += ", " + c.text();
  return {.name = name,
          .about = about,
          .key = manifest.key,
          .open = [transfer, name, options, seed, cache](const RunControl& control) {
            const transfer::TransferReader reader(transfer);
            const transfer::TransferManifest& m = reader.manifest();
            analysis::MapToEvaluate out;
            out.source = evaluated_source(reader.history(), m.controls.empty() ? "" : m.controls.front().source,
                                          m.texel_size_mm, options.num_times);
            out.source.mask = reader.source_mask();
            out.map = {.name = name,
                       .surface = std::make_shared<TexelMap>(reader.mesh(), reader.sheet(), control.part(0.0, 0.3)),
                       .coordinates = reader.coordinates(),
                       .control = m.controls.empty() ? ImageF() : reader.matched_control(0)};
            transfer::LaidFlow flow = transfer::read_flow(m, *out.map.surface);
            out.map.frames = std::move(flow.frames);
            out.map.turns = std::move(flow.turns);
            out.more = energy_figures(m.energy);
            if (options.num_audits == 0) return out;
            const HistoryReader history(reader.history().folder());
            AuditedMaking making{.history = history,
                                 .pixel_mm = m.texel_size_mm,
                                 .controls = {},
                                 .source_mask = out.source.mask,
                                 .options = m.measured_with,
                                 .appearance = transfer::appearance_source(history, cache)};
            for (std::size_t i = 0; i < m.controls.size(); ++i)
              making.controls.push_back({m.controls[i].source, reader.matched_control(i), m.controls[i].weight});
            audit(out, std::move(making), options, seed, control.part(0.3, 1.0));
            return out;
          }};
}

analysis::MapToEvaluate aged_map(const std::string& name, const transfer::AgedMesh& aged,
                                 const analysis::EvaluationOptions& options, std::uint64_t seed,
                                 const RunControl& control) {
  const ImageU8 mask = transfer::usable_mask(*aged.history, {});
  const transfer::MatchedControls matched =
      transfer::match_controls(*aged.history, mask, aged.controls, aged.coverage, control.part(0.0, 0.1));
  // Stored form, so that figures do not depend on whether there was a folder.
  const transfer::LaidFlow flow = transfer::as_stored(aged.frames, aged.turns, *aged.surface.map);
  analysis::MapToEvaluate out;
  out.source =
      evaluated_source(*aged.shown, aged.controls.front().source, aged.surface.texel_size_mm, options.num_times);
  out.source.mask = mask;
  out.map = {.name = name,
             .surface = aged.surface.map,
             .coordinates = aged.coordinates,
             .control = matched.destination.front(),
             .frames = flow.frames,
             .turns = flow.turns};
  out.more = energy_figures(aged.energy);
  AuditedMaking making{.history = *aged.history,
                       .pixel_mm = aged.surface.texel_size_mm,
                       .controls = {},
                       .source_mask = mask,
                       .options = aged.used};
  for (std::size_t i = 0; i < aged.controls.size(); ++i)
    making.controls.push_back({aged.controls[i].source, matched.destination[i], aged.controls[i].weight});
  audit(out, std::move(making), options, seed, control.part(0.1, 1.0));
  return out;
}

std::string named_control(const std::string& spec) {
  const std::size_t at = spec.find('=');  // npos + 1 is 0.
  return spec.substr(0, at + 1) + input_name(spec.substr(at + 1));
}

analysis::EvaluationItem foreign_item(const fs::path& map, const ForeignMapOptions& foreign,
                                      const analysis::EvaluationOptions& options, std::uint64_t seed,
                                      const transfer::CacheOptions& cache) {
  if (foreign.history.empty())
    throw UsageError("--history: is needed for " + map.string() +
                     ", which is no transfer: the history that the tool copied from");
  const HistoryReader history(foreign.history);
  const std::optional<transfer::ControlSpec> spec =
      foreign.control.empty() ? std::nullopt : std::optional(transfer::parse_control_spec(foreign.control));
  if (spec && (spec->weight != 1.0 || spec->mapping))
    throw UsageError(
        "--control: weight and mapping are the tool's own; give [SOURCE=]MAP with the values that the tool was given");
  const std::string source_name = spec ? transfer::source_control(history, *spec) : "";
  ContentHash hash;
  hash.add_file(map).add(transfer::history_content_key(history)).add(source_name);
  if (spec) hash.add_file(spec->destination);
  if (!foreign.picture.empty()) hash.add_file(foreign.picture);
  return {
      .name = map.stem().string(),
      .about = "coordinates " + input_name(map) + ", history " + input_name(foreign.history) +
               (spec ? ", " + named_control(foreign.control) : ""),
      .key = hash.hex(),
      .open = [map, foreign, spec, source_name, options, seed, cache](const RunControl& control) {
        const HistoryReader source(foreign.history);
        analysis::MapToEvaluate out;
        out.source = evaluated_source(source, source_name, 1.0, options.num_times);
        const ImageF wanted = spec ? read_gray(spec->destination) : ImageF();
        if (!foreign.picture.empty())
          out.made = analysis::MadePicture{.frame = out.source.frames.size() - 1,
                                           .codes = codes_of(read_color(foreign.picture))};
        out.map.name = map.filename().string();
        out.map.coordinates = read_coordinates(map, !wanted.empty() ? wanted : out.made ? out.made->codes : ImageF());
        for (float& place : out.map.coordinates.values()) place = std::floor(place + 0.5f);  // Copied pixel by pixel.
        out.map.surface = analysis::flat_surface(out.map.coordinates.width(), out.map.coordinates.height(), 1.0);
        if (!spec) {
          if (options.num_audits > 0) add_audit(out.more, {}, "no control was given");
          return out;
        }
        if (!wanted.same_size(out.map.coordinates)) {
          throw IoError(spec->destination, "is " + size_text(wanted.width(), wanted.height()) +
                                               "; the coordinate map is " +
                                               size_text(out.map.coordinates.width(), out.map.coordinates.height()));
        }
        out.map.control = wanted;
        audit(out,
              {.history = source,
               .pixel_mm = options.source_step > 0 ? 1.0 / options.source_step : 1.0,
               .controls = {{source_name, wanted}},
               .appearance = transfer::appearance_source(source, cache)},
              options, seed, control);
        return out;
      }};
}

}  // namespace patinate::app
