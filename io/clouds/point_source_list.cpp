#include "io/clouds/point_source_list.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <set>
#include <utility>

#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/points/coordinate_system.h"

namespace orbweave {
namespace {

/// What a file of the list was found to be.
struct ListedFile {
  std::filesystem::path path;
  PointSchema schema;
  std::uint64_t bytes = 0;
  std::uint64_t points = 0;  ///< declared
};

/// Bytes of a row that the common schema keeps.
struct KeptRun {
  std::size_t offset = 0;
  std::size_t bytes = 0;
};

std::vector<KeptRun> kept_runs(const PointSchema& from, const PointSchema& common) {
  std::vector<KeptRun> runs;
  for (const AttributeField& kept : common.attributes) {
    std::size_t offset = 0;
    for (const AttributeField& field : from.attributes) {
      if (field == kept) break;
      offset += size_of(field.type);
    }
    runs.push_back({offset, size_of(kept.type)});
  }
  return runs;
}

ScalarType wider(ScalarType a, ScalarType b) { return a == ScalarType::kFloat64 ? a : b; }

bool has_field(const PointSchema& schema, const AttributeField& field) {
  return std::find(schema.attributes.begin(), schema.attributes.end(), field) !=
         schema.attributes.end();
}

void refuse_mixed_normals(const ListedFile& with, const ListedFile& without) {
  throw_bad_input("some files have normals and some have none",
                  {.file = without.path.string(),
                   .found = "no normals",
                   .expected = "normals as in " + with.path.string()});
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
    std::erase_if(common.attributes,
                  [&](const AttributeField& field) { return !has_field(file.schema, field); });
  }
  return common;
}

/// One line per attribute of any file that not all have.
void note_left_out(const std::vector<ListedFile>& files, const PointSchema& common,
                   std::vector<std::string>& notes) {
  std::vector<AttributeField> told;
  for (const ListedFile& file : files) {
    for (const AttributeField& field : file.schema.attributes) {
      if (has_field(common, field) || std::find(told.begin(), told.end(), field) != told.end())
        continue;
      told.push_back(field);
      const auto lacking = std::find_if(files.begin(), files.end(), [&](const ListedFile& other) {
        return !has_field(other.schema, field);
      });
      notes.push_back("attribute " + field.name + " (" + name_of(field.type) + ") of " +
                      file.path.string() + " is left out: " + lacking->path.string() +
                      " does not have it");
    }
  }
}

/// What a file says of its coordinates.
struct NamedSystem {
  std::string text;
  std::filesystem::path file;
  std::optional<Vec3> meters_per_unit;
};

/// For messages: WKT is long.
std::string system_name(const std::string& text) {
  const std::optional<CoordinateSystem> known = known_coordinate_system(text);
  if (!known) return text.substr(0, 60);
  const bool has_code = !known->code.empty() && known->code != known->name;
  return known->name + (has_code ? ", " + known->code : "");
}

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
                   .found = system_name(other.text),
                   .expected = system_name(kept.text) + " as in " + kept.file.string(),
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
      files_.push_back(
          {path, source->schema(), source->bytes_total(), source->declared_points().value_or(0)});
      add_declared(source->declared_points());
      bytes_total_ += source->bytes_total();
      add_coordinate_system(*source, path);
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
  DroppedPoints left_out() const override {
    DroppedPoints all = left_out_;
    if (source_) add_left_out(all);
    return all;
  }
  std::string coordinate_system() const override {
    return coordinate_system_ ? coordinate_system_->text : std::string();
  }
  std::optional<Vec3> meters_per_unit() const override {
    return coordinate_system_ ? coordinate_system_->meters_per_unit : unit_without_system_;
  }
  void note(std::vector<std::string>& notes) const {
    note_left_out(files_, schema_, notes);
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
        if (!same_attributes_) keep_common(batch);
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
    runs_ = kept_runs(file.schema, schema_);
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

  /// Points are never converted. Of several texts that stand for one system the longest says most,
  /// whatever the order of the files; a file that names none takes the others'.
  void add_coordinate_system(const PointSource& source, const std::filesystem::path& path) {
    const std::string text = source.coordinate_system();
    if (text.empty()) {
      files_without_system_.push_back(path);
      if (!coordinate_system_) unit_without_system_ = source.meters_per_unit();
      return;
    }
    if (coordinate_system_ && coordinate_system_->text != text) compare_systems(text, path);
    const bool says_more =
        !coordinate_system_ || text.size() > coordinate_system_->text.size() ||
        (text.size() == coordinate_system_->text.size() && text < coordinate_system_->text);
    if (says_more) coordinate_system_ = {text, path, source.meters_per_unit()};
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
                                 system_name(other.text) + ") and " + path.string() + " (" +
                                 system_name(text) +
                                 ") are the same is not known; points are taken as they are");
    }
  }

  void keep_common(PointCloud& batch) {
    batch.positions.swap(whole_.positions);
    batch.normals.swap(whole_.normals);
    const std::size_t from_bytes = whole_.schema.attribute_bytes();
    const std::size_t to_bytes = schema_.attribute_bytes();
    batch.attributes.resize(batch.positions.size() * to_bytes);
    const std::byte* from = whole_.attributes.data();
    std::byte* to = batch.attributes.data();
    for (std::size_t i = 0; i < batch.positions.size(); ++i, from += from_bytes) {
      for (const KeptRun& run : runs_) {
        std::memcpy(to, from + run.offset, run.bytes);
        to += run.bytes;
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
  PointCloud whole_;  ///< a batch before attributes are left out
  std::vector<KeptRun> runs_;
  DroppedPoints left_out_;  ///< of the files that were read to their ends
  std::optional<NamedSystem> coordinate_system_;
  std::optional<Vec3> unit_without_system_;
  std::set<std::string> systems_compared_;
  std::vector<std::filesystem::path> files_without_system_;
  std::vector<std::string> disagreements_;
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
