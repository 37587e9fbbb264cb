#include "libcommon/image/decoder_wire.h"

#include <algorithm>
#include <cmath>

#include "patinate/core/error.h"

namespace patinate {

namespace {

void expect(bool is_right) {
  if (!is_right) throw InvalidInput("its decoder answered with what makes no sense");
}

int bounded(std::int32_t value, int low, int high) {
  expect(value >= low && value <= high);
  return value;
}

}  // namespace

std::string read_text(const WireRead& read) {
  const auto size = read_number<std::uint32_t>(read);
  expect(size <= kMaxWireText);
  std::string text(size, '\0');
  read(text.data(), text.size());
  return text;
}

void write_text(const WireWrite& write, const std::string& text) {
  const auto size = static_cast<std::uint32_t>(std::min<std::size_t>(text.size(), kMaxWireText));
  write_number(write, size);
  write(text.data(), size);
}

ImageInfo read_info(const WireRead& read) {
  ImageInfo info;
  info.width = bounded(read_number<std::int32_t>(read), 1, kMaxImageSide);
  info.height = bounded(read_number<std::int32_t>(read), 1, kMaxImageSide);
  const int num_channels = bounded(read_number<std::int32_t>(read), 1, kMaxImageChannels);
  for (int c = 0; c < num_channels; ++c) info.channels.push_back(read_text(read));
  info.is_integer = read_number<std::uint8_t>(read) != 0;
  info.is_raw = read_number<std::uint8_t>(read) != 0;
  info.num_frames = bounded(read_number<std::int32_t>(read), 1, kMaxImageFrames);
  info.frame_rate = read_number<double>(read);
  expect(std::isfinite(info.frame_rate) && info.frame_rate >= 0.0);
  const int num_times = bounded(read_number<std::int32_t>(read), 0, info.num_frames);
  for (int i = 0; i < num_times; ++i) {
    const double time = read_number<double>(read);
    expect(std::isfinite(time) && (i == 0 || info.frame_times_s.back() < time));
    info.frame_times_s.push_back(time);
  }
  info.date_time = read_text(read);
  info.digitized = read_text(read);
  ImageExposure& exposure = info.exposure;
  for (double* value : {&exposure.time_s, &exposure.f_number, &exposure.iso}) {
    *value = read_number<double>(read);
    expect(std::isfinite(*value) && *value >= 0.0);
  }
  exposure.white_balance = static_cast<ImageExposure::WhiteBalance>(bounded(read_number<std::int32_t>(read), 0, 2));
  info.key = read_text(read);
  ImageFacts& facts = info.facts;
  for (std::string* text :
       {&facts.color, &facts.orientation, &facts.alpha, &facts.window, &facts.layer, &facts.page, &facts.problem})
    *text = read_text(read);
  return info;
}

void write_info(const WireWrite& write, const ImageInfo& info) {
  write_number(write, std::int32_t{info.width});
  write_number(write, std::int32_t{info.height});
  write_number(write, static_cast<std::int32_t>(info.channels.size()));
  for (const std::string& channel : info.channels) write_text(write, channel);
  write_number(write, static_cast<std::uint8_t>(info.is_integer));
  write_number(write, static_cast<std::uint8_t>(info.is_raw));
  write_number(write, std::int32_t{info.num_frames});
  write_number(write, info.frame_rate);
  write_number(write, static_cast<std::int32_t>(info.frame_times_s.size()));
  for (double time : info.frame_times_s) write_number(write, time);
  write_text(write, info.date_time);
  write_text(write, info.digitized);
  const ImageExposure& exposure = info.exposure;
  for (double value : {exposure.time_s, exposure.f_number, exposure.iso}) write_number(write, value);
  write_number(write, static_cast<std::int32_t>(exposure.white_balance));
  write_text(write, info.key);
  const ImageFacts& facts = info.facts;
  for (const std::string* text :
       {&facts.color, &facts.orientation, &facts.alpha, &facts.window, &facts.layer, &facts.page, &facts.problem})
    write_text(write, *text);
}

CodedImage read_coded(const WireRead& read) {
  CodedImage image;
  image.width = bounded(read_number<std::int32_t>(read), 1, kMaxImageSide);
  image.height = bounded(read_number<std::int32_t>(read), 1, kMaxImageSide);
  image.channels = bounded(read_number<std::int32_t>(read), 1, kMaxImageChannels);
  image.type = static_cast<CodedImage::Type>(bounded(read_number<std::int32_t>(read), 0, 2));
  image.associated_alpha = bounded(read_number<std::int32_t>(read), -1, image.channels - 1);
  const std::size_t size = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                           static_cast<std::size_t>(image.channels) * bytes_per_value(image.type);
  // Grown as the bytes come, so that a claim alone allocates nothing.
  constexpr std::size_t kPart = std::size_t{1} << 24;
  while (image.bytes.size() < size) {
    const std::size_t begin = image.bytes.size();
    image.bytes.resize(std::min(size, begin + std::max(begin, kPart)));
    read(image.bytes.data() + begin, image.bytes.size() - begin);
  }
  return image;
}

void write_coded(const WireWrite& write, const CodedImage& image) {
  write_number(write, std::int32_t{image.width});
  write_number(write, std::int32_t{image.height});
  write_number(write, std::int32_t{image.channels});
  write_number(write, static_cast<std::int32_t>(image.type));
  write_number(write, std::int32_t{image.associated_alpha});
  write(image.bytes.data(), image.bytes.size());
}

}  // namespace patinate
