#include "tools/patinate/services/picture_series.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/hash.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/numbered_path.h"
#include "tools/patinate/command_line/output_file.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/services/movie_frames.h"
#include "tools/patinate/services/tile_files.h"

namespace patinate::cli {

namespace {

bool is_movie(const std::filesystem::path& output) {
  const std::vector<std::string>& all = movie_extensions();
  return std::find(all.begin(), all.end(), lower_extension(output)) != all.end();
}

RunControl without_progress(RunControl control) {
  control.on_progress = {};
  return control;
}

int make_movie(CommandRun& run, const std::filesystem::path& output, const PictureSeries& series,
               const MovieOptions& movie) {
  ContentHash hash;
  hash.add("movie 1").add(series.key).add(lower_extension(output)).add(movie.fps);
  for (double t : series.times) hash.add(t);
  const std::string key = hash.hex();
  const auto codes = [&](int i, const RunControl& control) {
    const double t = series.times[static_cast<std::size_t>(i)];
    return series.codes ? series.codes(t, control) : srgb8_from_linear(series.picture(t, control));
  };
  std::optional<JobStatus> status;
  if (run.request() != nullptr) {
    MovieFrames frames{
        .output = output, .label = series.label, .key = key, .keys = {}, .codes = codes, .options = movie};
    for (std::size_t i = 0; i < series.times.size(); ++i) {
      frames.keys.push_back(ContentHash()
                                .add("movie picture 1")
                                .add(series.key)
                                .add(series.times[i])
                                .add(static_cast<std::int64_t>(i))
                                .hex());
    }
    status = answer_movie(run, frames);
  } else {
    status = run.check_file(output, read_movie_key(output), key);
    if (status == JobStatus::Done) {
      const RunControl control = run.control(series.label);
      const RunControl silent = without_progress(control);
      write_coded_movie(
          output, static_cast<int>(series.times.size()), [&](int i) { return codes(i, silent); }, movie, key, control);
    }
  }
  if (!status) return 0;
  run.report_output(*status, output, Json{{"pictures", series.times.size()}, {"fps", movie.fps}});
  return 0;
}

int make_images(CommandRun& run, const std::filesystem::path& output, const PictureSeries& series) {
  require_extension(output, image_extensions());
  std::vector<OutputPiece> pieces;
  ContentHash all;
  Json files = Json::array();
  for (std::size_t i = 0; i < series.times.size(); ++i) {
    const std::filesystem::path file = numbered_path(output, static_cast<int>(i));
    const std::string key =
        ContentHash().add("picture 1").add(series.key).add(series.times[i]).add(lower_extension(output)).hex();
    files.push_back(Json{{series.measure, series.times[i]}, {"file", file.string()}});
    pieces.push_back({{file}, key});
    all.add(key);
  }
  const auto todo = unfinished_pieces(run, output, all.hex(), pieces);
  if (!todo) return 0;
  const RunControl control = run.control(series.label);
  for (std::size_t k = 0; k < todo->size(); ++k) {
    const OutputPiece& piece = pieces[(*todo)[k]];
    const double t = series.times[(*todo)[k]];
    if (series.write) {
      series.write(t, piece.files.front(), piece.key, without_progress(control));
    } else {
      write_color(piece.files.front(), series.picture(t, without_progress(control)), piece.key);
    }
    control.report((static_cast<double>(k) + 1.0) / static_cast<double>(todo->size()));
  }
  run.report_output(todo->empty() ? JobStatus::UpToDate : JobStatus::Done, output, Json{{"images", files}});
  return 0;
}

}  // namespace

bool is_series(const std::filesystem::path& output) { return is_movie(output) || has_number(output); }

int make_series(CommandRun& run, const std::filesystem::path& output, const PictureSeries& series,
                const MovieOptions& movie) {
  return is_movie(output) ? make_movie(run, output, series, movie) : make_images(run, output, series);
}

}  // namespace patinate::cli
