/// \file
/// Where the marks of a coated panel lie, and how large they become.
#pragma once

#include <optional>
#include <vector>

#include "datasets_synthetic/panel_marks.h"
#include "datasets_synthetic/panel_stains.h"
#include "datasets_synthetic/rust_texture.h"
#include "datasets_synthetic/sample_cover.h"
#include "patinate/core/run_control.h"
#include "patinate/datasets/panel.h"

namespace patinate::datasets {

/// All that does not depend on the time. Immutable; safe to use from several threads.
struct PanelLayout {
  PanelOptions options;
  SampleFrame test_area;
  std::vector<SpotOutline> spots = {};
  std::vector<PanelScribe> scribes = {};
  std::vector<PanelCrack> cracks = {};
  Stains stains;
  RustTexture rust;
  ImageF grain = {};   ///< Relative unevenness of the paint's color; mean 0 in the test area.
  ImageF uneven = {};  ///< Unevenness of the color's change.
};
/// @throws InvalidInput as check_panel().
[[nodiscard]] PanelLayout lay_out_panel(const PanelOptions& options, const RunControl& control = {});

/// Marks on the panel at a time.
struct PanelMarks {
  Marks rust;                        ///< Spots and edge rust.
  std::optional<Marks> scribe = {};  ///< The cut and what has crept from it.
  SampleImage cut = {};              ///< The cut alone; empty without a scribe.
  SampleImage cracks = {};           ///< Empty without cracks.
  ImageF stain = {};                 ///< Opacity; empty without stains.
};
[[nodiscard]] PanelMarks marks_at(const PanelLayout& layout, double hours, const RunControl& control = {});

}  // namespace patinate::datasets
