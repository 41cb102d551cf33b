#include "io/clouds/point_source_list.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <system_error>
#include <type_traits>
#include <utility>

#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/points/color_depth.h"
#include "io/points/coordinate_system.h"
#include "io/points/coordinate_system_file.h"
#include "io/points/point_views.h"

namespace orbweave {
namespace {

/// What a file of the list was found to be.
struct ListedFile {
  std::filesystem::path path;
  PointSchema schema;
  std::uint64_t bytes = 0;
  std::uint64_t points = 0;  ///< declared
  bool has_unused_normals = false;
};

/// A value of a row on its way into a row of the common schema.
struct CopiedValue {
  std::size_t from = 0;  ///< bytes from the front of the file's row
  std::size_t to = 0;    ///< of the common row
  std::size_t bytes = 0;
  ScalarType from_type = ScalarType::kUint8;
  ScalarType to_type = ScalarType::kUint8;
  bool scales_color = false;  ///< from 8 to 16 bits

  bool is_plain() const { return from_type == to_type; }
};

const AttributeField* field_of_name(const PointSchema& schema, const std::string& name) {
  const auto at = std::ranges::find(schema.attributes, name, &AttributeField::name);
  return at == schema.attributes.end() ? nullptr : &*at;
}

std::size_t offset_of(const PointSchema& schema, const std::string& name) {
  std::size_t offset = 0;
  for (const AttributeField& field : schema.attributes) {
    if (field.name == name) break;
    offset += size_of(field.type);
  }
  return offset;
}

/// How the rows of a file become rows of the common schema; neighbours that stay neighbours are
/// copied at once. What a file lacks is not named.
std::vector<CopiedValue> copied_values(const PointSchema& from, const PointSchema& common) {
  std::vector<CopiedValue> values;
  std::size_t to = 0;
  for (const AttributeField& field : common.attributes) {
    const AttributeField* const own = field_of_name(from, field.name);
    if (own != nullptr) {
      const CopiedValue value{offset_of(from, field.name), to, size_of(field.type), own->type,
                              field.type};
      CopiedValue* const last = values.empty() ? nullptr : &values.back();
      const bool joins = last != nullptr && last->is_plain() && value.is_plain() &&
                         last->from + last->bytes == value.from && last->to + last->bytes == to;
      if (joins)
        last->bytes += value.bytes;
      else
        values.push_back(value);
    }
    to += size_of(field.type);
  }
  return values;
}

/// Of a file with 8-bit colours beside files whose colours fill 16 bits.
void scale_colors(std::vector<CopiedValue>& values, const WideColors& colors) {
  for (CopiedValue& value : values)
    if (std::ranges::find(colors.offsets, value.to) != std::end(colors.offsets))
      value.scales_color = true;
}

/// Doubles hold the numbers of all types but the 64-bit integers.
template <class T>
auto exactly(T number) {
  if constexpr (std::is_integral_v<T> && sizeof(T) == 8)
    return number;
  else
    return static_cast<double>(number);
}

/// The common type holds every value of the file's type, but 64-bit integers beyond 2^53 where one
/// file has an integer and another a fraction.
void convert_value(const CopiedValue& value, const std::byte* from, std::byte* to) {
  if (value.scales_color) {
    const std::uint16_t color = widened_color(std::to_integer<std::uint8_t>(*from));
    std::memcpy(to, &color, sizeof color);
    return;
  }
  visit_scalar(value.from_type, [&](auto source) {
    std::memcpy(&source, from, sizeof source);
    const auto exact = exactly(source);
    visit_scalar(value.to_type, [&](auto target) {
      target = static_cast<decltype(target)>(exact);
      std::memcpy(to, &target, sizeof target);
    });
  });
}

bool is_float(ScalarType type) {
  return type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
}
bool is_signed(ScalarType type) {
  return type == ScalarType::kInt8 || type == ScalarType::kInt16 || type == ScalarType::kInt32 ||
         type == ScalarType::kInt64;
}

/// The narrowest type that holds the values of both: of a signed and an unsigned integer a signed
/// one that is wider than the unsigned one, of an integer and a fraction a double where a float
/// does not hold the integer.
ScalarType common_type(ScalarType a, ScalarType b) {
  if (a == b) return a;
  if (is_float(a) || is_float(b)) {
    const bool narrow = (a == ScalarType::kFloat32 || (!is_float(a) && size_of(a) <= 2)) &&
                        (b == ScalarType::kFloat32 || (!is_float(b) && size_of(b) <= 2));
    return narrow ? ScalarType::kFloat32 : ScalarType::kFloat64;
  }
  std::size_t bytes = std::max(size_of(a), size_of(b));
  const bool has_sign = is_signed(a) || is_signed(b);
  if (is_signed(a) != is_signed(b)) {
    const std::size_t of_unsigned = size_of(is_signed(a) ? b : a);
    if (of_unsigned == 8) return ScalarType::kFloat64;
    bytes = std::max(bytes, 2 * of_unsigned);
  }
  switch (bytes) {
    case 1:
      return has_sign ? ScalarType::kInt8 : ScalarType::kUint8;
    case 2:
      return has_sign ? ScalarType::kInt16 : ScalarType::kUint16;
    case 4:
      return has_sign ? ScalarType::kInt32 : ScalarType::kUint32;
    default:
      return has_sign ? ScalarType::kInt64 : ScalarType::kUint64;
  }
}

ScalarType wider(ScalarType a, ScalarType b) { return a == ScalarType::kFloat64 ? a : b; }

void refuse_mixed_normals(const ListedFile& with, const ListedFile& without) {
  throw_bad_input(
      "some files have normals and some have none",
      {.file = without.path.string(),
       .found = "no normals",
       .expected = "normals as in " + with.path.string(),
       .advice = "Have all estimated: normals.source = \"estimate\" (--normals estimate)"});
}

/// The type of an attribute that fits all files that have it, in whatever order they come.
ScalarType type_in_all(const std::vector<ListedFile>& files, const std::string& name) {
  std::set<ScalarType> types;
  for (const ListedFile& file : files)
    if (const AttributeField* const field = field_of_name(file.schema, name))
      types.insert(field->type);
  ScalarType common = *types.begin();
  for (const ScalarType type : types) common = common_type(common, type);
  return common;
}

/// Names and types, for an order of schemas that does not depend on the order of the files.
std::vector<std::pair<std::string, ScalarType>> names_of(const PointSchema& schema) {
  std::vector<std::pair<std::string, ScalarType>> names;
  for (const AttributeField& field : schema.attributes) names.emplace_back(field.name, field.type);
  return names;
}

/// Every attribute of every file: in the order of the file that has most of them, then the others
/// by name, so that the order of the files makes no difference. Attributes of the program's own,
/// which all files have at their ends, stay at the end.
std::vector<AttributeField> all_attributes(const std::vector<ListedFile>& files) {
  const ListedFile* fullest = &files.front();
  for (const ListedFile& file : files) {
    const auto names = names_of(file.schema), most = names_of(fullest->schema);
    if (names.size() > most.size() || (names.size() == most.size() && names < most))
      fullest = &file;
  }
  std::vector<AttributeField> all = fullest->schema.attributes;
  const auto own = static_cast<std::ptrdiff_t>(all.size());
  for (const ListedFile& file : files)
    for (const AttributeField& field : file.schema.attributes)
      if (std::ranges::find(all, field.name, &AttributeField::name) == all.end())
        all.push_back(field);
  for (AttributeField& field : all) field.type = type_in_all(files, field.name);
  std::sort(all.begin() + own, all.end(),
            [](const AttributeField& a, const AttributeField& b) { return a.name < b.name; });
  if (!view_offset(fullest->schema)) return all;
  const auto views = static_cast<std::ptrdiff_t>(view_fields().size());
  std::rotate(all.begin() + own - views, all.begin() + own, all.end());
  return all;
}

PointSchema common_schema(const std::vector<ListedFile>& files) {
  PointSchema common = files.front().schema;
  for (const ListedFile& file : files) {
    if (file.schema.has_normals != common.has_normals) {
      const bool first_has = common.has_normals;
      refuse_mixed_normals(first_has ? files.front() : file, first_has ? file : files.front());
    }
    common.position_type = wider(common.position_type, file.schema.position_type);
    common.normal_type = wider(common.normal_type, file.schema.normal_type);
  }
  common.attributes = all_attributes(files);
  return common;
}

/// One line per attribute that a file lacks.
void note_fillers(const std::vector<ListedFile>& files, const PointSchema& common,
                  std::vector<std::string>& notes) {
  for (const AttributeField& field : common.attributes) {
    std::size_t lacking = 0;
    const ListedFile* first = nullptr;
    for (const ListedFile& file : files) {
      if (field_of_name(file.schema, field.name) != nullptr) continue;
      if (lacking++ == 0) first = &file;
    }
    if (first == nullptr) continue;
    const std::string others = lacking > 1 ? " and " + std::to_string(lacking - 1) + " more" : "";
    notes.push_back("attribute " + field.name + " (" + name_of(field.type) +
                    ") is 0 at points of " + first->path.string() + others + ", which " +
                    (lacking > 1 ? "lack" : "lacks") + " it");
  }
}

/// Normals of some files that are not taken since others have none.
void note_unused_normals(const std::vector<ListedFile>& files, std::vector<std::string>& notes) {
  const auto with = std::ranges::find(files, true, &ListedFile::has_unused_normals);
  const auto without = std::ranges::find(files, false, &ListedFile::has_unused_normals);
  if (with == files.end() || without == files.end()) return;
  const auto others = std::ranges::count(files, true, &ListedFile::has_unused_normals) - 1;
  notes.push_back("the normals of " + with->path.string() +
                  (others > 0 ? " and " + std::to_string(others) + " more" : "") +
                  " are not taken, since " + without->path.string() +
                  " has none: normals of all points are estimated");
}

/// Colours that are fractions in one file and whole numbers in another: of 0 to 1 and 0 to 255,
/// say, which the points show and no type does.
void note_color_scales(const std::vector<ListedFile>& files, std::vector<std::string>& notes) {
  const ListedFile* fractions = nullptr;
  const ListedFile* integers = nullptr;
  for (const ListedFile& file : files)
    if (const AttributeField* const red = field_of_name(file.schema, "red"))
      (is_float(red->type) ? fractions : integers) = &file;
  if (fractions == nullptr || integers == nullptr) return;
  const auto told = [](const ListedFile& file) {
    return std::string(name_of(field_of_name(file.schema, "red")->type)) + " in " +
           file.path.string();
  };
  notes.push_back(
      "colours are " + told(*fractions) + " and " + told(*integers) +
      "; they are taken as they are, so they fit together only where both have one range");
}

/// What the first points of a file tell of its 16-bit colours.
enum class ColorsSeen { kNone, kEightBits, kMore };

ColorsSeen colors_seen(const ListedFile& file, const PointSourceOpener& opener) {
  constexpr std::size_t kLook = 4096;
  const std::optional<WideColors> colors = wide_colors(file.schema);
  std::error_code ignored;
  // A pipe is read once.
  if (!colors || !std::filesystem::is_regular_file(file.path, ignored)) return ColorsSeen::kNone;
  PointCloud batch;
  opener(file.path)->read(batch, kLook);
  if (exceed_8_bits(batch, *colors)) return ColorsSeen::kMore;
  const std::size_t row = batch.schema.attribute_bytes();
  for (std::size_t i = 0; i < batch.size(); ++i)
    for (const std::size_t offset : colors->offsets)
      if (batch.attributes[i * row + offset] != std::byte{0}) return ColorsSeen::kEightBits;
  return ColorsSeen::kNone;
}

/// Files with 8-bit colours in 16-bit fields beside files whose colours fill these: all are taken
/// alike, since a scan may come in any number of files.
void note_color_depths(const std::vector<ListedFile>& files, const PointSourceOpener& opener,
                       std::vector<std::string>& notes) {
  const auto has_wide = [](const ListedFile& file) { return wide_colors(file.schema).has_value(); };
  if (std::ranges::count_if(files, has_wide) < 2) return;
  const ListedFile* narrow = nullptr;
  const ListedFile* wide = nullptr;
  std::size_t others = 0;
  // Each file is opened once more: of thousands, some from all over the list tell enough.
  constexpr std::size_t kMostFiles = 128;
  const std::size_t looks = std::min(kMostFiles, files.size());
  for (std::size_t look = 0; look < looks; ++look) {
    const ListedFile& file = files[look * files.size() / looks];
    const ColorsSeen seen = colors_seen(file, opener);
    if (seen == ColorsSeen::kMore && wide == nullptr) wide = &file;
    if (seen != ColorsSeen::kEightBits) continue;
    if (narrow == nullptr)
      narrow = &file;
    else
      ++others;
  }
  if (narrow == nullptr || wide == nullptr) return;
  notes.push_back(
      narrow->path.string() +
      (others > 0 ? " and " + std::to_string(others) + " more have" : " has") +
      " colours up to 255 at the first points, and " + wide->path.string() +
      " has larger ones: all are taken as 16-bit colours, of which those up to 255 are "
      "nearly black. If colours of 8 bits are meant, write them as such: orbweave convert " +
      narrow->path.string() + " " + narrow->path.stem().string() + "-8bit.ply");
}

/// Values of points that no attribute has, which files hold.
struct LostValues {
  std::string words;
  std::filesystem::path first;  ///< of the files
  std::size_t files = 0;
};

void note_lost_values(const std::vector<LostValues>& all, std::vector<std::string>& notes) {
  for (const LostValues& lost : all) {
    const std::size_t others = lost.files - 1;
    notes.push_back(lost.first.string() +
                    (others > 0 ? " and " + std::to_string(others) + " more" : "") +
                    ": not carried over: " + lost.words);
  }
}

/// What a file says of its coordinates.
struct NamedSystem {
  std::string text;
  std::filesystem::path file;
  std::optional<Vec3> meters_per_unit;
};

/// The command that brings one file to the system of the other.
std::string reprojection_advice(const NamedSystem& kept, const NamedSystem& other) {
  const std::optional<CoordinateSystem> known = known_coordinate_system(kept.text);
  const std::string target = known && !known->code.empty() ? known->code : "EPSG:CODE";
  return "Points are not reprojected here; PDAL does that: pdal translate " + other.file.string() +
         " reprojected.laz reprojection --filters.reprojection.out_srs=" + target;
}

[[noreturn]] void refuse_mixed_systems(const NamedSystem& kept, const NamedSystem& other) {
  throw_bad_input("the scans of one job are in different coordinate systems",
                  {.file = other.file.string(),
                   .found = words_of_system(other.text),
                   .expected = words_of_system(kept.text) + " as in " + kept.file.string(),
                   .advice = reprojection_advice(kept, other)});
}

class PointSourceList final : public PointSource {
 public:
  PointSourceList(const std::vector<std::filesystem::path>& paths, PointSourceOpener opener)
      : opener_(std::move(opener)) {
    if (!opener_)
      opener_ = [](const std::filesystem::path& path) { return open_point_source(path); };
    declared_ = 0;
    for (const std::filesystem::path& path : paths) {
      // Opened for its header only: thousands of scans would not fit the open-file limit.
      const auto source = opener_(path);
      files_.push_back({path, source->schema(), source->bytes_total(),
                        source->declared_points().value_or(0), source->facts().has_unused_normals});
      add_declared(source->declared_points());
      bytes_total_ += source->bytes_total();
      add_coordinate_system(*source, path);
      add_lost_values(*source, path);
    }
    schema_ = common_schema(files_);
  }

