#include "io/job/job_keys.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "io/ball_radii.h"
#include "io/error.h"
#include "io/job/job_values.h"
#include "io/points/area_text.h"
#include "io/simplify_target.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max();
/// Below that the program itself, its libraries and one chunk do not fit.
constexpr std::uint64_t kLeastMemory = std::uint64_t{64} << 20;
constexpr std::int64_t kMostLevels = 8;
constexpr std::int64_t kMostThreads = 4096;
constexpr double kLargestNumber = std::numeric_limits<double>::max();

constexpr std::array kSeparatorNames = {"auto", "comma", "semicolon", "tab", "blank"};
constexpr std::array kSeparators = {'\0', ',', ';', '\t', ' '};

char separator_value(const WrittenValue& value) {
  const std::string text = text_value(value);
  for (std::size_t i = 0; i < kSeparators.size(); ++i)
    if (text == kSeparatorNames[i] || text == std::string(1, kSeparators[i])) return kSeparators[i];
  throw UnsuitableValue{};
}

std::string separator_text(char character) {
  for (std::size_t i = 0; i < kSeparators.size(); ++i)
    if (kSeparators[i] == character) return kSeparatorNames[i];
  return {1, character};
}

/// Scales that coordinates can be computed with, as in engine/validation/usable_scale.h; the
/// inverse of such a scale is one.
constexpr double kLeastScale = 1e-75;
constexpr double kMostScale = 1e75;

/// Three numbers, or nothing for "auto".
std::optional<Vec3> optional_vector(const WrittenValue& value) {
  if (is_auto(value)) return std::nullopt;
  return vector_value(value);
}

JobValue auto_or(const std::optional<Vec3>& vector) {
  if (!vector) return std::string("auto");
  return std::vector<double>{vector->x, vector->y, vector->z};
}

void set_units_per_meter(Job& job, const WrittenValue& value) {
  job.input.units_per_meter.reset();
  if (!is_auto(value)) job.input.units_per_meter = number_value(value, kLeastScale, kMostScale);
}

/// The sizes of cells whose names are exact (io/meshes/map_grid.h).
constexpr double kLeastTileSize = 1e-9;
constexpr double kLargestTileSize = 1e12;

void set_tile_size(Job& job, const WrittenValue& value) {
  const double size = number_value(value, 0.0, kLargestTileSize);
  if (size > 0.0 && size < kLeastTileSize) throw UnsuitableValue{};
  job.output.tile_size = size;
}

JobValue auto_or(const std::optional<double>& number) {
  if (!number) return std::string("auto");
  return *number;
}

void set_direction(std::optional<Vec3>& direction, const WrittenValue& value) {
  direction = optional_vector(value);
  if (direction && squared_norm(*direction) == 0.0)
    throw UnsuitableValue{"a direction has a length", ""};
}

/// [x, y, z] is a place, [x, y, z, 0] a direction: homogeneous coordinates.
void set_scanner(Job& job, const WrittenValue& value) {
  job.input.scanner.reset();
  if (is_auto(value)) return;
  const std::vector<double> numbers = numbers_value(value);
  const bool direction = numbers.size() == 4 && numbers[3] == 0.0;
  if (numbers.size() != 3 && !direction) throw UnsuitableValue{};
  const Vec3 vector{numbers[0], numbers[1], numbers[2]};
  if (direction && squared_norm(vector) == 0.0)
    throw UnsuitableValue{"a direction has a length", ""};
  job.input.scanner = ScannerPlace{vector, direction};
}

JobValue scanner_value(const Job& job) {
  if (!job.input.scanner) return std::string("auto");
  const Vec3 v = job.input.scanner->vector;
  std::vector<double> numbers = {v.x, v.y, v.z};
  if (job.input.scanner->is_direction) numbers.push_back(0.0);
  return numbers;
}

void set_pose(Job& job, const WrittenValue& value) {
  job.input.pose.clear();
  job.input.pose_lines.clear();
  for (const std::string& line : texts_value(value)) {
    try {
      job.input.pose.push_back(parse_pose(line));
      job.input.pose_lines.push_back(line);
    } catch (const std::invalid_argument& problem) {
      throw UnsuitableValue{problem.what(), ""};
    }
  }
}

void set_scanners(Job& job, const WrittenValue& value) {
  job.input.scanners.clear();
  job.input.scanner_lines = texts_value(value);
  for (const std::string& line : job.input.scanner_lines) {
    try {
      job.input.scanners.push_back(parse_scanner_of_value(line));
    } catch (const std::invalid_argument& problem) {
      throw UnsuitableValue{problem.what(), ""};
    }
    if (job.input.scanners.back().attribute != job.input.scanners.front().attribute)
      throw UnsuitableValue{"it names two attributes", ""};
  }
}

/// Whether a list is given by a word, for command lines where brackets mean something else.
bool is_none(const WrittenValue& value) {
  const bool is_text =
      value.items.size() == 1 && std::holds_alternative<std::string>(value.items[0]);
  return is_text && std::get<std::string>(value.items[0]) == "none";
}

std::vector<int> classes_value(const WrittenValue& value) {
  std::vector<int> classes;
  if (is_none(value)) return classes;
  for (const double number : numbers_value(value)) {
    if (number < 0.0 || number > 255.0 || number != std::floor(number)) throw UnsuitableValue{};
    classes.push_back(static_cast<int>(number));
  }
  return classes;
}

JobValue classes_of(const std::vector<int>& classes) {
  return std::vector<double>(classes.begin(), classes.end());
}

