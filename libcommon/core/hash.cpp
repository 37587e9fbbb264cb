#include "libcommon/core/hash.h"

#include <xxhash.h>

#include <array>
#include <bit>
#include <cstdio>
#include <fstream>
#include <vector>

#include "libcommon/core/read_limit.h"
#include "libcommon/core/regular_file.h"
#include "patinate/core/error.h"

namespace patinate {

struct ContentHash::State {
  struct Free {
    void operator()(XXH3_state_t* s) const { XXH3_freeState(s); }
  };
  std::unique_ptr<XXH3_state_t, Free> xxh{XXH3_createState()};
  State() { XXH3_128bits_reset(xxh.get()); }
  void update(const void* data, std::size_t size) { XXH3_128bits_update(xxh.get(), data, size); }
  void update_length(std::uint64_t n) { update(&n, sizeof n); }
};

ContentHash::ContentHash() : state_(std::make_unique<State>()) {}
ContentHash::~ContentHash() = default;
ContentHash::ContentHash(ContentHash&&) noexcept = default;
ContentHash& ContentHash::operator=(ContentHash&&) noexcept = default;

ContentHash& ContentHash::add(std::span<const std::byte> bytes) {
  state_->update_length(bytes.size());
  state_->update(bytes.data(), bytes.size());
  return *this;
}

ContentHash& ContentHash::add(std::string_view text) { return add(std::as_bytes(std::span(text))); }

ContentHash& ContentHash::add(double value) { return add(std::bit_cast<std::int64_t>(value)); }

ContentHash& ContentHash::add(std::int64_t value) {
  state_->update_length(sizeof value);
  state_->update(&value, sizeof value);
  return *this;
}

ContentHash& ContentHash::add_file(const std::filesystem::path& path) {
  check_may_read(path);
  require_regular_file(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw IoError(path.string(), "cannot be read; give a readable file");
  std::vector<char> buffer(1 << 20);
  std::uint64_t total = 0;
  while (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())), in.gcount() > 0) {
    state_->update(buffer.data(), static_cast<std::size_t>(in.gcount()));
    total += static_cast<std::uint64_t>(in.gcount());
  }
  if (in.bad()) throw IoError(path.string(), "reading failed part way");
  state_->update_length(total);
  return *this;
}

std::string ContentHash::hex() const {
  const XXH128_hash_t h = XXH3_128bits_digest(state_->xxh.get());
  std::array<char, 33> text{};
  std::snprintf(text.data(), text.size(), "%016llx%016llx", static_cast<unsigned long long>(h.high64),
                static_cast<unsigned long long>(h.low64));
  return text.data();
}

std::string hash_file(const std::filesystem::path& path) { return ContentHash().add_file(path).hex(); }

}  // namespace patinate