  const PointSchema& schema() const override { return schema_; }
  std::optional<std::uint64_t> declared_points() const override { return declared_; }
  std::uint64_t bytes_read() const override {
    return bytes_done_ + (source_ ? source_->bytes_read() : 0);
  }
  std::uint64_t bytes_total() const override { return bytes_total_; }
  std::optional<ScannerPlace> scanner() const override {
    return source_ ? source_->scanner() : std::nullopt;
  }
  ScanNumber scan() const override {
    if (!source_) return {};
    return {static_cast<std::uint32_t>(next_ - 1), source_->scan().scan};
  }
  DroppedPoints left_out() const override {
    DroppedPoints all = left_out_;
    if (source_) add_left_out(all);
    return all;
  }
  std::string coordinate_system() const override {
    return coordinate_system_ ? coordinate_system_->text : std::string();
  }
  std::optional<Vec3> meters_per_unit() const override {
    if (coordinate_system_) return coordinate_system_->meters_per_unit;
    return units_without_system_.size() == 1 ? std::optional(units_without_system_.front())
                                             : std::nullopt;
  }
  void note(std::vector<std::string>& notes) const {
    note_fillers(files_, schema_, notes);
    note_unused_normals(files_, notes);
    note_color_scales(files_, notes);
    note_color_depths(files_, opener_, notes);
    note_lost_values(lost_values_, notes);
    notes.insert(notes.end(), disagreements_.begin(), disagreements_.end());
    if (!coordinate_system_ || files_without_system_.empty()) return;
    const std::size_t others = files_without_system_.size() - 1;
    notes.push_back(files_without_system_.front().string() +
                    (others > 0 ? " and " + std::to_string(others) + " more name" : " names") +
                    " no coordinate system; taken to be in that of " +
                    coordinate_system_->file.string());
  }

