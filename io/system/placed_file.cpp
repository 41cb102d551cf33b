#include "io/system/placed_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <new>
#include <string>
#include <system_error>
#include <utility>

#include "io/error.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/system_advice.h"

namespace orbweave {
namespace {

/// What addresses, offsets and lengths are multiples of when the page cache is passed by: enough
/// for every device in use.
constexpr std::size_t kPage = 4096;
/// Below that, the pages that are only partly written would be most of the work.
constexpr std::size_t kLeastDirect = 16 * kPage;
constexpr int kWriters = 2;

}  // namespace

void PlacedBuffer::Free::operator()(std::byte* memory) const { std::free(memory); }

std::byte* PlacedBuffer::place(std::uint64_t offset, std::size_t bytes) {
  const std::size_t shift = offset % kPage;
  const std::size_t room = (shift + bytes + kPage - 1) / kPage * kPage;
  if (room > capacity_) {
    memory_.reset(static_cast<std::byte*>(std::aligned_alloc(kPage, room)));
    capacity_ = memory_ == nullptr ? 0 : room;
    if (memory_ == nullptr) throw std::bad_alloc();
  }
  offset_ = offset;
  data_ = memory_.get() + shift;
  bytes_ = bytes;
  return data_;
}

PlacedFile::PlacedFile(const std::filesystem::path& path, std::filesystem::path name)
    : name_(std::move(name)), file_(::open(path.c_str(), O_WRONLY | O_CLOEXEC)) {
  if (!file_.valid()) fail("cannot write the file");
#ifdef O_DIRECT
  direct_ = FileDescriptor(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_DIRECT));
  can_direct_ = direct_.valid();
#endif
}

void PlacedFile::reserve(std::uint64_t bytes) {
#ifdef __linux__
  int status;
  do {
    status = file_calls.fallocate(file_.get(), 0, 0, static_cast<off_t>(bytes));
  } while (status != 0 && errno == EINTR);
  if (status == 0 || bytes == 0) return;
  if (errno != EOPNOTSUPP && errno != ENOSYS && errno != EINVAL) fail("cannot write the file");
#endif
  if (file_calls.ftruncate(file_.get(), static_cast<off_t>(bytes)) != 0)
    fail("cannot write the file");
}

void PlacedFile::write(const PlacedBuffer& buffer) {
  const std::span<const std::byte> bytes = buffer.bytes();
  const std::size_t head =
      std::min(bytes.size(), static_cast<std::size_t>((kPage - buffer.offset() % kPage) % kPage));
  const std::size_t pages = (bytes.size() - head) / kPage * kPage;
  if (pages < kLeastDirect || !can_direct_) return write(buffer.offset(), bytes);
  write(buffer.offset(), bytes.first(head));
  const std::uint64_t begin = buffer.offset() + head;
  if (!write_direct(begin, bytes.subspan(head, pages))) write(begin, bytes.subspan(head, pages));
  write(begin + pages, bytes.subspan(head + pages));
}

void PlacedFile::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  write_to(file_.get(), offset, bytes);
}

/// False where the file system says that it cannot, which some only do now.
bool PlacedFile::write_direct(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t wrote =
        file_calls.pwrite(direct_.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0 && errno == EINVAL) {
      can_direct_ = false;
      return false;
    }
    if (wrote < 0) fail("cannot write the file");
    const auto count = static_cast<std::size_t>(wrote);
    offset += count;
    bytes = bytes.subspan(count);
    if (count % kPage != 0) {
      // Stopped inside a page, as at a limit of the file's size; the rest is said by a plain write.
      write_to(file_.get(), offset, bytes);
      return true;
    }
  }
  return true;
}

void PlacedFile::write_to(int file, std::uint64_t offset, std::span<const std::byte> bytes) {
  if (!write_at(file, offset, bytes)) fail("cannot write the file");
}

void PlacedFile::flush() {
  if (file_calls.fsync(file_.get()) != 0) fail("cannot flush the file");
}

void PlacedFile::fail(const char* problem) const {
  const int error = errno;
  throw_resource(problem + (": " + system_reason(error)),
                 {.file = name_.string(), .advice = advice_on(error)});
}

// Where the second thread cannot be started the destructor ends the first.
WriteBehind::WriteBehind(PlacedFile& file, std::size_t buffers) : WriteBehind(file) {
  for (std::size_t i = 0; i < buffers; ++i) free_.push_back(std::make_unique<PlacedBuffer>());
  for (int i = 0; i < kWriters; ++i) threads_.emplace_back([this] { run(); });
}

WriteBehind::~WriteBehind() {
  {
    const std::scoped_lock lock(mutex_);
    given_.clear();
    ending_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

std::unique_ptr<PlacedBuffer> WriteBehind::take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return failure_ != nullptr || !free_.empty(); });
  if (failure_) std::rethrow_exception(failure_);
  std::unique_ptr<PlacedBuffer> buffer = std::move(free_.back());
  free_.pop_back();
  return buffer;
}

void WriteBehind::give(std::unique_ptr<PlacedBuffer> buffer) {
  {
    const std::scoped_lock lock(mutex_);
    given_.push_back(std::move(buffer));
  }
  changed_.notify_all();
}

void WriteBehind::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return failure_ != nullptr || (given_.empty() && writing_ == 0); });
  if (failure_) std::rethrow_exception(failure_);
}

void WriteBehind::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return ending_ || (!failure_ && !given_.empty()); });
    if (ending_) return;
    std::unique_ptr<PlacedBuffer> buffer = std::move(given_.front());
    given_.pop_front();
    ++writing_;
    lock.unlock();
    std::exception_ptr failure;
    try {
      file_.write(*buffer);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    --writing_;
    free_.push_back(std::move(buffer));
    if (failure && !failure_) failure_ = failure;
    changed_.notify_all();
  }
}

}  // namespace orbweave
