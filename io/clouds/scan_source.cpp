#include "io/clouds/scan_source.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "io/clouds/scan_selection.h"
#include "io/clouds/trajectory.h"
#include "io/points/named_attribute.h"
#include "io/points/no_data.h"
#include "io/points/point_views.h"
#include "io/stop_token.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Box kEverywhere{{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};

/// The source's schema; where attributes only filter, it leaves those out that do not.
const PointSchema& schema_to_filter(PointSource& source, const ScanOptions& options) {
  if (options.without_attributes)
    source.skip_attributes([&](const std::string& name) {
      return filters_by(name) || (options.trajectory != nullptr && names_time(name)) ||
             (!options.scanners.empty() &&
              have_same_name(name, options.scanners.front().attribute));
    });
  return source.schema();
}

class ScanSource final : public PointSource {
 public:
  ScanSource(std::unique_ptr<PointSource> source, const ScanOptions& options,
             const std::string& file)
      : source_(std::move(source)),
        options_(options),
        schema_(schema_to_filter(*source_, options)),
        selection_(options, schema_, file) {
    if (!options.scanners.empty() && options.with_view)
      scan_ =
          required_attribute(schema_, options.scanners.front().attribute, "input.scanners", file);
    if (options.trajectory != nullptr && options.with_view) time_ = required_time(schema_, file);
    moves_ = options.motion != RigidMotion{};
    if (moves_) schema_.position_type = ScalarType::kFloat64;
    if (options.without_normals) schema_.has_normals = false;
    if (options.without_attributes) schema_.attributes.clear();
    if (options.with_view)
      schema_.attributes.insert(schema_.attributes.end(), view_fields().begin(),
                                view_fields().end());
    if (options.crop || options.area)
      source_->skip_parts([this](const Box& part) { return selection_.refuses(in_world(part)); });
  }

  const PointSchema& schema() const override { return schema_; }
  std::optional<std::uint64_t> declared_points() const override {
    return source_->declared_points();
  }
  bool keeps_declared_points() const override {
    return selection_.takes_all() && source_->keeps_declared_points();
  }
  bool restrict_rows(std::uint64_t first, std::uint64_t count) override {
    return source_->restrict_rows(first, count);
  }
  std::uint64_t bytes_read() const override { return source_->bytes_read(); }
  std::uint64_t bytes_total() const override { return source_->bytes_total(); }
  std::string coordinate_system() const override { return source_->coordinate_system(); }
  FileFacts facts() const override {
    FileFacts facts = source_->facts();
    if (options_.without_attributes) facts.lost_values.clear();  // they are not wanted
    facts.has_unused_normals = options_.would_take_normals && source_->schema().has_normals;
    return facts;
  }
  std::optional<Vec3> meters_per_unit() const override { return source_->meters_per_unit(); }

  std::optional<ScannerPlace> scanner() const override {
    std::optional<ScannerPlace> place = options_.scanner;
    if (!place) place = source_->scanner();
    if (!place) place = options_.usual_scanner;
    if (!place || !options_.scanners.empty() || options_.trajectory) return std::nullopt;
    return moved(*place);
  }

  ScanNumber scan() const override { return source_->scan(); }

  DroppedPoints left_out() const override {
    DroppedPoints all = source_->left_out();
    for (const auto& [reason, count] : selection_.removed()) all[reason] += count;
    return all;
  }

  bool read(PointCloud& batch, std::size_t capacity) override {
    do {
      check_stop(options_.stop);
      if (!source_->read(batch, capacity)) {
        batch.schema = schema_;
        return false;
      }
      if (moves_) move(batch);
      if (!selection_.takes_all()) selection_.apply(batch);
    } while (batch.empty());
    if (options_.with_view) find_scanners(batch);
    if (options_.without_normals) batch.normals.clear();
    if (options_.without_attributes) {
      batch.attributes.clear();
      batch.schema.attributes.clear();
    }
    if (options_.with_view) add_view(batch);
    batch.schema = schema_;
    return true;
  }

