// Any bytes as the compressed points of a LAZ file. In front: point format, length of a record (2),
// points (8), length of the record "laszip encoded" (1), and that record.
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <vector>

#include "io/clouds/laz/laz_reader.h"
#include "io/text/little_endian.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

constexpr std::size_t kHeaderBytes = 12;
// Few bytes can stand for millions of points that are all alike.
constexpr std::size_t kMostPoints = 1000;

void read(std::span<const std::byte> bytes) {
  const auto point_format = orbweave::load_little<std::uint8_t>(bytes.data());
  const auto record_bytes = orbweave::load_little<std::uint16_t>(bytes.data() + 1);
  const auto points = orbweave::load_little<std::uint64_t>(bytes.data() + 3);
  const std::size_t described = orbweave::load_little<std::uint8_t>(bytes.data() + 11);
  bytes = bytes.subspan(kHeaderBytes);
  if (bytes.size() < described) return;
  const auto file = orbweave::memory_random_access(bytes.subspan(described), "input");
  orbweave::LazReader reader(*file, bytes.first(described), 0, points, point_format, record_bytes);
  std::vector<std::byte> records(std::size_t{97} * record_bytes);
  std::size_t read = 0;
  while (read < kMostPoints) {
    const std::size_t some = reader.read(records);
    read += some;
    if (read > points) throw std::logic_error("more points than declared");
    if (some == 0 && read < points) throw std::logic_error("fewer points, and no error");
    if (some == 0) break;
  }
  if (reader.bytes_read() > file->size()) throw std::logic_error("more bytes read than there are");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // Two chunks at a time, but one after the other: a run must be the same every time.
  static const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  static tbb::task_arena arena(2);
  if (size < kHeaderBytes) return 0;
  arena.execute([&] {
    try {
      read(orbweave::fuzz::bytes_of(data, size));
    } catch (const orbweave::Error&) {
      // Damage, said so.
    }
  });
  return 0;
}
