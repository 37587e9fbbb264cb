/// \file
/// Frames of a history as the page of an ingest shows them. Inside of ingest only.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/history/history.h"
#include "patinate/image/image.h"

namespace patinate::capture {

inline constexpr int kThumbnailSide_px = 160;      ///< Longer side of a thumbnail, at most.
inline constexpr int kReportMapSide_px = 320;      ///< Longer side of a map, at most.
inline constexpr std::size_t kMaxThumbnails = 60;  ///< More frames are in the table alone.
inline constexpr std::size_t kMaxMarkedFrames =
    30;  ///< Largest number of frames that are shown because a warning names them.

/// Where most of some pixels lie: nine tenths of them in each direction. Pixels of the history, both ends included.
struct PixelSpan {
  int left = 0, right = 0, top = 0, bottom = 0;
};

struct ReportFrame {
  std::optional<std::array<double, 3>> lab = {};  ///< CIELAB of the mean color; nothing where all is masked.
  double masked_share = 0.0;                      ///< Masked share of the picture, by the frame's own mask.
  std::optional<PixelSpan> masked_at = {};        ///< Where that lies.
  ImageF thumbnail = {};                          ///< Linear; empty where none was asked for.
  ImageF marks = {};  ///< Shares of each pixel: outside of the history's mask, out of view, masked otherwise.
};

struct ReportFrames {
  std::vector<ReportFrame> frames;
  ImageF masked;  ///< In which share of the frames a place is masked, at most kReportMapSide_px large; empty: nowhere.
};

/// Reads every frame once, several at a time. Same bits for any number of threads.
/// @param history  Its frames are written. @param mask  The history's; may be empty. @param is_shown  As many as
/// frames: a thumbnail is wanted. @param out_of_view  Of a frame, H x W, not 0 = the camera did not see it; may be
/// empty or give an empty image.
[[nodiscard]] ReportFrames look_at_frames(const HistoryManifest& history, const std::filesystem::path& folder,
                                          const ImageU8& mask, const std::vector<bool>& is_shown,
                                          const std::function<ImageU8(int)>& out_of_view, const RunControl& control);

/// Frames that have a thumbnail: all of up to kMaxThumbnails; of more, those that are marked (at most
/// kMaxMarkedFrames), and others evenly, the first and the last among them.
[[nodiscard]] std::vector<bool> shown_frames(const std::vector<bool>& is_marked);

/// An image, at most `longest` pixels on its longer side.
[[nodiscard]] ImageF reduced_to(const ImageF& image, int longest);

}  // namespace patinate::capture