 private:
  /// A box in world coordinates around a box in the scan's own, with room for rounding. Some
  /// writers give the largest numbers there are as bounds of a scan that they have not measured.
  Box in_world(const Box& own) const {
    if (!moves_) return own;
    if (!is_finite(own.min) || !is_finite(own.max)) return kEverywhere;
    Box world;
    for (int corner = 0; corner < 8; ++corner)
      world.extend(options_.motion.point({corner & 1 ? own.max.x : own.min.x,
                                          corner & 2 ? own.max.y : own.min.y,
                                          corner & 4 ? own.max.z : own.min.z}));
    constexpr double kRounding = 1e-12;
    const auto largest = [](Vec3 p) {
      return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    };
    return world.grown(kRounding * std::max({largest(world.min), largest(world.max),
                                             largest(own.min), largest(own.max)}));
  }

  void move(PointCloud& batch) const {
    for (Vec3& p : batch.positions)
      if (!holds_no_data_value(p)) p = options_.motion.point(p);
    for (Vec3& n : batch.normals) n = options_.motion.direction(n);
  }

  /// To world coordinates.
  ScannerPlace moved(const ScannerPlace& place) const {
    return {place.is_direction ? options_.motion.direction(place.vector)
                               : options_.motion.point(place.vector),
            place.is_direction};
  }

  /// The place of each point's scanner, while the batch has its attributes.
  void find_scanners(const PointCloud& batch) {
    places_.assign(batch.size(), scanner());
    if (options_.trajectory) return follow_trajectory(batch);
    if (options_.scanners.empty()) return;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const double value = scan_(batch.attribute_row(i));
      const auto known = std::ranges::find(options_.scanners, value, &ScannerOfValue::value);
      if (known != options_.scanners.end()) places_[i] = moved(known->place);
    }
  }

  void follow_trajectory(const PointCloud& batch) {
    for (std::size_t i = 0; i < batch.size(); ++i)
      if (const auto place = options_.trajectory->at(time_(batch.attribute_row(i))))
        places_[i] = ScannerPlace{*place, false};
  }

  void add_view(PointCloud& batch) {
    views_.assign(batch.size(), {});
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const std::optional<ScannerPlace>& place = places_[i];
      if (place && is_finite(batch.positions[i]))
        views_[i] =
            encode_view(place->is_direction ? place->vector : place->vector - batch.positions[i]);
    }
    add_views(views_, batch);
  }

  std::unique_ptr<PointSource> source_;
  ScanOptions options_;
  PointSchema schema_;
  ScanSelection selection_;
  NamedAttribute scan_;  ///< that tells the scanner
  NamedAttribute time_;  ///< that tells where the scanner was
  bool moves_ = false;
  std::vector<std::optional<ScannerPlace>> places_;  ///< of the scanners of the batch's points
  std::vector<ViewCode> views_;                      ///< of the batch's points
};

}  // namespace

ScannerOfValue parse_scanner_of_value(std::string_view text) {
  const std::vector<std::string_view> words = words_of(text);
  if (words.size() != 4 && words.size() != 5)
    throw std::invalid_argument("it has " + std::to_string(words.size()) + " words");
  const std::size_t equals = words[0].find('=');
  if (equals == std::string_view::npos || equals == 0)
    throw std::invalid_argument("\"" + std::string(words[0]) + "\" is not ATTRIBUTE=VALUE");
  ScannerOfValue scanner;
  scanner.attribute = std::string(words[0].substr(0, equals));
  scanner.value = finite_number(words[0].substr(equals + 1));
  scanner.place.vector = {finite_number(words[1]), finite_number(words[2]),
                          finite_number(words[3])};
  scanner.place.is_direction = words.size() == 5;
  if (scanner.place.is_direction && finite_number(words[4]) != 0.0)
    throw std::invalid_argument("the fifth word of a direction is 0");
  if (scanner.place.is_direction && squared_norm(scanner.place.vector) == 0.0)
    throw std::invalid_argument("a direction has a length");
  return scanner;
}

std::unique_ptr<PointSource> open_scan_source(std::unique_ptr<PointSource> source,
                                              const ScanOptions& options, const std::string& file) {
  return std::make_unique<ScanSource>(std::move(source), options, file);
}

}  // namespace orbweave