/// Two corners, of x, y and z or of x and y alone.
void set_crop(Job& job, const WrittenValue& value) {
  job.input.crop.reset();
  if (is_none(value)) return;
  const std::vector<double> numbers = numbers_value(value);
  if (numbers.empty()) return;
  if (numbers.size() != 4 && numbers.size() != 6) throw UnsuitableValue{};
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const std::size_t axes = numbers.size() / 2;
  Box box{{numbers[0], numbers[1], -kFar}, {numbers[axes], numbers[axes + 1], kFar}};
  if (axes == 3) {
    box.min.z = numbers[2];
    box.max.z = numbers[5];
  }
  if (box.empty()) throw UnsuitableValue{"a smallest coordinate is above the largest", ""};
  job.input.crop = box;
}

JobValue crop_value(const Job& job) {
  if (!job.input.crop) return std::vector<double>{};
  const Box& box = *job.input.crop;
  if (std::isinf(box.min.z)) return std::vector<double>{box.min.x, box.min.y, box.max.x, box.max.y};
  return std::vector<double>{box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z};
}

/// Polygons as text stay as they are; anything else is the path of a file.
void set_crop_area(Job& job, const WrittenValue& value) {
  const std::string text = text_value(value);
  job.input.crop_area.clear();
  if (!is_area_text(text)) {
    job.input.crop_area = path_value(value);
    return;
  }
  try {
    parse_area(text, "");
  } catch (const Error& error) {
    const ErrorParts& parts = error.parts();
    throw UnsuitableValue{error.problem() + ", " + parts.place + ": found " + parts.found,
                          parts.expected};
  }
  job.input.crop_area = text;
}

void set_origin(Job& job, const WrittenValue& value) {
  static constexpr std::array kRules = {"auto", "none"};
  job.output.origin = {};
  const bool is_text = value.shape == WrittenValue::Shape::kScalar &&
                       std::holds_alternative<std::string>(value.items.front());
  if (is_text) {
    job.output.origin_rule = static_cast<OriginRule>(choice_value(value, kRules));
    return;
  }
  job.output.origin_rule = OriginRule::kGiven;
  job.output.origin = vector_value(value);
}

JobValue origin_value(const Job& job) {
  if (job.output.origin_rule == OriginRule::kAuto) return std::string("auto");
  if (job.output.origin_rule == OriginRule::kNone) return std::string("none");
  const Vec3 v = job.output.origin;
  return std::vector<double>{v.x, v.y, v.z};
}

void set_colors(Job& job, const WrittenValue& value) {
  const std::int64_t bits = integer_value(value, 8, 16);
  if (bits != 8 && bits != 16) throw UnsuitableValue{};
  job.output.color_bits = static_cast<int>(bits);
}

/// A choice's names in the order of its enumerators.
constexpr std::array kReturns = {"all", "first", "last", "only"};
constexpr std::array kSources = {"auto", "file", "estimate", "poles"};
constexpr std::array kOrientations = {"auto",      "scanner", "viewpoint", "up",
                                      "propagate", "ground",  "inward",    "none"};
constexpr std::array kMethods = {"ball_pivoting", "crust",        "power_crust",
                                 "cocone",        "tight_cocone", "super_cocone"};
constexpr std::array kKernels = {"biharmonic", "triharmonic"};
constexpr std::array kFormats = {"auto", "binary", "text"};
constexpr std::array kPrecisions = {"double", "float"};
constexpr std::array kPictureBacks = {"auto", "shown", "culled"};
constexpr std::array kPictureColors = {"patches", "confidence", "points", "component",
                                       "undersampled"};
constexpr std::array kTileCompressions = {"none", "meshopt"};
constexpr std::array kUpAxes = {"auto", "x", "y", "z"};

/// What limits of the keys share.
constexpr std::array kAuto = {"auto"};
constexpr std::array kNone = {"none"};
constexpr std::array kAutoOrNone = {"auto", "none"};
constexpr std::array kSeparatorCharacters = {",", ";", "\t", " "};
constexpr std::array kColorBits = {8, 16};
constexpr std::array kAxes = {3};
constexpr std::array kPlaceOrDirection = {3, 4};
constexpr std::array kCorners = {0, 4, 6};
constexpr double kLeastMemoryBytes = static_cast<double>(kLeastMemory);

template <class Enum>
std::string name_in(Choices names, Enum value) {
  return names[static_cast<std::size_t>(value)];
}

/// A count as a job file holds it: what is beyond its integers is no limit there either.
std::int64_t count_of(std::uint64_t count) {
  return static_cast<std::int64_t>(std::min(count, static_cast<std::uint64_t>(kLargest)));
}

std::uint64_t count_value(const WrittenValue& value) {
  return static_cast<std::uint64_t>(integer_value(value, 0, kLargest));
}

std::string color_text(const std::array<std::uint8_t, 3>& color) {
  constexpr const char* kHex = "0123456789abcdef";
  std::string text = "#";
  for (const std::uint8_t channel : color) {
    text += kHex[channel >> 4];
    text += kHex[channel & 15];
  }
  return text;
}

void set_format(Job& job, const WrittenValue& value) {
  const std::size_t choice = choice_value(value, kFormats);
  job.output.requires_binary = choice == 1;
  job.output.binary = choice != 2;
}

std::string format_text(const OutputOptions& output) {
  return kFormats[output.requires_binary ? 1 : output.binary ? 0 : 2];
}

void set_radii(Job& job, const WrittenValue& value) {
  job.reconstruct.ball_radii = is_auto(value) ? std::vector<double>{} : ascending_value(value);
  if (job.reconstruct.ball_radii.empty()) return;
  if (const auto objection = objection_to_radii(job.reconstruct.ball_radii))
    throw UnsuitableValue{objection->problem, objection->expected};
}

void set_chunk_points(Job& job, const WrittenValue& value) {
  job.partition.chunk_points =
      is_auto(value) ? 0 : static_cast<std::uint64_t>(integer_value(value, 1, kLargest));
}

