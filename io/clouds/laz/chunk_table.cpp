#include "io/clouds/laz/chunk_table.h"

#include <algorithm>
#include <array>
#include <string>

#include "io/clouds/laz/integer_decoder.h"
#include "io/clouds/laz/range_decoder.h"
#include "io/error.h"
#include "io/text/counted_noun.h"
#include "io/text/little_endian.h"

namespace orbweave::laz {
namespace {

constexpr std::uint64_t kPositionBytes = 8;
constexpr std::uint64_t kHeaderBytes = 8;  // version, number of chunks
constexpr std::uint64_t kPositionAtEnd = ~std::uint64_t{0};

template <class T>
T load_from(const RandomAccess& file, std::uint64_t offset) {
  std::array<std::byte, sizeof(T)> bytes;
  file.read(offset, bytes);
  return load_little<T>(bytes.data());
}

[[noreturn]] void refuse(const RandomAccess& file, std::uint64_t byte, std::string found,
                         std::string expected) {
  throw_bad_input("the table of compressed chunks is damaged",
                  {.file = file.name(),
                   .place = "byte " + std::to_string(byte),
                   .found = std::move(found),
                   .expected = std::move(expected),
                   .advice = "Copy or download the file again."});
}

/// Where the table begins; that of the point data when the writer never came to write it.
std::uint64_t table_position(const RandomAccess& file, std::uint64_t data) {
  std::uint64_t at = data;
  auto position = load_from<std::uint64_t>(file, at);
  if (position == kPositionAtEnd) {  // the writer could not go back
    at = file.size() - kPositionBytes;
    position = load_from<std::uint64_t>(file, at);
  }
  if (position == data) return position;
  if (position < data + kPositionBytes || file.size() < kHeaderBytes ||
      position > file.size() - kHeaderBytes)
    refuse(file, at, "its place, byte " + std::to_string(position),
           "one behind the points and before the file's end, byte " + std::to_string(file.size()));
  return position;
}

/// The chunks one after another, as their sizes come.
class Chunks {
 public:
  Chunks(const RandomAccess& file, std::uint64_t table, std::uint64_t begin, std::uint64_t points)
      : file_(file), table_(table), begin_(begin), points_(points) {}

  void add(std::uint64_t points, std::uint64_t bytes, std::size_t record_bytes) {
    const std::string chunk = "chunk " + std::to_string(count_++);
    if (bytes > table_ - begin_)
      refuse(file_, table_, chunk + " of " + std::to_string(bytes) + " bytes",
             "at most " + std::to_string(table_ - begin_) + ", up to the table");
    const std::uint64_t taken = std::min(points, points_);
    if (taken > 0 && bytes < record_bytes)
      refuse(file_, table_, chunk + " of " + std::to_string(bytes) + " bytes",
             "at least " + std::to_string(record_bytes) + ", a point");
    if (taken > 0) chunks_.push_back({begin_, begin_ + bytes, taken});
    begin_ += bytes;
    points_ -= taken;
  }
  std::uint64_t points_left() const { return points_; }
  std::vector<Chunk> take() { return std::move(chunks_); }

 private:
  const RandomAccess& file_;
  std::uint64_t table_, begin_;
  std::uint64_t points_;  ///< that no chunk holds yet
  std::uint64_t count_ = 0;
  std::vector<Chunk> chunks_;
};

std::vector<Chunk> read_entries(const RandomAccess& file, std::uint64_t table, std::uint64_t begin,
                                std::uint64_t points, std::uint32_t chunk_points,
                                std::size_t record_bytes) {
  if (const auto version = load_from<std::uint32_t>(file, table); version != 0)
    refuse(file, table, "version " + std::to_string(version), "0");
  const auto count = load_from<std::uint32_t>(file, table + 4);
  if (count > (table - begin) / record_bytes)
    refuse(file, table + 4, std::to_string(count) + " chunks",
           "at most " + std::to_string((table - begin) / record_bytes) + ", by the bytes before");
  RangeDecoder in;
  if (count > 0) in.open(file, table + kHeaderBytes, file.size());
  IntegerDecoder<32, 2> differences;
  Chunks chunks(file, table, begin, points);
  std::uint32_t last_points = 0;
  std::uint32_t last_bytes = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (chunk_points == 0) last_points = differences.decode(in, last_points, 0);
    last_bytes = differences.decode(in, last_bytes, 1);
    chunks.add(chunk_points == 0 ? last_points : chunk_points, last_bytes, record_bytes);
  }
  if (chunks.points_left() > 0)
    refuse(file, table, "chunks for " + counted_points(points - chunks.points_left()),
           std::to_string(points) + ", as the header says");
  return chunks.take();
}

}  // namespace

ChunkTable read_chunk_table(const RandomAccess& file, const LaszipRecord& record,
                            std::uint64_t point_data_offset, std::uint64_t points,
                            std::size_t record_bytes) {
  if (record.arrangement == Arrangement::kOneStream) {
    load_from<std::uint8_t>(file, point_data_offset);  // there is one
    Chunk all{point_data_offset, file.size(), points};
    return {.chunks = {all}, .first_begin = point_data_offset};
  }
  const std::uint64_t table = table_position(file, point_data_offset);
  const std::uint64_t begin = point_data_offset + kPositionBytes;
  if (table == point_data_offset) {
    if (record.chunk_points == 0)
      refuse(file, point_data_offset, "none, as its writer was interrupted",
             "one, as the chunks differ in their number of points");
    return {.chunks = {}, .missing = true, .first_begin = begin};
  }
  return {.chunks = read_entries(file, table, begin, points, record.chunk_points, record_bytes),
          .first_begin = begin};
}

}  // namespace orbweave::laz
