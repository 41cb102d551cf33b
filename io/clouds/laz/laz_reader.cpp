#include "io/clouds/laz/laz_reader.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <exception>
#include <utility>
#include <vector>

#include "io/clouds/laz/chunk_decoder.h"
#include "io/clouds/laz/chunk_table.h"
#include "io/clouds/laz/laszip_record.h"

namespace orbweave {
namespace {

// Chunks up to here are decoded as a whole, several at a time; larger ones piece by piece, so that
// memory is bounded whatever their size. LASzip's own chunks are 50000 points, 1 to 4 MB.
constexpr std::uint64_t kLargestWholeChunkBytes = 8 << 20;
constexpr std::uint64_t kBatchBytes = 64 << 20;
// Chunks differ in cost: with two for each thread, few threads wait for the last one.
constexpr std::size_t kChunksPerThread = 2;
// How many bytes a decoder of extra bytes takes for each, at most.
constexpr std::uint64_t kModelBytes = 4 * 1200;
// Records are decoded in pieces, so that damage is met before memory is taken for all of them.
constexpr std::size_t kPieceBytes = 64 << 10;

}  // namespace

class LazReader::Decoding {
 public:
  Decoding(const RandomAccess& file, laz::LaszipRecord record, std::uint64_t data_begin,
           std::uint64_t points, std::size_t record_bytes)
      : file_(file),
        record_(std::move(record)),
        record_bytes_(record_bytes),
        points_left_(points),
        data_begin_(data_begin),
        position_(data_begin) {
    if (points == 0) return;
    table_ = laz::read_chunk_table(file, record_, data_begin, points, record_bytes);
    position_ = table_.first_begin;
  }

  std::size_t read(std::span<std::byte> records);
  std::uint64_t bytes_read() const { return position() - data_begin_; }

 private:
  struct Slot {
    std::unique_ptr<laz::ChunkDecoder> decoder;
    laz::Chunk chunk{};
    std::vector<std::byte> records{};
    std::exception_ptr error{};
  };

  std::uint64_t position() const;
  std::size_t read_some(std::span<std::byte> records);
  void begin_next();
  std::vector<laz::Chunk> next_whole_chunks();
  void decode_batch(const std::vector<laz::Chunk>& chunks);
  void decode_whole(Slot& slot, const laz::Chunk& chunk) const;
  void begin_streaming();
  Slot& slot(std::size_t index);
  std::size_t take_whole(std::span<std::byte> records);
  std::size_t take_streamed(std::span<std::byte> records);
  std::uint64_t decoded_bytes(const laz::Chunk& chunk) const {
    return chunk.points > kBatchBytes ? chunk.points : chunk.points * record_bytes_;
  }

