/// \file
/// Settings of the two ways to synthesize.
#pragma once

#include "patinate/core/options.h"

namespace patinate::transfer {

/// Of synthesize_multi_level().
struct MultiLevelOptions {
  int num_levels = 8;      ///< [1, 8]. Fewer when source or atlas become smaller than 12. Large structures need all.
  int coarse_passes = 12;  ///< [1, 16]. On each level but the finest.
  int fine_passes = 2;     ///< [1, 16]. On the finest; the last goes by the energy alone.
  int num_random = 6;      ///< [0, 64]. Candidates of similar control value a texel and pass.
  double first_coherence = 0.2;  ///< [0, 1]. Coherence share on the coarsest level; rises to the final one.
  double coherence_bonus =
      8.0;  ///< [0, 8]. A candidate that continues no neighbor's source counts (1 + this) times its cost.
  double reuse_penalty = 1.5;  ///< [0, 8]. ... and this much more for each time its source is already reused.
};
void describe(OptionVisitor& v, MultiLevelOptions& o);

/// Of synthesize_reference().
struct ReferenceOptions {
  int window_px = 100;           ///< [8, 4096]. Side of the search window.
  double tolerance = 0.05;       ///< [0, 1]. How near a window's center must be in control value.
  int num_passes = 3;            ///< [1, 8]. The first sees only texels done before; later ones see all.
  double first_coherence = 0.1;  ///< [0, 1]. Coherence share of the first pass; rises linearly to the final one.
};
void describe(OptionVisitor& v, ReferenceOptions& o);

}  // namespace patinate::transfer
