// Which points of a scan are wanted: by class, by return, by place, and one in so many. A function
// of a point's own values: the only one, for every pass over points.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "io/clouds/scan_source.h"
#include "io/points/named_attribute.h"
#include "io/points/point_classes.h"

namespace orbweave {

/// The attribute that a key of the job goes by. Throws Error (bad input) where the schema lacks it.
NamedAttribute required_attribute(const PointSchema& schema, const std::string& name,
                                  const std::string& wanted_by, const std::string& file);

/// The attribute that tells when a point was measured. Throws Error (bad input) where there is
/// none.
NamedAttribute required_time(const PointSchema& schema, const std::string& file);

/// Whether points may be selected by an attribute of that name.
bool filters_by(const std::string& name);

class ScanSelection {
 public:
  /// Attributes may have any type and be written in any case, with or without '_'. Throws Error
  /// (bad input) where `classes` or `returns` ask for one that the schema lacks; `file` is for
  /// messages. `dropped_classes` ask for nothing: where there are no classes, none is left out.
  ScanSelection(const ScanOptions& options, const PointSchema& schema, const std::string& file);

  /// Every point is wanted.
  bool takes_all() const {
    return !by_place_ && !by_class_ && !by_return_ && !trajectory_ && every_ == 1;
  }
  /// Removes what is not wanted of a batch of the schema, in world coordinates, and counts it;
  /// keeps the order of the rest.
  void apply(PointCloud& batch);
  /// Whether no point in a box can be wanted, of its place alone. World coordinates.
  bool refuses(const Box& box) const;
  /// What apply() has removed so far, by reason.
  DroppedPoints removed() const;

 private:
  /// 0: wanted; else why not, as an index of removed_.
  using Objection = std::size_t;
  enum : Objection {
    kWanted = 0,
    kFirstClass = 1,
    kNoClass = kFirstClass + kPointClasses,
    kWrongReturn,
    kOutside,
    kNotChosen,
    kNotCovered,
    kObjections
  };

  bool is_inside(Vec3 p) const;
  Objection objection(Vec3 p, std::span<const std::byte> row) const;
  Objection objection_to_class(std::span<const std::byte> row) const;
  bool has_wanted_return(std::span<const std::byte> row) const;
  std::string reason(Objection objection) const;

  std::optional<Box> crop_;
  std::shared_ptr<const PolygonArea> area_;
  ReturnFilter returns_ = ReturnFilter::kAll;
  std::uint64_t every_ = 1;
  bool by_place_ = false;
  bool by_class_ = false;
  bool by_return_ = false;
  bool names_classes_ = false;  ///< those wanted, and not those dropped
  std::shared_ptr<const Trajectory> trajectory_;
  NamedAttribute class_, number_, count_, time_;
  std::array<bool, kPointClasses> leaves_out_{};  ///< by class
  std::array<std::uint64_t, kObjections> removed_{};
};

}  // namespace orbweave
