#include "app/output/picture_series.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/request/numbered_path.h"
#include "app/request/output_file.h"
#include "app/request/path_kind.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/hash.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::app {

namespace {

OutputWork movie_work(const std::filesystem::path& output, const PictureSeries& series, const MovieOptions& movie,
                      const RunControl& planning) {
  ContentHash hash;
  hash.add("movie 1").add(series.key).add(lower_extension(output)).add(movie.fps);
  for (double t : series.times) hash.add(t);
  const auto frames = std::make_shared<MovieFrames>(MovieFrames{
      .output = output, .label = series.label, .key = hash.hex(), .keys = {}, .codes = {}, .options = movie});
  frames->codes = [series](int i, const RunControl& control) {
    const double t = series.times[i];
    return series.codes ? series.codes(t, control) : srgb8_from_linear(series.picture(t, control));
  };
  for (std::size_t i = 0; i < series.times.size(); ++i) {
    planning.throw_if_stopped();
    frames->keys.push_back(ContentHash()
                               .add("movie picture 1")
                               .add(series.key)
                               .add(series.times[i])
                               .add(static_cast<std::int64_t>(i))
                               .hex());
  }
  OutputWork work{.output = output,
                  .label = series.label,
                  .key = frames->key,
                  .existing_key = written_key(output),
                  .report = std::make_shared<const Json>(Json{{"pictures", series.times.size()}, {"fps", movie.fps}})};
  work.movie = frames;
  work.make = [frames](const RunControl& control) {
    const RunControl silent = control.silent();
    write_coded_movie(
        frames->output, static_cast<int>(frames->keys.size()), [&](int i) { return frames->codes(i, silent); },
        frames->options, frames->key, control);
  };
  return work;
}

OutputWork images_work(const std::filesystem::path& output, const PictureSeries& series, const RunControl& planning) {
  require_extension(output, image_extensions());
  OutputWork work{.output = output, .label = series.label, .key = "", .existing_key = "", .report = nullptr};
  ContentHash all;
  Json files = Json::array();
  const auto shared = std::make_shared<const PictureSeries>(series);
  for (std::size_t i = 0; i < series.times.size(); ++i) {
    planning.throw_if_stopped();
    const double t = series.times[i];
    const std::filesystem::path file = numbered_path(output, static_cast<int>(i));
    const std::string key = ContentHash().add("picture 1").add(series.key).add(t).add(lower_extension(output)).hex();
    files.push_back(Json{{series.measure, t}, {"file", file.string()}});
    work.pieces.push_back({{file}, key, [shared, t, file, key](const RunControl& control) {
                             if (shared->write) return shared->write(t, file, key, control);
                             write_color(file, shared->picture(t, control), key);
                           }});
    all.add(key);
  }
  work.key = all.hex();
  work.report = std::make_shared<const Json>(Json{{"images", files}});
  return work;
}

}  // namespace

bool is_movie(const std::filesystem::path& output) {
  const std::vector<std::string>& all = movie_extensions();
  return std::find(all.begin(), all.end(), lower_extension(output)) != all.end();
}

bool is_series(const std::filesystem::path& output) { return is_movie(output) || has_number(output); }

OutputWork series_work(const std::filesystem::path& output, const PictureSeries& series, const MovieOptions& movie,
                       const RunControl& planning) {
  return is_movie(output) ? movie_work(output, series, movie, planning) : images_work(output, series, planning);
}

}  // namespace patinate::app
