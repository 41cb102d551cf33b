// Where the point records of a LAS file come from: the file as it is, or a decoder of LAZ.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "io/clouds/las/las_header.h"
#include "io/clouds/las/las_variable_records.h"
#include "io/streams/random_access.h"

namespace orbweave::las {

/// Point records in the order of the file.
class Records {
 public:
  virtual ~Records() = default;
  /// Fills `records` with the next whole records; returns how many, 0 only at the end or when
  /// `records` holds less than one. Throws Error (bad input) where the data is damaged.
  virtual std::size_t read(std::span<std::byte> records) = 0;
  /// Before the first read: leaves records [first, first + count). False where they have no fixed
  /// place.
  virtual bool restrict(std::uint64_t /*first*/, std::uint64_t /*count*/) { return false; }
  /// Bytes of the file behind what was handed out so far.
  virtual std::uint64_t bytes_read() const = 0;
};

/// The records of this file, which must outlive them.
std::unique_ptr<Records> open_records(const RandomAccess& file, const Header& header,
                                      const VariableRecords& records);

}  // namespace orbweave::las
