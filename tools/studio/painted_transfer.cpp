#include "tools/studio/painted_transfer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/request/repeating_command.h"
#include "libcommon/core/text.h"
#include "libcommon/image/between_pixels.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "tools/studio/outside_json.h"
#include "tools/studio/surface_in_time.h"
#include "tools/studio/tile_messages.h"
#include "transfer/lookup/packed_lookup.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxSide = 2048;  // Texels: what the page shows without scaling it down.
constexpr int kTile = 8;
constexpr std::size_t kMaxOpened = 2;
constexpr std::array<std::string_view, 5> kWhatNames{"look", "stroke", "refine", "undo", "redo"};

/// The file of edits beside a transfer.
/// @throws InvalidInput if none may be there
fs::path edits_file(const ServedFolder& folder, const fs::path& place) {
  if (place == folder.path())
    throw InvalidInput(
        "edits are kept beside the transfer, outside of the folder that is served; serve the folder above");
  const fs::path file = place.parent_path() / (place.filename().string() + ".edits.json");
  std::error_code error;
  const fs::file_status status = fs::symlink_status(file, error);
  if (fs::exists(status)) {
    if (!fs::is_regular_file(status))
      throw InvalidInput(folder.name_of(file) + ": is no file; edits are to be kept there");
    return file;
  }
  return folder.new_path(folder.name_of(file));
}

/// The command that made a transfer, with other ends. @returns "" where run.json does not say it.
std::string repeated_command(const fs::path& place, const std::string& more) {
  Json run;
  try {
    run = load_json(place / "run.json");
  } catch (const Error&) {
    return "";
  }
  if (!run.contains("command") || !run["command"].is_array()) return "";
  std::string command;
  bool is_value = false;
  for (const Json& word : run["command"]) {
    if (!word.is_string()) return "";
    const auto text = word.get<std::string>();
    if (std::exchange(is_value, text == "-o" || text == "--output") || is_value) continue;
    if (text == "--force" || text == "--quiet") continue;
    command += (command.empty() ? "" : " ") + app::shell_word(text);
  }
  return command + more;
}

std::string label_of(const transfer::TransferEdit& edit) {
  if (edit.kind == transfer::EditKind::Refine) return "Refine borders";
  return "Paint " + edit.control + " " + short_number_text(edit.value);
}

}  // namespace

PaintRequest parse_paint_request(const std::string& body) {
  const Json json = parse_outside_json(body);
  JsonReader reader("paint", json);
  PaintRequest request;
  request.what = static_cast<PaintRequest::What>(reader.member("do").choice(kWhatNames));
  request.time = reader.member("time").number();
  if (reader.has("between")) request.between = static_cast<Between>(reader.member("between").choice(kBetweenNames));
  if (request.what == PaintRequest::What::Stroke) {
    request.gesture = reader.member("gesture").integer(between(1, 1e15));
    (void)reader.member("edit");
    const Json document{{"format", transfer::kEditsFormat}, {"version", 1}, {"edits", Json::array({json["edit"]})}};
    request.edit = transfer::edits_from_json(document, "paint").edits.front();
    if (request.edit.kind != transfer::EditKind::Stroke) throw InvalidInput("paint: a stroke's kind is stroke");
  }
  request.edit.kind =
      request.what == PaintRequest::What::Refine ? transfer::EditKind::Refine : transfer::EditKind::Stroke;
  reader.finish();
  return request;
}

PaintedTransfer::PaintedTransfer(const ServedFolder& folder, const fs::path& place, const RunControl& control)
    : folder_(folder), transfer_(place), file_(edits_file(folder, place)) {
  const Sheet sheet = transfer::read_transfer_manifest(place).sheet();
  if (std::max(sheet.width(), sheet.height()) > kMaxSide)
    throw InvalidInput("transfers of up to " + std::to_string(kMaxSide) +
                       " texels along a side can be painted; make one with a smaller --resolution");
  editor_ = std::make_unique<transfer::TransferEditor>(place, transfer::AppearanceSource{}, control);
  const TexelMap& map = editor_->map();
  Image<std::uint32_t> shown(map.width(), map.height(), 1, kNoValue);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (map.is_covered(t)) shown.data()[t] = static_cast<std::uint32_t>(t);
  }
  transfer::fill_sheet(shown, sheet);
  shown_.assign(shown.values().begin(), shown.values().end());
  is_edited_.assign(shown_.size(), 0);
  is_dirty_.assign(shown_.size(), 0);
  std::error_code error;
  if (!fs::exists(file_, error)) return;
  for (const transfer::TransferEdit& edit : transfer::read_transfer_edits(file_).edits) {
    mark(editor_->apply(edit, control));
    done_.push_back({.label = label_of(edit)});
  }
}

void PaintedTransfer::mark(std::span<const TexelId> texels) {
  for (const TexelId t : texels) is_edited_[t] = is_dirty_[t] = 1;
}

std::string PaintedTransfer::answer(const PaintRequest& request, const RunControl& control) {
  const std::lock_guard lock(mutex_);
  if (request.what == PaintRequest::What::Look)
    is_dirty_ = is_edited_;  // Another time is shown: all that was edited.
  else
    apply(request, control);
  return tiles(request, control);
}

