// The records of one chunk, in order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "io/clouds/laz/chunk_table.h"
#include "io/clouds/laz/laszip_record.h"
#include "io/streams/random_access.h"

namespace orbweave::laz {

/// Decodes chunk after chunk, each on its own. Memory depends on the record's layout alone.
class ChunkDecoder {
 public:
  virtual ~ChunkDecoder() = default;
  /// Begins a chunk. Throws Error (bad input) when its bytes cannot be its beginning.
  virtual void start(const Chunk& chunk) = 0;
  /// Fills `records` with whole records, no more than the chunk has left. Throws Error (bad input)
  /// for damaged bytes.
  virtual void decode(std::span<std::byte> records) = 0;
  /// The byte of the file behind those used; the chunk's end once all its points are decoded.
  virtual std::uint64_t position() const = 0;
};

/// `file` must outlive the decoder.
std::unique_ptr<ChunkDecoder> make_chunk_decoder(const RandomAccess& file,
                                                 const LaszipRecord& record);

}  // namespace orbweave::laz
