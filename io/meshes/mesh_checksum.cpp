#include "io/meshes/mesh_checksum.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>

#include "io/hex_digits.h"
#include "io/system/running_checksum.h"

namespace orbweave {
namespace {

constexpr std::size_t kBlockWords = 3 * 1024;

std::uint64_t little_endian(std::uint64_t word) {
  if constexpr (std::endian::native == std::endian::little) return word;
  std::array<unsigned char, 8> bytes;
  for (int i = 0; i < 8; ++i) bytes[i] = static_cast<unsigned char>(word >> (8 * i));
  std::memcpy(&word, bytes.data(), sizeof word);
  return word;
}

std::uint64_t coordinate_bits(double value) {
  return std::bit_cast<std::uint64_t>(value == 0.0 ? 0.0 : value);
}

}  // namespace

struct MeshChecksum::State {
  RunningChecksum checksum;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  bool vertices_closed = false;

  void add_word(std::uint64_t word) {
    word = little_endian(word);
    checksum.add(&word, sizeof word);
  }
  void close_vertices() {
    if (vertices_closed) return;
    add_word(vertices);
    vertices_closed = true;
  }
};

MeshChecksum::MeshChecksum() : state_(std::make_unique<State>()) {}
MeshChecksum::~MeshChecksum() = default;
MeshChecksum::MeshChecksum(MeshChecksum&&) noexcept = default;
MeshChecksum& MeshChecksum::operator=(MeshChecksum&&) noexcept = default;

void MeshChecksum::add_vertices(std::span<const Vec3> positions) {
  if (state_->vertices_closed) throw std::logic_error("MeshChecksum: vertices after triangles");
  std::array<std::uint64_t, kBlockWords> block;
  for (std::size_t first = 0; first < positions.size(); first += kBlockWords / 3) {
    const auto part = positions.subspan(first, std::min(kBlockWords / 3, positions.size() - first));
    std::size_t words = 0;
    for (const Vec3& p : part)
      for (int axis = 0; axis < 3; ++axis) block[words++] = little_endian(coordinate_bits(p[axis]));
    state_->checksum.add(block.data(), words * sizeof(std::uint64_t));
  }
  state_->vertices += positions.size();
}

void MeshChecksum::add_triangles(std::span<const Triangle64> triangles) {
  state_->close_vertices();
  if constexpr (std::endian::native == std::endian::little) {
    state_->checksum.add(triangles.data(), triangles.size_bytes());
  } else {
    for (const Triangle64& t : triangles)
      for (const std::uint64_t index : t) state_->add_word(index);
  }
  state_->triangles += triangles.size();
}

std::string MeshChecksum::hex() const {
  State copy = *state_;
  copy.close_vertices();
  copy.add_word(state_->triangles);
  return hex_digits(copy.checksum.value());
}

}  // namespace orbweave
