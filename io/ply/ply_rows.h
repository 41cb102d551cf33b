// The rows of a PLY element, one after another, whatever the file's format.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "io/ply/ply_header.h"
#include "io/points/point_rows.h"
#include "io/streams/byte_reader.h"

namespace orbweave {

/// Reads an element's rows in blocks. Scalar values come packed in file order without padding;
/// lists are parsed and dropped, except one that may be captured. The reader, the element and
/// its header must outlive the object. Elements are read in file order, each to its end.
class PlyRowReader {
 public:
  PlyRowReader(ByteReader& reader, const PlyHeader& header, const PlyElement& element,
               std::optional<std::size_t> captured_list = std::nullopt);

  /// Places of the scalar properties in a packed row.
  const std::vector<RowColumn>& columns() const { return columns_; }
  std::size_t row_bytes() const { return row_bytes_; }
  /// The packed rows' byte order is not the machine's.
  bool swapped() const;

  /// Reads 1 to `limit` rows, as many as are at hand; none at the element's end. Throws Error
  /// (bad input) with the byte or line where the file is damaged. What `rows`, `list_sizes` and
  /// `list_values` say is valid until the next call.
  std::size_t next(std::size_t limit);
  const std::byte* rows() const { return rows_; }
  /// The captured list of each row: its length, and all values one after another.
  const std::vector<std::uint32_t>& list_sizes() const { return list_sizes_; }
  const std::vector<std::int64_t>& list_values() const { return list_values_; }
  std::uint64_t rows_left() const { return rows_left_; }

  /// Reads to the element's end.
  void skip();
  /// Before the first row is read: goes to row `first` and ends `count` rows later. Returns false,
  /// and does nothing, where rows have no fixed place.
  bool restrict(std::uint64_t first, std::uint64_t count);

 private:
  std::size_t next_fixed(std::size_t limit);
  void read_binary_row();
  void read_binary_list(const PlyProperty& property, bool capture);
  void read_text_row();
  void read_text_list(std::string_view& line, const PlyProperty& property, bool capture);
  std::int64_t binary_integer(ScalarType type);
  void add_packed(ScalarType type);
  std::string_view next_word(std::string_view& line, const PlyProperty& property);
  void parse_word(std::string_view word, const PlyProperty& property, ScalarType type,
                  std::byte* out) const;
  [[noreturn]] void truncated() const;
  [[noreturn]] void fail_row(const std::string& problem, std::string found,
                             std::string expected) const;
  std::string row_place() const;

  ByteReader& reader_;
  const PlyElement& element_;
  PlyFormat format_;
  std::optional<std::size_t> captured_list_;
  bool fixed_ = false;  ///< binary without lists: rows are used where they lie
  std::vector<RowColumn> columns_;
  std::size_t row_bytes_ = 0;
  std::uint64_t rows_left_ = 0;
  const std::byte* rows_ = nullptr;
  std::size_t to_consume_ = 0;
  std::vector<std::byte> packed_;
  std::vector<std::uint32_t> list_sizes_;
  std::vector<std::int64_t> list_values_;
};

/// A value of an integer type; a uint64 beyond the signed range comes out negative.
std::int64_t ply_integer(ScalarType type, const std::byte* bytes, bool swap);

/// Throws Error (bad input) unless nothing but blanks follows.
void check_ply_end(ByteReader& reader, const PlyElement& last_element);

}  // namespace orbweave
