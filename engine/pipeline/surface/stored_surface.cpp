#include "engine/pipeline/surface/stored_surface.h"

#include <oneapi/tbb/parallel_sort.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <list>
#include <mutex>
#include <utility>

#include "engine/holes/patch/numbers_near.h"
#include "engine/holes/patch/patch_vertices.h"
#include "engine/pipeline/surface/stored_mesh.h"
#include "engine/stitching/local_numbers.h"
#include "io/first_touch.h"
#include "io/store/chunk_points.h"
#include "io/whole_loop.h"

namespace orbweave {

/// A chunk's points, the triangles it owns, and which of them meet at each vertex.
struct StoredSurface::LoadedChunk {
  PointCloud points;
  std::uint64_t first_vertex = 0;
  std::vector<Triangle> triangles;            // in the chunk's own numbers
  std::vector<std::uint64_t> outer_vertices;  // sorted
  // Triangles at vertices by their own numbers: numbers into `triangles`.
  std::vector<std::uint32_t> first;
  std::vector<std::uint32_t> at;
  std::vector<ChunkId> neighbors;  // that may own triangles at own points

  std::size_t bytes() const {
    return points.size() * (sizeof(Vec3) + points.schema.attribute_bytes()) +
           triangles.size() * sizeof(Triangle) + outer_vertices.size() * 8 +
           (first.size() + at.size()) * 4;
  }
  bool has(std::uint64_t vertex) const { return vertex - first_vertex < points.size(); }
  LocalNumbers numbers() const { return {first_vertex, points.size(), outer_vertices}; }
  /// Numbers of the triangles at a vertex; none where the chunk does not know it.
  std::span<const std::uint32_t> at_vertex(std::uint64_t vertex) const {
    const LocalNumbers known = numbers();
    const std::uint64_t slot = known.local(vertex);
    if (slot == known.count()) return {};
    return {at.data() + first[slot], at.data() + first[slot + 1]};
  }
  /// Asks the processor for what will be read of own vertices and the triangles there: it waits for
  /// several at once.
  void fetch(std::span<const std::uint64_t> vertices) const {
    for (const std::uint64_t vertex : vertices)
      __builtin_prefetch(first.data() + (vertex - first_vertex));
    for (const std::uint64_t vertex : vertices)
      __builtin_prefetch(at.data() + first[vertex - first_vertex]);
    for (const std::uint64_t vertex : vertices)
      for (std::uint32_t i = first[vertex - first_vertex]; i < first[vertex - first_vertex + 1];
           ++i)
        __builtin_prefetch(triangles.data() + at[i]);
  }
  void add_triangles(std::uint64_t vertex, std::vector<Triangle64>& out) const {
    const LocalNumbers known = numbers();
    const std::span<const std::uint32_t> wanted = at_vertex(vertex);
    const std::size_t before = out.size();
    out.resize(before + wanted.size());
    Triangle64* to = out.data() + before;
    for (const std::uint32_t triangle : wanted) *to++ = known.global(triangles[triangle]);
  }
};

namespace {

/// Points of a chunk that several threads go through.
constexpr std::size_t kLeastShared = 100'000;
/// Triangles that are read at a time where a chunk is not kept.
constexpr std::uint64_t kRowsAtATime = std::uint64_t{1} << 18;

double distance_to(const Box& box, Vec3 p) {
  double most = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    most = std::max({most, box.min[axis] - p[axis], p[axis] - box.max[axis]});
  }
  return most;
}

}  // namespace

/// The chunks read last, the least recently used dropped first.
class StoredSurface::Cache {
 public:
  Cache(const StoredSurface& surface, std::size_t memory_bytes)
      : surface_(surface), memory_bytes_(memory_bytes) {}

  std::shared_ptr<const LoadedChunk> get(ChunkId chunk) {
    std::unique_lock lock(mutex_);
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
      if (entry->first != chunk) continue;
      if (entry != entries_.begin()) entries_.splice(entries_.begin(), entries_, entry);
      return entry->second;
    }
    lock.unlock();
    // One after the other: what is being read is held beside what is kept.
    const std::scoped_lock one_reads(reading_);
    lock.lock();
    for (const auto& entry : entries_) {
      if (entry.first == chunk) return entry.second;
    }
    shrink_to(memory_bytes_ - std::min(memory_bytes_, surface_.chunk_bytes(chunk)));
    lock.unlock();
    auto loaded = load(chunk);
    lock.lock();
    held_bytes_ += loaded->bytes();
    entries_.emplace_front(chunk, loaded);
    return loaded;
  }

  void limit(std::size_t memory_bytes) {
    const std::scoped_lock lock(mutex_);
    memory_bytes_ = memory_bytes;
    shrink_to(memory_bytes_);
  }

 private:
  /// Drops the least recently used.
  void shrink_to(std::size_t bytes) {
    while (held_bytes_ > bytes && !entries_.empty()) {
      held_bytes_ -= entries_.back().second->bytes();
      entries_.pop_back();
    }
  }
  std::shared_ptr<const LoadedChunk> load(ChunkId chunk) const;
  static void find_corners(LoadedChunk& loaded);

  const StoredSurface& surface_;
  std::size_t memory_bytes_;
  std::mutex mutex_;
  std::mutex reading_;
  std::list<std::pair<ChunkId, std::shared_ptr<const LoadedChunk>>> entries_;
  std::size_t held_bytes_ = 0;
};

