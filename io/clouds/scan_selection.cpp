#include "io/clouds/scan_selection.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "io/clouds/trajectory.h"
#include "io/error.h"
#include "io/points/polygon_area.h"

namespace orbweave {
namespace {

/// Mixes the bits of the coordinates; -0 counts as 0. Other than the hashes that samples of points
/// are chosen by, so that samples of what is kept are as good as samples of all.
/// Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, 2014, mix64variant13.
std::uint64_t hash_of(Vec3 p) {
  std::uint64_t hash = 0x6f7262776561u;
  for (int axis = 0; axis < 3; ++axis) {
    hash ^= std::bit_cast<std::uint64_t>(p[axis] + 0.0);
    hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9u;
    hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebu;
    hash ^= hash >> 31;
  }
  return hash;
}

/// One in `every` hashes; those of one in 20 are among those of one in 10.
bool is_chosen(Vec3 p, std::uint64_t every) {
  return hash_of(p) <= std::numeric_limits<std::uint64_t>::max() / every;
}

constexpr const char* kClass = "classification";
constexpr const char* kReturnNumber = "return_number";
constexpr const char* kReturns = "number_of_returns";

/// `bytes`: of a row of attributes.
void move_point(PointCloud& points, std::size_t bytes, std::size_t from, std::size_t to) {
  points.positions[to] = points.positions[from];
  if (!points.normals.empty()) points.normals[to] = points.normals[from];
  std::byte* const rows = points.attributes.data();
  if (bytes != 0) std::memcpy(rows + to * bytes, rows + from * bytes, bytes);
}

void shrink(PointCloud& points, std::size_t count) {
  points.positions.resize(count);
  if (!points.normals.empty()) points.normals.resize(count);
  points.attributes.resize(count * points.schema.attribute_bytes());
}

}  // namespace

bool filters_by(const std::string& name) {
  return std::ranges::any_of(std::array{kClass, kReturnNumber, kReturns},
                             [&](const char* known) { return have_same_name(name, known); });
}

NamedAttribute required_attribute(const PointSchema& schema, const std::string& name,
                                  const std::string& wanted_by, const std::string& file) {
  if (const auto attribute = find_attribute(schema, name)) return *attribute;
  throw_bad_input("the points have no " + name,
                  {.file = file,
                   .expected = "the attribute that " + wanted_by + " asks for",
                   .advice = "Leave that key out, or the file."});
}

NamedAttribute required_time(const PointSchema& schema, const std::string& file) {
  if (const auto time = find_time(schema)) return *time;
  throw_bad_input("the points have no time",
                  {.file = file,
                   .expected = "the attribute gps_time, time or timestamp, by which "
                               "input.trajectory tells where the scanner was",
                   .advice = "Leave that key out, or the file."});
}

ScanSelection::ScanSelection(const ScanOptions& options, const PointSchema& schema,
                             const std::string& file)
    : crop_(options.crop),
      area_(options.area),
      returns_(options.returns),
      every_(options.every),
      by_place_(crop_ || area_ != nullptr),
      by_return_(returns_ != ReturnFilter::kAll),
      names_classes_(!options.classes.empty()) {
  if (names_classes_) {
    class_ = required_attribute(schema, kClass, "input.las_classes", file);
    leaves_out_.fill(true);
    for (const int wanted : options.classes) leaves_out_[static_cast<std::size_t>(wanted)] = false;
    by_class_ = true;
  } else if (const auto known = find_attribute(schema, kClass)) {
    class_ = *known;
    for (const int dropped : options.dropped_classes)
      leaves_out_[static_cast<std::size_t>(dropped)] = true;
    by_class_ = !options.dropped_classes.empty();
  }
  if (options.with_view && options.trajectory) {
    trajectory_ = options.trajectory;
    time_ = required_time(schema, file);
  }
  if (!by_return_) return;
  number_ = required_attribute(schema, kReturnNumber, "input.returns", file);
  count_ = required_attribute(schema, kReturns, "input.returns", file);
}

bool ScanSelection::is_inside(Vec3 p) const {
  if (crop_ && !crop_->contains(p)) return false;
  return area_ == nullptr || area_->contains(p.x, p.y);
}

ScanSelection::Objection ScanSelection::objection_to_class(std::span<const std::byte> row) const {
  std::size_t number = 0;
  if (class_.type() == ScalarType::kUint8) {
    number = std::to_integer<std::size_t>(row[class_.offset()]);
  } else {
    const double value = class_(row);
    if (!(value >= 0.0 && value < static_cast<double>(kPointClasses)))
      return names_classes_ ? kNoClass : kWanted;
    number = static_cast<std::size_t>(value);
  }
  return leaves_out_[number] ? kFirstClass + number : kWanted;
}

bool ScanSelection::has_wanted_return(std::span<const std::byte> row) const {
  switch (returns_) {
    case ReturnFilter::kAll:
      return true;
    case ReturnFilter::kFirst:
      return number_(row) <= 1;
    case ReturnFilter::kLast:
      return number_(row) >= count_(row);
    case ReturnFilter::kOnly:
      return count_(row) <= 1;
  }
  return true;
}

/// The place comes first: it is all that is known of parts of files that are not read. What has no
/// place at all is left to those who know what it is.
ScanSelection::Objection ScanSelection::objection(Vec3 p, std::span<const std::byte> row) const {
  if (by_place_ && !is_inside(p) && is_finite(p)) return kOutside;
  if (by_class_)
    if (const Objection to_class = objection_to_class(row); to_class != kWanted) return to_class;
  if (by_return_ && !has_wanted_return(row)) return kWrongReturn;
  if (trajectory_ && !trajectory_->at(time_(row))) return kNotCovered;
  return every_ == 1 || is_chosen(p, every_) ? kWanted : kNotChosen;
}

void ScanSelection::apply(PointCloud& batch) {
  const std::size_t bytes = batch.schema.attribute_bytes();
  const std::span<const std::byte> rows = batch.attributes;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const Objection why = objection(batch.positions[i], rows.subspan(i * bytes, bytes));
    if (why != kWanted) {
      ++removed_[why];
      continue;
    }
    if (kept != i) move_point(batch, bytes, i, kept);
    ++kept;
  }
  if (kept != batch.size()) shrink(batch, kept);
}

bool ScanSelection::refuses(const Box& box) const {
  if (crop_ && !crop_->intersects(box)) return true;
  return area_ != nullptr && !area_->bounds().intersects(box);
}

std::string ScanSelection::reason(Objection objection) const {
  if (objection == kOutside) return kOutsideCrop;
  if (objection == kNoClass) return "no class from 0 to 255";
  if (objection == kNotChosen) return "not the one in " + std::to_string(every_);
  if (objection == kNotCovered) return kOutsideTrajectory;
  if (objection == kWrongReturn) {
    const char* const wanted = returns_ == ReturnFilter::kFirst  ? "a first"
                               : returns_ == ReturnFilter::kLast ? "a last"
                                                                 : "an only";
    return std::string("not ") + wanted + " return";
  }
  const auto number = static_cast<int>(objection - kFirstClass);
  return names_classes_ ? name_of_class(number) + " not selected" : text_of_dropped_class(number);
}

DroppedPoints ScanSelection::removed() const {
  DroppedPoints removed;
  for (Objection i = kFirstClass; i < kObjections; ++i)
    if (removed_[i] != 0) removed[reason(i)] += removed_[i];
  return removed;
}

}  // namespace orbweave
