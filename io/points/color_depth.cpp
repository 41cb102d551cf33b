#include "io/points/color_depth.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>

#include "io/text/lower_case.h"

namespace orbweave {
namespace {

constexpr std::array<const char*, 3> kChannels = {"red", "green", "blue"};
constexpr unsigned kMost8 = 255;
/// 65535 is 257 times 255.
constexpr unsigned kStep = 257;

std::uint16_t channel(const std::byte* at) {
  std::uint16_t value = 0;
  std::memcpy(&value, at, sizeof value);
  return value;
}

/// The nearest of the 256 values.
std::uint8_t narrowed(std::uint16_t value) {
  return static_cast<std::uint8_t>((value + kStep / 2) / kStep);
}

template <class Word>
void copy_ends(std::byte* to, const std::byte* from, std::size_t bytes) {
  Word front, back;
  std::memcpy(&front, from, sizeof front);
  std::memcpy(&back, from + bytes - sizeof back, sizeof back);
  std::memcpy(to, &front, sizeof front);
  std::memcpy(to + bytes - sizeof back, &back, sizeof back);
}

/// As memmove: the few bytes of a row in two words, which may overlap. A call per row would take
/// longer than everything else.
inline void move_bytes(std::byte* to, const std::byte* from, std::size_t bytes) {
  if (bytes >= 8 && bytes <= 16)
    copy_ends<std::uint64_t>(to, from, bytes);
  else if (bytes >= 4 && bytes < 8)
    copy_ends<std::uint32_t>(to, from, bytes);
  else
    std::memmove(to, from, bytes);
}

}  // namespace

std::optional<WideColors> wide_colors(const PointSchema& schema) {
  WideColors colors;
  std::size_t found = 0;
  for (std::size_t c = 0; c < kChannels.size(); ++c) {
    std::size_t offset = 0;
    for (std::size_t f = 0; f < schema.attributes.size(); ++f) {
      const AttributeField& field = schema.attributes[f];
      if (field.type == ScalarType::kUint16 && lower_case(field.name) == kChannels[c]) {
        colors.fields[c] = f;
        colors.offsets[c] = offset;
        ++found;
        break;
      }
      offset += size_of(field.type);
    }
  }
  return found == kChannels.size() ? std::optional(colors) : std::nullopt;
}

bool exceed_8_bits(const PointCloud& points, const WideColors& colors) {
  const std::size_t row_bytes = points.schema.attribute_bytes();
  const std::byte* row = points.attributes.data();
  for (std::size_t i = 0; i < points.size(); ++i, row += row_bytes)
    for (const std::size_t offset : colors.offsets)
      if (channel(row + offset) > kMost8) return true;
  return false;
}

bool widens_colors(const PointSchema& file, const PointSchema& common) {
  const std::optional<WideColors> wide = wide_colors(common);
  return wide && std::ranges::all_of(wide->fields, [&](std::size_t channel) {
           return std::ranges::find(file.attributes, AttributeField{common.attributes[channel].name,
                                                                    ScalarType::kUint8}) !=
                  file.attributes.end();
         });
}

std::uint16_t widened_color(std::uint8_t value) {
  return static_cast<std::uint16_t>(value * kStep);
}

ColorDepth::ColorDepth(const PointSchema& read, int bits, bool exceeds_8_bits)
    : written_(read), read_bytes_(read.attribute_bytes()), scales_(exceeds_8_bits) {
  constexpr int kNarrow = 8;
  if (bits == kNarrow) colors_ = wide_colors(read);
  if (!colors_) return;
  std::size_t from = 0, to = 0;
  for (std::size_t f = 0; f < read.attributes.size(); ++f) {
    const std::size_t bytes = size_of(read.attributes[f].type);
    const auto* const at = std::find(std::begin(colors_->fields), std::end(colors_->fields), f);
    if (at != std::end(colors_->fields)) {
      const auto c = static_cast<std::size_t>(at - std::begin(colors_->fields));
      written_.attributes[f] = {kChannels[c], ScalarType::kUint8};
      written_offsets_[c] = to++;
    } else {
      Run* const last = runs_.count == 0 ? nullptr : &runs_.at[runs_.count - 1];
      if (last != nullptr && last->from + last->bytes == from)
        last->bytes += bytes;
      else
        runs_.at.at(runs_.count++) = {from, to, bytes};
      to += bytes;
    }
    from += bytes;
  }
}

void ColorDepth::apply(PointCloud& points) const {
  if (!colors_) return;
  const std::size_t written_bytes = written_.attribute_bytes();
  // Copies, which bytes that are written cannot change: the compiler keeps them in registers.
  const WideColors colors = *colors_;
  const std::array<std::size_t, 3> places = written_offsets_;
  const Runs runs = runs_;
  const std::size_t read_bytes = read_bytes_;
  const bool scales = scales_;
  const std::byte* from = points.attributes.data();
  std::byte* to = points.attributes.data();
  const std::byte* const end = from + points.size() * read_bytes;
  // Rows and their parts only move towards the front: what is still to be read lies behind.
  for (; from != end; from += read_bytes, to += written_bytes) {
    std::array<std::uint8_t, 3> narrow;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint16_t value = channel(from + colors.offsets[c]);
      narrow[c] = scales ? narrowed(value) : static_cast<std::uint8_t>(value);
    }
    for (std::size_t r = 0; r < runs.count; ++r)
      move_bytes(to + runs.at[r].to, from + runs.at[r].from, runs.at[r].bytes);
    for (std::size_t c = 0; c < 3; ++c) to[places[c]] = std::byte{narrow[c]};
  }
  points.attributes.resize(points.size() * written_bytes);
  points.schema.attributes = written_.attributes;
}

}  // namespace orbweave
