/// \file
/// Transfers a material history onto a mesh: for every texel of its atlas the source coordinates of its value, once for
/// all times, the controls that led there, and the figures that judge them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/core/zeroed_vector.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image.h"
#include "patinate/transfer/appearance_space.h"
#include "patinate/transfer/control_matching.h"

namespace patinate::transfer {

/// Options of TransferMethod::Fast.
struct MultiLevelOptions {
  int num_levels = 8;      ///< [1, 8]. Fewer when source or atlas become smaller than 12. Large structures need all.
  int coarse_passes = 12;  ///< [1, 16]. On each level but the finest.
  int fine_passes = 2;     ///< [1, 16]. On the finest; the last goes by the energy alone.
  int num_random = 6;      ///< [0, 64]. Candidates of similar control value a texel and pass.
  std::optional<double> first_coherence =
      {};  ///< [0, 1]. Coherence share on the coarsest level; rises to the final one. None: 0.2, with structure 0.6.
  double coherence_bonus =
      8.0;  ///< [0, 8]. A candidate that continues no neighbor's source counts (1 + this) times its cost.
  double reuse_penalty = 1.5;  ///< [0, 8]. Extra cost factor for each existing use of the same source pixel.
};
void describe(OptionVisitor& v, MultiLevelOptions& o);

/// Options of TransferMethod::Reference.
struct ReferenceOptions {
  int window_px = 100;      ///< [8, 4096]. Side of the search window.
  double tolerance = 0.05;  ///< [0, 1]. How near a window's center must be in control value.
  double epsilon = 0.02;    ///< [0, 1]. Chosen at random among those that cost at most 1 + this of the least.
  int num_passes = 1;       ///< [1, 8]. The first sees only texels done before; later ones see all.
  std::optional<double> first_coherence =
      {};  ///< [0, 1]. Coherence share of the first pass; rises linearly to the final one. None: the final one.
};
void describe(OptionVisitor& v, ReferenceOptions& o);

/// How much time borders of copied pieces are given, where the source has structure (refinement.h).
enum class TransferQuality { Draft, Good, Best };
inline constexpr std::array<std::string_view, 3> kTransferQualityNames{"draft", "good", "best"};

enum class TransferMethod { Fast, Reference };
inline constexpr std::array<std::string_view, 2> kTransferMethodNames{"fast", "reference"};

/// May copied pieces turn against the requested directions? Where the directions turn, a piece that follows them is
/// sheared, and its lines break.
enum class PieceTurning {
  Auto,   ///< Where the history has lines that run every way, as a net of cracks.
  Free,   ///< Where it has lines.
  Never,  ///< Streaks run down.
};
inline constexpr std::array<std::string_view, 3> kPieceTurningNames{"auto", "free", "never"};

/// Value of a texel that covers several pixels of the history.
enum class Footprint {
  Mean,   ///< Their mean: thin lines stay lines.
  Pixel,  ///< The one in the middle: exactly a value that was seen.
};
inline constexpr std::array<std::string_view, 2> kFootprintNames{"mean", "pixel"};

struct TransferOptions {
  TransferMethod method = TransferMethod::Fast;
  /// [0, 1]. a of the energy: 1 = texture only, 0 = control only. None: 0.65, with structure 0.85;
  /// Reference 0.995, of a library 0.65.
  std::optional<double> coherence_share = {};
  int neighborhood_radius_px = 0;  ///< [0, 5]. 3 = the 48 nearest neighbors. 0: 3, with structure 4.
  TransferQuality quality = TransferQuality::Good;
  PieceTurning turning = PieceTurning::Auto;  ///< Only with frames: those of UVs may be mirrored.
  Footprint footprint = Footprint::Mean;
  std::int64_t seed = 1;
  AppearanceOptions appearance = {};
  MultiLevelOptions multi_level = {};
  ReferenceOptions reference = {};
};
void describe(OptionVisitor& v, TransferOptions& o);

/// One control pair: where in the history, where on the mesh.
struct TransferControl {
  std::string source;       ///< Name of the history's control.
  std::string destination;  ///< What the user asked for, as text.
  ImageF values;            ///< H x W over the atlas, [0, 1].
  ControlRange range;       ///< What 0 and 1 of `values` stand for.
  double weight = 1.0;
  ControlMapping mapping = ControlMapping::Rank;
};

/// Source pixel (y * width + x) per texel of the atlas; -1 = none (yet).
using CoordinateMap = ZeroedVector<std::int32_t>;

inline constexpr int kControlSteps = 4095;  ///< Controls are integers in [0, 4095].

using ControlImage = Image<std::uint16_t>;  ///< H x W x C.

/// The figures that transfer.json reports.
struct EnergyReport {
  double energy = 0.0;              ///< a C + (1 - a) K, mean over texels.
  double coherence = 0.0;           ///< C, mean.
  double control_mismatch = 0.0;    ///< K, mean.
  double control_error_mean = 0.0;  ///< Mean |P - Q| of the first control, in [0, 1].
  double control_error_p95 = 0.0;
  std::array<double, 4> control_error_quarters{};  ///< The mean by quarters of the texels, the lowest values first.
  double coherent_share =
      0.0;  ///< Adjacent texel pairs whose step in the source is that on the surface, to less than a pixel or texel.
  double used_share = 0.0;  ///< Usable source pixels that appear in the result.
};

/// Source of a texel: a pixel of the history, and an offset from its middle in 1/256 pixel.
struct SourcePlace {
  std::int32_t pixel = -1;  ///< y * width + x; -1 = none.
  std::int8_t beside_x = 0, beside_y = 0;
  std::int16_t turn = 0;  ///< Rotation of its piece relative to TransferInput::frames, in 2^-16 of a full turn: the
                          ///< history's x axis runs along (cos, -sin) of it in the frame.
};

struct TransferResult {
  CoordinateMap coordinates;            ///< Per texel of the atlas, index into the history's pixels; -1 outside.
  ZeroedVector<std::int8_t> fractions;  ///< x and y per texel, how far it looks beside the middle of its pixel, in
                                        ///< 1/256 pixel; empty: nowhere.
  ZeroedVector<std::int16_t> turns;     ///< Of each texel (SourcePlace); empty: pieces lie along the frames.
  ControlImage matched_controls;        ///< H x W x a channel for each control, in the history's values.
  EnergyReport energy;
  double explained_variance =
      0.0;               ///< Share of the variance of the history's colors that the compared appearance holds.
  TransferOptions used;  ///< With a value for everything that was left open.
  std::optional<StructureFacts> structure;  ///< Detected structure; none if the source has none, or none was searched.
  double refused_line_share = 0.0;  ///< Share of the source that looks like lines, if it is too large to be lines.