  /// A file that cannot be shared goes to the process that has the first row of the file.
  bool restrict_rows(std::uint64_t first, std::uint64_t count) override {
    if (!declared_) return false;
    first_row_ = first;
    end_row_ = first + count;
    return true;
  }
  bool has_row_access() const override {
    return declared_ && std::all_of(files_.begin(), files_.end(), [&](const ListedFile& file) {
             return opener_(file.path)->restrict_rows(0, file.points);
           });
  }

  bool read(PointCloud& batch, std::size_t capacity) override {
    while (source_ || open_next()) {
      PointCloud& target = same_attributes_ ? batch : whole_;
      if (source_->read(target, capacity)) {
        if (!same_attributes_) to_common(batch);
        batch.schema = schema_;
        return true;
      }
      bytes_done_ += files_[next_ - 1].bytes;
      add_left_out(left_out_);
      source_.reset();
    }
    batch.clear();
    batch.schema = schema_;
    return false;
  }

 private:
  bool open_next() {
    while (next_ < files_.size()) {
      const ListedFile& file = files_[next_++];
      source_ = open_share(file);
      if (source_) {
        check_opened(file);
        return true;
      }
      bytes_done_ += file.bytes;
    }
    return false;
  }

  /// The file, or the rows of it that are wanted; null where that is none.
  std::unique_ptr<PointSource> open_share(const ListedFile& file) {
    const std::uint64_t begin = rows_passed_;
    rows_passed_ += file.points;
    const std::uint64_t from = std::max(begin, first_row_);
    const std::uint64_t to = std::min(rows_passed_, end_row_);
    const bool whole = from == begin && to == rows_passed_;
    if (!whole && from >= to) return nullptr;
    auto source = opener_(file.path);
    if (whole || source->restrict_rows(from - begin, to - from)) return source;
    return from == begin ? std::move(source) : nullptr;
  }

