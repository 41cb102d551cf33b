#include "engine/pipeline/points/cleaned_source.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "io/points/point_views.h"
#include "io/store/chunk_points.h"

namespace orbweave {
namespace {

class CleanedSource final : public PointSource {
 public:
  CleanedSource(const ChunkStore& store, const RawCloud& cloud, const PatchOrientation* orientation)
      : store_(store),
        cloud_(cloud),
        orientation_(orientation),
        schema_(without_view(cloud.schema)) {
    for (ChunkId chunk = 0; chunk < chunks(); ++chunk)
      points_ += stored_points(store, chunk, cloud.stage);
  }

  const PointSchema& schema() const override { return schema_; }
  std::optional<std::uint64_t> declared_points() const override { return points_; }
  std::uint64_t bytes_read() const override { return delivered_ * row_bytes(); }
  std::uint64_t bytes_total() const override { return points_ * row_bytes(); }
  std::string coordinate_system() const override { return cloud_.partition.coordinate_system; }
  std::optional<Vec3> meters_per_unit() const override { return cloud_.partition.meters_per_unit; }

  bool restrict_rows(std::uint64_t first, std::uint64_t count) override {
    first_row_ = first;
    end_row_ = first + count;
    return true;
  }
  bool has_row_access() const override { return true; }

  bool read(PointCloud& batch, std::size_t capacity) override {
    while (row_ == rows_) {
      if (next_ == chunks()) {
        batch.clear();
        batch.schema = schema_;
        return false;
      }
      enter(next_++);
    }
    const std::uint64_t count = std::min<std::uint64_t>(capacity, rows_ - row_);
    batch = load_point_rows(store_, next_ - 1, cloud_.schema, row_, count, cloud_.stage);
    if (orientation_ != nullptr) turn(batch);
    drop_views(batch);
    batch.schema = schema_;
    row_ += count;
    delivered_ += count;
    return true;
  }

 private:
  ChunkId chunks() const { return static_cast<ChunkId>(cloud_.partition.octree.chunks().size()); }
  std::uint64_t row_bytes() const {
    return sizeof(Vec3) + 3 * size_of(schema_.normal_type) + schema_.attribute_bytes();
  }

  void enter(ChunkId chunk) {
    const std::uint64_t begin = rows_passed_;
    const std::uint64_t points = stored_points(store_, chunk, cloud_.stage);
    rows_passed_ += points;
    const std::uint64_t from = std::max(begin, first_row_);
    const std::uint64_t to = std::min(rows_passed_, end_row_);
    row_ = rows_ = 0;
    if (from >= to) return;
    row_ = from - begin;
    rows_ = to - begin;
    if (orientation_ != nullptr && rows_ > 0) turns_ = turns_of_chunk(store_, chunk, *orientation_);
  }

  void turn(PointCloud& batch) const {
    for (std::size_t i = 0; i < batch.size(); ++i)
      if (turns_[row_ + i] != 0) batch.normals[i] = -batch.normals[i];
  }

  const ChunkStore& store_;
  const RawCloud& cloud_;
  const PatchOrientation* orientation_;
  PointSchema schema_;
  std::uint64_t points_ = 0;
  std::uint64_t delivered_ = 0;
  ChunkId next_ = 0;        ///< chunk after the one being read
  std::uint64_t row_ = 0;   ///< of the chunk being read
  std::uint64_t rows_ = 0;  ///< where its wanted rows end
  std::uint64_t rows_passed_ = 0;
  std::uint64_t first_row_ = 0;
  std::uint64_t end_row_ = std::numeric_limits<std::uint64_t>::max();
  std::vector<std::uint8_t> turns_;
};

}  // namespace

std::unique_ptr<PointSource> open_cleaned(const ChunkStore& store, const RawCloud& cloud,
                                          const PatchOrientation* orientation) {
  return std::make_unique<CleanedSource>(store, cloud, orientation);
}

}  // namespace orbweave