  const RandomAccess& file_;
  laz::LaszipRecord record_;
  laz::ChunkTable table_;
  std::size_t record_bytes_;
  std::uint64_t points_left_;
  std::uint64_t data_begin_;
  std::uint64_t position_;         ///< byte behind the chunks that were handed out
  std::size_t next_chunk_ = 0;     ///< of the table
  std::vector<Slot> slots_;        ///< kept, as their models are large
  std::size_t batch_ = 0;          ///< slots in use
  std::size_t taken_slots_ = 0;    ///< of them, handed out
  std::size_t taken_bytes_ = 0;    ///< of the slot after those
  std::uint64_t stream_left_ = 0;  ///< points of the chunk that is decoded piece by piece
  std::exception_ptr failure_;
};

std::size_t LazReader::Decoding::read(std::span<std::byte> records) {
  const std::size_t capacity = records.size() / record_bytes_;
  std::size_t count = 0;
  while (count < capacity && points_left_ > 0 && !failure_) {
    try {
      const std::size_t some =
          read_some(records.subspan(count * record_bytes_, (capacity - count) * record_bytes_));
      count += some;
      points_left_ -= some;
    } catch (...) {
      // The points before are good; the next call tells of the damage.
      failure_ = std::current_exception();
    }
  }
  if (count == 0 && capacity > 0 && failure_) std::rethrow_exception(failure_);
  return count;
}

std::size_t LazReader::Decoding::read_some(std::span<std::byte> records) {
  if (taken_slots_ == batch_ && stream_left_ == 0) begin_next();
  return stream_left_ > 0 ? take_streamed(records) : take_whole(records);
}

void LazReader::Decoding::begin_next() {
  batch_ = taken_slots_ = taken_bytes_ = 0;
  const std::vector<laz::Chunk> chunks = next_whole_chunks();
  if (chunks.empty())
    begin_streaming();
  else
    decode_batch(chunks);
}

/// The next chunks that are decoded side by side; none when the next one is too large or where it
/// ends is not known.
std::vector<laz::Chunk> LazReader::Decoding::next_whole_chunks() {
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const std::size_t most = threads > 1 ? threads * kChunksPerThread : 1;
  std::vector<laz::Chunk> chunks;
  std::uint64_t bytes = 0;
  while (chunks.size() < most && next_chunk_ < table_.chunks.size()) {
    const laz::Chunk& chunk = table_.chunks[next_chunk_];
    if (decoded_bytes(chunk) > kLargestWholeChunkBytes) break;
    bytes += decoded_bytes(chunk) + record_bytes_ * kModelBytes;
    if (!chunks.empty() && bytes > kBatchBytes) break;
    chunks.push_back(chunk);
    ++next_chunk_;
  }
  return chunks;
}

void LazReader::Decoding::decode_batch(const std::vector<laz::Chunk>& chunks) {
  batch_ = chunks.size();
  slot(batch_ - 1);
  tbb::parallel_for(std::size_t{0}, batch_, [&](std::size_t i) {
    // Kept rather than thrown: the first damaged chunk is to be told of, not the first one met.
    try {
      decode_whole(slots_[i], chunks[i]);
    } catch (...) {
      slots_[i].error = std::current_exception();
    }
  });
}

void LazReader::Decoding::decode_whole(Slot& slot, const laz::Chunk& chunk) const {
  slot.chunk = chunk;
  slot.error = nullptr;
  slot.records.clear();
  slot.decoder->start(chunk);
  const std::size_t bytes = static_cast<std::size_t>(chunk.points) * record_bytes_;
  const std::size_t piece = std::max<std::size_t>(1, kPieceBytes / record_bytes_) * record_bytes_;
  for (std::size_t done = 0; done < bytes;) {
    const std::size_t next = std::min(piece, bytes - done);
    slot.records.resize(done + next);
    slot.decoder->decode(std::span(slot.records).subspan(done));
    done += next;
  }
}

void LazReader::Decoding::begin_streaming() {
  laz::Chunk& chunk = slot(0).chunk;
  if (table_.missing)
    chunk = {position_, file_.size(), std::min<std::uint64_t>(record_.chunk_points, points_left_)};
  else
    chunk = table_.chunks[next_chunk_++];
  slot(0).decoder->start(chunk);
  stream_left_ = chunk.points;
}

LazReader::Decoding::Slot& LazReader::Decoding::slot(std::size_t index) {
  while (slots_.size() <= index)
    slots_.push_back({.decoder = laz::make_chunk_decoder(file_, record_)});
  return slots_[index];
}

std::size_t LazReader::Decoding::take_whole(std::span<std::byte> records) {
  Slot& slot = slots_[taken_slots_];
  if (slot.error) std::rethrow_exception(slot.error);
  const std::size_t bytes = std::min(records.size(), slot.records.size() - taken_bytes_);
  const auto from = slot.records.begin() + static_cast<std::ptrdiff_t>(taken_bytes_);
  std::copy_n(from, bytes, records.begin());
  taken_bytes_ += bytes;
  if (taken_bytes_ == slot.records.size()) {
    position_ = slot.chunk.end;
    taken_bytes_ = 0;
    ++taken_slots_;
  }
  return bytes / record_bytes_;
}

std::size_t LazReader::Decoding::take_streamed(std::span<std::byte> records) {
  const auto count = static_cast<std::size_t>(
      std::min<std::uint64_t>(stream_left_, records.size() / record_bytes_));
  slots_[0].decoder->decode(records.first(count * record_bytes_));
  stream_left_ -= count;
  position_ = slots_[0].decoder->position();
  return count;
}

std::uint64_t LazReader::Decoding::position() const {
  if (taken_bytes_ == 0) return position_;
  const Slot& slot = slots_[taken_slots_];
  const double part = static_cast<double>(taken_bytes_) / static_cast<double>(slot.records.size());
  const auto bytes = static_cast<double>(slot.chunk.end - slot.chunk.begin);
  return slot.chunk.begin + static_cast<std::uint64_t>(part * bytes);
}

LazReader::LazReader(const RandomAccess& file, std::span<const std::byte> laszip_vlr,
                     std::uint64_t point_data_offset, std::uint64_t points,
                     std::uint8_t point_format, std::uint16_t record_bytes) {
  laz::LaszipRecord record =
      laz::parse_laszip_record(laszip_vlr, point_format, record_bytes, file.name());
  decoding_ =
      std::make_unique<Decoding>(file, std::move(record), point_data_offset, points, record_bytes);
}

LazReader::~LazReader() = default;
LazReader::LazReader(LazReader&&) noexcept = default;
LazReader& LazReader::operator=(LazReader&&) noexcept = default;

std::size_t LazReader::read(std::span<std::byte> records) { return decoding_->read(records); }

std::uint64_t LazReader::bytes_read() const { return decoding_->bytes_read(); }

}  // namespace orbweave
