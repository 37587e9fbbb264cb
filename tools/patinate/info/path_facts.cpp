#include "tools/patinate/info/path_facts.h"

#include <nlohmann/json.hpp>

#include "analysis/explanation/explanation_report.h"
#include "analysis/factorization/factorization_document.h"
#include "analysis/fit/fit_job.h"
#include "analysis/report/analysis_documents.h"
#include "app/request/path_kind.h"
#include "capture/project/capture_project.h"
#include "capture/project/frame_times.h"
#include "capture/project/relit_project.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/topology.h"
#include "libcommon/history/history_card.h"
#include "libcommon/history/history_documents.h"
#include "libcommon/history/history_times.h"
#include "libcommon/image/filters.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/atlas/atlas_mesh.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/transfer/transfer_io.h"
#include "simulation/job/simulation_job.h"

namespace patinate::cli {

Facts history_facts(const std::filesystem::path& path) {
  const HistoryReader history(path);
  const HistoryManifest& m = history.manifest();
  const std::string unit = shown_time_unit(m.time_unit);
  Facts facts("history");
  facts.add("name", m.name);
  facts.add("origin", m.origin);
  if (const std::optional<HistoryCard> card = read_history_card(history.folder())) {
    facts.add("title", card->title);
    facts.add("license", card->license);
    facts.add("attribution", card->attribution);
    if (!card->source.empty()) facts.add("source", card->source);
  }
  facts.add("size", Json{m.width, m.height}, size_text(m.width, m.height));
  Json times = Json::array(), controls = Json::array(), extrapolated = Json::array();
  std::string unseen;
  for (const HistoryFrame& frame : m.frames) {
    times.push_back(frame.time);
    if (!frame.is_extrapolated) continue;
    extrapolated.push_back(frame.time);
    unseen += (unseen.empty() ? "" : ", ") + short_number_text(frame.time);
  }
  facts.add("times", times,
            std::to_string(m.frames.size()) + " frames, " + short_number_text(m.frames.front().time) + " to " +
                short_number_text(m.frames.back().time) + " " + unit);
  if (!extrapolated.empty()) facts.add("extrapolated", extrapolated, unseen + " " + unit + ": not observed");
  facts.add("time_unit", time_unit_text(m.time_unit), "");
  if (m.texel_size_mm) facts.add("texel_size_mm", *m.texel_size_mm, short_number_text(*m.texel_size_mm));
  std::string shown;
  for (const ControlParameter& c : m.controls) {
    controls.push_back(Json{{"name", c.name}, {"range", {c.low, c.high}}, {"unit", c.unit}});
    shown += (shown.empty() ? "" : "; ") + c.name + ", " + short_number_text(c.low) + " to " +
             short_number_text(c.high) + " " + c.unit;
    if (const auto deviation = history.read_control_deviation(c.name)) {
      const double usual =
          (c.high - c.low) * static_cast<double>(percentiles(*deviation, history.read_mask(), 0.5, 0.5).low);
      controls.back()["deviation"] = usual;
      shown += ", deviation " + short_number_text(rounded(usual, 3));
    }
  }
  facts.add("controls", controls, shown.empty() ? "none" : shown);
  std::string warned;
  for (const HistoryWarning& w : m.warnings) warned += "\n    " + warning_text(w);
  facts.add("warnings", warnings_json(m.warnings), m.warnings.empty() ? "none" : warned);
  std::string maps;
  for (std::string_view name : kFrameExtraNames) {
    const auto count = std::count_if(m.frames.begin(), m.frames.end(), [&](const HistoryFrame& f) {
      return std::any_of(f.extras.begin(), f.extras.end(), [&](const HistoryImage& e) { return e.name == name; });
    });
    if (count == 0) continue;
    maps += (maps.empty() ? "" : ", ") + std::string(name);
    if (count < std::ssize(m.frames)) maps += " (" + std::to_string(count) + " frames)";
  }
  facts.add("frame_maps", maps, maps.empty() ? "none" : maps);
  std::string constant;
  for (const HistoryMap& map : m.maps) constant += (constant.empty() ? "" : ", ") + map.name;
  if (!constant.empty()) facts.add("constant_maps", constant);
  facts.add("mask", m.mask.has_value(), m.mask ? "yes" : "no");
  Json library = Json::array();
  std::string parts;
  for (const LibraryPart& part : m.parts) {
    parts += (parts.empty() ? "" : "; ") + std::to_string(library.size()) + " " + part.name + ", " +
             size_text(part.width, part.height);
    library.push_back(Json{{"name", part.name}, {"x", part.x}, {"width", part.width}, {"height", part.height}});
  }
  if (!library.empty()) facts.add("library", library, parts);
  facts.add("key", m.key);
  return facts;
}

Facts transfer_facts(const std::filesystem::path& path) {
  const transfer::TransferManifest m = transfer::read_transfer_manifest(path);
  Facts facts("transfer");
  facts.add("history", m.history.string());
  facts.add("atlas", Json{m.width, m.height}, size_text(m.width, m.height) + (m.is_unwrapped ? ", unwrapped" : ""));
  std::string tiles;
  for (const transfer::TransferTile& tile : m.tiles) tiles += (tiles.empty() ? "" : ", ") + tile.name;
  if (!tiles.empty()) facts.add("tiles", m.sheet().names, tiles);
  std::string shown;
  Json controls = Json::array();
  for (const transfer::RecordedControl& c : m.controls) {
    shown += (shown.empty() ? "" : "; ") + c.text();
    controls.push_back(c.text());
  }
  facts.add("controls", controls, shown);
  facts.add("energy", m.energy.energy, short_number_text(m.energy.energy));
  facts.add("control_error_mean", m.energy.control_error_mean, short_number_text(m.energy.control_error_mean));
  facts.add("coherent_share", m.energy.coherent_share, short_number_text(m.energy.coherent_share));
  facts.add("key", m.key);
  return facts;
}

namespace {

std::string joined_or_none(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text.empty() ? "none" : text;
}

}  // namespace

Facts simulation_facts(const std::filesystem::path& path) {
  const simulation::SimulationManifest m = simulation::read_simulation_manifest(path);
  Facts facts("simulation");
  facts.add("name", m.name);
  facts.add("scene", m.scene.string());
  facts.add("iterations", m.iterations);
  facts.add("time", m.time, short_number_text(m.time) + " " + time_unit_text(m.time_unit));
  facts.add("atlas", Json{m.resolution, m.resolution}, size_text(m.resolution, m.resolution));
  facts.add("materials", m.materials, joined_or_none(m.materials));
  facts.add("controls", m.control_names(), joined_or_none(m.control_names()));
  facts.add("key", m.key);
  return facts;
}

Facts factorization_facts(const std::filesystem::path& path) {
  const analysis::FactorizationManifest m = analysis::read_factorization(path);
  Facts facts("factorization");
  facts.add("name", m.name);
  facts.add("size", Json{m.width, m.height}, size_text(m.width, m.height));
  const analysis::TemporalCurve& curve = m.models.front().curve;
  facts.add("clock", Json{curve.low, curve.high},
            short_number_text(rounded(curve.low, 4)) + " to " + short_number_text(rounded(curve.high, 4)) + " " +
                shown_time_unit(m.time_unit) + ", " +
                (m.models.size() == 1 ? "one for all channels" : "red; others for green and blue"));
  const std::int64_t extrapolated = m.num_extrapolated();
  facts.add("frames", static_cast<std::int64_t>(m.frames.size()) - extrapolated);
  facts.add("extrapolated", extrapolated, extrapolated == 0 ? "none" : std::to_string(extrapolated) + ", not observed");
  for (const analysis::ListedFigure& listed : m.figures) {
    const analysis::Figure& f = listed.figure;
    facts.add(f.name, f.value ? short_number_text(rounded(*f.value, 4)) + " " + f.unit : "undefined: " + f.undefined);
  }
  facts.add("history", m.history.string());
  facts.add("key", m.origin_of_report.key);
  return facts;
}

Facts fit_facts(const std::filesystem::path& path) {
  const analysis::FitManifest m = analysis::read_fit_manifest(path);
  Facts facts("fit");
  facts.add("model", m.model);
  facts.add("history", m.history);
  const double before = m.objective_before.value_or(0.0);
  facts.add("objective", Json{before, m.objective_after},
            short_number_text(rounded(before, 4)) + " before, " + short_number_text(rounded(m.objective_after, 4)) +
                " after");
  facts.add("evaluations", static_cast<std::int64_t>(m.num_agings));
  facts.add("converged", m.is_converged, m.is_converged ? "yes" : "no");
  for (const analysis::FittedNumber& n : m.numbers) {
    facts.add(
        n.name(), Json{{"initial", n.initial}, {"best", n.best}, {"verdict", n.verdict}},
        short_number_text(rounded(n.initial, 4)) + " -> " + short_number_text(rounded(n.best, 4)) + "; " + n.verdict);
  }
  facts.add("key", m.origin.key);
  return facts;
}

Facts explanation_facts(const std::filesystem::path& path) {
  const analysis::ExplanationManifest m = analysis::read_explanation(path);
  Facts facts("explanation");
  facts.add("reference", m.reference);
  facts.add("mesh", m.mesh);
  facts.add("verdict", m.verdict);
  Json candidates = Json::array();
  std::string shown;
  for (const auto& c : m.candidates) {
    Json entry{{"name", c.found.name}};
    shown += "\n    " + c.found.name + ": ";
    if (!c.found.is_even) {
      const double correlation = c.found.figures.correlation, corrected_p = c.found.figures.corrected_p;
      entry["correlation"] = correlation;
      entry["corrected_p"] = corrected_p;
      shown +=
          short_number_text(rounded(correlation, 2)) + ", corrected p " + short_number_text(rounded(corrected_p, 2));
    } else {
      shown += "the same everywhere";
    }
    candidates.push_back(std::move(entry));
  }
  facts.add("candidates", candidates, shown);
  facts.add("mix", m.mix ? m.mix->argument : "");
  facts.add("key", m.origin.key);
  return facts;
}

namespace {

std::filesystem::path report_file(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return path;
  const std::filesystem::path evaluation = path / "evaluation.json";
  return std::filesystem::exists(evaluation, error) ? evaluation : path / "report.json";
}

/// "0.5 mm", or why there is none.
std::string figure_line(const Json& figure) {
  if (figure.at("value").is_null()) return "undefined, " + figure.at("undefined").get<std::string>();
  const std::string unit = figure.at("unit").get<std::string>();
  return short_number_text(rounded(figure.at("value").get<double>(), 3)) + (unit.empty() ? "" : " " + unit);
}

void add_figures(Facts& facts, const std::string& name, const Json& figures) {
  std::string shown = std::to_string(figures.size());
  for (const Json& f : figures) shown += "\n    " + f.at("name").get<std::string>() + ": " + figure_line(f);
  facts.add(name, figures, shown);
}

}  // namespace

void check_report(const std::filesystem::path& path) {
  const std::filesystem::path file = report_file(path);
  const Json json = load_json(file);
  const std::string format = JsonReader(file.string(), json).member("format").string();
  if (format == "patinate.evaluation") return analysis::check_evaluation(file);
  if (format == "patinate.grade") return analysis::check_grade_report(file);
  if (format == "patinate.grade_groups") return analysis::check_grade_groups(file);
  if (format == "patinate.replicates") return analysis::check_replicates_report(file);
  analysis::check_compare_report(file);
}

Facts report_facts(const std::filesystem::path& path) {
  check_report(path);
  const Json json = load_json(report_file(path));
  const std::string format = json.at("format").get<std::string>();
  Facts facts(format == "patinate.evaluation"     ? "evaluation"
              : format == "patinate.grade"        ? "grades"
              : format == "patinate.grade_groups" ? "grades of groups"
              : format == "patinate.replicates"   ? "comparison of replicates"
                                                  : "comparison");
  if (format == "patinate.evaluation") {
    for (const Json& map : json.at("maps")) add_figures(facts, map.at("name").get<std::string>(), map.at("figures"));
  } else if (format == "patinate.grade") {
    std::string shown;
    for (const Json& line : json.at("summary")) shown += "\n    " + line.get<std::string>();
    facts.add("summary", json.at("summary"), shown);
  } else if (format == "patinate.replicates" || format == "patinate.grade_groups") {
    std::string shown;
    for (const Json& sentence : json.at("verdict")) shown += "\n    " + sentence.get<std::string>();
    facts.add("verdict", json.at("verdict"), shown);
  } else {
    for (const char* side : {"a", "b"}) facts.add(side, json.at(side).at("name").get<std::string>());
    add_figures(facts, "figures", json.at("figures"));
  }
  facts.add("command", json.at("command").get<std::string>());
  facts.add("key", json.at("key").get<std::string>());
  return facts;
}

namespace {

Facts relit_facts(const capture::RelitProject& project) {
  Facts facts("capture");
  facts.add("name", project.name);
  facts.add("capture_kind", "relit", "a scan and one photograph per light at every step");
  facts.add("photographs", Json{project.width(), project.height()}, size_text(project.width(), project.height()));
  facts.add("lights", static_cast<std::int64_t>(project.lights.size()));
  Json times = Json::array();
  for (const capture::RelitStep& step : project.steps) times.push_back(step.time);
  const std::string unit = shown_time_unit(project.time_unit);
  facts.add("times", times,
            std::to_string(project.steps.size()) + " steps, " + short_number_text(project.steps.front().time) + " to " +
                short_number_text(project.steps.back().time) + " " + unit);
  facts.add("time_unit", time_unit_text(project.time_unit), "");
  return facts;
}

}  // namespace

Facts capture_facts(const std::filesystem::path& path) {
  if (capture::is_relit_capture(capture::capture_file(path)))
    return relit_facts(capture::read_relit_project(capture::capture_file(path)));
  const capture::CaptureProject project = capture::read_capture_project(capture::capture_file(path));
  const std::string unit = shown_time_unit(project.time_unit);
  Facts facts("capture");
  facts.add("name", project.name);
  facts.add("photographs", Json{project.photo_width, project.photo_height},
            size_text(project.photo_width, project.photo_height));
  facts.add("size", Json{project.width(), project.height()}, size_text(project.width(), project.height()));
  Json times = Json::array();
  for (const capture::CapturePhoto& frame : project.frames) times.push_back(frame.time);
  facts.add("times", times,
            std::to_string(project.frames.size()) + " frames, " + short_number_text(project.frames.front().time) +
                " to " + short_number_text(project.frames.back().time) + " " + unit + " (from " + project.time_source +
                (project.time_span.empty() ? "" : ", " + project.time_span) + ")");
  facts.add("time_unit", time_unit_text(project.time_unit), "");
  facts.add("transmission", project.transmission.has_value(), project.transmission ? "yes" : "no");
  return facts;
}

namespace {

/// Adds a photograph's exposure by EXIF, where it says something.
void add_exposure(Facts& facts, const ImageExposure& exposure) {
  if (exposure.time_s > 0.0)
    facts.add("exposure_time_s", exposure.time_s,
              exposure.time_s < 0.4 ? "1/" + short_number_text(std::round(1.0 / exposure.time_s)) + " s"
                                    : short_number_text(exposure.time_s) + " s");
  if (exposure.f_number > 0.0) facts.add("f_number", exposure.f_number, "f/" + short_number_text(exposure.f_number));
  if (exposure.iso > 0.0) facts.add("iso", exposure.iso, short_number_text(exposure.iso));
  if (exposure.white_balance != ImageExposure::WhiteBalance::Unknown)
    facts.add("white_balance", exposure.white_balance == ImageExposure::WhiteBalance::Auto ? "auto" : "manual");
}

}  // namespace

Facts image_facts(const std::filesystem::path& path) {
  const ImageInfo info = probe_image(path);
  Facts facts("image");
  facts.add("size", Json{info.width, info.height}, size_text(info.width, info.height));
  std::string channels;
  for (const std::string& c : info.channels) channels += (channels.empty() ? "" : " ") + c;
  facts.add("channels", info.channels, channels);
  facts.add("values", info.is_integer ? "integer codes" : "floating point");
  for (const auto& [name, text] : info.facts.named()) facts.add(name, text);
  if (info.num_frames > 1) facts.add("frames", info.num_frames);
  if (!info.frame_times_s.empty()) {
    facts.add("frame_times_s", info.frame_times_s,
              "shown from 0 to " + short_number_text(info.frame_times_s.back()) + " s");
  }
  const std::string time = capture::photo_time_text(path, info);
  if (!time.empty()) facts.add("time", time);
  add_exposure(facts, info.exposure);
  if (info.scale) {
    const ValueScale& s = *info.scale;
    const std::string unit = s.unit.empty() ? "" : " " + s.unit;
    facts.add("range", Json{s.low, s.high},
              "0 stands for " + short_number_text(s.low) + ", 1 for " + short_number_text(s.high) + unit);
    facts.add("unit", s.unit, "");
  }
  if (!info.key.empty()) facts.add("key", info.key);
  return facts;
}

Facts mesh_facts(const std::filesystem::path& path) {
  std::vector<std::string> notes;
  std::string shown_notes;
  const Mesh mesh = read_mesh(path, &notes);
  const Box box = bounding_box(mesh);
  const Vec3 extent = box.high - box.low;
  Facts facts("mesh");
  facts.add("positions", static_cast<std::int64_t>(mesh.positions.size()));
  facts.add("triangles", mesh.num_triangles());
  const UvLayout layout = find_uv_layout(mesh);
  std::string tiles;
  for (const AtlasTile& tile : layout.tiles) tiles += (tiles.empty() ? "" : ", ") + tile.name;
  facts.add("uvs", mesh.has_uvs(),
            !layout.problem.empty() ? layout.problem + ": --atlas auto unwraps"
            : tiles.empty()         ? "one square"
                                    : "tiles " + tiles);
  facts.add("uv_overlap", layout.overlap_share, mesh.has_uvs() ? percent_text(layout.overlap_share) : "");
  const MeshTopology topology = mesh_topology(mesh);
  facts.add("parts", topology.num_parts);
  facts.add("boundary_loops", topology.num_boundary_loops,
            topology.is_closed() ? "none: closed" : std::to_string(topology.num_boundary_loops));
  facts.add("nonmanifold_triangles", topology.num_nonmanifold_triangles);
  facts.add(
      "extent", Json{extent.x(), extent.y(), extent.z()},
      short_number_text(extent.x()) + " x " + short_number_text(extent.y()) + " x " + short_number_text(extent.z()));
  facts.add("unit", is_gltf_file(path) ? Json("m") : Json(),
            is_gltf_file(path) ? "m" : "none in the file: --unit says it");
  if (is_gltf_file(path)) {
    const MeshFileExtensions extensions = mesh_file_extensions(path);
    facts.add("extensions_read", extensions.read, joined_or_none(extensions.read));
    facts.add("extensions_not_looked_at", extensions.ignored, joined_or_none(extensions.ignored));
  }
  for (const std::string& text : notes) shown_notes += "\n    " + text;
  facts.add("notes", notes, notes.empty() ? "none" : shown_notes);
  Json surfaces = Json::array();
  std::string shown;
  for (const Mesh::Surface& s : mesh.surfaces) {
    surfaces.push_back(Json{{"node", s.node}, {"material", s.material}});
    shown += "\n    node \"" + s.node + "\", material \"" + s.material + "\"";
  }
  facts.add("surfaces", surfaces, std::to_string(mesh.surfaces.size()) + shown);
  return facts;
}

}  // namespace patinate::cli
