/// \file
/// Figures of one region from what was found on the whole surface.
#pragma once

#include "analysis/grading/graded_surface.h"
#include "analysis/grading/relief_marks.h"
#include "analysis/grading/rust_map.h"

namespace patinate::analysis {

/// Sets rusted_percent, the spots and their distribution.
void add_rust_figures(const RustFrame& rust, const ImageU8& region, std::optional<double> pixel_mm,
                      const RustRule& rule, RegionFigures& figures);
/// Sets the differences between the colors of the coating, CIE 1976 and CIEDE2000. Intervals are those of the mean of
/// up to 16 places of the region. @param before, now  H x W x 3, linear. @param cracks  As for add_crack_figures().
void add_color_figures(const ImageF& before, const ImageF& now, const ImageF& rust, const ImageU8& cracks,
                       const ImageU8& region, RegionFigures& figures);
/// Sets gloss units from the lobe of the coating; intervals as those of colors. @param f0, roughness  H x W, 0 = not
/// known.
void add_gloss_figures(const ImageF& f0, const ImageF& roughness, const ImageF& rust, const ImageU8& cracks,
                       const ImageU8& region, RegionFigures& figures);
/// Sets length and width of cracks; 0 without any. @param cracks  0 / 255; may be empty: none.
void add_crack_figures(const ImageU8& cracks, const ImageU8& region, double pixel_mm, RegionFigures& figures);
/// Sets areas and mean sizes of blisters and flakes: the diameter of a circle of a blister's area, the largest
/// dimension of a flake. A blister that is more than half rust is a pile of rust. @param rust  Coverage.
void add_relief_figures(const ReliefMarks& blisters, const ReliefMarks& flakes, const ImageF& rust,
                        const ImageU8& region, double pixel_mm, RegionFigures& figures);
/// Sets mean and largest creep to one side of the scribes [ISO 4628-8:2012, clause 6]. Places near an end of a scribe,
/// near where two of them cross and where the rust of two has merged do not count. @param rust  Coverage. @param
/// scribes  At least one.
void add_creep_figures(const ImageF& rust, const ImageU8& region, double pixel_mm, const std::vector<Scribe>& scribes,
                       RegionFigures& figures);

}  // namespace patinate::analysis
