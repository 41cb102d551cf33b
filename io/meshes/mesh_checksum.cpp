#include "io/meshes/mesh_checksum.h"

#include <xxhash.h>

#include <array>
#include <bit>
#include <charconv>

#include "io/hex_digits.h"

namespace orbweave {
namespace {

using Words = std::array<std::uint64_t, 4>;

constexpr std::uint64_t little_endian(std::uint64_t word) {
  if constexpr (std::endian::native == std::endian::little) return word;
  std::uint64_t swapped = 0;
  for (int i = 0; i < 8; ++i) swapped |= (word >> (8 * i) & 0xff) << (56 - 8 * i);
  return swapped;
}

std::uint64_t hash_of(Words words) {
  for (std::uint64_t& word : words) word = little_endian(word);
  return XXH3_64bits(words.data(), sizeof words);
}

std::uint64_t coordinate_bits(double value) {
  return std::bit_cast<std::uint64_t>(value == 0.0 ? 0.0 : value);
}

}  // namespace

void MeshChecksum::add_vertices(std::span<const Vec3> positions, std::uint64_t first) {
  for (const Vec3& p : positions)
    vertices_.hashes +=
        hash_of({first++, coordinate_bits(p.x), coordinate_bits(p.y), coordinate_bits(p.z)});
  vertices_.rows += positions.size();
}

void MeshChecksum::add_triangles(std::span<const Triangle64> triangles, std::uint64_t first) {
  for (const Triangle64& t : triangles) triangles_.hashes += hash_of({first++, t[0], t[1], t[2]});
  triangles_.rows += triangles.size();
}

void MeshChecksum::add(const MeshChecksum& other) {
  vertices_.hashes += other.vertices_.hashes;
  vertices_.rows += other.vertices_.rows;
  triangles_.hashes += other.triangles_.hashes;
  triangles_.rows += other.triangles_.rows;
}

std::string MeshChecksum::hex() const {
  return hex_digits(
      hash_of({vertices_.hashes, vertices_.rows, triangles_.hashes, triangles_.rows}));
}

std::string MeshChecksum::state() const {
  return hex_digits(vertices_.hashes) + hex_digits(vertices_.rows) + hex_digits(triangles_.hashes) +
         hex_digits(triangles_.rows);
}

std::optional<MeshChecksum> MeshChecksum::from_state(std::string_view state) {
  constexpr std::size_t kDigits = 16;
  Words words{};
  if (state.size() != words.size() * kDigits) return std::nullopt;
  for (std::uint64_t& word : words) {
    const auto [end, error] = std::from_chars(state.data(), state.data() + kDigits, word, 16);
    if (error != std::errc{} || end != state.data() + kDigits) return std::nullopt;
    state.remove_prefix(kDigits);
  }
  MeshChecksum checksum;
  checksum.vertices_ = {words[0], words[1]};
  checksum.triangles_ = {words[2], words[3]};
  return checksum;
}

}  // namespace orbweave
