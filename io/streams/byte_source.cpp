#include "io/streams/byte_source.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "io/error.h"
#include "io/streams/gzip_source.h"
#include "io/system/file_descriptor.h"

namespace orbweave {
namespace {

class FileSource final : public ByteSource {
 public:
  /// Takes over the descriptor.
  FileSource(int descriptor, std::string name) : descriptor_(descriptor), name_(std::move(name)) {}
  ~FileSource() override {
    if (descriptor_ != STDIN_FILENO) ::close(descriptor_);
  }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  std::size_t read(std::span<std::byte> out) override {
    std::size_t done = 0;
    while (done < out.size()) {
      const ssize_t got = ::read(descriptor_, out.data() + done, out.size() - done);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0)
        throw_unread("cannot read the file",
                     {.file = name_, .place = "byte " + std::to_string(bytes_read_)}, errno);
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
      bytes_read_ += static_cast<std::uint64_t>(got);
    }
    return done;
  }
  std::uint64_t skip(std::uint64_t bytes) override {
    if (!size_) return ByteSource::skip(bytes);
    const std::uint64_t step = std::min(bytes, *size_ - std::min(*size_, bytes_read_));
    if (::lseek(descriptor_, static_cast<off_t>(bytes_read_ + step), SEEK_SET) < 0)
      return ByteSource::skip(bytes);
    bytes_read_ += step;
    return step;
  }
  std::uint64_t bytes_read() const override { return bytes_read_; }
  std::uint64_t bytes_total() const override { return size_.value_or(0); }
  std::optional<std::uint64_t> length() const override { return size_; }
  const std::string& name() const override { return name_; }
  void set_size(std::optional<std::uint64_t> size) { size_ = size; }

 private:
  int descriptor_;
  std::string name_;
  std::optional<std::uint64_t> size_;
  std::uint64_t bytes_read_ = 0;
};

class MemorySource final : public ByteSource {
 public:
  MemorySource(std::span<const std::byte> bytes, std::string name)
      : bytes_(bytes), name_(std::move(name)) {}
  std::size_t read(std::span<std::byte> out) override {
    const std::size_t count = std::min(out.size(), bytes_.size() - at_);
    if (count != 0) std::memcpy(out.data(), bytes_.data() + at_, count);
    at_ += count;
    return count;
  }
  std::uint64_t bytes_read() const override { return at_; }
  std::uint64_t bytes_total() const override { return bytes_.size(); }
  std::optional<std::uint64_t> length() const override { return bytes_.size(); }
  const std::string& name() const override { return name_; }

 private:
  std::span<const std::byte> bytes_;
  std::string name_;
  std::size_t at_ = 0;
};

}  // namespace

std::uint64_t ByteSource::skip(std::uint64_t bytes) {
  std::vector<std::byte> dropped(
      static_cast<std::size_t>(std::min<std::uint64_t>(bytes, std::uint64_t{1} << 18)));
  std::uint64_t left = bytes;
  while (left > 0) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(left, dropped.size()));
    const std::size_t got = read(std::span(dropped).first(wanted));
    left -= got;
    if (got < wanted) break;
  }
  return bytes - left;
}

std::unique_ptr<ByteSource> open_byte_source(const std::filesystem::path& path) {
  if (path == "-") return std::make_unique<FileSource>(STDIN_FILENO, "standard input");
  const std::string name = path.string();
  const int descriptor = open_or_throw(name);
  // Owns the descriptor from here on, whatever the checks throw.
  auto file = std::make_unique<FileSource>(descriptor, name);
  file->set_size(checked_size(descriptor, name));
  ::posix_fadvise(descriptor, 0, 0, POSIX_FADV_SEQUENTIAL);
  if (path.extension() == ".gz" || starts_like_gzip(descriptor))
    return gunzip_byte_source(std::move(file));
  return file;
}

std::unique_ptr<ByteSource> memory_byte_source(std::span<const std::byte> bytes, std::string name) {
  return std::make_unique<MemorySource>(bytes, std::move(name));
}

}  // namespace orbweave
