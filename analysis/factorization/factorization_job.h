/// \file
/// A factorization as a job: curve, maps, a denoised history, and what they leave over.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/job/job.h"
#include "patinate/analysis/factorization.h"
#include "patinate/history/history.h"

namespace patinate::analysis {

enum class FactorQuantity { Color, Roughness, Specular, Metalness, Height };
inline constexpr std::array<std::string_view, 5> kFactorQuantityNames{"color", "roughness", "specular", "metalness",
                                                                      "height"};
[[nodiscard]] std::string name_of(FactorQuantity quantity);
/// @throws InvalidInput
[[nodiscard]] FactorQuantity parse_factor_quantity(const std::string& name);

/// Where frames keep a quantity that is a map: what they have beside color, and the channel of it.
struct QuantityPlace {
  std::string extra;
  int channel = 0;
};
/// @param quantity  Not Color.
[[nodiscard]] QuantityPlace place_of(FactorQuantity quantity);

/// A history whose frames show a map in place of their color, in three equal channels, and nothing beside it. Where the
/// roughness of a frame is 0 nobody knows it: its mask is 0 there.
class QuantityHistory final : public History {
 public:
  /// @param source  Outlives this. @param quantity  Not Color.
  /// @throws InvalidInput if a frame has no such map, listing what all of them have.
  QuantityHistory(const HistoryReader& source, FactorQuantity quantity);

  [[nodiscard]] const HistoryFacts& facts() const override { return facts_; }
  [[nodiscard]] const std::string& label() const override { return source_.label(); }

 private:
  [[nodiscard]] ImageF load_frame(std::size_t frame) const override;
  [[nodiscard]] ImageF load_control(std::size_t control) const override {
    return source_.read_control(facts_.controls[control].name);
  }
  [[nodiscard]] ImageF load_control_deviation(std::size_t control) const override {
    return *source_.read_control_deviation(facts_.controls[control].name);
  }
  [[nodiscard]] ImageU8 load_mask() const override { return source_.read_mask(); }
  [[nodiscard]] ImageF load_map(std::size_t map) const override { return source_.read_map(facts_.maps[map]); }
  [[nodiscard]] ImageF load_frame_extra(std::size_t frame, std::size_t extra) const override;
  [[nodiscard]] ImageU8 load_frame_mask(std::size_t frame) const override;

  const HistoryReader& source_;
  FactorQuantity quantity_;
  HistoryFacts facts_;
};

inline constexpr const char* kFactorizationManifestFile = "factorization.json";
inline constexpr const char* kFactorizationPageFile = "report.html";

struct FactorizationTask {
  std::filesystem::path history;
  FactorQuantity of = FactorQuantity::Color;  ///< A map goes without `times` and with one clock.
  FactorizationOptions options = {};
  std::vector<double> times =
      {};  ///< Times of frames that the denoised history gets beside those of the frames, in the history's unit.
  std::string command = {};  ///< Command that repeats it, for the page; no part of the key.
};

/// Opens the history at once. Of a map, the denoised history has the frames of its source with that map without noise.
/// @throws InvalidInput (fewer than kLeastFrames frames, a map that some frame lacks, a time that is not finite,
/// options), IoError.
[[nodiscard]] JobPlan plan_factorization(FactorizationTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
