#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "io/byte_order_mark.h"
#include "io/error.h"
#include "io/mesh_size.h"
#include "io/meshes/mesh_parsers.h"
#include "io/text/counted_noun.h"
#include "io/text/little_endian.h"
#include "io/text/lower_case.h"
#include "io/text/text_fields.h"
#include "io/text/text_number.h"

namespace orbweave {
namespace {

constexpr std::size_t kTitleBytes = 80;
constexpr std::size_t kHeaderBytes = kTitleBytes + sizeof(std::uint32_t);
constexpr std::size_t kFacetBytes = 12 * sizeof(float) + sizeof(std::uint16_t);

/// Bits of a position, so that equal coordinates (-0 is 0) are one key and NaN is a key at all.
using PositionKey = std::array<std::uint64_t, 3>;

struct PositionKeyHash {
  std::size_t operator()(const PositionKey& key) const {
    std::uint64_t hash = 0;
    for (const std::uint64_t part : key) {
      hash = (hash ^ part) * 0x9E3779B97F4A7C15ULL;
      hash ^= hash >> 32;
    }
    return static_cast<std::size_t>(hash);
  }
};

/// Joins corners of equal coordinates to vertices, numbered as they appear.
class VertexJoiner {
 public:
  VertexJoiner(TriangleMesh& mesh, std::string file) : mesh_(mesh), file_(std::move(file)) {}

  void add_triangle(const std::array<Vec3, 3>& corners) {
    mesh_.triangles.push_back({index_of(corners[0]), index_of(corners[1]), index_of(corners[2])});
  }

 private:
  std::uint32_t index_of(Vec3 p) {
    const PositionKey key = {bits(p.x), bits(p.y), bits(p.z)};
    std::vector<Vec3>& positions = mesh_.vertices.positions;
    const auto [at, is_new] =
        indices_.try_emplace(key, static_cast<std::uint32_t>(positions.size()));
    if (!is_new) return at->second;
    if (positions.size() == kMostMeshVertices) require_mesh_in_core(file_, positions.size() + 1, 0);
    positions.push_back(p);
    return at->second;
  }
  static std::uint64_t bits(double value) {
    return std::bit_cast<std::uint64_t>(value == 0.0 ? 0.0 : value);
  }

  TriangleMesh& mesh_;
  std::string file_;
  std::unordered_map<PositionKey, std::uint32_t, PositionKeyHash> indices_;
};

Vec3 float_vector(const std::byte* bytes) {
  const auto value = [&](std::size_t i) {
    return static_cast<double>(load_little<float>(bytes + i * sizeof(float)));
  };
  return {value(0), value(1), value(2)};
}

[[noreturn]] void truncated(const ByteReader& reader, std::uint64_t found, std::uint64_t expected) {
  throw_bad_input("the STL file ends early", {.file = reader.name(),
                                              .place = reader.byte_place(),
                                              .found = counted_noun(found, "triangle", "triangles"),
                                              .expected = std::to_string(expected)});
}

TriangleMesh read_binary(ByteReader& reader) {
  if (!reader.ensure(kHeaderBytes))
    throw_bad_input("this is no STL file", {.file = reader.name(),
                                            .found = "too few bytes for a header",
                                            .expected = "\"solid\" or 84 bytes of header"});
  const std::uint32_t count = load_little<std::uint32_t>(reader.data() + kTitleBytes);
  reader.consume(kHeaderBytes);
  const std::optional<std::uint64_t> left = reader.bytes_left();
  if (left && *left / kFacetBytes < count) truncated(reader, *left / kFacetBytes, count);
  TriangleMesh mesh;
  mesh.vertices.schema.position_type = ScalarType::kFloat32;
  VertexJoiner joiner(mesh, reader.name());
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!reader.ensure(kFacetBytes)) truncated(reader, i, count);
    const std::byte* corners = reader.data() + 3 * sizeof(float);  // after the normal
    constexpr std::size_t kCorner = 3 * sizeof(float);
    joiner.add_triangle({float_vector(corners), float_vector(corners + kCorner),
                         float_vector(corners + 2 * kCorner)});
    reader.consume(kFacetBytes);
  }
  if (reader.ensure(1))
    throw_bad_input("the STL file goes on after its last triangle",
                    {.file = reader.name(),
                     .place = reader.byte_place(),
                     .expected = "the end after " + counted_noun(count, "triangle", "triangles")});
  return mesh;
}

/// What the lines before have opened. Some programs leave out the loop around a facet's corners.
enum class FacetPart { kOutside, kFacet, kCorners, kLoop, kAfterLoop };

/// A keyword that lines begin with, behind which part it may stand, and the part that follows.
struct LineKind {
  std::string_view keyword;
  FacetPart before;
  FacetPart after;
};
constexpr std::array kLineKinds = {
    LineKind{"solid", FacetPart::kOutside, FacetPart::kOutside},
    LineKind{"facet", FacetPart::kOutside, FacetPart::kFacet},
    LineKind{"outer", FacetPart::kFacet, FacetPart::kLoop},
    LineKind{"vertex", FacetPart::kLoop, FacetPart::kLoop},
    LineKind{"vertex", FacetPart::kFacet, FacetPart::kCorners},
    LineKind{"vertex", FacetPart::kCorners, FacetPart::kCorners},
    LineKind{"endloop", FacetPart::kLoop, FacetPart::kAfterLoop},
    LineKind{"endfacet", FacetPart::kAfterLoop, FacetPart::kOutside},
    LineKind{"endfacet", FacetPart::kCorners, FacetPart::kOutside},
    LineKind{"endsolid", FacetPart::kOutside, FacetPart::kOutside},
};

