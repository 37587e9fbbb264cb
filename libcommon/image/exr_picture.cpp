#include "libcommon/image/exr_picture.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiView.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <utility>

#include "libcommon/image/image_decoder.h"

namespace patinate {

namespace {

bool is_suffix(const ExrChannel& channel, const char* suffix) {
  return ::strcasecmp(channel.suffix.c_str(), suffix) == 0;
}

/// OpenImageIO's order, which is that of our files' readers: by layer, then color before all else, then by name.
void sort_channels(std::vector<ExrChannel>& channels) {
  constexpr std::array kUsual{"R",     "Red", "G",  "Green", "B",  "Blue", "Y",  "real", "imag",  "A",
                              "Alpha", "AR",  "RA", "AG",    "GA", "AB",   "BA", "Z",    "Depth", "Zback"};
  constexpr std::array kPlace{"R", "Red",   "G",  "Green", "B",  "Blue", "X",  "Y",  "Z",     "real", "imag",
                              "A", "Alpha", "AR", "RA",    "AG", "GA",   "AB", "BA", "Depth", "Zback"};
  std::stable_sort(channels.begin(), channels.end(),
                   [](const ExrChannel& a, const ExrChannel& b) { return a.layer < b.layer; });
  for (auto begin = channels.begin(); begin != channels.end();) {
    const auto end = std::find_if(begin, channels.end(), [&](const ExrChannel& c) { return c.layer != begin->layer; });
    const auto has = [&](const char* suffix) {
      return std::any_of(begin, end, [&](const ExrChannel& c) { return is_suffix(c, suffix); });
    };
    const bool is_place = has("X") && (has("Y") || has("Z"));
    const auto rank = [](const auto& names, const ExrChannel& c) {
      return static_cast<std::size_t>(
          std::find_if(names.begin(), names.end(), [&](const char* name) { return is_suffix(c, name); }) -
          names.begin());
    };
    for (auto c = begin; c != end; ++c) c->rank = is_place ? rank(kPlace, *c) : rank(kUsual, *c);
    std::sort(begin, end, [](const ExrChannel& a, const ExrChannel& b) {
      return a.rank != b.rank ? a.rank < b.rank : a.suffix < b.suffix;
    });
    begin = end;
  }
}

/// A layer of a part that is a picture in color.
struct ColorLayer {
  int part = 0;
  std::string layer;               ///< With its dot.
  std::vector<std::string> words;  ///< Words of its part and layer, without views.
  bool is_luminance_chroma = false;

  [[nodiscard]] std::string name() const {
    std::string all;
    for (const std::string& word : words) all += (all.empty() ? "" : ".") + word;
    return all.empty() ? "part " + std::to_string(part + 1) : all;
  }
};

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words{""};
  for (const char c : text) {
    if (c == '.')
      words.emplace_back();
    else
      words.back().push_back(c);
  }
  std::erase(words, "");
  return words;
}

/// Views of the file, the default one first.
std::vector<std::string> views_of(const Imf::MultiPartInputFile& file) {
  std::vector<std::string> views;
  for (int p = 0; p < file.parts(); ++p) {
    const Imf::Header& header = file.header(p);
    std::vector<std::string> named = Imf::hasMultiView(header) ? Imf::multiView(header) : std::vector<std::string>{};
    if (header.hasView()) named.push_back(header.view());
    for (const std::string& view : named) {
      if (std::find(views.begin(), views.end(), view) == views.end()) views.push_back(view);
    }
  }
  return views;
}

bool is_deep(const Imf::Header& header) {
  return header.hasType() && (header.type() == Imf::DEEPSCANLINE || header.type() == Imf::DEEPTILE);
}

struct PartChannels {
  std::vector<ExrChannel> whole;  ///< A sample for each pixel.
  std::map<std::string, std::vector<ExrChannel>> layers;
  bool has_light = false;  ///< Floats, not just whole numbers.
};

PartChannels channels_of(const Imf::Header& header) {
  PartChannels part;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    const std::string name = it.name();
    const std::size_t dot = name.rfind('.');
    const std::size_t start = dot == std::string::npos ? 0 : dot + 1;
    const ExrChannel channel{.name = name, .layer = name.substr(0, start), .suffix = name.substr(start)};
    part.layers[channel.layer].push_back(channel);
    if (it.channel().xSampling == 1 && it.channel().ySampling == 1) part.whole.push_back(channel);
    part.has_light = part.has_light || it.channel().type != Imf::UINT;
  }
  sort_channels(part.whole);
  return part;
}

bool has_suffixes(const std::vector<ExrChannel>& channels, const std::vector<std::array<const char*, 2>>& suffixes) {
  return std::all_of(suffixes.begin(), suffixes.end(), [&](const auto& names) {
    return std::any_of(channels.begin(), channels.end(),
                       [&](const ExrChannel& c) { return is_suffix(c, names[0]) || is_suffix(c, names[1]); });
  });
}

