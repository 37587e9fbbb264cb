/// \file
/// What an ingest found out about the light and did to it: kept in survey.json, said by the command, warned of.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "capture/project/frame_sources.h"
#include "capture/stability/static_light.h"
#include "capture/stability/uneven_light.h"
#include "patinate/capture/thickness.h"
#include "patinate/core/json.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

/// Smallest and largest factor of a channel.
using FactorRange = std::array<double, 2>;

/// A photograph and by what it was multiplied.
struct ChangedPhoto {
  std::string photo;  ///< Name, without its folder.
  std::array<double, 3> factors{1.0, 1.0, 1.0};
};

/// Report of --flat-field.
struct FlatFieldReport {
  double ratio = 1.0;  ///< Brightest to darkest light that was divided out, as UnevenLight::ratio; the largest channel.
  std::array<FactorRange, 3> ranges{};
  /// For `--flat-field first`: how much of that light the last photograph still shows, by channel, in [0, 1]; else
  /// empty.
  std::vector<double> last_shares = {};
};

/// Report of --deflicker.
struct DeflickerReport {
  std::array<FactorRange, 3> ranges{};
  std::vector<ChangedPhoto> changed;  ///< Every photograph that was changed, the most changed first.
  std::vector<std::string> unsure;    ///< Photographs whose change against the one before was left as it is.
};

/// How exposures by EXIF vary.
struct ExifExposureReport {
  double ratio = 1.0;                                ///< Largest to smallest amount of light for a code.
  std::string least_photo, least, most_photo, most;  ///< "1/250 s, f/2.8, ISO 100".
  bool is_white_balance_mixed = false;               ///< Some photographs automatic, some set by hand.
};

struct SeriesLight {
  std::optional<UnevenLight> uneven;  ///< Uneven light of the finished frames: what repairs left.
  std::optional<FlatFieldReport> flat_field;
  std::optional<DeflickerReport> deflicker;
  std::optional<StaticLight>
      static_light;  ///< Light that was removed because it stayed while the surface was replaced.
  std::optional<LayerWindow> layer_window;  ///< Layer window of the thickness from transmitted light.
  std::optional<ExifExposureReport> exif;   ///< Where two photographs or more say it.
};

/// Members `uneven_light`, `flat_field`, `deflicker`, `static_light`, `layer_window`, `exif_exposure` of survey.json,
/// as far as there are.
void add_light_report(Json& survey, const SeriesLight& report);
/// @throws IoError
[[nodiscard]] SeriesLight read_light_report(JsonReader& survey);

[[nodiscard]] std::optional<ExifExposureReport> exif_exposures(const std::vector<CapturePhoto>& photos);
/// Factors of which those under 1 %, too little to be named, become 1: a photograph that is not named is not changed.
[[nodiscard]] std::vector<std::array<double, 3>> named_factors(std::vector<std::array<double, 3>> factors);
/// @param factors  Of every frame, named_factors(). @param unsure  Frames.
[[nodiscard]] DeflickerReport deflicker_report(const std::vector<CapturePhoto>& photos,
                                               const std::vector<std::array<double, 3>>& factors,
                                               const std::vector<int>& unsure);
/// @param gain  H x W x 3.
[[nodiscard]] FlatFieldReport flat_field_report(const ImageF& gain);

/// Uneven light that is left, changes that deflickering could not judge, exposures that vary by more than 5 %.
/// @param flat_field  RepairOptions::flat_field. @param num_frames  Of the history; >= 1.
[[nodiscard]] std::vector<HistoryWarning> light_warnings(const SeriesLight& report, const std::string& flat_field,
                                                         int num_frames);
/// Notes on the light, a line each.
[[nodiscard]] std::vector<std::string> light_notes(const SeriesLight& report);

}  // namespace patinate::capture
