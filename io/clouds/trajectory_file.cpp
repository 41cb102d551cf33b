#include "io/clouds/trajectory_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/streams/byte_source.h"
#include "io/streams/stoppable.h"
#include "io/text/column_name.h"
#include "io/text/counted_noun.h"
#include "io/text/file_format.h"
#include "io/text/lower_case.h"
#include "io/text/text_fields.h"

namespace orbweave {
namespace {

/// Places in the order of the file, evenly thinned to as many as are kept.
class KeptPlaces {
 public:
  void add(const Trajectory::Place& place) {
    if (!first_ || place.time < first_->time) first_ = place;
    if (!last_ || place.time > last_->time) last_ = place;
    if (read_++ % stride_ != 0) return;
    places_.push_back(place);
    if (places_.size() < kMostTrajectoryPlaces) return;
    for (std::size_t i = 0; 2 * i < places_.size(); ++i) places_[i] = places_[2 * i];
    places_.resize((places_.size() + 1) / 2);
    stride_ *= 2;
  }

  Trajectory trajectory(const std::string& file) && {
    if (read_ == 0 || !(first_->time < last_->time))
      throw_bad_input("the trajectory has fewer than two places",
                      {.file = file,
                       .found = counted_noun(read_, "place", "places"),
                       .expected = "lines of time, x, y and z, at two times or more"});
    places_.push_back(*first_);
    places_.push_back(*last_);
    Box bounds;
    for (const Trajectory::Place& place : places_) bounds.extend(place.position);
    if (!std::isfinite(last_->time - first_->time) || !std::isfinite(norm(bounds.max - bounds.min)))
      throw_bad_input("the numbers of the trajectory are too large",
                      {.file = file, .expected = "seconds, and coordinates of the scans"});
    return Trajectory(std::move(places_));
  }

 private:
  std::vector<Trajectory::Place> places_;
  std::optional<Trajectory::Place> first_, last_;  // by time
  std::uint64_t read_ = 0;
  std::uint64_t stride_ = 1;
};

/// Where time, x, y and z are in a line.
using PlaceColumns = std::array<std::size_t, 4>;
constexpr PlaceColumns kFirstFour = {0, 1, 2, 3};
constexpr std::array<const char*, 4> kQuantities = {"time", "x", "y", "z"};

/// Letters and digits of a name in lower case, without the unit behind it.
std::string plain_name(std::string_view name) {
  std::string plain = lower_case(std::string(without_unit(name)));
  std::erase_if(plain, [](char c) { return !(c >= 'a' && c <= 'z') && !(c >= '0' && c <= '9'); });
  return plain;
}

/// Which of time, x, y and z a name stands for.
std::optional<std::size_t> quantity_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::size_t>, 34> kNames = {
      {{"time", 0},    {"timestamp", 0}, {"gpstime", 0},   {"gpsseconds", 0}, {"gpssec", 0},
       {"seconds", 0}, {"secs", 0},      {"sec", 0},       {"t", 0},          {"x", 1},
       {"tx", 1},      {"px", 1},        {"posx", 1},      {"positionx", 1},  {"easting", 1},
       {"east", 1},    {"e", 1},         {"y", 2},         {"ty", 2},         {"py", 2},
       {"posy", 2},    {"positiony", 2}, {"northing", 2},  {"north", 2},      {"n", 2},
       {"z", 3},       {"tz", 3},        {"pz", 3},        {"posz", 3},       {"positionz", 3},
       {"height", 3},  {"altitude", 3},  {"elevation", 3}, {"elev", 3}}};
  const std::string plain = plain_name(name);
  for (const auto& [known, quantity] : kNames)
    if (plain == known) return quantity;
  return std::nullopt;
}

/// The lines of a trajectory as text.
class TrajectoryText {
 public:
  explicit TrajectoryText(ByteReader reader) : reader_(std::move(reader)) {}

  Trajectory read() {
    skip_byte_order_mark(reader_);
    KeptPlaces places;
    std::string_view line;
    while (reader_.next_line(line)) {
      line = trimmed(line);
      if (line.empty()) continue;
      if (const std::size_t mark = comment_mark(line); mark > 0) {
        if (!has_places_) look_for_names(line.substr(mark));
      } else if (!begins_with_number(line) && (!has_places_ || line == names_)) {
        look_for_names(line);  // files that were put together have it again
      } else {
        places.add(place_of(line));
        has_places_ = true;
      }
    }
    return std::move(places).trajectory(reader_.name());
  }