/// Each thread takes the vertices of a range and goes through all triangles: they are read in the
/// order of memory, and written to are a few pages around.
void StoredSurface::Cache::find_corners(LoadedChunk& loaded) {
  const std::size_t count = loaded.numbers().count();
  const std::size_t ranges =
      count < kLeastShared ? 1 : std::min(tbb::this_task_arena::max_concurrency(), 4);
  const auto for_range = [&](std::size_t range, const auto& visit) {
    const std::size_t begin = count * range / ranges, end = count * (range + 1) / ranges;
    for (std::uint32_t t = 0; t < loaded.triangles.size(); ++t)
      for (const std::uint32_t vertex : loaded.triangles[t])
        if (vertex - begin < end - begin) visit(vertex, t);
  };
  std::vector<std::uint32_t>& first = loaded.first;
  first.assign(count + 1, 0);
  for_each_whole(ranges, [&](std::size_t range) {
    for_range(range, [&](std::uint32_t vertex, std::uint32_t) { ++first[vertex + 1]; });
  });
  for (std::size_t slot = 1; slot < first.size(); ++slot) first[slot] += first[slot - 1];
  reserve_touched(loaded.at, first.back());
  loaded.at.resize(first.back());
  std::vector<std::uint32_t> place(first.begin(), first.end() - 1);
  for_each_whole(ranges, [&](std::size_t range) {
    for_range(range,
              [&](std::uint32_t vertex, std::uint32_t t) { loaded.at[place[vertex]++] = t; });
  });
}

std::shared_ptr<const StoredSurface::LoadedChunk> StoredSurface::Cache::load(ChunkId chunk) const {
  auto loaded = std::make_shared<LoadedChunk>();
  const Partition& partition = surface_.partition_;
  PointSchema schema = partition.schema;
  schema.has_normals = false;
  if (!surface_.with_values_) schema.attributes.clear();
  loaded->points = load_points(surface_.store_, chunk, schema, partition.stage);
  const auto stored = surface_.store_.open(kMeshStage, chunk);
  loaded->first_vertex = partition.first_vertex[chunk];
  const std::uint64_t triangles = stored->rows(kStoredTriangles);
  reserve_touched(loaded->triangles, triangles);
  loaded->triangles.resize(triangles);
  stored->read(kStoredTriangles, 0, triangles, loaded->triangles.data());
  loaded->outer_vertices = stored->read_all<std::uint64_t>(kStoredOuter);
  loaded->neighbors = partition.octree.neighbors(chunk, surface_.reach_);

  find_corners(*loaded);
  return loaded;
}

StoredSurface::StoredSurface(const ChunkStore& store, const Partition& partition, double reach,
                             std::size_t memory_bytes, bool with_values)
    : store_(store),
      partition_(partition),
      reach_(reach),
      with_values_(with_values && !partition.schema.attributes.empty()),
      cache_(std::make_unique<Cache>(*this, memory_bytes)) {}

StoredSurface::~StoredSurface() = default;

void StoredSurface::limit_memory(std::size_t memory_bytes) { cache_->limit(memory_bytes); }

std::size_t StoredSurface::chunk_bytes(ChunkId chunk) const {
  // Two triangles per point, each at three of the vertices.
  constexpr std::size_t kPerPoint = sizeof(Vec3) + 2 * sizeof(Triangle) + 7 * 4;
  const std::size_t attributes = with_values_ ? partition_.schema.attribute_bytes() : 0;
  return partition_.points_in(chunk) * (kPerPoint + attributes);
}

Vec3 StoredSurface::position(std::uint64_t vertex) const {
  const ChunkId chunk = partition_.chunk_of(vertex);
  return cache_->get(chunk)->points.positions[vertex - partition_.first_vertex[chunk]];
}

