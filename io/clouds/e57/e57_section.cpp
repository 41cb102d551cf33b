#include "io/clouds/e57/e57_section.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "io/error.h"
#include "io/text/counted_noun.h"
#include "io/text/little_endian.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kSectionHeaderBytes = 32;
constexpr std::uint64_t kSectionId = 1;
constexpr std::size_t kPacketHeaderBytes = 4;      ///< type, flags, length less one
constexpr std::size_t kDataPacketHeaderBytes = 6;  ///< and the number of streams
constexpr std::size_t kLoadBytes = 8;
constexpr std::size_t kPadding = 2 * kLoadBytes;

enum class PacketType : unsigned { kIndex = 0, kData = 1, kEmpty = 2 };

/// Out of range and "not a number" become the nearest there is and zero.
std::int64_t to_integer(double value) {
  constexpr double kAbove = 9223372036854775808.0;
  if (!(std::abs(value) < kAbove))
    return std::isnan(value) ? 0
           : value > 0       ? std::numeric_limits<std::int64_t>::max()
                             : std::numeric_limits<std::int64_t>::min();
  return static_cast<std::int64_t>(value);
}

/// Refuses a count that lies before anything is made of it.
void check_room(const E57Pages& pages, const E57Scan& scan, const E57Section& section) {
  std::uint64_t bits = 0;
  for (const E57Field& field : scan.fields)
    if (field.kind != E57Kind::kString) bits += field.bits;
  // Points of no bits cost nothing to claim; they too are bounded by the file's size.
  const std::uint64_t room = 8 * (section.end - (bits == 0 ? section.begin : section.data));
  const std::uint64_t most = room / std::max<std::uint64_t>(bits, 1);
  if (scan.records > most)
    throw_bad_input(scan.label + " claims more points than its section can hold",
                    {.file = pages.name(),
                     .place = pages.place(section.begin),
                     .found = counted_points(scan.records),
                     .expected = "at most " + std::to_string(most)});
}

}  // namespace

E57Section read_e57_section(E57Pages& pages, const E57Scan& scan) {
  E57Section section;
  section.begin = pages.to_logical(scan.section_offset, "the points of " + scan.label);
  const auto refuse = [&](const std::string& problem, std::uint64_t found,
                          const std::string& expected) {
    throw_bad_input(problem, {.file = pages.name(),
                              .place = pages.place(section.begin),
                              .found = std::to_string(found),
                              .expected = expected});
  };
  std::array<std::byte, kSectionHeaderBytes> header;
  pages.read(section.begin, header);
  const auto field = [&](std::size_t at) { return load_little<std::uint64_t>(header.data() + at); };
  const auto id = static_cast<std::uint64_t>(header[0]);
  if (id != kSectionId)
    refuse("the section of " + scan.label + " holds no compressed points: its id is wrong", id,
           std::to_string(kSectionId));
  const std::uint64_t bytes = field(8);
  const std::uint64_t room = pages.logical_bytes() - section.begin;
  if (bytes < kSectionHeaderBytes || bytes > room)
    refuse("the section of " + scan.label + " has an impossible length", bytes,
           std::to_string(kSectionHeaderBytes) + " to " + std::to_string(room) + " bytes");
  section.end = section.begin + bytes;
  if (scan.records == 0) return section;
  section.data = pages.to_logical(field(16), "the packets of " + scan.label);
  if (section.data < section.begin + kSectionHeaderBytes || section.data > section.end)
    refuse("the packets of " + scan.label + " begin outside of its section", field(16),
           "a byte from " + std::to_string(pages.to_physical(section.begin + kSectionHeaderBytes)) +
               " to " + std::to_string(pages.to_physical(section.end)));
  check_room(pages, scan, section);
  return section;
}

E57Packets::E57Packets(E57Pages& pages, const E57Section& section, std::size_t streams)
    : pages_(pages), section_(section), streams_(streams) {}

bool E57Packets::next(std::uint64_t& at) {
  while (section_.end - at >= kPacketHeaderBytes) {
    if (at == begin_) {
      at += bytes_.size();
      return true;
    }
    std::array<std::byte, kPacketHeaderBytes> header;
    pages_.read(at, header);
    const auto type = static_cast<unsigned>(header[0]);
    const std::uint64_t length_less_one = load_little<std::uint16_t>(header.data() + 2);
    if (type == 0 && length_less_one == 0) return false;  // zeros that fill up the section
    check_packet(at, type, length_less_one + 1);
    if (static_cast<PacketType>(type) == PacketType::kData)
      load(at, length_less_one + 1);
    else
      at += length_less_one + 1;
  }
  return false;
}

void E57Packets::check_packet(std::uint64_t at, unsigned type, std::uint64_t length) const {
  if (type > static_cast<unsigned>(PacketType::kEmpty))
    throw_bad_input("a packet of points has an unknown type", {.file = pages_.name(),
                                                               .place = pages_.place(at),
                                                               .found = std::to_string(type),
                                                               .expected = "0, 1 or 2"});
  const bool is_data = static_cast<PacketType>(type) == PacketType::kData;
  const std::uint64_t least = is_data ? kDataPacketHeaderBytes : kPacketHeaderBytes;
  if (length < least || length > section_.end - at)
    throw_bad_input("a packet of points has an impossible length",
                    {.file = pages_.name(),
                     .place = pages_.place(at),
                     .found = std::to_string(length) + " bytes",
                     .expected = std::to_string(least) + " to " +
                                 std::to_string(section_.end - at) + " bytes"});
}

