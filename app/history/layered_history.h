/// \file
/// One history inside another: patina in the cracks of a paint, rust once the primer is gone.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "libcommon/job/job.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"
#include "transfer/library/library_layout.h"

namespace patinate::app {

/// Properties that a place may be chosen by, beside the controls of the lower history, whose names come first: of its
/// frame at that time, `height` (mm), `metalness`, `roughness`, `lightness` (L* / 100) and `change` (Delta E*ab from
/// its first frame / 100).
struct LayerTask {
  std::shared_ptr<const History> below, above;
  std::string where;  ///< A control expression: the share of `above` that shows. Below 0 and above 1 are cut.
  transfer::LibraryClock clock = transfer::LibraryClock::Absolute;
};

/// `below` with `above` laid over it where `where` says. At every place `above` begins when `where` first passes a half
/// there, so that it is as old as the place has been open. It lies pixel on pixel, or mm on mm where both know their
/// size, and is mirrored where it ends.
///
/// Colors, normals, gloss and metalness are blended by the share, heights are added. Frames are those of `below`, and
/// those of `above` from the first time that a place opens. Controls, mask and shape are those of `below`;
/// deviations, tints and masks of single frames are left out.
/// @throws ParseError for an expression that cannot be read; InvalidInput if it is above a half nowhere; IoError
[[nodiscard]] std::shared_ptr<const History> layered_history(LayerTask task, const RunControl& control = {});

/// Plans the same with folders. @param below, above  Folders of histories.
[[nodiscard]] JobPlan plan_layers(const std::filesystem::path& below, const std::filesystem::path& above,
                                  const std::string& where, transfer::LibraryClock clock,
                                  const std::filesystem::path& output);

}  // namespace patinate::app