class TextStlParser {
 public:
  explicit TextStlParser(ByteReader& reader) : reader_(reader), joiner_(mesh_, reader.name()) {}

  TriangleMesh parse() {
    std::string_view line;
    while (reader_.next_line(line)) {
      const auto keyword = take_field(line, ' ');
      if (keyword) parse_line(*keyword, line);
    }
    if (!ended_ || part_ != FacetPart::kOutside)
      fail("the STL file ends early", "the end of the file",
           part_ == FacetPart::kOutside ? "\"endsolid\"" : expected_line());
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem, std::string found,
                         std::string expected) const {
    throw_bad_input(problem, {.file = reader_.name(),
                              .place = reader_.line_place(),
                              .found = std::move(found),
                              .expected = std::move(expected)});
  }

  void parse_line(std::string_view given, std::string_view rest) {
    const std::string keyword = lower_case(std::string(given));  // of some programs in capitals
    if (std::ranges::find(kLineKinds, keyword, &LineKind::keyword) == kLineKinds.end())
      fail("unknown line in the STL file", excerpt(given),
           "facet, outer loop, vertex, endloop or endfacet");
    if (keyword == "endloop" || keyword == "endfacet") check_corners();
    const auto kind = std::ranges::find_if(kLineKinds, [&](const LineKind& known) {
      return known.keyword == keyword && known.before == part_;
    });
    if (kind == kLineKinds.end())
      fail("a line of the STL file is at the wrong place", excerpt(given), expected_line());
    part_ = kind->after;
    if (keyword == "outer" && lower_case(std::string(take_field(rest, ' ').value_or(""))) != "loop")
      fail("unknown line in the STL file", excerpt(given), "outer loop");
    if (keyword == "vertex") return add_corner(rest);
    if (keyword == "endfacet") return end_facet();
    if (keyword == "solid") ended_ = false;
    if (keyword == "endsolid") ended_ = true;
  }

  /// Before a facet, or its loop, ends.
  void check_corners() const {
    const bool has_corners = part_ == FacetPart::kLoop || part_ == FacetPart::kCorners;
    if (has_corners && corners_ != facet_.size())
      fail("a facet has fewer than three corners", std::to_string(corners_), "3");
  }

  std::string expected_line() const {
    const bool lacks_corners = corners_ < facet_.size();
    switch (part_) {
      case FacetPart::kOutside:
        return "facet or endsolid";
      case FacetPart::kFacet:
        return "outer loop";
      case FacetPart::kCorners:
        return lacks_corners ? "vertex" : "endfacet";
      case FacetPart::kLoop:
        return lacks_corners ? "vertex" : "endloop";
      case FacetPart::kAfterLoop:
        break;
    }
    return "endfacet";
  }

  void add_corner(std::string_view line) {
    if (corners_ == 3)
      fail("a facet has more than three corners", "a fourth",
           part_ == FacetPart::kLoop ? "endloop" : "endfacet");
    Vec3& v = facet_[corners_++];
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view text = take_field(line, ' ').value_or("");
      const char* const last = text.data() + text.size();
      if (text.empty() || parse_number(text.data(), last, v[axis]) != last)
        fail("a coordinate is no number", excerpt(text), "three numbers");
    }
    if (const auto excess = take_field(line, ' '))
      fail("a vertex has more than three coordinates", excerpt(*excess), "the end of the line");
  }

  void end_facet() {
    joiner_.add_triangle(facet_);
    corners_ = 0;
  }

  ByteReader& reader_;
  TriangleMesh mesh_;
  VertexJoiner joiner_;
  std::array<Vec3, 3> facet_;
  std::size_t corners_ = 0;
  FacetPart part_ = FacetPart::kOutside;
  bool ended_ = true;
};

/// Text begins with "solid", but so do some binary titles. Those have the length that their count
/// of triangles asks for, or, where the file is compressed or damaged, a zero byte in that count or
/// in the first facet: text has none.
bool is_text(ByteReader& reader) {
  reader.ensure(kHeaderBytes + kFacetBytes);
  const std::string_view front(reinterpret_cast<const char*>(reader.data()),
                               std::min(reader.available(), kHeaderBytes + kFacetBytes));
  constexpr std::string_view kSolid = "solid";
  std::string_view text = without_byte_order_mark(front);
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  if (lower_case(std::string(text.substr(0, kSolid.size()))) != kSolid) return false;
  const bool has_header = front.size() >= kHeaderBytes;
  if (has_header && front.find('\0', kTitleBytes) != front.npos) return false;
  const std::optional<std::uint64_t> length = reader.bytes_left();
  if (length && has_header) {
    const std::uint64_t count = load_little<std::uint32_t>(reader.data() + kTitleBytes);
    if (*length == kHeaderBytes + count * kFacetBytes) return false;
  }
  skip_byte_order_mark(reader);
  return true;
}

}  // namespace

TriangleMesh read_stl_mesh(ByteReader reader) {
  return is_text(reader) ? TextStlParser(reader).parse() : read_binary(reader);
}

}  // namespace orbweave