  [[nodiscard]] SourcePlace place(TexelId t) const {
    const auto i = static_cast<std::size_t>(t);
    SourcePlace place{.pixel = coordinates[i]};
    if (!fractions.empty()) place.beside_x = fractions[2 * i], place.beside_y = fractions[2 * i + 1];
    if (!turns.empty()) place.turn = turns[i];
    return place;
  }
};

class SearchDevice;

/// Input of a transfer: the history, the surface and their controls.
struct TransferInput {
  std::shared_ptr<const History> history;
  std::shared_ptr<const TexelMap> map;                 ///< The destination in mm.
  double texel_size_mm = 1.0;                          ///< Surface length of one history pixel; > 0.
  std::vector<TransferControl> controls;               ///< At least one.
  std::shared_ptr<const FlowFrames> frames = nullptr;  ///< Which way the history's rows and columns run on the surface
                                                       ///< (direction_field.h); none: as the UVs do.
  ImageU8 source_mask =
      {};  ///< Of the history's size; 0 = must not be copied, as where the history's own mask is 0. Empty: only that.
  AppearanceSource appearance = {};  ///< Of the history; no result depends on it. Empty: built.
  std::shared_ptr<const SearchDevice> device =
      nullptr;  ///< Runs the fast synthesis; no result depends on it. None: the CPU.
};

/// @throws InvalidInput
[[nodiscard]] TransferResult transfer(const TransferInput& input, const TransferOptions& options = {},
                                      const RunControl& control = {});

}  // namespace patinate::transfer