void set_cluster_points(Job& job, const WrittenValue& value) {
  constexpr std::int64_t kMostOfCluster = 100000;
  job.cleaning.cluster_points.reset();
  if (!is_auto(value))
    job.cleaning.cluster_points =
        static_cast<std::uint64_t>(integer_value(value, 0, kMostOfCluster));
}

JobValue auto_or(std::uint64_t number) {
  if (number == 0) return std::string("auto");
  return count_of(number);
}

JobValue auto_or(const std::optional<std::uint64_t>& number) {
  if (!number) return std::string("auto");
  return count_of(*number);
}

JobValue auto_or(const std::vector<double>& numbers) {
  if (numbers.empty()) return std::string("auto");
  return numbers;
}

/// Of a table with one entry: "ratio=0.1" of {ratio = 0.1}.
std::string text_of_entry(const WrittenValue& value) {
  if (value.items.size() != 2) throw UnsuitableValue{};
  const std::string name = std::get<std::string>(value.items[0]) + "=";
  if (const auto* integer = std::get_if<std::int64_t>(&value.items[1]))
    return name + std::to_string(*integer);
  if (const auto* number = std::get_if<double>(&value.items[1]))
    return name + format_exact(*number);
  throw UnsuitableValue{};
}

void set_simplify(Job& job, const WrittenValue& value) {
  const std::string text =
      value.shape == WrittenValue::Shape::kOther ? text_of_entry(value) : text_value(value);
  job.output.simplify = parse_simplify_target(text);
  if (!job.output.simplify && !text.empty()) throw UnsuitableValue{};
}

JobValue simplify_value(const Job& job) {
  return job.output.simplify ? simplify_target_text(*job.output.simplify) : std::string();
}

using W = WrittenValue;
using T = JobKeyType;