/// Pictures in color of the default view.
std::vector<ColorLayer> color_layers(const Imf::MultiPartInputFile& file, const std::vector<std::string>& views) {
  std::vector<ColorLayer> found;
  for (int p = 0; p < file.parts(); ++p) {
    const Imf::Header& header = file.header(p);
    if (is_deep(header)) continue;
    for (const auto& [layer, channels] : channels_of(header).layers) {
      const bool is_color = has_suffixes(channels, {{"R", "Red"}, {"G", "Green"}, {"B", "Blue"}});
      // OpenEXR filters chroma of the first part alone.
      const bool is_chroma = p == 0 && has_suffixes(channels, {{"Y", "Y"}, {"RY", "RY"}, {"BY", "BY"}});
      if (!is_color && !is_chroma) continue;
      std::vector<std::string> words = words_of(layer);
      bool is_other_view = header.hasView() && !views.empty() && header.view() != views.front();
      for (std::size_t v = 1; v < views.size(); ++v)
        is_other_view = is_other_view || std::find(words.begin(), words.end(), views[v]) != words.end();
      if (is_other_view) continue;
      if (file.parts() > 1 && header.hasName()) {
        const std::vector<std::string> part_words = words_of(header.name());
        words.insert(words.begin(), part_words.begin(), part_words.end());
      }
      if (!views.empty()) std::erase(words, views.front());
      found.push_back({p, layer, std::move(words), is_chroma && !is_color});
    }
  }
  return found;
}

/// Names that renderers give the picture itself, among others of the same view.
bool is_picture_name(const ColorLayer& layer) {
  constexpr std::array kNames{"combined", "beauty", "rgba", "rgb", "c", "color", "main", "default"};
  return layer.words.empty() || std::any_of(kNames.begin(), kNames.end(), [&](const char* name) {
           return ::strcasecmp(layer.words.back().c_str(), name) == 0;
         });
}

/// The one that is meant, or nothing.
const ColorLayer* chosen_layer(const std::vector<ColorLayer>& layers, bool is_one_part) {
  if (layers.size() == 1) return &layers.front();
  std::vector<const ColorLayer*> named;
  for (const ColorLayer& layer : layers) {
    if (is_one_part && layer.layer.empty()) return &layer;
    if (is_picture_name(layer)) named.push_back(&layer);
  }
  return named.size() == 1 ? named.front() : nullptr;
}

std::string picture_text(const Imf::MultiPartInputFile& file, const ColorLayer& layer,
                         const std::vector<std::string>& views, std::size_t num_layers) {
  const Imf::Header& header = file.header(layer.part);
  std::string text;
  if (file.parts() > 1)
    text = "part " + std::to_string(layer.part + 1) + (header.hasName() ? " (" + header.name() + ")" : "") + " of " +
           std::to_string(file.parts());
  if (!layer.layer.empty()) text += (text.empty() ? "" : ", layer ") + layer.layer.substr(0, layer.layer.size() - 1);
  if (file.parts() == 1 && !layer.layer.empty() && num_layers > 1) text += " of " + std::to_string(num_layers);
  if (views.size() > 1) text += (text.empty() ? "view " : ", view ") + views.front();
  return text;
}

}  // namespace

std::optional<ExrPicture> find_exr_picture(const Imf::MultiPartInputFile& file) {
  const std::vector<std::string> views = views_of(file);
  const std::vector<ColorLayer> layers = color_layers(file, views);
  ExrPicture picture;
  if (!layers.empty()) {
    const ColorLayer* chosen = chosen_layer(layers, file.parts() == 1);
    const ColorLayer& layer = chosen != nullptr ? *chosen : layers.front();
    picture.part = layer.part;
    picture.layer = layer.layer;
    picture.has_color = true;
    picture.is_luminance_chroma = layer.is_luminance_chroma;
    picture.text = picture_text(file, layer, views, channels_of(file.header(layer.part)).layers.size());
    if (chosen == nullptr) {
      std::string names;
      for (const ColorLayer& other : layers) names += (names.empty() ? "" : ", ") + other.name();
      picture.problem = "holds several pictures in color (" + names +
                        "); save the one that is meant as a file of its own, or name it beauty";
      picture.text = "not known: " + names;
    }
  }
  while (layers.empty() && picture.part < file.parts() && is_deep(file.header(picture.part))) ++picture.part;
  if (picture.part >= file.parts() || is_deep(file.header(picture.part))) return std::nullopt;
  PartChannels part = channels_of(file.header(picture.part));
  if (!part.has_light) return std::nullopt;  // Whole numbers are codes to OpenImageIO.
  picture.channels = std::move(part.whole);
  if (picture.is_luminance_chroma) {
    const bool has_alpha = has_suffixes(part.layers[picture.layer], {{"A", "Alpha"}});
    picture.channels.clear();
    for (const char* suffix : {"R", "G", "B", "A"}) {
      if (*suffix != 'A' || has_alpha)
        picture.channels.push_back({.name = picture.layer + suffix, .layer = picture.layer, .suffix = suffix});
    }
  }
  if (picture.channels.empty() || picture.channels.size() > static_cast<std::size_t>(kMaxImageChannels))
    return std::nullopt;
  return picture;
}

}  // namespace patinate