  void check_opened(const ListedFile& file) {
    if (source_->schema() != file.schema)
      throw_bad_input("the file's columns changed while the job ran", {.file = file.path.string()});
    same_attributes_ = file.schema.attributes == schema_.attributes;
    values_ = copied_values(file.schema, schema_);
    if (widens_colors(file.schema, schema_) && fills_16_bits())
      scale_colors(values_, *wide_colors(schema_));
  }

  /// Whether a 16-bit colour of any file exceeds 8 bits. Where none does, all are 8-bit colours.
  /// Mostly the first points of a file tell; they are looked at only where widths differ.
  bool fills_16_bits() {
    if (!fills_16_bits_)
      fills_16_bits_ = std::ranges::any_of(files_, [&](const ListedFile& file) {
        return wide_colors(file.schema) && file_fills_16_bits(file);
      });
    return *fills_16_bits_;
  }

  bool file_fills_16_bits(const ListedFile& file) const {
    constexpr std::size_t kBatchPoints = std::size_t{1} << 16;
    const auto source = opener_(file.path);
    const WideColors colors = *wide_colors(file.schema);
    for (PointCloud batch; source->read(batch, kBatchPoints);)
      if (exceed_8_bits(batch, colors)) return true;
    return false;
  }

  /// Nothing once a file does not say, or says what no sum holds.
  void add_declared(std::optional<std::uint64_t> points) {
    if (!declared_) return;
    const std::uint64_t most = std::numeric_limits<std::uint64_t>::max() - *declared_;
    declared_ = points && *points <= most ? std::optional(*declared_ + *points) : std::nullopt;
  }