// clang-format off
constexpr JobKey kKeys[] = {
    {"input", "files", T::kPaths, "a list of paths and patterns such as [\"scans/*.ply\"]", {},
     "scans to read, as paths and patterns", "", "",
     [](Job& job, const W& value) { job.input.files = patterns_value(value); },
     [](const Job& job) -> JobValue { return job.input.files; }},
    {"input", "columns", T::kTexts, "a list of names such as [\"x\", \"y\", \"z\", \"nx\", \"ny\", \"nz\"]; [] to detect them", {},
     "names of the columns of a text cloud, such as x,y,z,nx,ny,nz; the default detects the columns", "columns", "",
     [](Job& job, const W& value) { job.input.text.columns = texts_value(value); },
     [](const Job& job) -> JobValue { return job.input.text.columns; }},
    {"input", "separator", T::kChoice, "", kSeparatorNames,
     "separator between the columns of a text cloud", "separator", "",
     [](Job& job, const W& value) { job.input.text.separator = separator_value(value); },
     [](const Job& job) -> JobValue { return separator_text(job.input.text.separator); },
     {.words = kSeparatorCharacters}},

    {"input", "poses", T::kPath, "the path of a Stanford .conf, or \"\" for none", {},
     "file with a pose per scan (Stanford .conf)", "poses", "",
     [](Job& job, const W& value) { job.input.poses = path_value(value); },
     [](const Job& job) -> JobValue { return job.input.poses; }},
    {"input", "pose", T::kTexts, "a list of texts \"FILE tx ty tz qx qy qz qw\", or \"FILE\" and the 16 numbers of a matrix", {},
     "poses of scans: the quaternion q turns p to q p q*, the other way round than in a Stanford .conf; a matrix, row by row, is applied to columns", "", "",
     set_pose,
     [](const Job& job) -> JobValue { return job.input.pose_lines; }},
    {"input", "scanner", T::kNumbers, "\"auto\", a place [x, y, z] or a direction [x, y, z, 0]", {},
     "position x,y,z of the scanner, or direction x,y,z,0 towards the scanner, in each scan's own coordinates", "scanner", "",
     set_scanner, scanner_value,
     {.words = kAuto, .lengths = kPlaceOrDirection}},
    {"input", "scanners", T::kTexts, "a list of texts \"ATTRIBUTE=VALUE x y z\", or with a 0 behind a direction; [] for none", {},
     "positions of the scanners of merged scans, one per value of an attribute of the points, such as \"scan=0 1.2 0.5 1.6\"", "", "",
     set_scanners,
     [](const Job& job) -> JobValue { return job.input.scanner_lines; }},
    {"input", "trajectory", T::kPath, "the path of a file of times and places (text, LAS, LAZ, PLY, PCD, E57), or \"\" for none", {},
     "path of a scanner that moved: a file with time, x, y and z per line, in world coordinates; the points' own times tell where the scanner was", "trajectory", "",
     [](Job& job, const W& value) { job.input.trajectory = path_value(value); },
     [](const Job& job) -> JobValue { return job.input.trajectory; }},
    {"input", "las_classes", T::kNumbers, "a list of integers from 0 to 255; [] for all", {},
     "LAS point classes to keep, such as 2,6 (ground, building); the default keeps all", "las-classes", "",
     [](Job& job, const W& value) { job.input.las_classes = classes_value(value); },
     [](const Job& job) { return classes_of(job.input.las_classes); },
     {.least = 0, .most = 255, .is_whole = true, .words = kNone}},
    {"input", "drop_classes", T::kNumbers, "a list of integers from 0 to 255; [] or \"none\" for none", {},
     "point classes to leave out where las_classes names none to keep; the default is noise, low point and high noise", "drop-classes", "",
     [](Job& job, const W& value) { job.input.drop_classes = classes_value(value); },
     [](const Job& job) { return classes_of(job.input.drop_classes); },
     {.least = 0, .most = 255, .is_whole = true, .words = kNone}},
    {"input", "returns", T::kChoice, "", kReturns,
     "returns of a laser pulse to keep", "returns", "",
     [](Job& job, const W& value) { job.input.returns = static_cast<ReturnFilter>(choice_value(value, kReturns)); },
     [](const Job& job) -> JobValue { return name_in(kReturns, job.input.returns); }},
    {"input", "crop", T::kNumbers, "a list [xmin, ymin, zmin, xmax, ymax, zmax] or [xmin, ymin, xmax, ymax]; [] or \"none\" for none", {},
     "box of the points to keep, in world coordinates, limits included", "crop", "",
     set_crop, crop_value,
     {.words = kNone, .lengths = kCorners}},
    {"input", "crop_area", T::kPath, "polygons as WKT, such as \"POLYGON ((0 0, 9 0, 9 9, 0 0))\", the path of a WKT or GeoJSON file, or \"\" for none", {},
     "polygons of the points to keep, by x and y in world coordinates: the path of a WKT or GeoJSON file, or WKT itself", "crop-area", "",
     set_crop_area,
     [](const Job& job) -> JobValue { return job.input.crop_area; }},
    {"input", "every", T::kInteger, "an integer of at least 1", {},
     "keep one in so many points, whatever their order; 1 keeps all", "every", "",
     [](Job& job, const W& value) { job.input.every = static_cast<std::uint64_t>(integer_value(value, 1, kLargest)); },
     [](const Job& job) -> JobValue { return count_of(job.input.every); },
     {.least = 1}},

    {"input", "keep_strays", T::kFlag, "true or false", {},
     "keep points that are no measurements: no-data values, missing returns at (0, 0, 0), strays far from all other points", "keep-strays", "true",
     [](Job& job, const W& value) { job.input.keep_strays = flag_value(value); },
     [](const Job& job) -> JobValue { return job.input.keep_strays; }},
    {"input", "units_per_meter", T::kNumber, "\"auto\" or a number from 1e-75 to 1e75", {},
     "units of the scan in one metre, such as 1000 for millimetres; auto takes the unit of the coordinate system; used by checks and reports only", "units-per-meter", "",
     set_units_per_meter,
     [](const Job& job) -> JobValue { return auto_or(job.input.units_per_meter); },
     {.least = kLeastScale, .most = kMostScale, .words = kAuto}},

    {"partition", "memory", T::kBytes, "a quantity such as \"4GiB\", or a number of bytes, at least 64MiB", {},
     "memory budget of the whole process, such as 4GiB; at least 64MiB", "memory", "",
     [](Job& job, const W& value) { job.partition.memory_bytes = bytes_value(value, kLeastMemory); },
     [](const Job& job) -> JobValue { return count_of(job.partition.memory_bytes); },
     {.least = kLeastMemoryBytes}},
    {"partition", "chunk_points", T::kInteger, "\"auto\" or an integer of at least 1", {},
     "maximum number of points of a chunk; auto derives the number from the memory budget", "chunk-points", "",
     set_chunk_points,
     [](const Job& job) -> JobValue { return auto_or(job.partition.chunk_points); },
     {.least = 1, .words = kAuto}},

    {"cleaning", "auto", T::kFlag, "true or false", {},
     "cleaning chosen by measuring the noise of the scan: outliers, smoothing and thinning where the noise exceeds 9 % of the point spacing", "cleaning", "true",
     [](Job& job, const W& value) { job.cleaning.automatic = flag_value(value); },
     [](const Job& job) -> JobValue { return job.cleaning.automatic; }},
    {"cleaning", "outlier_sigma", T::kNumber, "a number of at least 0; 0 is off", {},
     "outlier threshold in standard deviations: drops a point whose mean neighbour distance exceeds its neighbours' mean by more than this; 0 disables it, 4 is typical", "outlier-sigma", "",
     [](Job& job, const W& value) { job.cleaning.outlier_sigma = number_value(value, 0.0, kLargestNumber); },
     [](const Job& job) -> JobValue { return job.cleaning.outlier_sigma; },
     {.least = 0, .most = kLargestNumber}},
    {"cleaning", "merge_tolerance", T::kNumber, "a number of at least 0, in the scan's units; 0 is off", {},
     "distance below which points are merged into one, in scan units; 0 disables merging", "merge-tolerance", "",
     [](Job& job, const W& value) { job.cleaning.merge_tolerance = number_value(value, 0.0, kLargestNumber); },
     [](const Job& job) -> JobValue { return job.cleaning.merge_tolerance; },
     {.least = 0, .most = kLargestNumber}},
    {"cleaning", "smooth_radius", T::kNumber, "a number of at least 0, in the scan's units; 0 is off", {},
     "radius of the moving least squares smoothing, in scan units; 0 disables smoothing, four point spacings are typical", "smooth-radius", "",
     [](Job& job, const W& value) { job.cleaning.smooth_radius = number_value(value, 0.0, kLargestNumber); },
     [](const Job& job) -> JobValue { return job.cleaning.smooth_radius; },
     {.least = 0, .most = kLargestNumber}},
    {"cleaning", "smooth_passes", T::kInteger, "an integer from 1 to 8", {},
     "number of smoothing passes", "smooth-passes", "",
     [](Job& job, const W& value) { job.cleaning.smooth_passes = static_cast<int>(integer_value(value, 1, kMostLevels)); },
     [](const Job& job) -> JobValue { return std::int64_t{job.cleaning.smooth_passes}; },
     {.least = 1, .most = 8}},
    {"cleaning", "thin_to_spacing", T::kNumber, "a number of at least 0, in the scan's units; 0 is off", {},
     "minimum distance between the points that thinning keeps, in scan units; 0 disables thinning", "thin-to-spacing", "",
     [](Job& job, const W& value) { job.cleaning.thin_to_spacing = number_value(value, 0.0, kLargestNumber); },
     [](const Job& job) -> JobValue { return job.cleaning.thin_to_spacing; },
     {.least = 0, .most = kLargestNumber}},
    {"cleaning", "cluster_points", T::kInteger, "\"auto\" or an integer from 0 to 100000; 0 is off", {},
     "drops clusters of fewer points that lie apart from everything else; 0 is off, auto is 0 where cleaning.auto is off", "cluster-points", "",
     set_cluster_points,
     [](const Job& job) -> JobValue { return auto_or(job.cleaning.cluster_points); },
     {.least = 0, .most = 100000, .words = kAuto}},
    {"cleaning", "min_surfaceness", T::kNumber, "a number from 0 to 1; 0 is off", {},
     "drops points whose neighbours lie less like a surface than this: 1 is a surface, 0 a wire or a cloud; 0 is off, 0.15 drops wires and twigs", "min-surfaceness", "",
     [](Job& job, const W& value) { job.cleaning.min_surfaceness = number_value(value, 0.0, 1.0); },
     [](const Job& job) -> JobValue { return job.cleaning.min_surfaceness; },
     {.least = 0, .most = 1}},

    {"normals", "source", T::kChoice, "", kSources,
     "source of the normals; auto estimates normals where a scan has none; poles takes the directions to the poles of the Voronoi cells, which holds the whole cloud in memory and is there where the program was built with CGAL", "normals", "",
     [](Job& job, const W& value) { job.normals.source = static_cast<NormalSource>(choice_value(value, kSources)); },
     [](const Job& job) -> JobValue { return name_in(kSources, job.normals.source); }},
    {"normals", "neighbors", T::kInteger, "an integer from 3 to 256", {},
     "number of neighbours that a normal is estimated from", "neighbors", "",
     [](Job& job, const W& value) { job.normals.neighbors = static_cast<int>(integer_value(value, 3, 256)); },
     [](const Job& job) -> JobValue { return std::int64_t{job.normals.neighbors}; },
     {.least = 3, .most = 256}},
    {"normals", "orientation", T::kChoice, "", kOrientations,
     "rule that orients estimated normals; auto takes scanner, viewpoint, up or propagate, the first that is known; ground is for scenes: scanner, viewpoint, or propagate with the ground turned up; inward is for rooms: propagate, but closed surfaces point inward", "orientation", "",
     [](Job& job, const W& value) { job.normals.orientation = static_cast<Orientation>(choice_value(value, kOrientations)); },
     [](const Job& job) -> JobValue { return name_in(kOrientations, job.normals.orientation); }},
    {"normals", "viewpoint", T::kNumbers, "\"auto\" or three numbers [x, y, z]", {},
     "position x,y,z that normals point towards", "viewpoint", "",
     [](Job& job, const W& value) { job.normals.viewpoint = optional_vector(value); },
     [](const Job& job) -> JobValue { return auto_or(job.normals.viewpoint); },
     {.words = kAuto, .lengths = kAxes}},
    {"normals", "up", T::kNumbers, "\"auto\" or three numbers [x, y, z]", {},
     "direction x,y,z on whose side normals point", "up", "",
     [](Job& job, const W& value) { set_direction(job.normals.up, value); },
     [](const Job& job) -> JobValue { return auto_or(job.normals.up); },
     {.words = kAuto, .lengths = kAxes}},

    {"reconstruct", "method", T::kChoice, "", kMethods,
     "reconstruction method; all but ball_pivoting are there where the program was built with CGAL, and hold the whole cloud in memory; super_cocone, and cocone beyond the memory budget, go chunk by chunk", "method", "",
     [](Job& job, const W& value) { job.reconstruct.method = static_cast<ReconstructionMethod>(choice_value(value, kMethods)); },
     [](const Job& job) -> JobValue { return name_in(kMethods, job.reconstruct.method); }},
    {"reconstruct", "ball_radii", T::kNumbers, "\"auto\" or positive numbers in ascending order such as [0.0015, 0.003]", {},
     "ball radii in ascending order, in scan units, such as 0.0015,0.003; auto measures the point spacing", "ball-radii", "",
     set_radii,
     [](const Job& job) -> JobValue { return auto_or(job.reconstruct.ball_radii); },
     {.least = kLeastBallRadius, .most = kMostBallRadius, .words = kAuto, .least_length = 1}},
    {"reconstruct", "levels", T::kInteger, "\"auto\" or an integer from 1 to 8", {},
     "number of automatic ball radii, 1 to 8; auto derives the number from the density", "levels", "",
     [](Job& job, const W& value) { job.reconstruct.levels = is_auto(value) ? 0 : static_cast<int>(integer_value(value, 1, kMostLevels)); },
     [](const Job& job) -> JobValue { return auto_or(static_cast<std::uint64_t>(job.reconstruct.levels)); },
     {.least = 1, .most = kMostLevels, .words = kAuto}},

    {"fill", "enabled", T::kFlag, "true or false", {},
     "fill holes", "no-fill", "false",
     [](Job& job, const W& value) { job.fill.enabled = flag_value(value); },
     [](const Job& job) -> JobValue { return job.fill.enabled; }},
    {"fill", "kernel", T::kChoice, "", kKernels,
     "radial basis function of the patches", "kernel", "",
     [](Job& job, const W& value) { job.fill.kernel = static_cast<FillKernel>(choice_value(value, kKernels)); },
     [](const Job& job) -> JobValue { return name_in(kKernels, job.fill.kernel); }},
    {"fill", "neighborhood", T::kNumber, "a number of at least 1", {},
     "radius of the neighbourhood that shapes a patch, in radii of the hole", "neighborhood", "",
     [](Job& job, const W& value) { job.fill.neighborhood = number_value(value, 1.0, kLargestNumber); },
     [](const Job& job) -> JobValue { return job.fill.neighborhood; },
     {.least = 1, .most = kLargestNumber}},
    {"fill", "max_diameter", T::kNumber, "\"auto\", a positive number, or inf for no limit", {},
     "maximum diameter of a hole to fill, in scan units; inf sets no limit; auto leaves wide gaps of open scenes open", "max-diameter", "",
     [](Job& job, const W& value) {
       job.fill.max_diameter.reset();
       if (!is_auto(value)) job.fill.max_diameter = limit_value(value);
     },
     [](const Job& job) -> JobValue { return auto_or(job.fill.max_diameter); },
     {.least = 0, .is_above = true, .words = kAuto}},
    {"fill", "max_perimeter", T::kNumber, "a positive number, or inf for no limit", {},
     "maximum perimeter of a hole to fill, in scan units; inf sets no limit", "max-perimeter", "",
     [](Job& job, const W& value) { job.fill.max_perimeter = limit_value(value); },
     [](const Job& job) -> JobValue { return job.fill.max_perimeter; },
     {.least = 0, .is_above = true}},
    {"fill", "max_edges", T::kInteger, "an integer of at least 0", {},
     "maximum number of edges of a hole to fill; 0 sets no limit", "max-edges", "",
     [](Job& job, const W& value) { job.fill.max_edges = count_value(value); },
     [](const Job& job) -> JobValue { return count_of(job.fill.max_edges); },
     {.least = 0}},
    {"fill", "keep_outer_border", T::kFlag, "true or false", {},
     "leave the outer border of an open sheet open", "close-outer-border", "false",
     [](Job& job, const W& value) { job.fill.keep_outer_border = flag_value(value); },
     [](const Job& job) -> JobValue { return job.fill.keep_outer_border; }},
    {"fill", "allow_intersections", T::kFlag, "true or false", {},
     "use a patch that intersects the surface where no other patch exists", "allow-intersections", "true",
     [](Job& job, const W& value) { job.fill.allow_intersections = flag_value(value); },
     [](const Job& job) -> JobValue { return job.fill.allow_intersections; }},
    {"fill", "graded", T::kFlag, "true or false", {},
     "let the triangles of a large patch grow with the distance from its rim", "uniform-patches", "false",
     [](Job& job, const W& value) { job.fill.graded = flag_value(value); },
     [](const Job& job) -> JobValue { return job.fill.graded; }},
    {"fill", "min_triangles", T::kInteger, "\"auto\" or an integer of at least 0", {},
     "minimum number of triangles of a component; smaller components are removed; 0 removes none", "min-triangles", "",
     [](Job& job, const W& value) {
       job.fill.min_triangles.reset();
       if (!is_auto(value)) job.fill.min_triangles = count_value(value);
     },
     [](const Job& job) -> JobValue { return auto_or(job.fill.min_triangles); },
     {.least = 0, .words = kAuto}},

    {"output", "mesh", T::kPath, "a path that ends in .ply, .obj, .stl, .glb, .vtp or .xdmf", {},
     "mesh to write: .ply (also .ply.gz), .obj, .stl, .glb, .vtp or .xdmf", "output", "",
     [](Job& job, const W& value) { job.output.mesh = path_value(value); },
     [](const Job& job) -> JobValue { return job.output.mesh; }},
    {"output", "format", T::kChoice, "", kFormats,
     "encoding of the mesh; auto is binary where the format has a binary encoding", "format", "",
     set_format,
     [](const Job& job) -> JobValue { return format_text(job.output); }},
    {"output", "precision", T::kChoice, "", kPrecisions,
     "type of the coordinates in the mesh", "precision", "",
     [](Job& job, const W& value) { job.output.float_positions = choice_value(value, kPrecisions) == 1; },
     [](const Job& job) -> JobValue { return std::string(job.output.float_positions ? "float" : "double"); }},
    {"output", "origin", T::kNumbers, "\"auto\", \"none\" or a list of three numbers", {},
     "where the mesh file counts coordinates from: auto shifts them where 4-byte numbers (STL, GLB, precision float) would move a vertex by a thousandth of the spacing; none refuses that", "origin", "",
     set_origin, origin_value,
     {.words = kAutoOrNone, .lengths = kAxes}},
    {"output", "colors", T::kInteger, "8 or 16", {},
     "bits of red, green and blue of the vertices: 8, which other programs show, or 16, as 16-bit scans have them", "colors", "",
     set_colors, [](const Job& job) -> JobValue { return std::int64_t{job.output.color_bits}; },
     {.values = kColorBits}},
    {"output", "attributes", T::kFlag, "true or false", {},
     "carry normals, colours and other attributes to the vertices", "no-attributes", "false",
     [](Job& job, const W& value) { job.output.attributes = flag_value(value); },
     [](const Job& job) -> JobValue { return job.output.attributes; }},
    {"output", "confidence", T::kFlag, "true or false", {},
     "write the confidence of each face (PLY): 1 of scanned faces, from 0 to 1 of filled holes", "confidence", "true",
     [](Job& job, const W& value) { job.output.confidence = flag_value(value); },
     [](const Job& job) -> JobValue { return job.output.confidence; }},
    {"output", "vertex_quality", T::kFlag, "true or false", {},
     "write the quality of each vertex (PLY): spacing, noise, distance moved by cleaning, origin of the normal", "vertex-quality", "true",
     [](Job& job, const W& value) { job.output.vertex_quality = flag_value(value); },
     [](const Job& job) -> JobValue { return job.output.vertex_quality; }},
    {"output", "vertex_undersampled", T::kFlag, "true or false", {},
     "write where the scan is too sparse for its shape (PLY, of cocone and tight_cocone): undersampled is 1 there, 0 elsewhere, 255 at vertices of patches", "vertex-undersampled", "true",
     [](Job& job, const W& value) { job.output.vertex_undersampled = flag_value(value); },
     [](const Job& job) -> JobValue { return job.output.vertex_undersampled; }},
    {"output", "check_surface", T::kFlag, "true or false", {},
     "count the pairs of triangles that cross in the whole mesh, not only those with a patch", "check-surface", "true",
     [](Job& job, const W& value) { job.output.check_surface = flag_value(value); },
     [](const Job& job) -> JobValue { return job.output.check_surface; }},
    {"output", "tiles", T::kFlag, "true or false", {},
     "write tiles with shared border vertices, one per chunk or per cell of tile_size, instead of one mesh", "tiles", "true",
     [](Job& job, const W& value) { job.output.tiles = flag_value(value); },
     [](const Job& job) -> JobValue { return job.output.tiles; }},
    {"output", "tile_size", T::kNumber, "0 or a number from 1e-9 to 1e12", {},
     "edge of the tiles' square cells in x and y, in scan units, such as 500: each tile holds the triangles whose centroid is in its cell; 0 makes a tile per chunk; needs tiles", "tile-size", "",
     set_tile_size,
     [](const Job& job) -> JobValue { return job.output.tile_size; },
     {.least = kLeastTileSize, .most = kLargestTileSize, .has_zero = true}},
    {"output", "tileset", T::kDirectory, "a path, or \"\" for none", {},
     "directory to write levels of detail of the mesh to, as 3D Tiles 1.1; the mesh is a .ply file then", "tileset", "",
     [](Job& job, const W& value) { job.output.tileset = path_value(value); },
     [](const Job& job) -> JobValue { return job.output.tileset; }},
    {"output", "tileset_compression", T::kChoice, "", kTileCompressions,
     "compression of the tileset's tiles: none, or meshopt (EXT_meshopt_compression, without loss)", "tileset-compression", "",
     [](Job& job, const W& value) { job.output.tileset_compression = static_cast<TileCompression>(choice_value(value, kTileCompressions)); },
     [](const Job& job) -> JobValue { return name_in(kTileCompressions, job.output.tileset_compression); }},
    {"output", "simplify", T::kSimplification, "\"ratio=R\" (0 < R <= 1), \"triangles=N\", \"error=E\" in scan units, a table such as {ratio = 0.1}, or \"\" for none", {},
     "write a simplified mesh, too: with at most a share of the triangles, at most so many, or within a distance of the mesh; the mesh is a .ply file then", "simplify", "",
     set_simplify,
     simplify_value},
    {"output", "simplified", T::kPath, "a path, or \"\" for the mesh's name with .simplified.ply", {},
     "the simplified mesh to write; the default is the name of the mesh with .simplified.ply", "simplified", "",
     [](Job& job, const W& value) { job.output.simplified = path_value(value); },
     [](const Job& job) -> JobValue { return job.output.simplified; }},
    {"output", "polygons", T::kPath, "a path, or \"\" for none", {},
     "file to write the polygons of a Power Crust to (.ply or .obj); the mesh has them cut into triangles", "polygons", "",
     [](Job& job, const W& value) { job.output.polygons = path_value(value); },
     [](const Job& job) -> JobValue { return job.output.polygons; }},
    {"output", "medial_axis", T::kPath, "a path, or \"\" for none", {},
     "file to write the medial axis of a Power Crust to (.ply): the centres of its inner balls, with their radii", "medial-axis", "",
     [](Job& job, const W& value) { job.output.medial_axis = path_value(value); },
     [](const Job& job) -> JobValue { return job.output.medial_axis; }},
    {"output", "report", T::kPath, "a path, or \"\" for none", {},
     "report to write (JSON); a page for reading (HTML) is written beside it", "report", "",
     [](Job& job, const W& value) { job.output.report = path_value(value); },
     [](const Job& job) -> JobValue { return job.output.report; }},
    {"output", "picture", T::kPath, "a path, or \"\" for none", {},
     "picture of the mesh to write (PNG)", "picture", "",
     [](Job& job, const W& value) { job.output.picture = path_value(value); },
     [](const Job& job) -> JobValue { return job.output.picture; }},
    {"output", "picture_up", T::kChoice, "", kUpAxes,
     "axis that is upright in the picture; auto takes normals.up, what the scans imply, or the shape", "picture-up", "",
     [](Job& job, const W& value) { job.output.picture_up = static_cast<UpAxis>(choice_value(value, kUpAxes)); },
     [](const Job& job) -> JobValue { return name_in(kUpAxes, job.output.picture_up); }},
    {"output", "picture_colors", T::kChoice, "", kPictureColors,
     "what the colours of the picture tell: patches (filled holes), confidence (doubtful patches are orange), points (colours of the scan, else its intensity as grey), component (one colour for each) or undersampled (of cocone and tight_cocone: orange where the scan is too sparse for its shape)", "picture-colors", "",
     [](Job& job, const W& value) { job.output.picture_colors = static_cast<PictureColors>(choice_value(value, kPictureColors)); },
     [](const Job& job) -> JobValue { return name_in(kPictureColors, job.output.picture_colors); }},
    {"output", "picture_backs", T::kChoice, "", kPictureBacks,
     "back faces in the picture; auto leaves them out where scanners stood inside the mesh", "picture-backs", "",
     [](Job& job, const W& value) { job.output.picture_backs = static_cast<PictureBacks>(choice_value(value, kPictureBacks)); },
     [](const Job& job) -> JobValue { return name_in(kPictureBacks, job.output.picture_backs); }},
    {"output", "patch_color", T::kColor, "a colour such as \"#4477cc\"", {},
     "colour of filled holes in the picture", "patch-color", "",
     [](Job& job, const W& value) { job.output.patch_color = color_value(value); },
     [](const Job& job) -> JobValue { return color_text(job.output.patch_color); }},

    {"run", "threads", T::kInteger, "an integer from 0 (all) to 4096", {},
     "number of threads; 0 uses all cores", "threads", "",
     [](Job& job, const W& value) { job.run.threads = static_cast<int>(integer_value(value, 0, kMostThreads)); },
     [](const Job& job) -> JobValue { return std::int64_t{job.run.threads}; },
     {.least = 0, .most = kMostThreads}},
    {"run", "work_dir", T::kDirectory, "a path, or \"\" for the mesh's name with .work", {},
     "work directory that an interrupted run resumes from; the default is the name of the mesh with .work", "work-dir", "",
     [](Job& job, const W& value) { job.run.work_dir = path_value(value); },
     [](const Job& job) -> JobValue { return job.run.work_dir; }},
    {"run", "keep_work_dir", T::kFlag, "true or false", {},
     "keep the work directory after the run", "keep-work-dir", "true",
     [](Job& job, const W& value) { job.run.keep_work_dir = flag_value(value); },
     [](const Job& job) -> JobValue { return job.run.keep_work_dir; }},
    {"run", "compress", T::kFlag, "true or false", {},
     "compress the work directory: less space, more time", "compress", "true",
     [](Job& job, const W& value) { job.run.compress = flag_value(value); },
     [](const Job& job) -> JobValue { return job.run.compress; }},
};
// clang-format on