void E57Packets::load(std::uint64_t at, std::uint64_t length) {
  begin_ = 0;
  bytes_.resize(static_cast<std::size_t>(length));
  pages_.read(at, bytes_);
  const auto count = load_little<std::uint16_t>(bytes_.data() + kPacketHeaderBytes);
  if (count != streams_)
    throw_bad_input("a packet of points does not hold the fields that its scan declares",
                    {.file = pages_.name(),
                     .place = pages_.place(at),
                     .found = std::to_string(count) + " streams",
                     .expected = std::to_string(streams_)});
  const std::size_t lengths_end = kDataPacketHeaderBytes + 2 * streams_;
  std::size_t end = lengths_end;
  bounds_.assign(1, end);
  for (std::size_t i = 0; i < streams_ && lengths_end <= bytes_.size(); ++i) {
    end += load_little<std::uint16_t>(bytes_.data() + kDataPacketHeaderBytes + 2 * i);
    bounds_.push_back(end);
  }
  if (end > bytes_.size())
    throw_bad_input("the streams of a packet of points are longer than the packet",
                    {.file = pages_.name(),
                     .place = pages_.place(at),
                     .found = std::to_string(end) + " bytes",
                     .expected = "at most " + std::to_string(bytes_.size())});
  begin_ = at;
}

std::span<const std::byte> E57Packets::stream(std::size_t index) const {
  return std::span(bytes_).subspan(bounds_[index], bounds_[index + 1] - bounds_[index]);
}

E57FieldStream::E57FieldStream(const E57Field& field, std::size_t index, std::uint64_t begin)
    : field_(field), index_(index), next_packet_(begin), buffer_(kPadding) {}

std::uint64_t E57FieldStream::available() const {
  if (field_.bits == 0) return std::numeric_limits<std::uint64_t>::max();
  return (end_bit_ - bit_) / field_.bits;
}

std::uint64_t E57FieldStream::fill(E57Packets& packets) {
  while (available() == 0 && packets.next(next_packet_)) {
    const std::span<const std::byte> fresh = packets.stream(index_);
    // What is left is less than one value, whose bits may have begun in the packet before.
    const auto used = static_cast<std::size_t>(bit_ / 8);
    const auto left = static_cast<std::size_t>(end_bit_ / 8) - used;
    std::memmove(buffer_.data(), buffer_.data() + used, left);
    buffer_.resize(left + fresh.size() + kPadding);
    std::copy(fresh.begin(), fresh.end(), buffer_.begin() + static_cast<std::ptrdiff_t>(left));
    bit_ %= 8;
    end_bit_ = 8 * static_cast<std::uint64_t>(left + fresh.size());
  }
  return available();
}

/// Values lie least significant bit first, one after the other, across bytes.
template <class Output, class Convert>
void E57FieldStream::unpack(std::span<Output> out, Convert convert) {
  const unsigned bits = field_.bits;
  const std::uint64_t mask = bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
  const std::byte* const bytes = buffer_.data();
  std::uint64_t bit = bit_;
  if (bits <= 64 - 7) {
    for (Output& value : out) {
      value = convert(load_little<std::uint64_t>(bytes + bit / 8) >> bit % 8 & mask);
      bit += bits;
    }
  } else {
    for (Output& value : out) {
      const std::uint64_t low = load_little<std::uint64_t>(bytes + bit / 8) >> bit % 8;
      // Shifted in two steps: a shift by 64 would not be defined.
      const std::uint64_t high = load_little<std::uint64_t>(bytes + bit / 8 + kLoadBytes)
                                 << 1 << (63 - bit % 8);
      value = convert((low | high) & mask);
      bit += bits;
    }
  }
  bit_ = bit;
}

void E57FieldStream::decode(std::span<double> out) {
  const auto minimum = static_cast<std::uint64_t>(field_.minimum);
  const double scale = field_.scale, offset = field_.offset;
  switch (field_.kind) {
    case E57Kind::kFloat32:
      return unpack(out, [](std::uint64_t word) {
        return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(word)));
      });
    case E57Kind::kFloat64:
      return unpack(out, [](std::uint64_t word) { return std::bit_cast<double>(word); });
    case E57Kind::kScaledInteger:
      return unpack(out, [=](std::uint64_t word) {
        return static_cast<double>(static_cast<std::int64_t>(minimum + word)) * scale + offset;
      });
    case E57Kind::kInteger:
    case E57Kind::kString:
      return unpack(out, [=](std::uint64_t word) {
        return static_cast<double>(static_cast<std::int64_t>(minimum + word));
      });
  }
}

void E57FieldStream::decode(std::span<std::int64_t> out) {
  if (field_.kind == E57Kind::kFloat32 || field_.kind == E57Kind::kFloat64) {
    std::vector<double> reals(out.size());
    decode(std::span(reals));
    std::transform(reals.begin(), reals.end(), out.begin(), to_integer);
    return;
  }
  const auto minimum = static_cast<std::uint64_t>(field_.minimum);
  unpack(out, [=](std::uint64_t word) { return static_cast<std::int64_t>(minimum + word); });
}

bool E57FieldStream::has_surplus(E57Packets& packets) {
  if (field_.bits == 0) return false;
  // Writers fill up the last word of packed integers, of up to 64 bits.
  const bool is_packed = field_.kind == E57Kind::kInteger || field_.kind == E57Kind::kScaledInteger;
  const std::uint64_t filled = is_packed ? 64 : 0;
  const std::uint64_t least = std::max<std::uint64_t>(field_.bits, filled);
  std::uint64_t left = end_bit_ - bit_;
  while (left < least && packets.next(next_packet_))
    left += 8 * static_cast<std::uint64_t>(packets.stream(index_).size());
  return left >= least;
}

}  // namespace orbweave