void StoredSurface::triangles_at(std::uint64_t vertex, std::vector<Triangle64>& out) const {
  const auto begin = static_cast<std::ptrdiff_t>(out.size());
  std::vector<std::size_t> ends;
  triangles_at(std::span(&vertex, 1), out, ends);
  std::sort(out.begin() + begin, out.end());
}

void StoredSurface::positions(std::span<const std::uint64_t> vertices, std::span<Vec3> out) const {
  for (std::size_t i = 0; i < vertices.size();) {
    const ChunkId chunk = partition_.chunk_of(vertices[i]);
    const auto own = cache_->get(chunk);
    for (; i < vertices.size() && own->has(vertices[i]); ++i)
      out[i] = own->points.positions[vertices[i] - own->first_vertex];
  }
}

template <class Visit, class End>
void StoredSurface::visit_chunks_at(std::span<const std::uint64_t> vertices, const Visit& visit,
                                    const End& end) const {
  for (std::size_t i = 0; i < vertices.size();) {
    const ChunkId chunk = partition_.chunk_of(vertices[i]);
    const auto own = cache_->get(chunk);
    // The last neighbour asked for: what lies beside one vertex lies beside the next one, too. No
    // more than these two chunks are held at a time.
    ChunkId held = chunk;
    std::shared_ptr<const LoadedChunk> neighbor;
    constexpr std::size_t kAtOnce = 16;
    std::size_t fetched = i;
    for (; i < vertices.size() && own->has(vertices[i]); ++i) {
      if (i == fetched) {
        const std::size_t most = std::min(vertices.size(), i + kAtOnce);
        while (fetched < most && own->has(vertices[fetched])) ++fetched;
        own->fetch(vertices.subspan(i, fetched - i));
      }
      visit(chunk, *own, vertices[i]);
      for (const ChunkId other : own->neighbors) {
        const Vec3 position = own->points.positions[vertices[i] - own->first_vertex];
        if (distance_to(partition_.octree.chunks()[other].box, position) > reach_) continue;
        if (other != held) neighbor = cache_->get(held = other);
        visit(other, *neighbor, vertices[i]);
      }
      end(vertices[i]);
    }
  }
}

void StoredSurface::triangles_at(std::span<const std::uint64_t> vertices,
                                 std::vector<Triangle64>& out,
                                 std::vector<std::size_t>& ends) const {
  std::size_t begin = out.size();
  visit_chunks_at(
      vertices,
      [&](ChunkId, const LoadedChunk& loaded, std::uint64_t vertex) {
        loaded.add_triangles(vertex, out);
      },
      [&](std::uint64_t vertex) {
        if (removed_at_.may_have(vertex)) {
          out.erase(std::remove_if(out.begin() + static_cast<std::ptrdiff_t>(begin), out.end(),
                                   [&](const Triangle64& t) { return is_removed(t); }),
                    out.end());
        }
        begin = out.size();
        ends.push_back(begin);
      });
}

void StoredSurface::new_triangles_at(std::span<const std::uint64_t> vertices, TriangleMarks& met,
                                     std::vector<Triangle64>& out) const {
  visit_chunks_at(
      vertices,
      [&](ChunkId chunk, const LoadedChunk& loaded, std::uint64_t vertex) {
        const std::uint64_t first_number = std::uint64_t{chunk} << 32;
        const bool may_be_removed = removed_at_.may_have(vertex);
        const LocalNumbers numbers = loaded.numbers();
        for (const std::uint32_t triangle : loaded.at_vertex(vertex)) {
          if (!met.mark(first_number + triangle)) continue;
          const Triangle64 corners = numbers.global(loaded.triangles[triangle]);
          if (!may_be_removed || !is_removed(corners)) out.push_back(corners);
        }
      },
      [](std::uint64_t) {});
}

bool StoredSurface::is_removed(const Triangle64& triangle) const {
  const bool may_be = std::ranges::all_of(
      triangle, [&](std::uint64_t vertex) { return removed_at_.may_have(vertex); });
  return may_be && std::binary_search(removed_.begin(), removed_.end(), triangle);
}

