#include "io/streams/gzip_sink.h"

#include <zlib.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "io/error.h"

namespace orbweave {
namespace {

constexpr std::size_t kOutputBytes = std::size_t{1} << 18;
constexpr int kGzipWindowBits = 15 + 16;
constexpr int kMemoryLevel = 8;  // zlib's default

class GzipSink final : public ByteSink {
 public:
  explicit GzipSink(std::unique_ptr<ByteSink> next) : next_(std::move(next)), out_(kOutputBytes) {
    if (deflateInit2(&stream_, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzipWindowBits, kMemoryLevel,
                     Z_DEFAULT_STRATEGY) != Z_OK)
      throw_resource("no memory to compress");
  }
  ~GzipSink() override { deflateEnd(&stream_); }
  GzipSink(const GzipSink&) = delete;
  GzipSink& operator=(const GzipSink&) = delete;

  using ByteSink::write;
  void write(std::span<const std::byte> bytes) override {
    while (!bytes.empty()) {
      // zlib counts in 32 bits.
      const auto piece = bytes.first(std::min(bytes.size(), std::size_t{1} << 30));
      stream_.next_in =
          const_cast<Bytef*>(reinterpret_cast<const Bytef*>(piece.data()));  // only read
      stream_.avail_in = static_cast<uInt>(piece.size());
      compress(Z_NO_FLUSH);
      bytes = bytes.subspan(piece.size());
    }
  }
  void finish() override {
    stream_.avail_in = 0;
    compress(Z_FINISH);
    next_->finish();
  }
  std::uint64_t bytes_written() const override { return next_->bytes_written(); }

 private:
  void compress(int flush) {
    do {
      stream_.next_out = reinterpret_cast<Bytef*>(out_.data());
      stream_.avail_out = static_cast<uInt>(out_.size());
      deflate(&stream_, flush);
      next_->write(std::span(out_).first(out_.size() - stream_.avail_out));
    } while (stream_.avail_out == 0);
  }

  std::unique_ptr<ByteSink> next_;
  std::vector<std::byte> out_;
  z_stream stream_{};
};

}  // namespace

std::unique_ptr<ByteSink> gzip_byte_sink(std::unique_ptr<ByteSink> compressed) {
  return std::make_unique<GzipSink>(std::move(compressed));
}

}  // namespace orbweave
