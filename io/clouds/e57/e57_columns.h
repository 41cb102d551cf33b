// From the fields of one scan of an E57 file to points, block by block.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "io/clouds/e57/e57_layout.h"
#include "io/clouds/e57/e57_section.h"
#include "io/point_cloud.h"

namespace orbweave {

/// Decodes the points of one scan.
class E57ScanReader {
 public:
  /// The document's scan and its layout must outlive the reader.
  E57ScanReader(E57Pages& pages, const E57Scan& scan, const E57ScanLayout& layout,
                const PointSchema& schema);

  /// Appends the points of at most `records` more records to a batch of the schema, leaving out
  /// those without position. Returns false once all records are read. Throws Error (bad input)
  /// where the section has fewer records than the scan declares, or more.
  bool read(PointCloud& batch, std::uint64_t records);
  /// Points without position so far.
  std::uint64_t left_out() const { return left_out_; }
  /// Logical bytes of the section read so far, and in all.
  std::uint64_t bytes_read() const;
  std::uint64_t bytes_total() const { return section_.end - section_.begin; }

 private:
  void add_stream(std::size_t field);
  std::size_t next_block(std::uint64_t records);
  void find_kept(std::size_t count);
  template <class T>
  std::span<T> decode(std::size_t count, std::vector<T>& column);
  void append_positions(PointCloud& batch, std::size_t count);
  void append_normals(PointCloud& batch, std::size_t count);
  void append_attributes(PointCloud& batch, std::size_t count);
  void check_end();

  const E57Scan& scan_;
  const E57ScanLayout& layout_;
  const PointSchema& schema_;
  E57Pages& pages_;
  E57Section section_;
  E57Packets packets_;
  std::vector<E57FieldStream> streams_;  ///< in the order in which a block decodes them
  std::size_t next_stream_ = 0;
  std::uint64_t records_done_ = 0;
  std::uint64_t left_out_ = 0;
  bool all_kept_ = true;
  std::vector<std::uint32_t> kept_;  ///< records of the block that have a position
  std::vector<std::int64_t> integers_;
  std::array<std::vector<double>, 3> reals_;
};

}  // namespace orbweave
