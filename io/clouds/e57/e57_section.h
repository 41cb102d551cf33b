// The points of one scan in E57 (ASTM E2807, compressed vector binary sections): a
// section header, packets, and in them one stream of bits per field.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/clouds/e57/e57_document.h"
#include "io/clouds/e57/e57_pages.h"

namespace orbweave {

/// Where a section lies; logical offsets.
struct E57Section {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
  std::uint64_t data = 0;  ///< the first packet; only of scans that have points
};

/// Reads a scan's section header. Throws Error (bad input) where it is none, does not fit into the
/// file or is too small for the scan's points.
E57Section read_e57_section(E57Pages& pages, const E57Scan& scan);

/// The packets of a section, of which data packets alone are shown. Holds one packet.
class E57Packets {
 public:
  E57Packets(E57Pages& pages, const E57Section& section, std::size_t streams);

  /// Finds the first data packet at or after logical offset `at` and moves `at` behind it. Returns
  /// false at the end of the section. Throws Error (bad input) for a packet that is none.
  bool next(std::uint64_t& at);
  /// One stream's bytes in the packet found last; valid until the next call of next().
  std::span<const std::byte> stream(std::size_t index) const;

 private:
  void check_packet(std::uint64_t at, unsigned type, std::uint64_t length) const;
  void load(std::uint64_t at, std::uint64_t length);

  E57Pages& pages_;
  E57Section section_;
  std::size_t streams_;
  std::uint64_t begin_ = 0;  ///< of the packet at hand; 0: none
  std::vector<std::byte> bytes_;
  std::vector<std::size_t> bounds_;  ///< in bytes_: stream i lies in [bounds_[i], bounds_[i + 1])
};

/// Decodes one field, value by value, whatever the packets that its bits are spread over.
class E57FieldStream {
 public:
  /// `index` of the field in its scan; `begin` is the first packet's logical offset.
  E57FieldStream(const E57Field& field, std::size_t index, std::uint64_t begin);

  /// Values at hand, at least one unless the section has no more. A field of no bits never ends.
  std::uint64_t fill(E57Packets& packets);
  /// The next values, as many as out has room for; no more than are at hand. Integers are scaled.
  void decode(std::span<double> out);
  /// The same as plain integers, before scaling; floating point is cut off and clamped.
  void decode(std::span<std::int64_t> out);
  /// True when the section goes on after the values decoded so far; bits that fill up the last
  /// word are no values.
  bool has_surplus(E57Packets& packets);
  /// Logical offset of the packet that comes next.
  std::uint64_t position() const { return next_packet_; }

 private:
  std::uint64_t available() const;
  template <class Output, class Convert>
  void unpack(std::span<Output> out, Convert convert);

  E57Field field_;
  std::size_t index_;
  std::uint64_t next_packet_;
  std::vector<std::byte> buffer_;  ///< bytes not decoded yet, then padding for wide loads
  std::uint64_t bit_ = 0;          ///< next value in buffer_
  std::uint64_t end_bit_ = 0;
};

}  // namespace orbweave