  void add_left_out(DroppedPoints& all) const {
    for (const auto& [reason, count] : source_->left_out()) all[reason] += count;
  }

  void add_lost_values(const PointSource& source, const std::filesystem::path& path) {
    for (std::string& words : source.facts().lost_values) {
      const auto known = std::ranges::find(lost_values_, words, &LostValues::words);
      if (known == lost_values_.end())
        lost_values_.push_back({std::move(words), path, 1});
      else
        ++known->files;
    }
  }

  /// Points are never converted. Of several texts that stand for one system the longest says most,
  /// whatever the order of the files; a file that names none takes the others'.
  void add_coordinate_system(const PointSource& source, const std::filesystem::path& path) {
    const std::string text = source.coordinate_system();
    if (text.empty()) {
      files_without_system_.push_back(path);
      if (const std::string words = unknown_system_beside(path); !words.empty())
        disagreements_.push_back(
            coordinate_system_file(path).string() +
            " names no coordinate system that is known, so it is passed over: " + words);
      add_unit_without_system(source.meters_per_unit());
      return;
    }
    if (coordinate_system_ && coordinate_system_->text != text) compare_systems(text, path);
    const bool says_more =
        !coordinate_system_ || text.size() > coordinate_system_->text.size() ||
        (text.size() == coordinate_system_->text.size() && text < coordinate_system_->text);
    if (says_more) coordinate_system_ = {text, path, source.meters_per_unit()};
  }

