// What the tests of readers and writers share: files made of strings, and clouds read back.
#pragma once

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/points/point_source.h"
#include "io/streams/byte_sink.h"

namespace orbweave::test {

inline void write_file(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

inline void gzip_file(const std::filesystem::path& path, const std::string& content) {
  const auto sink = open_byte_sink(path);
  sink->write(std::string_view(content));
  sink->finish();
}

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline PointCloud read_cloud(const std::filesystem::path& path,
                             const PointSourceOptions& options = {}) {
  return read_all(*open_point_source(path, options));
}

/// The Error that reading a cloud throws; kind kNone where it throws none.
inline Error reading_error(const std::filesystem::path& path,
                           const PointSourceOptions& options = {}) {
  try {
    read_cloud(path, options);
  } catch (const Error& error) {
    return error;
  }
  return Error(ErrorKind::kNone, "");
}

/// Same schema, same bits (NaN included).
inline bool same_bits(const PointCloud& a, const PointCloud& b) {
  const auto equal = [](const std::vector<Vec3>& p, const std::vector<Vec3>& q) {
    return p.size() == q.size() &&
           (p.empty() || std::memcmp(p.data(), q.data(), p.size() * sizeof(Vec3)) == 0);
  };
  return a.schema == b.schema && equal(a.positions, b.positions) && equal(a.normals, b.normals) &&
         a.attributes == b.attributes;
}

/// "intensity", "red", ...
inline std::vector<std::string> attribute_names(const PointSchema& schema) {
  std::vector<std::string> names;
  for (const AttributeField& field : schema.attributes) names.push_back(field.name);
  return names;
}

/// "intensity uint16", "red uint8", ...
inline std::vector<std::string> typed_names(const PointSchema& schema) {
  std::vector<std::string> names;
  for (const AttributeField& field : schema.attributes)
    names.push_back(field.name + " " + name_of(field.type));
  return names;
}

/// Place of an attribute. Throws where there is none of this name.
inline std::size_t field_of(const PointSchema& schema, const std::string& name) {
  for (std::size_t i = 0; i < schema.attributes.size(); ++i)
    if (schema.attributes[i].name == name) return i;
  throw std::out_of_range("no attribute " + name);
}

inline double value_of(const PointCloud& cloud, std::size_t point, const std::string& name) {
  return attribute_value(cloud, point, field_of(cloud.schema, name));
}

inline double sum_of(const PointCloud& cloud, const std::string& name) {
  const std::size_t field = field_of(cloud.schema, name);
  double sum = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) sum += attribute_value(cloud, i, field);
  return sum;
}

/// The bytes of a value, in the machine's order or turned around.
template <class T>
std::string raw(T value, bool turned = false) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return turned ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

}  // namespace orbweave::test
