#include "engine/pipeline/surface/power_crust_stage.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "engine/normals/normals_from_faces.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/stage/stage_begin.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/stitching/triangle_fans.h"
#include "io/store/chunk_points.h"
#include "partition/canonical_order.h"

namespace orbweave {
namespace {

constexpr const char* kTriangles = "triangles";
constexpr const char* kCorners = "polygon_corners";
constexpr const char* kBegin = "polygon_begin";
constexpr const char* kCenters = "medial_centers";
constexpr const char* kRadii = "medial_radii";

/// The surface as it is stored.
struct CrustMesh {
  PointCloud vertices;
  std::vector<Triangle> triangles;
  PolygonFaces polygons;
  MedialAxis medial_axis;
};

/// The vertices in canonical order; several at one place stay in their order.
std::vector<std::uint32_t> canonical_vertices(std::span<const Vec3> positions,
                                              const RootCube& root) {
  const MortonFrame frame(root);
  std::vector<std::uint64_t> codes;
  codes.reserve(positions.size());
  for (const Vec3 p : positions) codes.push_back(frame.code(p));
  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 &p = positions[a], &q = positions[b];
    return std::tie(codes[a], p.x, p.y, p.z, a) < std::tie(codes[b], q.x, q.y, q.z, b);
  });
  return order;
}

/// Normals from the faces; where these have no area, those of the samples.
std::vector<Vec3> normals_of(TriangleMesh& mesh, std::span<const Vec3> of_samples) {
  std::vector<Vec3> normals = normals_from_faces(mesh);
  for (std::size_t v = 0; v < normals.size(); ++v)
    if (normals[v] == Vec3{}) normals[v] = of_samples[v];
  return normals;
}

/// The polygons over vertices of other ranks, each turned as its first triangle is.
PolygonFaces ranked_polygons(const voronoi::PowerCrustSurface& surface,
                             std::span<const std::uint32_t> rank,
                             std::span<const Triangle> turned) {
  std::vector<std::uint32_t> corners;
  corners.reserve(surface.corners.size());
  for (const std::uint32_t corner : surface.corners) corners.push_back(rank[corner]);
  std::vector<std::span<std::uint32_t>> polygons;
  polygons.reserve(surface.polygons());
  for (std::size_t f = 0; f < surface.polygons(); ++f) {
    const std::uint32_t begin = surface.polygon_begin[f], end = surface.polygon_begin[f + 1];
    const auto polygon = std::span(corners).subspan(begin, end - begin);
    const Triangle first = smallest_first(Triangle{polygon[0], polygon[1], polygon[2]});
    if (!std::binary_search(turned.begin(), turned.end(), first))
      std::reverse(polygon.begin(), polygon.end());
    std::rotate(polygon.begin(), std::min_element(polygon.begin(), polygon.end()), polygon.end());
    polygons.push_back(polygon);
  }
  std::sort(polygons.begin(), polygons.end(), [](const auto& a, const auto& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  });
  PolygonFaces faces;
  faces.corners.reserve(corners.size());
  faces.begin.reserve(polygons.size() + 1);
  for (const auto& polygon : polygons) {
    faces.corners.insert(faces.corners.end(), polygon.begin(), polygon.end());
    faces.begin.push_back(static_cast<std::uint32_t>(faces.corners.size()));
  }
  return faces;
}

