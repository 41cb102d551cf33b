#include "io/clouds/e57/e57_columns.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "io/error.h"
#include "io/points/no_data.h"
#include "io/scalar_types.h"
#include "io/text/counted_noun.h"

namespace orbweave {
namespace {

/// Records decoded at a time: their columns fit the cache.
constexpr std::uint64_t kBlockRecords = 2048;

/// Drops the values of records that are not kept.
template <class T>
void compact(const std::vector<std::uint32_t>& kept, std::vector<T>& column) {
  for (std::size_t i = 0; i < kept.size(); ++i) column[i] = column[kept[i]];
}

/// The nearest value of T; zero for "not a number" where T is an integer.
template <class T>
T nearest(double value) {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value);
  } else {
    using Limits = std::numeric_limits<T>;
    if (std::isnan(value)) return 0;
    const double rounded = std::nearbyint(value);
    if (rounded <= static_cast<double>(Limits::min())) return Limits::min();
    if (rounded >= static_cast<double>(Limits::max())) return Limits::max();
    return static_cast<T>(rounded);
  }
}

template <class T>
T nearest(std::int64_t value) {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value);
  } else {
    if (std::in_range<T>(value)) return static_cast<T>(value);
    return value < 0 ? std::numeric_limits<T>::min() : std::numeric_limits<T>::max();
  }
}

/// One attribute of `values.size()` rows of `row_bytes`; `place` is the first one's.
template <class T, class Value>
void store_as(std::span<const Value> values, std::span<std::byte> rows, std::size_t place,
              std::size_t row_bytes) {
  for (const Value value : values) {
    const T stored = nearest<T>(value);
    std::memcpy(rows.data() + place, &stored, sizeof stored);
    place += row_bytes;
  }
}

template <class Value>
void store(ScalarType type, std::span<const Value> values, std::span<std::byte> rows,
           std::size_t place, std::size_t row_bytes) {
  visit_scalar(type, [&](auto kind) { store_as<decltype(kind)>(values, rows, place, row_bytes); });
}

/// ASTM E2807: azimuth about z from x, elevation from the x-y plane; radians.
Vec3 from_spherical(double range, double azimuth, double elevation) {
  const double level = range * std::cos(elevation);
  return {level * std::cos(azimuth), level * std::sin(azimuth), range * std::sin(elevation)};
}

}  // namespace

E57ScanReader::E57ScanReader(E57Pages& pages, const E57Scan& scan, const E57ScanLayout& layout,
                             const PointSchema& schema)
    : scan_(scan),
      layout_(layout),
      schema_(schema),
      pages_(pages),
      section_(read_e57_section(pages, scan)),
      packets_(pages, section_, scan.fields.size()) {
  if (layout.invalid_state) add_stream(*layout.invalid_state);
  for (const std::size_t field : layout.position) add_stream(field);
  if (schema.has_normals)
    for (const std::size_t field : layout.normal) add_stream(field);
  for (const E57Attribute& attribute : layout.attributes)
    if (attribute.field) add_stream(*attribute.field);
  integers_.resize(kBlockRecords);
  for (std::vector<double>& column : reals_) column.resize(kBlockRecords);
}

void E57ScanReader::add_stream(std::size_t field) {
  streams_.emplace_back(scan_.fields[field], field, section_.data);
}

std::uint64_t E57ScanReader::bytes_read() const {
  std::uint64_t position = section_.begin;
  for (const E57FieldStream& stream : streams_) position = std::max(position, stream.position());
  return position - section_.begin;
}

bool E57ScanReader::read(PointCloud& batch, std::uint64_t records) {
  while (records != 0 && records_done_ < scan_.records) {
    const std::size_t count = next_block(records);
    next_stream_ = 0;
    find_kept(count);
    append_positions(batch, count);
    if (schema_.has_normals) append_normals(batch, count);
    append_attributes(batch, count);
    records_done_ += count;
    records -= count;
    if (records_done_ == scan_.records) check_end();
  }
  return records_done_ < scan_.records;
}

/// How many records all streams have at hand, at least one.
std::size_t E57ScanReader::next_block(std::uint64_t records) {
  std::uint64_t count = std::min({records, scan_.records - records_done_, kBlockRecords});
  for (E57FieldStream& stream : streams_) count = std::min(count, stream.fill(packets_));
  if (count == 0)
    throw_bad_input(scan_.label + " ends too early", {.file = pages_.name(),
                                                      .place = pages_.place(section_.begin),
                                                      .found = counted_points(records_done_),
                                                      .expected = std::to_string(scan_.records)});
  return static_cast<std::size_t>(count);
}

