#include "io/streams/byte_sink.h"

#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "io/error.h"
#include "io/streams/gzip_sink.h"
#include "io/system/atomic_file.h"
#include "io/system/file_descriptor.h"
#include "io/system/system_advice.h"

namespace orbweave {
namespace {

constexpr std::size_t kGatherBytes = std::size_t{1} << 18;

class FileSink final : public ByteSink {
 public:
  explicit FileSink(const std::filesystem::path& path) : file_(path) {}
  using ByteSink::write;
  void write(std::span<const std::byte> bytes) override { file_.write(bytes); }
  void finish() override { file_.commit(); }
  std::uint64_t bytes_written() const override { return file_.bytes_written(); }

 private:
  AtomicFile file_;
};

class StandardOutputSink final : public ByteSink {
 public:
  using ByteSink::write;
  void write(std::span<const std::byte> bytes) override {
    while (!bytes.empty()) {
      const ssize_t wrote = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
      if (wrote < 0 && errno == EINTR) continue;
      if (wrote < 0) {
        const int error = errno;
        if (error == EPIPE) throw ClosedOutput();
        throw_resource("cannot write: " + system_reason(error),
                       {.file = "standard output", .advice = advice_on(error)});
      }
      bytes = bytes.subspan(static_cast<std::size_t>(wrote));
      written_ += static_cast<std::uint64_t>(wrote);
    }
  }
  void finish() override {}
  std::uint64_t bytes_written() const override { return written_; }

 private:
  std::uint64_t written_ = 0;
};

/// Gathers small writes; large ones pass through.
class GatheringSink final : public ByteSink {
 public:
  explicit GatheringSink(std::unique_ptr<ByteSink> next) : next_(std::move(next)) {
    gathered_.reserve(kGatherBytes);
  }
  using ByteSink::write;
  void write(std::span<const std::byte> bytes) override {
    if (gathered_.size() + bytes.size() > kGatherBytes) flush();
    if (bytes.size() > kGatherBytes)
      next_->write(bytes);
    else
      gathered_.insert(gathered_.end(), bytes.begin(), bytes.end());
  }
  void finish() override {
    flush();
    next_->finish();
  }
  std::uint64_t bytes_written() const override { return next_->bytes_written() + gathered_.size(); }

 private:
  void flush() {
    if (!gathered_.empty()) next_->write(gathered_);
    gathered_.clear();
  }

  std::unique_ptr<ByteSink> next_;
  std::vector<std::byte> gathered_;
};

}  // namespace

ClosedOutput::ClosedOutput()
    : Error(ErrorKind::kResource, "the reader has closed the pipe",
            {.file = "standard output",
             .place = {},
             .found = {},
             .expected = {},
             .advice = "Write to a file to keep the whole"}) {}

std::unique_ptr<ByteSink> open_byte_sink(const std::filesystem::path& path) {
  std::unique_ptr<ByteSink> sink;
  if (path == "-")
    sink = std::make_unique<StandardOutputSink>();
  else
    sink = std::make_unique<FileSink>(path);
  if (path.extension() == ".gz") sink = gzip_byte_sink(std::move(sink));
  return std::make_unique<GatheringSink>(std::move(sink));
}

}  // namespace orbweave
