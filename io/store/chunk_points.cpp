#include "io/store/chunk_points.h"

#include <algorithm>
#include <stdexcept>

#include "io/first_touch.h"

namespace orbweave {
namespace {

constexpr const char* kPositions = "positions";
constexpr const char* kNormals = "normals";
constexpr const char* kAttributes = "attributes";
constexpr const char* kBlockBounds = "block_bounds";
constexpr const char* kSourceRows = "source_rows";

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Box) == 2 * sizeof(Vec3));

std::vector<Box> block_bounds(std::span<const Vec3> positions) {
  std::vector<Box> boxes;
  for (std::size_t begin = 0; begin < positions.size(); begin += kPointBlockRows) {
    const std::size_t rows = std::min<std::size_t>(kPointBlockRows, positions.size() - begin);
    Box box;
    for (const Vec3& p : positions.subspan(begin, rows)) box.extend(p);
    boxes.push_back(box);
  }
  return boxes;
}

std::vector<float> as_floats(std::span<const Vec3> vectors) {
  std::vector<float> values;
  values.reserve(vectors.size() * 3);
  for (const Vec3& v : vectors)
    for (int axis = 0; axis < 3; ++axis) values.push_back(static_cast<float>(v[axis]));
  return values;
}

/// Guards the reads below, which copy to memory of the schema's size.
void expect_row_bytes(const StoredResult& stored, const char* array, std::size_t bytes) {
  if (stored.row_bytes(array) != bytes)
    throw std::logic_error(std::string("stored points have another schema: ") + array);
}

void expect_schema(const StoredResult& stored, const PointSchema& schema) {
  expect_row_bytes(stored, kPositions, sizeof(Vec3));
  expect_row_bytes(stored, kBlockBounds, sizeof(Box));
  if (schema.has_normals) expect_row_bytes(stored, kNormals, 3 * size_of(schema.normal_type));
  if (schema.attribute_bytes() > 0) expect_row_bytes(stored, kAttributes, schema.attribute_bytes());
}

