// Rows of numbers, made smaller: the bytes of equal place are gathered (HDF5's shuffle filter),
// then compressed (its deflate filter). Any HDF5 tool reads what comes out.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace orbweave {

/// Packs `rows`, numbers of `number_bytes` each, as if zeros followed up to `padded_bytes`.
std::vector<std::byte> pack_block(std::span<const std::byte> rows, std::size_t number_bytes,
                                  std::size_t padded_bytes);

/// The inverse: the first rows.size() of `padded_bytes`. False where `packed` is something else.
bool unpack_block(std::span<const std::byte> packed, std::size_t number_bytes,
                  std::size_t padded_bytes, std::span<std::byte> rows);

/// Most bytes that a packed block takes.
std::size_t most_packed_bytes(std::size_t padded_bytes);

}  // namespace orbweave
