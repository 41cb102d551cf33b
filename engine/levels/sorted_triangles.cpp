#include "engine/levels/sorted_triangles.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <queue>
#include <utility>

namespace orbweave {
namespace {

constexpr std::size_t kBufferedTriangles = std::size_t{1} << 14;

/// A run that is read from front to back.
class RunReader {
 public:
  RunReader(const SpoolFile& file, std::uint64_t offset, std::uint64_t size)
      : file_(&file), offset_(offset), left_(size) {
    refill();
  }
  bool at_end() const { return at_ == buffer_.size(); }
  const CodedTriangle& front() const { return buffer_[at_]; }
  void pop() {
    if (++at_ == buffer_.size()) refill();
  }

 private:
  void refill() {
    buffer_.resize(std::min<std::uint64_t>(left_, kBufferedTriangles));
    at_ = 0;
    file_->read_values(offset_, std::span(buffer_));
    offset_ += buffer_.size() * sizeof(CodedTriangle);
    left_ -= buffer_.size();
  }

  const SpoolFile* file_;
  std::uint64_t offset_;
  std::uint64_t left_;
  std::vector<CodedTriangle> buffer_;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<CodedTriangle> SortedTriangles::read(std::uint64_t first, std::uint64_t count) const {
  std::vector<CodedTriangle> triangles(count);
  file_->read_values(offset_ + first * sizeof(CodedTriangle), std::span(triangles));
  return triangles;
}

std::uint64_t SortedTriangles::first_at_least(std::uint64_t code, std::uint64_t first,
                                              std::uint64_t last) const {
  while (first < last) {
    const std::uint64_t middle = first + (last - first) / 2;
    if (read(middle, 1).front().code < code)
      first = middle + 1;
    else
      last = middle;
  }
  return first;
}

TriangleSorter::TriangleSorter(std::filesystem::path directory, std::size_t run_bytes)
    : directory_(std::move(directory)),
      most_(std::max(run_bytes / sizeof(CodedTriangle), kBufferedTriangles)),
      file_(std::make_unique<SpoolFile>(directory_)) {}

void TriangleSorter::add(const CodedTriangle& triangle) {
  if (triangles_.size() == most_) write_run();
  if (triangles_.size() == triangles_.capacity())
    triangles_.reserve(std::min(most_, std::max(2 * triangles_.size(), kBufferedTriangles)));
  triangles_.push_back(triangle);
}

void TriangleSorter::write_run() {
  tbb::parallel_sort(triangles_.begin(), triangles_.end());
  const std::uint64_t offset = file_->append_values(std::span<const CodedTriangle>(triangles_));
  runs_.push_back({offset, triangles_.size()});
  triangles_.clear();
}

SortedTriangles TriangleSorter::finish(const StopToken& stop) {
  if (!triangles_.empty() || runs_.empty()) write_run();
  triangles_ = {};
  if (runs_.size() > 1) return merged(stop);
  return {std::move(file_), runs_.front().offset, runs_.front().size};
}

SortedTriangles TriangleSorter::merged(const StopToken& stop) const {
  std::vector<RunReader> readers;
  readers.reserve(runs_.size());
  std::uint64_t all = 0;
  for (const Run& run : runs_) {
    readers.emplace_back(*file_, run.offset, run.size);
    all += run.size;
  }
  const auto comes_later = [&](std::size_t a, std::size_t b) {
    return readers[b].front() < readers[a].front();
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(comes_later)> queue(
      comes_later);
  for (std::size_t i = 0; i < readers.size(); ++i) queue.push(i);
  auto merged = std::make_unique<SpoolFile>(directory_);
  std::vector<CodedTriangle> batch;
  const auto flush = [&] {
    stop.check();
    merged->append_values(std::span<const CodedTriangle>(batch));
    batch.clear();
  };
  while (!queue.empty()) {
    const std::size_t next = queue.top();
    queue.pop();
    batch.push_back(readers[next].front());
    readers[next].pop();
    if (!readers[next].at_end()) queue.push(next);
    if (batch.size() == kBufferedTriangles) flush();
  }
  flush();
  return {std::move(merged), 0, all};
}

}  // namespace orbweave
