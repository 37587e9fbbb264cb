/// \file
/// The page of an ingest of a fixed camera or of photographs from the hand. Inside of ingest only.
#pragma once

#include <filesystem>

#include "capture/timelapse/ingest_work.h"

namespace patinate::capture {

/// Writes kIngestPageFile, with all pictures in it: what was understood of each photograph, how they lie, the mask,
/// brightness and color over time, and the warnings with the place where they apply. Names of photographs are in it,
/// folders are not. Same bytes for any number of threads.
/// @param history  All of it but for the manifest's file is written. @param mask  The history's; may be empty.
/// @throws IoError, CannotComplete
void write_ingest_report(const HistoryManifest& history, const IngestWork& work, const std::filesystem::path& folder,
                         const ImageU8& mask, const RunControl& control);

}  // namespace patinate::capture
