// Any loop in space, its vertices visited any number of times, with any chords forbidden: what is
// made of it is a sound patch after every operation.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <vector>

#include "engine/holes/patch/patch_mesh.h"
#include "engine/holes/triangulation/loop_chords.h"

namespace {

using orbweave::CornerTriangle;
using orbweave::PatchMesh;
using orbweave::Vec3;
using orbweave::VertexPair;

void require(bool holds) {
  if (!holds) std::abort();
}

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  bool empty() const { return left_ == 0; }
  std::uint8_t next() {
    if (left_ == 0) return 0;
    --left_;
    return *data_++;
  }
  double coordinate() {
    const std::uint8_t byte = next();
    if (byte == 127) return NAN;
    if (byte == 128) return 1e300;
    return static_cast<std::int8_t>(byte);
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

struct Loop {
  std::vector<Vec3> corners;
  std::vector<std::uint32_t> vertices;
  std::vector<VertexPair> forbidden;
};

Loop loop_of(Bytes& bytes) {
  Loop loop;
  const std::uint32_t n = 3 + bytes.next() % 30;
  std::map<std::uint32_t, Vec3> places;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint8_t vertex = bytes.next();
    loop.vertices.push_back(vertex >= 192 ? vertex % n : 100 + i);
    const double x = bytes.coordinate(), y = bytes.coordinate();
    loop.corners.push_back(
        places.emplace(loop.vertices[i], Vec3{x, y, bytes.coordinate()}).first->second);
  }
  for (std::uint32_t i = bytes.next() % 8; i > 0; --i) {
    const std::uint32_t a = loop.vertices[bytes.next() % n];
    loop.forbidden.push_back(orbweave::vertex_pair(a, loop.vertices[bytes.next() % n]));
  }
  std::sort(loop.forbidden.begin(), loop.forbidden.end());
  return loop;
}

bool rim_is_sound(const Loop& loop) {
  std::map<VertexPair, int> uses;
  for (std::size_t i = 0; i < loop.vertices.size(); ++i) {
    const VertexPair pair =
        orbweave::vertex_pair(loop.vertices[i], loop.vertices[(i + 1) % loop.vertices.size()]);
    if (pair[0] == pair[1] || ++uses[pair] > 1) return false;
  }
  return true;
}

/// No edge inside is forbidden, joins a vertex to itself or has more than two triangles.
void require_sound(const Loop& loop, const std::vector<CornerTriangle>& triangles) {
  const auto n = static_cast<std::uint32_t>(loop.vertices.size());
  std::map<VertexPair, int> uses;
  for (const CornerTriangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const auto number = [&](std::uint32_t v) { return v < n ? loop.vertices[v] : 1000 + v; };
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      const VertexPair pair = orbweave::vertex_pair(number(a), number(b));
      require(pair[0] != pair[1] && ++uses[pair] <= 2);
      const bool rim = a < n && b < n && (b == (a + 1) % n);
      require(rim || !std::binary_search(loop.forbidden.begin(), loop.forbidden.end(), pair));
    }
  }
}

void operate(PatchMesh& mesh, Bytes& bytes) {
  const double length = 1.0 + bytes.next();
  switch (bytes.next() % 6) {
    case 0:
      mesh.split_long_edges(length, 60);
      break;
    case 1:
      mesh.collapse_short_edges(length);
      break;
    case 2:
      mesh.flip_to_delaunay();
      break;
    case 3:
      mesh.smooth(1);
      break;
    case 4:
      mesh.smooth(2);
      break;
    default:
      mesh.split_forbidden_chords();
      break;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const Loop loop = loop_of(bytes);
  const auto n = static_cast<std::uint32_t>(loop.corners.size());
  std::vector<CornerTriangle> triangles = orbweave::triangulate_loop(
      {loop.corners, loop.vertices, {}, loop.forbidden}, 3 + bytes.next() % 40);
  if (!triangles.empty()) require(triangles.size() == n - 2);
  if (!rim_is_sound(loop)) return 0;
  require_sound(loop, triangles);
  if (triangles.empty() || bytes.next() % 2 == 0) {
    triangles.clear();
    for (std::uint32_t i = 1; i + 1 < n; ++i) triangles.push_back({0, i, i + 1});
  }
  PatchMesh mesh(loop.corners, loop.vertices, triangles, loop.forbidden);
  require(mesh.defect().empty());
  mesh.split_forbidden_chords();
  for (int step = 0; step < 8 && !bytes.empty(); ++step) {
    require(mesh.defect().empty());
    require_sound(loop, mesh.triangles());
    operate(mesh, bytes);
  }
  require(mesh.defect().empty());
  require_sound(loop, mesh.triangles());
  return 0;
}
