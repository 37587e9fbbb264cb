#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libcommon/core/file_name.h"
#include "libcommon/history/frame_locator.h"
#include "libcommon/history/history_times.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/history/history_sampling.h"
#include "tests/fuzz/fuzz_target.h"
#include "transfer/library/library_layout.h"

using namespace patinate;

namespace {

/// Whatever its times are, every one of them falls somewhere.
void check_times(const HistoryManifest& m) {
  std::vector<double> times;
  for (const HistoryFrame& frame : m.frames) times.push_back(frame.time);
  const FrameLocator locate(times, Between::Blend);
  const int last = static_cast<int>(m.frames.size()) - 1;
  for (int i = 0; i <= last; ++i) {
    const double time = m.frames[i].time, next = m.frames[std::min(i + 1, last)].time;
    for (const double t : {time, 0.5 * time + 0.5 * next}) {
      const TimePosition at = locate(t);
      fuzz::require(at.index >= 0 && at.index <= last && at.fraction >= 0.0 && at.fraction <= 1.0,
                    "a time falls between two frames");
    }
  }
}

/// Beside a plain history, its times mapped onto that one's and the other way round.
void check_library(const HistoryManifest& m) {
  HistoryManifest plain = m;
  plain.frames.clear();
  for (int i = 0; i < 3; ++i) plain.frames.push_back({.time = 2.5 * i, .file = {}});
  const std::array<transfer::LibrarySource, 2> one{transfer::LibrarySource{m, "a", "a"},
                                                   transfer::LibrarySource{plain, "b", "b"}},
      other{one[1], one[0]};
  for (const auto& sources : {one, other}) {
    for (const transfer::LibraryClock clock : {transfer::LibraryClock::Absolute, transfer::LibraryClock::Span}) {
      try {
        for (const transfer::LibraryFrame& frame : transfer::lay_out_library(sources, {}, {.clock = clock}).frames) {
          fuzz::require(std::isfinite(frame.time), "a library's times are numbers");
          for (std::size_t p = 0; p < sources.size(); ++p) {
            const int last = static_cast<int>(sources[p].manifest.frames.size()) - 1;
            fuzz::require(frame.at[p].index >= 0 && frame.at[p].index <= last && frame.at[p].fraction >= 0.0 &&
                              frame.at[p].fraction <= 1.0,
                          "a library's time falls between two frames of each");
          }
        }
      } catch (const InvalidInput&) {  // They need not go together.
      }
    }
  }
}

}  // namespace

PATINATE_FUZZ_TARGET(history) {
  const HistoryManifest manifest = read_history_manifest(fuzz::fuzz_file("history.json", bytes));
  fuzz::require(!manifest.frames.empty(), "a history has a frame");
  for (std::size_t i = 0; i < manifest.frames.size(); ++i) {
    fuzz::require(std::abs(manifest.frames[i].time) <= kFarthestTime, "times are numbers to compute with");
    if (i > 0)
      fuzz::require(manifest.frames[i].time - manifest.frames[i - 1].time >= kMinTimeStep,
                    "times rise, by steps to divide by");
  }
  for (const ControlParameter& control : manifest.controls)
    fuzz::require(is_file_name(control.name), "a control's name is that of a file");
  check_times(manifest);
  check_library(manifest);
  write_history_manifest(fuzz::fuzz_folder() / "copy.json", manifest);
  const HistoryManifest copy = read_history_manifest(fuzz::fuzz_folder() / "copy.json");
  fuzz::require(copy.frames.size() == manifest.frames.size() && copy.width == manifest.width,
                "what is written can be read");
}