void PaintedTransfer::apply(const PaintRequest& request, const RunControl& control) {
  using What = PaintRequest::What;
  if (request.what == What::Stroke || request.what == What::Refine) {
    mark(editor_->apply(request.edit, control));
    undone_.clear();
    const bool goes_on = request.gesture != 0 && !done_.empty() && done_.back().gesture == request.gesture;
    if (goes_on)
      ++done_.back().num_edits;
    else
      done_.push_back({.label = label_of(request.edit), .gesture = request.gesture});
  } else {
    const bool is_undo = request.what == What::Undo;
    std::vector<Step>&from = is_undo ? done_ : undone_, &to = is_undo ? undone_ : done_;
    if (from.empty()) return;
    const auto room = is_undo ? editor_->num_undoable() : editor_->num_redoable();
    if (static_cast<std::size_t>(from.back().num_edits) > room) throw InvalidInput("this step is too old to be undone");
    for (int i = 0; i < from.back().num_edits; ++i) mark(is_undo ? editor_->undo() : editor_->redo());
    to.push_back(std::move(from.back()));
    from.pop_back();
  }
  save();
}

void PaintedTransfer::save() {
  std::error_code error;
  if (fs::is_symlink(file_, error))
    throw InvalidInput(folder_.name_of(file_) + ": is a link; edits are to be kept there");
  transfer::write_transfer_edits(file_, editor_->edits());
}

std::string PaintedTransfer::tiles(const PaintRequest& request, const RunControl& control) {
  const HistoryReader& history = editor_->reader().history();
  const std::string now =
      number_text(request.time) + " " + std::string(kBetweenNames[static_cast<int>(request.between)]);
  if (now != seen_) color_ = sample(history, request.time, request.between);
  seen_ = now;
  const TexelMap& map = editor_->map();
  const int columns = (map.width() + kTile - 1) / kTile, rows = (map.height() + kTile - 1) / kTile;
  std::vector<ScreenTile> changed;
  std::string texels;
  for (int tile = 0; tile < columns * rows; ++tile) {
    const int x0 = tile % columns * kTile, y0 = tile / columns * kTile;
    const int x1 = std::min(x0 + kTile, map.width()), y1 = std::min(y0 + kTile, map.height());
    bool is_changed = false;
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        const std::uint32_t t =
            shown_[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width()) + static_cast<std::size_t>(x)];
        is_changed = is_changed || (t != kNoValue && is_dirty_[t] != 0);
      }
    }
    if (!is_changed) continue;
    changed.push_back(static_cast<ScreenTile>(tile));
    std::array<std::uint8_t, 4 * kTile * kTile> bytes{};
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        const std::uint32_t t =
            shown_[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width()) + static_cast<std::size_t>(x)];
        const transfer::SourcePlace place = editor_->place(t);
        std::array<float, 3> rgb{};
        look_at<3>(color_.data(), color_.width(), color_.height(),
                   static_cast<float>(place.pixel % color_.width()) + static_cast<float>(place.beside_x) / 256.0f,
                   static_cast<float>(place.pixel / color_.width()) + static_cast<float>(place.beside_y) / 256.0f,
                   rgb.data());
        std::uint8_t* const to = bytes.data() + 4 * ((y - y0) * kTile + x - x0);
        for (std::size_t c = 0; c < 3; ++c) to[c] = srgb8_from_linear(rgb[c]);
        to[3] = 255;
      }
    }
    texels.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  control.throw_if_stopped();
  std::fill(is_dirty_.begin(), is_dirty_.end(), std::uint8_t{0});
  Json about = header();
  about["count"] = changed.size();
  std::string payload(changed.size() * sizeof(ScreenTile), '\0');
  if (!changed.empty()) std::memcpy(payload.data(), changed.data(), payload.size());
  return binary_message(about, payload + texels);
}

Json PaintedTransfer::header() const {
  Json controls = Json::array();
  for (const transfer::RecordedControl& c : editor_->reader().manifest().controls) {
    const ControlFacts& facts = editor_->reader().history().control(c.source);
    controls.push_back({{"name", c.source}, {"low", facts.low}, {"high", facts.high}, {"unit", facts.unit}});
  }
  const auto labels = [](const std::vector<Step>& steps) {
    Json list = Json::array();
    for (const Step& step : steps) list.push_back(step.label);
    return list;
  };
  const TexelMap& map = editor_->map();
  const std::string file = folder_.name_of(file_);
  return {{"tile", kTile},
          {"width", map.width()},
          {"height", map.height()},
          {"texel_mm", map.median_texel_size_mm()},
          {"controls", std::move(controls)},
          {"done", labels(done_)},
          {"undone", labels(undone_)},
          {"can_refine", editor_->has_structure() && editor_->can_refine()},
          {"file", file},
          {"command", repeated_command(transfer_, " --edits " + app::shell_word(file) + app::kAnyOutput)}};
}

std::shared_ptr<PaintedTransfer> PaintedTransfers::open(const ServedFolder& folder, const fs::path& place,
                                                        const RunControl& control) {
  std::error_code error;
  const fs::file_time_type changed = fs::last_write_time(place / "transfer.json", error);
  const std::lock_guard lock(mutex_);  // Another page that opens the same transfer gets this one.
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.path == place; });
  if (found != entries_.end() && found->changed == changed) {
    entries_.splice(entries_.begin(), entries_, found);
    return entries_.front().painted;
  }
  if (found != entries_.end()) entries_.erase(found);
  auto painted = std::make_shared<PaintedTransfer>(folder, place, control);
  entries_.push_front({place, changed, painted});
  if (entries_.size() > kMaxOpened) entries_.pop_back();
  return painted;
}

}  // namespace patinate::studio
