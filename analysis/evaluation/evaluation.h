/// \file
/// How good a texture synthesis is, whichever tool made it: the metrics M2-M12 of one coordinate map as figures and
/// maps.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/evaluation/structure_figures.h"
#include "analysis/evaluation/synthesized_map.h"
#include "analysis/evaluation/texture_distance.h"
#include "patinate/analysis/report_parts.h"
#include "patinate/core/options.h"

namespace patinate::analysis {

struct EvaluationOptions {
  int num_samples = 20000;  ///< [100, 10^6]. Patches drawn for the distances of distributions.
  int num_directions = 64;  ///< [1, 1024].
  int num_times = 5;        ///< [1, 100]. At which colors are compared.
  int num_audits = 2000;    ///< [0, 10^6]. Texels whose pixel is compared with the best there is (M1); 0: none.
  int source_step = 0;      ///< [0, 256]. Source pixels of a texel step; 0: texel size / pixel size.
};
void describe(OptionVisitor& v, EvaluationOptions& o);

/// Picture that a tool presents as its result; M9 tells whether the coordinates explain it.
struct MadePicture {
  std::size_t frame = 0;  ///< Frame of the source.
  ImageF codes;           ///< H x W x 3, sRGB codes in [0, 255].
};

/// One map's figures, and pictures of where it loses.
struct Evaluation {
  std::string name;
  std::vector<Figure> figures;
  std::vector<Picture> pictures;
  std::vector<LineFigures> lines;  ///< Figures of lines (M11), whose means are reported.
  std::string hash;                ///< M10: of the rounded coordinates; equal maps have equal ones.
};

/// Figures, in this order; those that cannot be had are undefined and say why:
/// control_error_mean, control_error_p95 (M2: |Ps(s(t)) - Pt(t)|), control_error_s3_mean, control_error_s3_p95 (both
/// maps under a Gaussian of 3 px first), coherent_share, texels_per_piece (M3), patch_swd, gradient_emd, spectrum (M4),
/// joint_swd (M5), rep64, used_share, rep_all (M6), seam_gradient_ratio, seam_coherence_ratio (M7), scale_error_median,
/// scale_error_p99 (M8), explained_pixels (M9), those of
/// measure_lines() (M11), border_contrast (M12). M4 and M5 have as `split` what two draws from the source itself give.
/// A map of several tiles is measured tile by tile: repetition and the Gaussian end at a tile, which lies beside the
/// next one by chance. Its pictures are no larger than a page needs.
/// @throws InvalidInput if sizes do not fit. Same bits for any number of threads.
[[nodiscard]] Evaluation evaluate(const SynthesisSource& source, const SynthesizedMap& map,
                                  const EvaluationOptions& options, std::uint64_t seed,
                                  const MadePicture* made = nullptr, const RunControl& control = {});

/// Coordinates as colors: red along x, green along y, blue in a fine checker, so that borders of pieces show. Linear.
[[nodiscard]] ImageF coordinate_picture(const MapPart& part, int source_width, int source_height);

}  // namespace patinate::analysis
