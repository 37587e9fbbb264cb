#include <algorithm>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <vector>

#include "libcommon/image/file_bytes.h"
#include "libcommon/image/file_words.h"

namespace patinate {

namespace {

constexpr int kMaxBoxes = 100'000;

/// A box of JPEG 2000 and HEIF.
struct Box {
  std::string_view type;
  std::uint64_t begin = 0, end = 0;  ///< Range of its content.
};

std::vector<Box> boxes_in(const FileBytes& file, std::uint64_t begin, std::uint64_t end) {
  std::vector<Box> boxes;
  while (boxes.size() < kMaxBoxes && begin + 8 <= end && file.holds(begin, 8)) {
    std::uint64_t size = file.number(begin, 4), head = 8;
    if (size == 1) size = file.number(begin + 8, 8), head = 16;
    if (size == 0) size = end - begin;
    if (size < head || size > end - begin) break;
    boxes.push_back({file.text(begin + 4, 4), begin + head, begin + size});
    begin += size;
  }
  return boxes;
}

/// The content of the first box with the name, in one after another.
std::optional<Box> find_box(const FileBytes& file, std::initializer_list<std::string_view> path) {
  Box at{"", 0, file.size()};
  for (std::string_view name : path) {
    const std::vector<Box> boxes = boxes_in(file, at.begin, at.end);
    const auto found = std::find_if(boxes.begin(), boxes.end(), [&](const Box& b) { return b.type == name; });
    if (found == boxes.end()) return {};
    at = *found;
    if (name == "meta") at.begin += 4;  // Version and flags.
  }
  return at;
}

/// Properties (counted from 1) of the picture of a HEIF file.
std::vector<std::uint64_t> picture_properties(const FileBytes& file) {
  const auto primary = find_box(file, {"meta", "pitm"});
  const auto associations = find_box(file, {"meta", "iprp", "ipma"});
  std::vector<std::uint64_t> found;
  if (!primary || !associations) return found;
  const unsigned primary_width = file.number(primary->begin, 1) == 0 ? 2 : 4;
  const std::uint64_t picture = file.number(primary->begin + 4, primary_width);
  const unsigned id_width = file.number(associations->begin, 1) == 0 ? 2 : 4;
  const bool is_wide = (file.number(associations->begin + 3, 1) & 1) != 0;
  const std::uint64_t count = std::min<std::uint64_t>(file.number(associations->begin + 4, 4), kMaxBoxes);
  std::uint64_t at = associations->begin + 8;
  for (std::uint64_t i = 0; i < count && at < associations->end; ++i) {
    const std::uint64_t id = file.number(at, id_width), number = file.number(at + id_width, 1);
    at += id_width + 1;
    for (std::uint64_t k = 0; k < number; ++k, at += is_wide ? 2 : 1) {
      if (id == picture) found.push_back(is_wide ? file.number(at, 2) & 0x7fff : file.number(at, 1) & 0x7f);
    }
  }
  return found;
}

/// The EXIF data of a HEIF file: an item of its own, behind the length of what stands before it.
FileBytes exif_of_heif(const FileBytes& file) {
  const FileBytes none{std::span<const unsigned char>()};
  const auto names = find_box(file, {"meta", "iinf"}), places = find_box(file, {"meta", "iloc"});
  if (!names || !places) return none;
  std::optional<std::uint64_t> exif;
  const std::uint64_t list = names->begin + (file.number(names->begin, 1) == 0 ? 6 : 8);
  for (const Box& box : boxes_in(file, list, names->end)) {
    const std::uint64_t version = file.number(box.begin, 1);
    if (box.type != "infe" || version < 2) continue;
    const unsigned width = version == 2 ? 2 : 4;
    if (file.text(box.begin + 4 + width + 2, 4) == "Exif") exif = file.number(box.begin + 4, width);
  }
  if (!exif) return none;
  const std::uint64_t version = file.number(places->begin, 1), sizes = file.number(places->begin + 4, 2);
  const unsigned offset_size = sizes >> 12 & 15, length_size = sizes >> 8 & 15, base_size = sizes >> 4 & 15;
  const unsigned index_size = version == 0 ? 0 : sizes & 15, id_size = version < 2 ? 2 : 4;
  const auto number = [&](std::uint64_t at, unsigned size) {
    return size == 0 ? 0 : file.number(at, std::min(size, 8U));
  };
  const std::uint64_t count = std::min<std::uint64_t>(file.number(places->begin + 6, id_size), kMaxBoxes);
  std::uint64_t at = places->begin + 6 + id_size;
  for (std::uint64_t i = 0; i < count && at < places->end; ++i) {
    const std::uint64_t id = file.number(at, id_size);
    const std::uint64_t method = version == 0 ? 0 : file.number(at + id_size, 2) & 15;
    at += id_size + (version == 0 ? 2 : 4);
    const std::uint64_t base = number(at, base_size), num_extents = file.number(at + base_size, 2);
    at += base_size + 2;
    if (id == *exif && method == 0 && num_extents == 1) {
      const std::uint64_t begin = base + number(at + index_size, offset_size),
                          length = number(at + index_size + offset_size, length_size);
      // The text before the TIFF data should be counted; some count something else, and all write "Exif".
      const bool is_named = file.starts_with("Exif", begin + 4);
      const std::uint64_t skip = 4 + (is_named ? 6 : file.number(begin, 4));
      return length > skip ? FileBytes(file.part(begin + skip, length - skip)) : none;
    }
    at += num_extents * (index_size + offset_size + length_size);
  }
  return none;
}

}  // namespace

void read_jpeg_2000_words(const FileBytes& file, FileWords& words) {
  const auto box = find_box(file, {"jp2h", "colr"});
  if (!box) return;
  constexpr std::uint64_t kProfile = 2, kAnyProfile = 3, kSrgb = 16;
  const std::uint64_t method = file.number(box->begin, 1);
  if (method == kProfile || method == kAnyProfile) words.icc = file.text(box->begin + 3, box->end - box->begin - 3);
  words.is_srgb = method == 1 && file.number(box->begin + 3, 4) == kSrgb;
}

/// libheif turns pictures by the properties `irot` and `imir`, which rule; EXIF's orientation says the same again, or
/// is not used [ISO/IEC 23008-12, A.2].
void read_heif_words(const FileBytes& file, FileWords& words) {
  if (find_box(file, {"moov"})) {
    words.refusal =
        "is a sequence of pictures (HEIF or AVIF), which is not read; convert it to a movie, or save its "
        "pictures as files of their own";
  }
  const auto container = find_box(file, {"meta", "iprp", "ipco"});
  if (!container) return;
  const std::vector<Box> properties = boxes_in(file, container->begin, container->end);
  for (const std::uint64_t number : picture_properties(file)) {
    if (number == 0 || number > properties.size()) continue;
    const Box& box = properties[number - 1];
    const std::uint64_t how = file.number(box.begin, 1);
    if (box.type == "irot" && (how & 3) != 0)
      words.turn = orientation_words(how == 1 ? 8 : how == 2 ? 3 : 6) + " (HEIF irot)";
    if (box.type == "imir") words.turn += words.turn.empty() ? "mirrored (HEIF imir)" : ", mirrored (HEIF imir)";
    if (box.type != "colr") continue;
    const std::string_view kind = file.text(box.begin, 4);
    if (kind == "prof" || kind == "rICC") words.icc = file.text(box.begin + 4, box.end - box.begin - 4);
    if (kind == "nclx")
      words.code_points = ColorCodePoints{static_cast<int>(file.number(box.begin + 4, 2)),
                                          static_cast<int>(file.number(box.begin + 6, 2)), true};
  }
  if (!words.icc.empty()) words.code_points.reset();
  FileWords exif;
  const FileBytes exif_data = exif_of_heif(file);
  if (exif_data.size() > 0) read_exif_words(exif_data.part(0, exif_data.size()), exif);
  if (exif.orientation != 1 && words.turn.empty()) {
    words.problems.push_back("its " + orientation_text(exif.orientation) +
                             " is not used: a HEIF is turned by `irot`, which it lacks");
  }
}

}  // namespace patinate
