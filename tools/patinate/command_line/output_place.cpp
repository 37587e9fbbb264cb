#include "tools/patinate/command_line/output_place.h"

#include <algorithm>
#include <system_error>

#include "app/request/usage_error.h"
#include "libcommon/core/files.h"
#include "libcommon/job/result_folder.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// Without links, "..", and a slash at the end.
fs::path place_of(const fs::path& path) {
  std::error_code error;
  fs::path place = fs::weakly_canonical(fs::absolute(path, error), error).lexically_normal();
  return place.has_filename() ? place : place.parent_path();
}

bool is_inside(const fs::path& place, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), place.begin(), place.end()).first == folder.end();
}

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

/// Files that a text names, as far as they exist: the whole of it, and its words with and without what may be a minus
/// or a plus.
std::vector<fs::path> files_named_by(const std::string& text) {
  std::vector<std::string> words{text};
  for (const char* separators : {" ()*,=:;!|&<>^?", " ()*,=:;!|&<>^?+-"}) {
    for (std::size_t begin = 0; (begin = text.find_first_not_of(separators, begin)) != std::string::npos;) {
      const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
      words.push_back(text.substr(begin, end - begin));
      begin = end;
    }
  }
  std::vector<fs::path> files;
  for (const std::string& word : words) {
    std::error_code error;
    if (fs::is_regular_file(word, error)) files.emplace_back(word);
  }
  return files;
}

/// The files that stand where the output, or one of its numbered images, is to be.
std::vector<fs::path> places_of_output(const fs::path& output) {
  std::vector<fs::path> places{place_of(output)};
  std::string pattern = output.filename().string();
  const std::size_t percent = pattern.find('%'), udim = pattern.find("<UDIM>");
  const std::size_t end = percent == std::string::npos ? std::string::npos : pattern.find('d', percent);
  if (udim != std::string::npos) {
    pattern.replace(udim, 6, "*");
  } else if (end != std::string::npos) {
    pattern.replace(percent, end + 1 - percent, "*");
  } else if (output.has_extension()) {
    pattern = output.stem().string() + ".????" + output.extension().string();  // Tiles: 1001 and so on.
  } else {
    return places;  // A folder, or no image.
  }
  const fs::path folder = place_of(output).parent_path();
  std::error_code error;
  if (!fs::is_directory(folder, error)) return places;
  for (const fs::path& file : list_files(folder, pattern)) places.push_back(place_of(file));
  return places;
}

[[noreturn]] void refuse(const std::string& argument, const fs::path& output, const std::string& why) {
  throw app::UsageError(argument + ": found `" + output.string() + "`, " + why + "; expected another place");
}

}  // namespace

void require_apart(const std::string& argument, const fs::path& output, const std::vector<GivenInput>& inputs) {
  const std::vector<fs::path> places = places_of_output(output);
  for (const GivenInput& input : inputs) {
    const std::vector<fs::path> files = input.is_path ? std::vector<fs::path>{input.text} : files_named_by(input.text);
    for (const fs::path& file : files) {
      if (!is_there(file)) continue;
      const fs::path place = place_of(file);
      if (std::find(places.begin(), places.end(), place) != places.end())
        refuse(argument, output, "which is an input (" + input.argument + ") and would be replaced");
      if (is_inside(place, places.front()))
        refuse(argument, output, "which holds an input (" + input.argument + ") and would be replaced");
    }
  }
  const fs::path result = result_around(places.front().parent_path());
  if (!result.empty())
    refuse(argument, output,
           "which lies inside " + result.string() + ", a finished result, which stays as it was made");
}

}  // namespace patinate::cli