 private:
  /// Length of what makes the line a comment; 0: it is none.
  static std::size_t comment_mark(std::string_view line) {
    if (line[0] == '#' || line[0] == '%') return 1;
    return line.starts_with("//") ? 2 : 0;
  }

  static bool begins_with_number(std::string_view line) {
    const auto field = take_field(line, find_separator(line));
    double ignored = 0.0;
    return field && to_number(*field, ignored);
  }

  /// Takes the places of columns from a line of names, where it is one.
  void look_for_names(std::string_view line) {
    std::array<std::optional<std::size_t>, 4> found;
    bool is_geographic = false;
    const std::vector<std::string_view> names = fields_of(line, find_separator(line));
    for (std::size_t column = 0; column < names.size(); ++column) {
      const std::string plain = plain_name(names[column]);
      is_geographic |= plain == "lat" || plain == "latitude" || plain == "lon" || plain == "long" ||
                       plain == "longitude";
      const std::optional<std::size_t> quantity = quantity_of(names[column]);
      if (quantity && !found[*quantity]) found[*quantity] = column;
    }
    if (found[0] && is_geographic && !(found[1] && found[2]))
      throw_bad_input("the trajectory is in degrees of longitude and latitude",
                      {.file = reader_.name(),
                       .place = reader_.line_place(),
                       .found = excerpt(line),
                       .expected = "x, y and z in the coordinate system of the scans",
                       .advice = "Export it in that system."});
    if (!std::ranges::all_of(found, [](const auto& column) { return column.has_value(); })) return;
    for (std::size_t i = 0; i < found.size(); ++i) columns_[i] = *found[i];
    names_ = line;
  }

  Trajectory::Place place_of(std::string_view line) {
    if (!has_places_) separator_ = find_separator(line);
    const std::vector<std::string_view> fields = fields_of(line, separator_);
    std::array<double, 4> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (columns_[i] >= fields.size()) refuse(columns_[i], i, "the end of the line");
      const std::string_view field = fields[columns_[i]];
      if (!to_number(field, values[i]) || !std::isfinite(values[i]))
        refuse(columns_[i], i, excerpt(field));
    }
    return {values[0], {values[1], values[2], values[3]}};
  }

  [[noreturn]] void refuse(std::size_t column, std::size_t quantity,
                           const std::string& found) const {
    throw_bad_input("this is no place of a trajectory",
                    {.file = reader_.name(),
                     .place = reader_.line_place() + ", column " + std::to_string(column + 1),
                     .found = found,
                     .expected = std::string("a number, the ") + kQuantities[quantity],
                     .advice = "A header line may name the columns time, x, y and z."});
  }

  ByteReader reader_;
  PlaceColumns columns_ = kFirstFour;
  std::string names_;  // the line that they are from
  char separator_ = ' ';
  bool has_places_ = false;
};

/// Points, each with a time.
Trajectory read_points(PointSource& source, const std::string& file) {
  const std::optional<NamedAttribute> time = find_time(source.schema());
  if (!time)
    throw_bad_input("the points of the trajectory have no time",
                    {.file = file, .expected = "an attribute gps_time, time or timestamp"});
  constexpr std::size_t kBatchPoints = std::size_t{1} << 16;
  KeptPlaces places;
  for (PointCloud batch; source.read(batch, kBatchPoints);) {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const double at = (*time)(batch.attribute_row(i));
      if (std::isfinite(at) && is_finite(batch.positions[i])) places.add({at, batch.positions[i]});
    }
  }
  return std::move(places).trajectory(file);
}

bool holds_points(const std::filesystem::path& path) {
  const std::optional<NamedFormat> named = format_of_name(path);
  if (!named) return false;
  const FileFormat format = named->facts.format;
  return format == FileFormat::kLas || format == FileFormat::kLaz || format == FileFormat::kPly ||
         format == FileFormat::kPcd || format == FileFormat::kE57;
}

}  // namespace

Trajectory read_trajectory(const std::filesystem::path& path, const StopToken* stop) {
  if (holds_points(path))
    return read_points(*open_point_source(path, {.text = {}, .stop = stop}), path.string());
  return read_trajectory_text(ByteReader(stoppable(open_byte_source(path), stop)));
}

Trajectory read_trajectory_text(ByteReader reader) {
  return TrajectoryText(std::move(reader)).read();
}

}  // namespace orbweave