void E57ScanReader::find_kept(std::size_t count) {
  all_kept_ = true;
  if (!layout_.invalid_state) return;
  streams_[next_stream_++].decode(std::span(integers_).first(count));
  const auto states = std::span(integers_).first(count);
  all_kept_ = std::all_of(states.begin(), states.end(), [](std::int64_t s) { return s == 0; });
  if (all_kept_) return;
  kept_.clear();
  for (std::size_t i = 0; i < count; ++i)
    if (states[i] == 0) kept_.push_back(static_cast<std::uint32_t>(i));
  left_out_ += count - kept_.size();
}

/// Decodes the next stream's values of a block; what is not kept is dropped.
template <class T>
std::span<T> E57ScanReader::decode(std::size_t count, std::vector<T>& column) {
  streams_[next_stream_++].decode(std::span(column).first(count));
  if (all_kept_) return std::span(column).first(count);
  compact(kept_, column);
  return std::span(column).first(kept_.size());
}

void E57ScanReader::append_positions(PointCloud& batch, std::size_t count) {
  const std::span<double> a = decode(count, reals_[0]);
  const std::span<double> b = decode(count, reals_[1]);
  const std::span<double> c = decode(count, reals_[2]);
  const std::size_t begin = batch.positions.size();
  batch.positions.resize(begin + a.size());
  Vec3* const positions = batch.positions.data() + begin;
  for (std::size_t i = 0; i < a.size(); ++i) {
    positions[i] = {a[i], b[i], c[i]};
    if (holds_no_data_value(positions[i])) continue;
    if (layout_.is_spherical) positions[i] = from_spherical(a[i], b[i], c[i]);
    if (scan_.is_moved()) positions[i] = scan_.pose->point(positions[i]);
  }
}

void E57ScanReader::append_normals(PointCloud& batch, std::size_t count) {
  const std::span<double> x = decode(count, reals_[0]);
  const std::span<double> y = decode(count, reals_[1]);
  const std::span<double> z = decode(count, reals_[2]);
  const bool is_moved = scan_.is_moved();
  const bool is_float = schema_.normal_type == ScalarType::kFloat32;
  const auto rounded = [&](double v) { return is_float ? static_cast<float>(v) : v; };
  for (std::size_t i = 0; i < x.size(); ++i) {
    Vec3 normal = {x[i], y[i], z[i]};
    if (is_moved) {
      normal = scan_.pose->direction(normal);
      normal = {rounded(normal.x), rounded(normal.y), rounded(normal.z)};
    }
    batch.normals.push_back(normal);
  }
}

void E57ScanReader::append_attributes(PointCloud& batch, std::size_t count) {
  const std::size_t row_bytes = schema_.attribute_bytes();
  const std::size_t points = all_kept_ ? count : kept_.size();
  std::size_t place = batch.attributes.size();
  batch.attributes.resize(place + points * row_bytes);
  const std::span<std::byte> rows = batch.attributes;
  for (const E57Attribute& attribute : layout_.attributes) {
    if (!attribute.field) {
      place += size_of(attribute.type);  // 0, as the rows are made
      continue;
    }
    if (attribute.is_plain() && scan_.fields[*attribute.field].kind == E57Kind::kInteger) {
      const std::span<const std::int64_t> values = decode(count, integers_);
      store(attribute.type, values, rows, place, row_bytes);
    } else {
      const std::span<double> values = decode(count, reals_[0]);
      for (double& v : values) v = (v - attribute.from) * attribute.scale + attribute.to;
      store(attribute.type, std::span<const double>(values), rows, place, row_bytes);
    }
    place += size_of(attribute.type);
  }
}

void E57ScanReader::check_end() {
  for (E57FieldStream& stream : streams_)
    if (stream.has_surplus(packets_))
      throw_bad_input(scan_.label + " goes on after its last point",
                      {.file = pages_.name(),
                       .place = pages_.place(section_.begin),
                       .found = "more than " + counted_points(scan_.records),
                       .expected = "as many as its recordCount says"});
}

}  // namespace orbweave
