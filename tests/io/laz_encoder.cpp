#include "tests/io/laz_encoder.h"

#include <algorithm>
#include <array>

#include "tests/io/laz_range_encoder.h"

namespace orbweave::test {
namespace {

constexpr std::uint64_t kDataOffset = 37;
constexpr std::uint32_t kAnySize = 0xffffffffU;

struct ChunkSize {
  std::uint32_t points, bytes;
};

std::vector<std::array<unsigned, 3>> items_of(const LazOptions& options) {
  const unsigned format = options.point_format;
  std::vector<std::array<unsigned, 3>> items;
  if (format < 6) {
    items.push_back({6, 20, 2});
    if (format == 1 || format >= 3) items.push_back({7, 8, 2});
    if (format == 2 || format == 3 || format == 5) items.push_back({8, 6, 2});
    if (format >= 4) items.push_back({9, 29, 1});
    if (options.extra_bytes > 0)
      items.push_back({0, static_cast<unsigned>(options.extra_bytes), 2});
  } else {
    const unsigned version = options.layer_version;
    items.push_back({10, 30, version});
    if (format == 7) items.push_back({11, 6, version});
    if (format == 8 || format == 10) items.push_back({12, 8, version});
    if (format >= 9) items.push_back({13, 29, version});
    if (options.extra_bytes > 0)
      items.push_back({14, static_cast<unsigned>(options.extra_bytes), version});
  }
  return items;
}

std::vector<std::uint8_t> laszip_payload(const LazOptions& options) {
  std::vector<std::uint8_t> vlr;
  append(vlr, static_cast<std::uint16_t>(options.compressor));
  append(vlr, std::uint16_t{0});
  append(vlr, std::uint32_t{0x00030403});  // written by 3.4 revision 3
  append(vlr, std::uint32_t{0});
  append(vlr,
         options.chunk_points == 0 ? kAnySize : static_cast<std::uint32_t>(options.chunk_points));
  append(vlr, ~std::uint64_t{0});
  append(vlr, ~std::uint64_t{0});
  const auto items = items_of(options);
  append(vlr, static_cast<std::uint16_t>(items.size()));
  for (const auto& item : items)
    for (const unsigned field : item) append(vlr, static_cast<std::uint16_t>(field));
  return vlr;
}

void append_table(std::vector<std::uint8_t>& bytes, const std::vector<ChunkSize>& chunks,
                  bool any_size) {
  append(bytes, std::uint32_t{0});
  append(bytes, static_cast<std::uint32_t>(chunks.size()));
  RangeEncoder out;
  IntegerEncoder sizes(32);
  ChunkSize last{0, 0};
  for (const ChunkSize& chunk : chunks) {
    if (any_size) sizes.encode(out, last.points, chunk.points, 0);
    sizes.encode(out, last.bytes, chunk.bytes, 1);
    last = chunk;
  }
  const auto coded = out.finish();
  bytes.insert(bytes.end(), coded.begin(), coded.end());
}

/// The number of points of chunk `index`.
std::size_t chunk_points(const LazOptions& options, std::size_t index, std::size_t all) {
  constexpr std::array<std::size_t, 3> kSizes{40, 1, 70};
  if (options.compressor == 1) return all;
  return options.chunk_points > 0 ? options.chunk_points : kSizes[index % kSizes.size()];
}

std::vector<std::byte> as_bytes(const std::vector<std::uint8_t>& bytes) {
  const auto view = std::as_bytes(std::span(bytes));
  return {view.begin(), view.end()};
}

void overwrite(std::vector<std::uint8_t>& bytes, std::size_t at, std::uint64_t value) {
  std::vector<std::uint8_t> word;
  append(word, value);
  std::copy(word.begin(), word.end(), bytes.begin() + static_cast<long>(at));
}

}  // namespace

std::size_t record_bytes(const LazOptions& options) {
  std::size_t bytes = 0;
  for (const auto& item : items_of(options)) bytes += item[1];
  return bytes;
}

LazFile encode_laz(const LazOptions& options, std::span<const std::uint8_t> records) {
  const std::size_t size = record_bytes(options);
  std::vector<std::uint8_t> bytes(kDataOffset, 0x5a);
  const bool chunked = options.compressor != 1;
  if (chunked)
    append(bytes, options.table == TablePlace::kNamedAtEnd ? ~std::uint64_t{0} : kDataOffset);
  std::vector<ChunkSize> chunks;
  for (std::size_t done = 0; done < records.size();) {
    const std::size_t points = std::min(chunk_points(options, chunks.size(), records.size() / size),
                                        (records.size() - done) / size);
    const auto part = records.subspan(done, points * size);
    const auto chunk = options.compressor == 3 ? encode_layered_chunk(options, part)
                                               : encode_pointwise_chunk(options, part);
    chunks.push_back(
        {static_cast<std::uint32_t>(points), static_cast<std::uint32_t>(chunk.size())});
    bytes.insert(bytes.end(), chunk.begin(), chunk.end());
    done += part.size();
  }
  if (chunked && options.table != TablePlace::kMissing) {
    const std::uint64_t table = bytes.size();
    append_table(bytes, chunks, options.chunk_points == 0);
    if (options.table == TablePlace::kNamedAtEnd)
      append(bytes, table);
    else
      overwrite(bytes, kDataOffset, table);
  }
  return {as_bytes(bytes), as_bytes(laszip_payload(options)), kDataOffset, records.size() / size,
          options};
}

}  // namespace orbweave::test
