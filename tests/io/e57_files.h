// E57 files made of values, for the tests of their reader; written by the tables of ASTM E2807,
// apart from the code that reads them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "io/points/point_source.h"

namespace orbweave::test {

/// One field of a scan: what the prototype says of it, and the bits of each value.
struct E57Column {
  std::string name{};
  std::string declaration{};  ///< attributes of the prototype's element
  unsigned bits = 0;
  std::vector<std::uint64_t> words{};
};
E57Column integers(const std::string& name, std::int64_t minimum, std::int64_t maximum,
                   const std::vector<std::int64_t>& values);
/// `values` before scaling.
E57Column scaled(const std::string& name, std::int64_t minimum, std::int64_t maximum, double scale,
                 double offset, const std::vector<std::int64_t>& values);
E57Column floats(const std::string& name, const std::vector<float>& values);
E57Column doubles(const std::string& name, const std::vector<double>& values);

/// One scan, and how its points are spread over packets.
struct E57Scan3D {
  std::vector<E57Column> columns{};
  std::string xml{};            ///< pose, colour limits and the like
  std::string codecs{};         ///< content of its element
  std::string record_count{};   ///< what the file claims; empty: the truth
  std::string file_offset{};    ///< likewise, of the section
  std::size_t extra_bytes = 0;  ///< added to each stream at its end
  /// Bytes of each stream per packet, one number per column; empty: 4096 for all.
  std::vector<std::size_t> packet_bytes{};
  bool with_other_packets = false;  ///< an index and an empty packet before each data packet
};

struct E57File3D {
  std::vector<E57Scan3D> scans{};
  std::string root_attributes{};  ///< xmlns:nor="..." and the like
  std::string xml{};              ///< children of the root besides data3D
  std::size_t page_bytes = 1024;
};

/// The bytes of a file, checksums and all. `edit_xml` and `edit_logical`, where given, change the
/// XML section and the logical bytes (header, sections, XML) before the checksums are made.
using E57Edit = std::function<void(std::string& bytes)>;
std::string make_e57(const E57File3D& file, const E57Edit& edit_xml = nullptr,
                     const E57Edit& edit_logical = nullptr);

/// Reads bytes that stay alive as long as the source.
std::unique_ptr<PointSource> open_e57(const std::string& bytes);
PointCloud read_e57(const std::string& bytes);

/// Three columns of doubles.
std::vector<E57Column> cartesian(const std::vector<Vec3>& points);

}  // namespace orbweave::test
