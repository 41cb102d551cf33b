#include "io/streams/stoppable.h"

#include <utility>

namespace orbweave {
namespace {

class StoppableBytes final : public ByteSource {
 public:
  StoppableBytes(std::unique_ptr<ByteSource> source, const StopToken* stop)
      : source_(std::move(source)), stop_(stop) {}
  std::size_t read(std::span<std::byte> out) override {
    check_stop(stop_);
    return source_->read(out);
  }
  std::uint64_t skip(std::uint64_t bytes) override {
    check_stop(stop_);
    return source_->skip(bytes);
  }
  std::uint64_t bytes_read() const override { return source_->bytes_read(); }
  std::uint64_t bytes_total() const override { return source_->bytes_total(); }
  std::optional<std::uint64_t> length() const override { return source_->length(); }
  const std::string& name() const override { return source_->name(); }

 private:
  std::unique_ptr<ByteSource> source_;
  const StopToken* stop_;
};

class StoppableFile final : public RandomAccess {
 public:
  StoppableFile(std::unique_ptr<RandomAccess> file, const StopToken* stop)
      : file_(std::move(file)), stop_(stop) {}
  std::uint64_t size() const override { return file_->size(); }
  const std::string& name() const override { return file_->name(); }

 private:
  void read_inside(std::uint64_t offset, std::span<std::byte> out) const override {
    check_stop(stop_);
    file_->read(offset, out);
  }

  std::unique_ptr<RandomAccess> file_;
  const StopToken* stop_;
};

}  // namespace

std::unique_ptr<ByteSource> stoppable(std::unique_ptr<ByteSource> source, const StopToken* stop) {
  if (stop == nullptr) return source;
  return std::make_unique<StoppableBytes>(std::move(source), stop);
}

std::unique_ptr<RandomAccess> stoppable(std::unique_ptr<RandomAccess> file, const StopToken* stop) {
  if (stop == nullptr) return file;
  return std::make_unique<StoppableFile>(std::move(file), stop);
}

}  // namespace orbweave
