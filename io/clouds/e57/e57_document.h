// The XML section of E57 (ASTM E2807): which scans a file holds, what each of
// their points carries, and where.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/box.h"
#include "io/clouds/e57/e57_pages.h"
#include "io/points/scan_pose.h"

namespace orbweave {

/// How the values of one field are stored. Strings are never decoded.
enum class E57Kind { kInteger, kScaledInteger, kFloat32, kFloat64, kString };

/// One leaf of a scan's prototype: one byte stream of its packets.
struct E57Field {
  std::string name;  ///< as given, but for the prefixes "nor:" (surface normals) and "las:"
  E57Kind kind = E57Kind::kFloat64;
  std::int64_t minimum = 0;  ///< of integers, before scaling
  std::int64_t maximum = 0;
  double scale = 1.0;  ///< of scaled integers: value = integer * scale + offset
  double offset = 0.0;
  unsigned bits = 64;  ///< of one value in the stream; 0: every value is `minimum`
  friend bool operator==(const E57Field&, const E57Field&) = default;
};

/// Values that a sensor can produce, from darkest to brightest.
struct E57Limits {
  double low = 0.0;
  double high = 0.0;
};

/// One entry of data3D.
struct E57Scan {
  std::string label;       ///< "scan 2 \"hall\"", for messages; counted from 1
  std::string given_name;  ///< may be empty
  std::string sensor;      ///< vendor and model, where the file says
  std::uint64_t records = 0;
  std::uint64_t section_offset = 0;  ///< physical
  std::vector<E57Field> fields;      ///< in the order of the byte streams
  std::optional<RigidMotion> pose;   ///< from the scan's coordinates to the file's
  std::optional<Box> bounds;         ///< as claimed, in the scan's coordinates
  std::array<std::optional<E57Limits>, 3> color_limits;  ///< red, green, blue
  double start_seconds = 0.0;  ///< GPS time that time stamps count from; 0: not given
  int first_return = 0;        ///< returnIndex of a pulse's first return

  /// Index of a field, or nothing.
  std::optional<std::size_t> find(std::string_view name) const;
  /// It has a pose that is not the identity.
  bool is_moved() const { return pose && *pose != RigidMotion{}; }
};

struct E57Document {
  std::string version;            ///< "1.0"
  std::string software;           ///< version of the library that wrote the file; may be empty
  std::string coordinate_system;  ///< coordinateMetadata: WKT, or empty
  std::vector<E57Scan> scans;     ///< in file order, those without points included
  std::size_t pictures = 0;       ///< entries of images2D
};

/// Reads the XML section. Entities are not expanded and no other file is opened. Throws Error (bad
/// input) with the place of what is no XML, is missing or contradicts the standard, and for a
/// section that would take more than 32 MiB of memory.
E57Document read_e57_document(E57Pages& pages);

}  // namespace orbweave
