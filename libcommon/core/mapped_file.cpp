#include "libcommon/core/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace patinate {

MappedFile::MappedFile(std::filesystem::path path) : path_(std::move(path)) {
  const auto refuse = [&] { throw IoError(path_.string(), std::string("cannot be read; ") + std::strerror(errno)); };
  const int file = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) refuse();
  struct stat facts {};
  void* memory = nullptr;
  if (::fstat(file, &facts) == 0 && facts.st_size > 0)
    memory = ::mmap(nullptr, static_cast<std::size_t>(facts.st_size), PROT_READ, MAP_PRIVATE, file, 0);
  ::close(file);
  if (memory == MAP_FAILED) refuse();
  bytes_ = static_cast<std::byte*>(memory);
  size_ = static_cast<std::size_t>(facts.st_size);
}

MappedFile::~MappedFile() {
  if (bytes_ != nullptr) ::munmap(bytes_, size_);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : path_(std::move(other.path_)),
      bytes_(std::exchange(other.bytes_, nullptr)),
      size_(std::exchange(other.size_, 0)) {}

void MappedFile::fail() const { throw IoError(path_.string(), "is damaged; remove it and try again"); }

}  // namespace patinate
