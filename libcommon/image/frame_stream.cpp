#include "libcommon/image/frame_stream.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <span>
#include <thread>
#include <utility>

#include "libcommon/image/decoder_process.h"

namespace patinate {

namespace {

constexpr std::size_t kMaxProcesses = 4;

/// More than there are workers, so that none of them finds its frame gone.
std::size_t max_waiting() { return std::max<std::size_t>(16, 2 * std::size_t{std::thread::hardware_concurrency()}); }

}  // namespace

struct FrameStream::Impl {
  /// A process somewhere in the movie: workers at distant places do not send each other back.
  struct Cursor {
    std::unique_ptr<DecoderProcess> process;
    int next = 0;  ///< The frame it comes to.
    int last_use = 0;
  };

  std::filesystem::path path;
  std::vector<int> wanted;
  std::mutex mutex;
  std::vector<Cursor> cursors;
  std::map<int, CodedImage> waiting;  ///< Decoded, and not asked for yet.
  int num_uses = 0;

  std::pair<CodedImage, ImageInfo> take(int frame) {
    const std::lock_guard lock(mutex);
    try {
      if (cursors.empty()) cursors.push_back({std::make_unique<DecoderProcess>(path), frame, 0});
      CodedImage image = decode(frame);
      return {std::move(image), cursors.front().process->info()};
    } catch (...) {
      cursors.clear();  // The next one who asks gets a fresh process, and its own error.
      waiting.clear();
      throw;
    }
  }

 private:
  /// Frames that are wanted in [begin, end).
  std::span<const int> wanted_between(int begin, int end) const {
    const auto from = std::lower_bound(wanted.begin(), wanted.end(), begin);
    return {from, std::lower_bound(from, wanted.end(), end)};
  }

  Cursor& cursor_for(int frame) {
    Cursor* nearest = nullptr;
    for (Cursor& c : cursors) {
      if (c.next <= frame && (nearest == nullptr || c.next > nearest->next)) nearest = &c;
    }
    if (nearest != nullptr && wanted_between(nearest->next, frame).size() < max_waiting()) return *nearest;
    if (cursors.size() < kMaxProcesses)
      return cursors.emplace_back(Cursor{std::make_unique<DecoderProcess>(path), frame, 0});
    Cursor& oldest = *std::min_element(cursors.begin(), cursors.end(),
                                       [](const Cursor& a, const Cursor& b) { return a.last_use < b.last_use; });
    oldest.next = frame;
    return oldest;
  }

  CodedImage decode(int frame) {
    if (auto found = waiting.extract(frame)) return std::move(found.mapped());
    Cursor& cursor = cursor_for(frame);
    for (const int before : wanted_between(cursor.next, frame)) {
      waiting.insert_or_assign(before, cursor.process->read(before));
      if (waiting.size() > max_waiting()) waiting.erase(waiting.begin());
    }
    cursor.next = frame + 1;
    cursor.last_use = ++num_uses;
    return cursor.process->read(frame);
  }
};

FrameStream::FrameStream(std::filesystem::path path, std::vector<int> wanted) : impl_(std::make_unique<Impl>()) {
  impl_->path = std::move(path);
  impl_->wanted = std::move(wanted);
}
FrameStream::~FrameStream() = default;

DecodedImage FrameStream::read(int frame) {
  const auto [coded, info] = impl_->take(frame);
  return decoded(coded, info, impl_->path);
}

}  // namespace patinate