void read_normals(const StoredResult& stored, ScalarType type, std::uint64_t first,
                  std::uint64_t count, Vec3* out) {
  if (type == ScalarType::kFloat64) return stored.read(kNormals, first, count, out);
  std::vector<float> values(count * 3);
  stored.read(kNormals, first, count, values.data());
  for (std::size_t i = 0; i < count; ++i)
    out[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

/// Contiguous rows of which every block meets the box.
struct Run {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

std::vector<Run> runs_in_box(std::span<const Box> blocks, std::uint64_t rows, const Box& box) {
  // Bounds the scratch memory of a query; long enough for the disk.
  constexpr std::uint64_t kLongest = 64 * kPointBlockRows;
  std::vector<Run> runs;
  for (std::size_t block = 0; block < blocks.size(); ++block) {
    if (!blocks[block].intersects(box)) continue;
    const std::uint64_t first = block * std::uint64_t{kPointBlockRows};
    const std::uint64_t last = std::min(first + kPointBlockRows, rows);
    if (!runs.empty() && runs.back().last == first && last - runs.back().first <= kLongest)
      runs.back().last = last;
    else
      runs.push_back({first, last});
  }
  return runs;
}

/// One box query on one open chunk.
class BoxQuery {
 public:
  BoxQuery(const StoredResult& stored, const PointSchema& schema, const Box& box, PointParts parts)
      : stored_(stored), schema_(schema), box_(box), parts_(parts) {
    parts_.normals = parts.normals && schema.has_normals;
    result.points.schema = schema;
    result.points.schema.has_normals = parts_.normals;
    if (!parts.attributes) result.points.schema.attributes.clear();
  }

  void read(Run run) {
    positions_.resize(run.last - run.first);
    stored_.read(kPositions, run.first, positions_.size(), positions_.data());
    const std::size_t found_before = result.rows.size();
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      if (!box_.contains(positions_[i])) continue;
      result.points.positions.push_back(positions_[i]);
      result.rows.push_back(static_cast<std::uint32_t>(run.first + i));
    }
    const auto found = std::span<const std::uint32_t>(result.rows).subspan(found_before);
    if (found.empty()) return;
    if (parts_.normals) add_normals(run, found);
    if (result.points.schema.attribute_bytes() > 0) add_attributes(run, found);
  }

  PointsInBox result;

 private:
  void add_normals(Run run, std::span<const std::uint32_t> rows) {
    normals_.resize(run.last - run.first);
    read_normals(stored_, schema_.normal_type, run.first, normals_.size(), normals_.data());
    for (const std::uint32_t row : rows) result.points.normals.push_back(normals_[row - run.first]);
  }

  void add_attributes(Run run, std::span<const std::uint32_t> rows) {
    const std::size_t width = schema_.attribute_bytes();
    attributes_.resize((run.last - run.first) * width);
    stored_.read(kAttributes, run.first, run.last - run.first, attributes_.data());
    for (const std::uint32_t row : rows) {
      const auto begin = attributes_.begin() + (row - run.first) * width;
      result.points.attributes.insert(result.points.attributes.end(), begin, begin + width);
    }
  }

  const StoredResult& stored_;
  const PointSchema& schema_;
  const Box box_;
  PointParts parts_;
  std::vector<Vec3> positions_, normals_;
  std::vector<std::byte> attributes_;
};

}  // namespace

void commit_points(ChunkStore& store, ChunkId chunk, const PointCloud& points,
                   const std::string& stage, std::span<const std::uint32_t> source_rows,
                   std::span<const ArrayView> beside) {
  const std::uint64_t rows = points.size();
  const std::vector<Box> boxes = block_bounds(points.positions);
  std::vector<ArrayView> arrays = {
      {kPositions, ScalarType::kFloat64, 3, rows, points.positions.data()},
      {kBlockBounds, ScalarType::kFloat64, 6, boxes.size(), boxes.data()}};
  std::vector<float> narrow;
  if (points.schema.has_normals) {
    const bool single = points.schema.normal_type == ScalarType::kFloat32;
    if (single) narrow = as_floats(points.normals);
    const void* data = single ? static_cast<const void*>(narrow.data()) : points.normals.data();
    arrays.push_back({kNormals, points.schema.normal_type, 3, rows, data});
  }
  if (const std::size_t width = points.schema.attribute_bytes(); width > 0)
    arrays.push_back({kAttributes, ScalarType::kUint8, static_cast<std::uint32_t>(width), rows,
                      points.attributes.data()});
  if (!source_rows.empty())
    arrays.push_back({kSourceRows, ScalarType::kUint32, 1, source_rows.size(), source_rows.data()});
  arrays.insert(arrays.end(), beside.begin(), beside.end());
  store.commit(stage, chunk, arrays, false);
}

std::vector<std::uint32_t> load_source_rows(const ChunkStore& store, ChunkId chunk,
                                            const std::string& stage) {
  const auto stored = store.open(stage, chunk);
  return stored->has(kSourceRows) ? stored->read_all<std::uint32_t>(kSourceRows)
                                  : std::vector<std::uint32_t>();
}

std::uint64_t stored_points(const ChunkStore& store, ChunkId chunk, const std::string& stage) {
  return store.open(stage, chunk)->rows(kPositions);
}

std::vector<Box> stored_block_bounds(const ChunkStore& store, ChunkId chunk,
                                     const std::string& stage) {
  return store.open(stage, chunk)->read_all<Box>(kBlockBounds);
}

PointCloud load_points(const ChunkStore& store, ChunkId chunk, const PointSchema& schema,
                       const std::string& stage) {
  return load_point_rows(store, chunk, schema, 0, stored_points(store, chunk, stage), stage);
}

PointCloud load_point_rows(const ChunkStore& store, ChunkId chunk, const PointSchema& schema,
                           std::uint64_t first, std::uint64_t count, const std::string& stage) {
  PointCloud points;
  load_point_rows(store, chunk, schema, first, count, points, stage);
  return points;
}

void load_point_rows(const ChunkStore& store, ChunkId chunk, const PointSchema& schema,
                     std::uint64_t first, std::uint64_t count, PointCloud& points,
                     const std::string& stage) {
  const auto stored = store.open(stage, chunk);
  expect_schema(*stored, schema);
  points.schema = schema;
  reserve_touched(points.positions, count);
  points.positions.resize(count);
  stored->read(kPositions, first, count, points.positions.data());
  if (schema.has_normals) {
    reserve_touched(points.normals, count);
    points.normals.resize(count);
    read_normals(*stored, schema.normal_type, first, count, points.normals.data());
  } else {
    points.normals.clear();
  }
  if (const std::size_t width = schema.attribute_bytes(); width > 0) {
    reserve_touched(points.attributes, count * width);
    points.attributes.resize(count * width);
    stored->read(kAttributes, first, count, points.attributes.data());
  } else {
    points.attributes.clear();
  }
}

void load_oriented_points(const ChunkStore& store, ChunkId chunk, const PointSchema& schema,
                          std::span<Vec3> positions, std::span<Vec3> normals,
                          const std::string& stage) {
  const auto stored = store.open(stage, chunk);
  expect_schema(*stored, schema);
  if (stored->rows(kPositions) != positions.size() || normals.size() != positions.size())
    throw std::logic_error("room for another number of points than the chunk has");
  stored->read(kPositions, 0, positions.size(), positions.data());
  read_normals(*stored, schema.normal_type, 0, normals.size(), normals.data());
}

PointsInBox load_points_in_box(const ChunkStore& store, ChunkId chunk, const PointSchema& schema,
                               const Box& box, PointParts parts, const std::string& stage) {
  const auto stored = store.open(stage, chunk);
  expect_schema(*stored, schema);
  std::vector<Box> blocks(stored->rows(kBlockBounds));
  stored->read(kBlockBounds, 0, blocks.size(), blocks.data());
  BoxQuery query(*stored, schema, box, parts);
  for (const Run run : runs_in_box(blocks, stored->rows(kPositions), box)) query.read(run);
  return std::move(query.result);
}

}  // namespace orbweave
