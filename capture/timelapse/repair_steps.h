/// \file
/// The steps of an ingest that survey and repair. Inside of ingest only.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "capture/stability/static_light.h"
#include "capture/timelapse/ingest_work.h"
#include "libcommon/job/job.h"

namespace patinate::capture {

struct SeriesGloss;

/// Stages of the items: all of one are finished before the next starts. Frames that wait for no repair come first, so
/// that a broken photograph costs none of the others.
struct IngestStages {
  int frames, survey, decisions;
};
[[nodiscard]] IngestStages ingest_stages(const IngestWork& work);

/// Tables that the repairs of all frames need, loaded once.
struct RepairTables {
  std::mutex mutex;
  bool is_loaded = false;
  std::vector<Eigen::Affine2d> motions;        ///< Pixels of the roi; empty when frames are left where they are.
  std::vector<std::array<double, 3>> factors;  ///< Empty when the exposure is left.
  ImageF flat_field;                           ///< Gain over the roi; empty when there is none.
};
[[nodiscard]] const RepairTables& repair_tables(const IngestWork& work, const std::filesystem::path& folder);

/// The lamp's fall-off as a gain over the roi.
inline constexpr const char* kFlatFieldFile = "survey/flat_field.exr";

/// RepairOptions::flat_field that takes the light of the first photograph out (first_light.h).
inline constexpr const char* kFlatFieldOfFirst = "first";
/// survey/light-0007.json: remaining_first_light() of a photograph.
[[nodiscard]] std::filesystem::path light_share_file(int index);
/// @throws ParseError unless RepairOptions::flat_field is empty, a word or a file.
void check_flat_field(const std::string& flat_field);

/// Whether frames carry a validity of their own.
[[nodiscard]] bool has_validity(const IngestWork& work);
/// Items that look at neighboring photographs, and those that decide the repairs from what they found.
void add_survey_items(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work);
/// survey/validity-0007.png.
[[nodiscard]] std::filesystem::path validity_file(int index);
/// survey/clipped-0007.json: ClippedPixels of a photograph that may be clipped.
[[nodiscard]] std::filesystem::path clipped_file(int index);
/// Codes of Validity of a finished frame.
[[nodiscard]] ImageU8 read_validity(const std::filesystem::path& folder, int index);
/// Key of the repairs that a frame depends on besides its own photograph; "" = none.
[[nodiscard]] std::string repair_frame_key(const IngestWork& work);
/// Adds what the history depends on.
void add_repair_inputs(JobInputs& inputs, const IngestWork& work);

/// The gain of --flat-field over the roi: one channel where it is estimated, three of an image.
/// @throws IoError; InvalidInput; CannotComplete as refuse_worse_light().
[[nodiscard]] ImageF make_flat_field(const IngestWork& work, const std::filesystem::path& folder,
                                     const RunControl& control);
/// Key of its inputs.
[[nodiscard]] std::string flat_field_key(const IngestWork& work);
/// Content of all photographs.
[[nodiscard]] std::string all_photos_key(const IngestWork& work);
/// @param gain  Of --flat-field estimate, over the roi. @param mask  As known before the frames are finished; may be
/// empty. @throws CannotComplete if the light inside the mask is less even with the gain than without.
void refuse_worse_light(const IngestWork& work, const std::function<ImageF(int)>& read_frame, const ImageF& gain,
                        const ImageU8& mask, const RunControl& control);

/// A frame as the history shows it, repaired; writes its validity where frames have one.
[[nodiscard]] ImageF develop_frame(const IngestWork& work, int index, const std::filesystem::path& folder);

/// Gives pixels of `validity` a code where more than a tenth of them, by area, is covered.
/// @param shares  Of the roi's size: 1 = covered.
void mark_invalid(const ImageF& shares, Validity code, ImageU8& validity);
/// A mask that stands with the camera, where the first frame has it.
[[nodiscard]] ImageU8 mask_in_place(const ImageU8& mask, const Eigen::Affine2d& motion);

/// When all frames are written: fills what can be filled, writes the frames' masks, and completes survey.json.
/// @param mask  What is inside so far; may be empty. @param gloss  Of which frames are freed before they are filled;
/// null = of none. @returns The history's mask; may be empty.
[[nodiscard]] ImageU8 mask_frames(HistoryWriter& writer, const IngestWork& work, const std::filesystem::path& folder,
                                  const ImageU8& mask, const SeriesGloss* gloss, const RunControl& control);

/// When all frames are written and filled: removes light that stayed while the surface changed (find_static_light())
/// from every frame, and writes the results as the `filled` frames. The frames with this light stay beside them.
/// @param mask  Mask of the history; may be empty. @returns the removed light, or nothing if the options turn this off
/// or the series does not show that it is light.
[[nodiscard]] std::optional<StaticLight> take_static_light_out(HistoryWriter& writer, const IngestWork& work,
                                                               const std::filesystem::path& folder, const ImageU8& mask,
                                                               const RunControl& control);

/// Looks at the light of the finished frames, completes survey.json by it and by what the repairs did, and says what is
/// to be warned of.
/// @param mask  The history's; may be empty. @param given  What of it was given or found: all but what frames have
/// masked; may be empty. @param report  What is known of it so far: static_light, layer_window.
[[nodiscard]] std::vector<HistoryWarning> look_at_light(const HistoryWriter& writer, const IngestWork& work,
                                                        const std::filesystem::path& folder, const ImageU8& mask,
                                                        const ImageU8& given, SeriesLight report,
                                                        const RunControl& control);

}  // namespace patinate::capture