void StoredSurface::collect_of_chunk(ChunkId chunk, std::span<const std::uint64_t> vertices,
                                     std::vector<TriangleAt>& out) const {
  const auto stored = store_.open(kMeshStage, chunk);
  const auto outer = stored->read_all<std::uint64_t>(kStoredOuter);
  const LocalNumbers numbers(partition_.first_vertex[chunk], partition_.points_in(chunk), outer);
  std::vector<std::uint8_t> is_asked(numbers.count(), 0);
  const auto begin =
      std::lower_bound(vertices.begin(), vertices.end(), partition_.first_vertex[chunk]);
  const auto end = std::lower_bound(begin, vertices.end(), partition_.first_vertex[chunk + 1]);
  for (auto vertex = begin; vertex != end; ++vertex) is_asked[numbers.local(*vertex)] = 1;
  bool any = begin != end;
  for (std::size_t i = 0; i < outer.size(); ++i) {
    if (!std::binary_search(vertices.begin(), vertices.end(), outer[i])) continue;
    is_asked[numbers.own() + i] = 1;
    any = true;
  }
  if (!any) return;
  const std::uint64_t count = stored->rows(kStoredTriangles);
  std::vector<Triangle> triangles;
  for (std::uint64_t first = 0; first < count; first += triangles.size()) {
    triangles.resize(std::min(kRowsAtATime, count - first));
    stored->read(kStoredTriangles, first, triangles.size(), triangles.data());
    for (const Triangle& t : triangles) {
      for (const std::uint32_t corner : t) {
        if (is_asked[corner] == 0) continue;
        const TriangleAt at{numbers.global(corner), numbers.global(t)};
        if (!removed_at_.may_have(at.vertex) || !is_removed(at.triangle)) out.push_back(at);
      }
    }
  }
}

std::vector<TriangleAt> StoredSurface::collect_triangles_at(std::span<const std::uint64_t> vertices,
                                                            const StopToken& stop) const {
  std::vector<std::uint8_t> may_have_some(partition_.octree.chunks().size(), 0);
  for (std::size_t i = 0; i < vertices.size();) {
    const ChunkId chunk = partition_.chunk_of(vertices[i]);
    may_have_some[chunk] = 1;
    for (const ChunkId other : partition_.octree.neighbors(chunk, reach_)) may_have_some[other] = 1;
    const std::uint64_t next = partition_.first_vertex[chunk + 1];
    while (i < vertices.size() && vertices[i] < next) ++i;
  }
  std::vector<std::vector<TriangleAt>> of_chunk(may_have_some.size());
  for_each_whole(of_chunk.size(), [&](std::size_t chunk) {
    stop.check();
    if (may_have_some[chunk] != 0)
      collect_of_chunk(static_cast<ChunkId>(chunk), vertices, of_chunk[chunk]);
  });
  std::vector<TriangleAt> found;
  for (std::vector<TriangleAt>& some : of_chunk) {
    found.insert(found.end(), some.begin(), some.end());
    some = {};
  }
  tbb::parallel_sort(found.begin(), found.end());
  return found;
}

std::vector<Vec3> StoredSurface::positions_of(ChunkId chunk) const {
  return cache_->get(chunk)->points.positions;
}

void StoredSurface::triangles_of(ChunkId chunk, std::vector<Triangle64>& out) const {
  const auto own = cache_->get(chunk);
  const LocalNumbers numbers = own->numbers();
  for (const Triangle& t : own->triangles) {
    const Triangle64 global = numbers.global(t);
    if (!is_removed(global)) out.push_back(global);
  }
}

void StoredSurface::triangles_near(ChunkId chunk, const BoxTree& places,
                                   std::vector<Triangle64>& out) const {
  const auto own = cache_->get(chunk);
  const LocalNumbers numbers = own->numbers();
  const std::vector<Vec3>& positions = own->points.positions;
  const auto box_of = [&](std::uint32_t number) {
    Box box;
    bool is_own = true;
    for (const std::uint32_t vertex : own->triangles[number]) {
      if (vertex < positions.size())
        box.extend(positions[vertex]);
      else
        is_own = false;
    }
    return is_own ? box : box.grown(reach_);
  };
  for (const std::uint32_t number :
       numbers_near(static_cast<std::uint32_t>(own->triangles.size()), places, box_of)) {
    const Triangle64 global = numbers.global(own->triangles[number]);
    if (!is_removed(global)) out.push_back(global);
  }
}

std::uint32_t StoredSurface::channels() const {
  return with_values_ ? static_cast<std::uint32_t>(partition_.schema.attributes.size()) : 0;
}

std::vector<double> StoredSurface::values(std::span<const std::uint64_t> vertices) const {
  std::vector<double> values;
  values.reserve(vertices.size() * channels());
  for (std::size_t i = 0, end = 0; i < vertices.size(); i = end) {
    const ChunkId chunk = partition_.chunk_of(vertices[i]);
    std::vector<std::uint64_t> rows;
    for (end = i; end < vertices.size() && vertices[end] < partition_.first_vertex[chunk + 1];
         ++end) {
      rows.push_back(vertices[end] - partition_.first_vertex[chunk]);
    }
    const std::vector<double> part = attribute_values(cache_->get(chunk)->points, rows);
    values.insert(values.end(), part.begin(), part.end());
  }
  return values;
}

}  // namespace orbweave
