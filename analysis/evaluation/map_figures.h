/// \file
/// An evaluation in parts: what is measured of a tile, and what follows from all of them. No part looks at another's
/// texels but for those over its seams, so that no process need hold more than one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evaluation/coherence.h"
#include "analysis/evaluation/evaluation.h"
#include "analysis/evaluation/structure_figures.h"
#include "analysis/evaluation/texture_distance.h"
#include "analysis/evaluation/value_counts.h"

namespace patinate::analysis {

/// Pairs of texels right of and below each other in a chart whose step in the source is not that on the surface.
struct BorderSums {
  std::int64_t count = 0;
  double shown = 0.0, own = 0.0;

  void add(const BorderSums& other);
  /// 1 = features go on as in the source; 1 without borders; nothing where the source is flat wherever pieces meet.
  [[nodiscard]] std::optional<double> contrast() const;
};
/// Sum over such pairs (t, n), and over all frames, of |A(s(t)) - A(s(n))|, A = (R, G, B, and the luma's two central
/// differences) in codes, against what the source itself has there at the same step d: the mean of
/// |A(s(t)) - A(s(t) + d)| and |A(s(n) - d) - A(s(n))|. Same bits for any number of threads.
/// @param frames  With their mask: steps that leave it are left out.
[[nodiscard]] BorderSums measure_borders(const MapPart& part, const SynthesisSource& frames, const SourceScale& scale,
                                         const RunControl& control = {});

/// Share of texels whose source is used more often than if all of it were used evenly, wherever that is: 0 where a
/// source is used once, or where each pixel is used as often as every other; 8/9 where a ninth of it is used for all.
/// @param width  Of the source. @param num_usable  Pixels of it that could be used. @param pixels_per_texel  Along a
/// side: pixels that one texel covers are one place; texels that one pixel covers do not repeat it.
[[nodiscard]] double overuse_of(const ReuseSums& reuse, int width, std::int64_t num_usable, double pixels_per_texel);

inline constexpr double kShownControlError = 0.25;  ///< At the light end of the map of control errors.

/// Sums of |P(s(t)) - Q(t)|, in bins of 2^-16.
struct ErrorSums {
  double sum = 0.0;
  ValueCounts counts{1.0 / 65536.0};

  void add(const ErrorSums& other);
};

/// Sums of one of the source's frames.
struct FrameSums {
  ValueCounts gradients;
  SpectrumSums spectrum;

  void add(const FrameSums& other);
};

/// Figures measured of parts; those of all parts, added in their order, are the map's.
struct MapSums {
  std::vector<std::string> hashes;  ///< One a part: of its rounded coordinates.
  ErrorSums error, smooth_error;    ///< The second after a Gaussian of 3 px.
  CoherenceSums coherence;
  std::vector<FrameSums> frames;
  TextureDraws draws;
  ReuseSums reuse;
  SeamSums seams;
  ValueCounts scale;
  std::int64_t explained = 0;  ///< Texels whose color the tool's picture has.
  StructureSums structure;
  BorderSums borders;
  std::vector<std::vector<Picture>> pictures;  ///< One list a part, small where there are several.

  void add(MapSums other);
};

/// A map and all that its parts are measured against.
struct MapFacts {
  std::string name;
  std::shared_ptr<const TexelMap> surface;   ///< With its figures.
  std::shared_ptr<const FlowFrames> frames;  ///< One a triangle.
  bool has_control = false;                  ///< The wanted control is known.
  std::vector<std::int16_t> turns = {};      ///< Turns as SynthesizedMap's.
};

/// Measures a map tile by tile. Thread-safe.
class MapFigures {
 public:
  /// @param source,options  Must outlive it. @throws InvalidInput if sizes of the source's images differ.
  MapFigures(const SynthesisSource& source, MapFacts map, const EvaluationOptions& options, std::uint64_t seed,
             const RunControl& control = {});

  /// @param wanted  The control of the tile's rectangle (cell_of()); empty without.
  /// @param before,all  Places in earlier parts and in all (count_part()). @param made  Of maps of one part only.
  /// @throws InvalidInput if coordinates are missing, or outside the source.
  [[nodiscard]] MapSums measure(int tile, const CoordinateReader& coordinates, ImageF wanted, const PartCounts& before,
                                const PartCounts& all, const MadePicture* made = nullptr,
                                const RunControl& control = {}) const;
  /// @param sums  Of all parts. @param has_made  Whether the tool's picture was given.
  [[nodiscard]] Evaluation conclude(MapSums sums, bool has_made, const RunControl& control = {}) const;

 private:
  void add_pictures(const MapPart& part, MapSums& sums) const;
  void measure_control(const MapPart& part, MapSums& sums, const RunControl& control) const;
  [[nodiscard]] TextureDistanceOptions draw_options() const;

  const SynthesisSource& source_;
  MapFacts map_;
  const EvaluationOptions& options_;
  std::uint64_t seed_;
  SourceScale scale_;
  SourceStructure structure_;
};

/// Pictures of tiles beside each other as they lie in the sheet, or of a map of one tile. @param parts  One list a
/// tile.
[[nodiscard]] std::vector<Picture> sheet_pictures(std::vector<std::vector<Picture>> parts, const Sheet& sheet);
/// A picture of a tile's rectangle without its margins, small enough for sheet_pictures(); of a map of one tile as it
/// is.
[[nodiscard]] ImageF tile_picture(ImageF picture, const Sheet& sheet, const RunControl& control = {});

}  // namespace patinate::analysis