/// `schema`: of the points, as the vertices have it.
CrustMesh crust_mesh(const PointCloud& points, const RootCube& root, const StopToken& stop,
                     const voronoi::ShareDone& done) {
  voronoi::PowerCrustSurface surface = power_crust_in_core(points.positions, &stop, done);
  CrustMesh mesh;
  mesh.triangles = triangles_in_core(surface);
  const std::vector<std::uint32_t> order = canonical_vertices(surface.vertices, root);
  std::vector<std::uint32_t> rank(order.size());
  TriangleMesh bare;
  std::vector<Vec3> of_samples;
  mesh.vertices.schema = points.schema;
  const std::size_t width = points.schema.attribute_bytes();
  for (std::uint32_t v = 0; v < order.size(); ++v) {
    const std::uint32_t sample = surface.samples[order[v]];
    rank[order[v]] = v;
    bare.vertices.positions.push_back(surface.vertices[order[v]]);
    of_samples.push_back(points.normals[sample]);
    const auto row = points.attributes.begin() + static_cast<std::ptrdiff_t>(sample * width);
    mesh.vertices.attributes.insert(mesh.vertices.attributes.end(), row,
                                    row + static_cast<std::ptrdiff_t>(width));
  }
  for (const voronoi::MedialBall& ball : surface.medial_axis) {
    mesh.medial_axis.centers.push_back(ball.center);
    mesh.medial_axis.radii.push_back(ball.radius);
  }
  stop.check();
  for (Triangle& t : mesh.triangles)
    t = smallest_first(Triangle{rank[t[0]], rank[t[1]], rank[t[2]]});
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
  turn_to_normals(bare.vertices.positions, of_samples, mesh.triangles, &stop);
  mesh.polygons = ranked_polygons(surface, rank, mesh.triangles);
  surface = {};
  bare.triangles = std::move(mesh.triangles);
  mesh.vertices.normals = normals_of(bare, of_samples);
  mesh.triangles = std::move(bare.triangles);
  mesh.vertices.positions = std::move(bare.vertices.positions);
  return mesh;
}

void commit(ChunkStore& store, const CrustMesh& mesh) {
  const MedialAxis& axis = mesh.medial_axis;
  const std::array<ArrayView, 5> faces = {
      ArrayView{kTriangles, ScalarType::kUint32, 3, mesh.triangles.size(), mesh.triangles.data()},
      ArrayView{kCorners, ScalarType::kUint32, 1, mesh.polygons.corners.size(),
                mesh.polygons.corners.data()},
      ArrayView{kBegin, ScalarType::kUint32, 1, mesh.polygons.begin.size(),
                mesh.polygons.begin.data()},
      ArrayView{kCenters, ScalarType::kFloat64, 3, axis.centers.size(), axis.centers.data()},
      ArrayView{kRadii, ScalarType::kFloat64, 1, axis.radii.size(), axis.radii.data()}};
  commit_points(store, 0, mesh.vertices, kPowerCrustStage, {}, faces);
}

}  // namespace

Partition make_power_crust(const Partition& points, StageRunner& runner) {
  if (points.octree.chunks().size() != 1)
    throw std::logic_error("a Power Crust needs all points in one chunk");
  require_memory_for_method(runner.job, points.points());
  by_root(runner, [&] {
    begin_stage(runner, kPowerCrustStage,
                power_crust_key(runner.job, stored_key(runner.store, points.stage)));
  });
  {
    StageClock clock(runner, Stage::kPowerCrust, points.points(), "points");
    const std::uint64_t bytes =
        points.points() * costs_of(runner.job.reconstruct.method).bytes_per_point;
    share_chunks(runner, clock, kPowerCrustStage, {{0, bytes, points.points(), points.points()}},
                 bytes, [&](ChunkId chunk) {
                   const PointCloud cloud =
                       load_points(runner.store, chunk, points.schema, points.stage);
                   commit(runner.store, crust_mesh(cloud, points.octree.root(), runner.stop,
                                                   progress_within_chunk(runner, points.points())));
                 });
    clock.facts().points = points.points();
  }
  Partition vertices = points;
  vertices.stage = kPowerCrustStage;
  Chunk whole = points.octree.chunks().front();
  whole.points = stored_points(runner.store, 0, kPowerCrustStage);
  vertices.first_vertex = {0, whole.points};
  vertices.octree = Octree(points.octree.root(), {whole});
  return vertices;
}

std::vector<Triangle> load_power_crust(const ChunkStore& store) {
  return store.open(kPowerCrustStage, 0)->read_all<Triangle>(kTriangles);
}

PolygonFaces load_polygons(const ChunkStore& store) {
  const auto stored = store.open(kPowerCrustStage, 0);
  return {stored->read_all<std::uint32_t>(kCorners), stored->read_all<std::uint32_t>(kBegin)};
}

MedialAxis load_medial_axis(const ChunkStore& store) {
  const auto stored = store.open(kPowerCrustStage, 0);
  return {stored->read_all<Vec3>(kCenters), stored->read_all<double>(kRadii)};
}

}  // namespace orbweave