constexpr std::string_view kCleaning = "cleaning";
/// Job files and work directories of earlier versions call the section by this name.
constexpr std::string_view kFormerCleaning = "prepare";
constexpr FormerSection kFormerSections[] = {{kFormerCleaning, kCleaning}};

/// "from.key" as "to.key"; other names stay.
std::string renamed_section(std::string_view name, std::string_view from, std::string_view to) {
  const bool is_of_it = name.starts_with(from) && name.substr(from.size()).starts_with('.');
  return is_of_it ? std::string(to) + std::string(name.substr(from.size())) : std::string(name);
}

/// A TOML basic string.
std::string quoted(const std::string& text) {
  constexpr const char* kHex = "0123456789ABCDEF";
  std::string quoted_text = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted_text += std::string("\\") + c;
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted_text += std::string("\\u00") + kHex[byte >> 4] + kHex[byte & 15];
    } else {
      quoted_text += c;
    }
  }
  return quoted_text + "\"";
}

/// TOML tells numbers from integers by the point.
std::string number_text(double value) {
  const std::string text = format_exact(value);
  return text.find_first_of(".eni") == std::string::npos ? text + ".0" : text;
}

struct TextOf {
  JobKeyType type;
  std::string operator()(bool flag) const { return flag ? "true" : "false"; }
  std::string operator()(std::int64_t integer) const {
    if (type != JobKeyType::kBytes) return std::to_string(integer);
    const std::string text = exact_bytes(static_cast<std::uint64_t>(integer));
    return text.ends_with("B") ? quoted(text) : text;
  }
  std::string operator()(double number) const { return number_text(number); }
  std::string operator()(const std::string& text) const { return quoted(text); }
  std::string operator()(const std::vector<double>& numbers) const {
    std::string text;
    for (const double number : numbers) text += (text.empty() ? "" : ", ") + number_text(number);
    return "[" + text + "]";
  }
  std::string operator()(const std::vector<std::string>& texts) const {
    std::string joined;
    for (const std::string& text : texts) joined += (joined.empty() ? "" : ", ") + quoted(text);
    return "[" + joined + "]";
  }
};

}  // namespace

