// The lowest layer of E57 (ASTM E2807): a header of 48 bytes, and pages that each end
// with a checksum. Offsets in the file are physical; what lies between the checksums is logical.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/streams/random_access.h"

namespace orbweave {

/// The file header.
struct E57Header {
  std::uint64_t physical_bytes = 0;  ///< of the whole file
  std::uint64_t xml_offset = 0;      ///< physical
  std::uint64_t xml_bytes = 0;       ///< logical
  std::uint64_t page_bytes = 0;      ///< checksum included
};

/// The logical bytes of a file. Checks every page that it reads; holds up to sixteen windows of
/// pages, for fields whose packets lie apart. Not for several threads at once.
class E57Pages {
 public:
  /// Reads and checks the header. Throws Error (bad input) for what is no E57 file of version 1,
  /// is shorter than its header says or has a header that contradicts itself.
  explicit E57Pages(std::unique_ptr<RandomAccess> file);

  const E57Header& header() const { return header_; }
  const RandomAccess& file() const { return *file_; }
  const std::string& name() const { return file_->name(); }
  std::uint64_t logical_bytes() const { return pages_ * payload_; }

  /// Throws Error (bad input) for a physical offset outside of the file, inside of its header or
  /// within a checksum; `what` says in messages what should be there.
  std::uint64_t to_logical(std::uint64_t physical, const std::string& what) const;
  std::uint64_t to_physical(std::uint64_t logical) const {
    return logical / payload_ * header_.page_bytes + logical % payload_;
  }
  /// "byte 1042": the physical place of a logical offset, for messages.
  std::string place(std::uint64_t logical) const;

  /// Fills `out` from logical offset `logical` on. Throws Error (bad input) past the end, and for
  /// a page whose checksum is wrong, naming page and byte.
  void read(std::uint64_t logical, std::span<std::byte> out);

 private:
  /// Some pages that follow each other, without their checksums.
  struct Window {
    std::uint64_t begin = 0;  ///< logical offset
    std::uint64_t last_use = 0;
    std::vector<std::byte> bytes;
  };

  const Window& window_at(std::uint64_t logical);
  void load(std::uint64_t page, Window& window);
  void check_page(std::uint64_t page, std::span<const std::byte> bytes) const;

  std::unique_ptr<RandomAccess> file_;
  E57Header header_;
  std::uint64_t payload_ = 0;  ///< bytes of a page without its checksum
  std::uint64_t pages_ = 0;
  std::uint64_t uses_ = 0;
  std::vector<Window> windows_;
  std::vector<std::byte> raw_;
};

}  // namespace orbweave
