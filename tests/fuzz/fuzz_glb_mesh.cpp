// Any bytes as a GLB file. Where the first byte is odd, what follows up to a zero is the document
// and the rest its data, in a file that is whole.
#include <algorithm>
#include <cstdint>
#include <string>

#include "io/meshes/mesh_parsers.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

void append_word(std::string& bytes, std::size_t word) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(word >> shift));
}

std::string whole_file(const std::string& text, const std::string& data) {
  std::string bytes = "glTF";
  append_word(bytes, 2);
  append_word(bytes, 28 + text.size() + data.size());
  append_word(bytes, text.size());
  bytes += "JSON" + text;
  append_word(bytes, data.size());
  bytes += std::string("BIN\0", 4);
  return bytes + data;
}

std::string input_of(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 2 == 0) return bytes;
  const std::size_t end = std::min(bytes.find('\0'), bytes.size());
  return whole_file(bytes.substr(0, end), bytes.substr(std::min(end + 1, bytes.size())));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    const std::string input = input_of(data, size);
    const auto bytes =
        orbweave::fuzz::bytes_of(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
    const orbweave::TriangleMesh mesh = orbweave::read_glb_mesh(orbweave::fuzz::reader_of(bytes));
    const orbweave::PointCloud& vertices = mesh.vertices;
    for (const orbweave::Triangle& triangle : mesh.triangles)
      for (const std::uint32_t corner : triangle)
        if (corner >= vertices.size()) throw std::logic_error("a corner without a vertex");
    if (!mesh.hole.empty() && mesh.hole.size() != mesh.triangles.size())
      throw std::logic_error("hole ids without triangles");
    if (vertices.attributes.size() != vertices.size() * vertices.schema.attribute_bytes())
      throw std::logic_error("attributes of another length");
  } catch (const orbweave::Error&) {
    // Damage, said so.
  }
  return 0;
}