std::span<const JobKey> job_keys() { return kKeys; }

std::span<const FormerSection> former_sections() { return kFormerSections; }

std::string_view current_section(std::string_view section) {
  return section == kFormerCleaning ? kCleaning : section;
}

std::string current_key_name(std::string_view name) {
  return renamed_section(name, kFormerCleaning, kCleaning);
}

std::string stored_key_name(std::string_view name) {
  return renamed_section(name, kCleaning, kFormerCleaning);
}

std::string JobKey::expected() const {
  std::string text;
  for (std::size_t i = 0; i < choices.size(); ++i)
    text += std::string(i == 0                    ? "\""
                        : i + 1 == choices.size() ? " or \""
                                                  : ", \"") +
            choices[i] + "\"";
  return choices.empty() ? range : text;
}

std::string JobKey::default_text() const {
  const JobValue value = get(Job{});
  const auto* const numbers = std::get_if<std::vector<double>>(&value);
  if (numbers == nullptr || !limits.is_whole) return value_text(value, type);
  std::string text;
  for (const double number : *numbers) text += (text.empty() ? "" : ", ") + format_exact(number);
  return "[" + text + "]";
}

const char* type_name(JobKeyType type) {
  switch (type) {
    case JobKeyType::kTexts:
      return "list of texts";
    case JobKeyType::kPath:
    case JobKeyType::kDirectory:
      return "path";
    case JobKeyType::kPaths:
      return "list of paths";
    case JobKeyType::kFlag:
      return "true or false";
    case JobKeyType::kChoice:
      return "name";
    case JobKeyType::kInteger:
      return "integer";
    case JobKeyType::kBytes:
      return "bytes";
    case JobKeyType::kNumber:
      return "number";
    case JobKeyType::kNumbers:
      return "list of numbers";
    case JobKeyType::kColor:
      return "colour";
    case JobKeyType::kSimplification:
      return "limit of a simplification";
  }
  return "";
}

std::string value_text(const JobValue& value, JobKeyType type) {
  return std::visit(TextOf{type}, value);
}

}  // namespace orbweave
