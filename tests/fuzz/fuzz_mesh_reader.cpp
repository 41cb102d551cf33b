// Any bytes as a mesh. The first byte chooses the format.
#include "io/meshes/mesh_parsers.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr orbweave::MeshFormat kFormats[] = {
      orbweave::MeshFormat::kPly, orbweave::MeshFormat::kObj, orbweave::MeshFormat::kStl};
  try {
    const auto bytes = orbweave::fuzz::bytes_of(data + 1, size - 1);
    const orbweave::TriangleMesh mesh =
        orbweave::read_mesh(orbweave::fuzz::reader_of(bytes), kFormats[data[0] % 3]);
    for (const orbweave::Triangle& triangle : mesh.triangles)
      for (const std::uint32_t corner : triangle)
        if (corner >= mesh.vertices.size()) throw std::logic_error("a corner without a vertex");
    if (!mesh.hole.empty() && mesh.hole.size() != mesh.triangles.size())
      throw std::logic_error("hole ids without triangles");
  } catch (const orbweave::Error&) {
    // Damage, said so.
  }
  return 0;
}