  void add_unit_without_system(const std::optional<Vec3>& unit) {
    if (unit && std::ranges::find(units_without_system_, *unit) == units_without_system_.end())
      units_without_system_.push_back(*unit);
  }

  void compare_systems(const std::string& text, const std::filesystem::path& path) {
    const auto [known, is_new] = systems_compared_.insert(text);
    if (!is_new) return;
    const NamedSystem& other = *coordinate_system_;
    switch (systems_differ(other.text, text)) {
      case SystemsDiffer::kNo:
        return;
      case SystemsDiffer::kYes:
        refuse_mixed_systems(other, {text, path, {}});
      case SystemsDiffer::kUnknown:
        disagreements_.push_back("whether the coordinate systems of " + other.file.string() + " (" +
                                 words_of_system(other.text) + ") and " + path.string() + " (" +
                                 words_of_system(text) +
                                 ") are the same is not known; points are taken as they are");
    }
  }

  void to_common(PointCloud& batch) {
    batch.positions.swap(whole_.positions);
    batch.normals.swap(whole_.normals);
    const std::size_t from_bytes = whole_.schema.attribute_bytes();
    const std::size_t to_bytes = schema_.attribute_bytes();
    batch.attributes.assign(batch.positions.size() * to_bytes, std::byte{});
    const std::byte* from = whole_.attributes.data();
    std::byte* to = batch.attributes.data();
    for (std::size_t i = 0; i < batch.positions.size(); ++i, from += from_bytes, to += to_bytes) {
      for (const CopiedValue& value : values_) {
        if (value.is_plain())
          std::memcpy(to + value.to, from + value.from, value.bytes);
        else
          convert_value(value, from + value.from, to + value.to);
      }
    }
  }

  PointSourceOpener opener_;
  std::vector<ListedFile> files_;
  PointSchema schema_;
  std::optional<std::uint64_t> declared_;
  std::uint64_t bytes_total_ = 0;
  std::uint64_t bytes_done_ = 0;
  std::size_t next_ = 0;
  std::uint64_t rows_passed_ = 0;  ///< of files opened or passed over
  std::uint64_t first_row_ = 0;
  std::uint64_t end_row_ = std::numeric_limits<std::uint64_t>::max();
  std::unique_ptr<PointSource> source_;
  bool same_attributes_ = true;
  PointCloud whole_;  ///< a batch as the file has it
  std::vector<CopiedValue> values_;
  std::optional<bool> fills_16_bits_;  ///< once it was asked for
  DroppedPoints left_out_;             ///< of the files that were read to their ends
  std::optional<NamedSystem> coordinate_system_;
  std::vector<Vec3> units_without_system_;  // each once, of files that name no system
  std::set<std::string> systems_compared_;
  std::vector<std::filesystem::path> files_without_system_;
  std::vector<std::string> disagreements_;
  std::vector<LostValues> lost_values_;
};

}  // namespace

std::unique_ptr<PointSource> open_point_sources(const std::vector<std::filesystem::path>& paths,
                                                const PointSourceOpener& opener,
                                                std::vector<std::string>* notes) {
  if (paths.empty()) throw_usage("no input file", {.expected = "at least one scan"});
  auto list = std::make_unique<PointSourceList>(paths, opener);
  if (notes != nullptr) list->note(*notes);
  return list;
}

}  // namespace orbweave
