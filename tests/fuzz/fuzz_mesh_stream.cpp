// Any bytes as a PLY mesh that is read as a stream, as levels of detail do.
#include "io/meshes/mesh_stream.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

constexpr std::size_t kCapacity = 7;

void drain(orbweave::MeshStream& mesh) {
  std::uint64_t vertices = 0;
  for (orbweave::PointCloud batch; mesh.read_vertices(batch, kCapacity);) {
    const bool whole = batch.size() <= kCapacity && batch.schema == mesh.schema() &&
                       batch.attributes.size() == batch.size() * batch.schema.attribute_bytes();
    if (!whole) throw std::logic_error("a batch breaks the invariant of PointCloud");
    vertices += batch.size();
  }
  if (vertices != mesh.vertices()) throw std::logic_error("not as many vertices as declared");
  for (std::vector<orbweave::Triangle64> batch; mesh.read_triangles(batch, kCapacity);)
    for (const orbweave::Triangle64& triangle : batch)
      for (const std::uint64_t corner : triangle)
        if (corner >= vertices) throw std::logic_error("a corner without a vertex");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto bytes = orbweave::fuzz::bytes_of(data, size);
    const auto mesh = orbweave::ply_mesh_stream(orbweave::fuzz::reader_of(bytes), {1.0, 0.0, 0.0});
    if (mesh != nullptr) drain(*mesh);
  } catch (const orbweave::Error&) {
    // Damage, said so.
  }
  return 0;
}
