/// \file
/// A transfer as `patinate transfer` is asked for it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/mesh/mesh_source.h"
#include "app/request/words.h"
#include "libcommon/device/device_choice.h"
#include "patinate/controls/control_kinds.h"
#include "transfer/exemplar/appearance_cache.h"
#include "transfer/job/transfer_job.h"

namespace patinate::app {

struct TransferRequest {
  std::filesystem::path history;      ///< A history, a simulation, or library:NAME.
  std::vector<std::string> controls;  ///< [SOURCE=]DESTINATION[:weight[:mapping]]
  MeshSource mesh;
  AtlasOptions atlas;
  bool is_resolution_given = false;  ///< Else it follows from the history's texel size, where that is known.
  std::optional<double> texel_size_mm = std::nullopt;  ///< Texel size of the history; not given: what it says.
  transfer::TransferOptions transfer;
  ControlKindOptions kinds;
  std::string flow = "gravity";       ///< One of kDirectionKindNames, or a file of curves.
  std::filesystem::path source_mask;  ///< 8 bit, of the history's size; 0 is not copied. May be empty.
  std::filesystem::path edits;        ///< Applied to the finished transfer (transfer_edits.h). May be empty.
  transfer::CacheOptions cache;       ///< No result depends on it.
  device::DeviceOptions device;       ///< No result depends on it.
};

/// Checks a request before anything is opened. @throws UsageError
void check_request(const TransferRequest& request);
/// Reads the history, the mesh and its controls: what is left to do is plan_transfer().
/// @throws UsageError if what is asked for does not go together; IoError; InvalidInput; Canceled
[[nodiscard]] transfer::TransferTask transfer_task(const TransferRequest& request, const Words& say);
/// The edits that a request names. @throws IoError
[[nodiscard]] transfer::TransferEdits requested_edits(const TransferRequest& request);
/// Makes the map of a control on the surface.
using MakeControl = std::function<ControlMap(std::size_t number, const transfer::ControlSpec& spec)>;
/// Controls of the history with their maps; notes say what a user should know of each. Of a library, the control that
/// chooses the history is one of the first two.
[[nodiscard]] std::vector<transfer::TransferControl> noted_controls(const History& history,
                                                                    std::span<const transfer::ControlSpec> specs,
                                                                    const TexelMap& map, const MakeControl& make,
                                                                    const Words& say);

/// What a transfer found in its history.
struct FoundStructure {
  std::optional<transfer::StructureFacts> structure;
  double refused_line_share = 0.0;
  transfer::TransferOptions used;
};
/// What a user should know of a transfer that is made: which lines were found, whether pieces turned.
[[nodiscard]] std::vector<std::string> transfer_notes(const FoundStructure& found,
                                                      const transfer::TransferOptions& asked);
[[nodiscard]] std::vector<std::string> transfer_notes(const transfer::TransferManifest& made,
                                                      const transfer::TransferOptions& asked);

}  // namespace patinate::app
