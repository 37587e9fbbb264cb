#include "libcommon/output/usdz_archive.h"

#include <zlib.h>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::uint64_t kAlignment = 64;  // What USDZ asks for.
constexpr std::uint64_t kLargest = 0xFFFFFFFFu;
constexpr std::uint32_t kFirstDay = 0x0021;  // 1980-01-01: zip knows no "none".

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xFF);
}

}  // namespace

UsdzArchive::UsdzArchive(const std::filesystem::path& path) : path_(path), out_(path, std::ios::binary) {
  if (!out_) throw CannotComplete(path.string() + ": cannot be written");
}

void UsdzArchive::write(const std::string& bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out_) throw CannotComplete(path_.string() + ": cannot be written; is the disk full?");
  position_ += bytes.size();
}

void UsdzArchive::add(const std::string& name, const std::filesystem::path& file) {
  const std::string bytes = read_file(file);
  if (position_ + bytes.size() + name.size() + 256 > kLargest)
    throw CannotComplete(path_.string() + ": would hold more than 4 GiB; export fewer times, or .usda");
  const auto crc = static_cast<std::uint32_t>(
      crc32_z(crc32(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
  const Entry entry{name, crc, static_cast<std::uint32_t>(bytes.size()), static_cast<std::uint32_t>(position_)};
  constexpr std::uint64_t kHeader = 30, kExtraHeader = 4;
  // An extra field fills up to where the file may begin.
  const std::uint64_t begin = position_ + kHeader + name.size();
  std::uint64_t extra = (kAlignment - begin % kAlignment) % kAlignment;
  if (extra != 0 && extra < kExtraHeader) extra += kAlignment;
  std::string head;
  put(head, 0x04034b50, 4);
  put(head, 20, 2);  // Version that is needed,
  put(head, 0, 2);   // no flags,
  put(head, 0, 2);   // not compressed.
  put(head, 0, 2);
  put(head, kFirstDay, 2);
  put(head, crc, 4);
  put(head, entry.size, 4);
  put(head, entry.size, 4);
  put(head, name.size(), 2);
  put(head, extra, 2);
  head += name;
  if (extra != 0) {
    put(head, 0x1986, 2);  // As USD's own writer has it.
    put(head, extra - kExtraHeader, 2);
    head.append(extra - kExtraHeader, '\0');
  }
  write(head);
  write(bytes);
  entries_.push_back(entry);
}

void UsdzArchive::finish() {
  const std::uint64_t begin = position_;
  for (const Entry& entry : entries_) {
    std::string head;
    put(head, 0x02014b50, 4);
    put(head, 20, 2);
    put(head, 20, 2);
    put(head, 0, 2);
    put(head, 0, 2);
    put(head, 0, 2);
    put(head, kFirstDay, 2);
    put(head, entry.crc, 4);
    put(head, entry.size, 4);
    put(head, entry.size, 4);
    put(head, entry.name.size(), 2);
    put(head, 0, 2 + 2 + 2 + 2);  // No extra field, comment, other disk, attributes,
    put(head, 0, 4);
    put(head, entry.offset, 4);
    write(head + entry.name);
  }
  const std::uint64_t size = position_ - begin;
  std::string end;
  put(end, 0x06054b50, 4);
  put(end, 0, 4);
  put(end, entries_.size(), 2);
  put(end, entries_.size(), 2);
  put(end, size, 4);
  put(end, begin, 4);
  put(end, 0, 2);
  write(end);
  out_.close();
  if (!out_) throw CannotComplete(path_.string() + ": cannot be written; is the disk full?");
}

}  // namespace patinate
