#include "io/streams/gzip_source.h"

#include <zlib.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "io/error.h"

namespace orbweave {
namespace {

constexpr std::size_t kInputBytes = std::size_t{1} << 18;
// inflateInit2: the largest window, plus 16 for "gzip and nothing else".
constexpr int kGzipWindowBits = 15 + 16;

class GzipSource final : public ByteSource {
 public:
  explicit GzipSource(std::unique_ptr<ByteSource> compressed) : compressed_(std::move(compressed)) {
    const std::uint64_t length = compressed_->length().value_or(kInputBytes);
    input_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(length + 1, kInputBytes)));
    if (inflateInit2(&stream_, kGzipWindowBits) != Z_OK)
      throw_resource("cannot start the decompressor", {.file = name()});
  }
  ~GzipSource() override { inflateEnd(&stream_); }
  GzipSource(const GzipSource&) = delete;
  GzipSource& operator=(const GzipSource&) = delete;

  std::size_t read(std::span<std::byte> out) override {
    std::size_t done = 0;
    while (done < out.size() && !at_end_) {
      if (stream_.avail_in == 0) refill();
      done += inflate_some(out.subspan(done));
    }
    return done;
  }
  std::uint64_t bytes_read() const override { return compressed_->bytes_read() - stream_.avail_in; }
  std::uint64_t bytes_total() const override { return compressed_->bytes_total(); }
  std::optional<std::uint64_t> length() const override { return std::nullopt; }
  const std::string& name() const override { return compressed_->name(); }

 private:
  void refill() {
    stream_.avail_in = static_cast<uInt>(compressed_->read(input_));
    stream_.next_in = reinterpret_cast<Bytef*>(input_.data());
    if (stream_.avail_in != 0) return;
    // Between members the data may end; inside one it may not.
    if (inside_member_ || bytes_read() == 0) damaged("the compressed data ends early");
    at_end_ = true;
  }

  std::size_t inflate_some(std::span<std::byte> out) {
    if (at_end_ || (!inside_member_ && !has_start())) return 0;
    // zlib counts in 32 bits.
    const auto room = static_cast<uInt>(std::min<std::size_t>(out.size(), std::size_t{1} << 30));
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = room;
    inside_member_ = true;
    const int status = inflate(&stream_, Z_NO_FLUSH);
    if (status == Z_MEM_ERROR) throw_resource("no memory to decompress", {.file = name()});
    if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR)
      damaged("the compressed data is damaged");
    if (status == Z_STREAM_END) {
      inside_member_ = false;
      member_has_ended_ = true;
      inflateReset(&stream_);
    }
    return room - stream_.avail_out;
  }

  /// What follows a member is another one, or zeros to the end of a block of a tape or disk image.
  /// Returns false where no more bytes are at hand.
  bool has_start() {
    constexpr Bytef kFirstByte = 0x1f;
    if (!member_has_ended_) return true;
    for (; stream_.avail_in != 0 && *stream_.next_in == 0; --stream_.avail_in) ++stream_.next_in;
    if (stream_.avail_in == 0) return false;
    if (*stream_.next_in == kFirstByte) return true;
    throw_bad_input("the file goes on behind its compressed data",
                    {.file = name(),
                     .place = "byte " + std::to_string(bytes_read()),
                     .found = "bytes that are no gzip data",
                     .expected = "the end of the file"});
  }

  [[noreturn]] void damaged(const std::string& problem) const {
    throw_bad_input(problem, {.file = name(),
                              .place = "byte " + std::to_string(bytes_read()),
                              .found = stream_.msg != nullptr ? stream_.msg : "",
                              .expected = "gzip data"});
  }

  std::unique_ptr<ByteSource> compressed_;
  std::vector<std::byte> input_;
  z_stream stream_{};
  bool inside_member_ = false;
  bool member_has_ended_ = false;
  bool at_end_ = false;
};

}  // namespace

std::unique_ptr<ByteSource> gunzip_byte_source(std::unique_ptr<ByteSource> compressed) {
  return std::make_unique<GzipSource>(std::move(compressed));
}

}  // namespace orbweave
