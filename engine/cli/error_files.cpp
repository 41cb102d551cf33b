#include "engine/cli/error_files.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "engine/cli/mesh_drawing.h"
#include "engine/cli/numbers.h"
#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/shift_file.h"
#include "io/report/output_names.h"
#include "io/shown_text.h"
#include "io/text/file_format.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

/// A sample takes some 100 bytes.
constexpr std::uint64_t kMostSamples = 20'000'000;

/// A vertex that lies on the other surface may have so large a distance to it: some rounding errors
/// of its coordinates.
double rounding_of(const Box& bounds) {
  double largest = 0.0;
  for (int axis = 0; axis < 3 && !bounds.empty(); ++axis)
    largest = std::max({largest, std::abs(bounds.min[axis]), std::abs(bounds.max[axis])});
  return 8.0 * std::numeric_limits<double>::epsilon() * largest;
}

/// The error that 95 of 100 vertices with an error do not exceed; 0 where there is none. Vertices
/// of a mesh that interpolates lie on the points of its cloud.
double usual_error(std::span<const double> errors, double rounding) {
  std::vector<double> finite;
  std::ranges::copy_if(errors, std::back_inserter(finite), [rounding](double error) {
    return std::isfinite(error) && error > rounding;
  });
  if (finite.empty()) return 0.0;
  const auto place = finite.begin() + static_cast<std::ptrdiff_t>((finite.size() - 1) * 95 / 100);
  std::ranges::nth_element(finite, place);
  return *place;
}

void write_with_errors(const std::string& file, TriangleMesh mesh, std::span<const double> errors) {
  PointCloud& vertices = mesh.vertices;
  vertices.schema.attributes = {{"error", ScalarType::kFloat64}};
  vertices.attributes.resize(errors.size() * sizeof(double));
  std::memcpy(vertices.attributes.data(), errors.data(), vertices.attributes.size());
  write_mesh(file, mesh);
  write_shift(file, {});
}

std::string draw_errors(const std::string& file, const TriangleMesh& mesh,
                        std::span<const double> errors, UpAxis up) {
  const double largest = usual_error(errors, rounding_of(mesh.vertices.bounds()));
  std::vector<float> shares;
  shares.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const double error = (errors[t[0]] + errors[t[1]] + errors[t[2]]) / 3.0;
    const double share = largest > 0.0 ? error / largest : 0.0;
    shares.push_back(std::isfinite(share) ? static_cast<float>(std::min(share, 1.0)) : 1.0F);
  }
  if (!(largest > 0.0)) {
    draw_mesh_by_shares(mesh, shares, "", file, {.up = up});
    return shown(file) + ": white, there is no error\n";
  }
  draw_mesh_by_shares(mesh, shares, format_number(largest) + " and more", file, {.up = up});
  return shown(file) + ": from white (0) to purple (" + format_number(largest) + " and more)\n";
}

}  // namespace

void add_error_options(CLI::App& command, ErrorFiles& files, const std::string& from,
                       const std::string& to) {
  command
      .add_option("--errors", files.mesh,
                  "Write " + from + " with the distance of each vertex to " + to +
                      " as the property error (PLY)")
      ->type_name("FILE");
  command
      .add_option("--errors-picture", files.picture,
                  "Draw " + from + " in the colours of these distances (PNG)")
      ->type_name("FILE");
}

void add_measure_options(CLI::App& command, CompareOptions& options, const std::string& within) {
  const auto take_distances = [&options](const std::vector<std::string>& distances) {
    options.within.clear();
    for (const std::string& distance : distances)
      options.within.push_back(positive_argument("--within", distance));
  };
  command.add_option_function<std::vector<std::string>>("--within", take_distances, within)
      ->type_name("D,...")
      ->delimiter(',');
  command
      .add_option("--samples", options.area_samples,
                  "Points that are spread over each surface by area (500000)")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{1}, kMostSamples));
}

/// Other formats have no place for a number at each vertex.
void check_error_files(const ErrorFiles& files) {
  check_picture_name(files.picture);
  if (files.mesh.empty()) return;
  const std::optional<NamedFormat> format = format_of_name(files.mesh);
  if (files.mesh == "-" || !format || format->facts.format != FileFormat::kPly)
    throw_usage("--errors writes PLY",
                {.file = files.mesh, .expected = "a name that ends in .ply"});
}

std::vector<PathRole> roles_of(const ErrorFiles& files) {
  return {{"the mesh with errors", files.mesh, PathUse::kWrittenFile},
          {"the picture of errors", files.picture, PathUse::kWrittenFile}};
}

std::string write_errors(const ErrorFiles& files, TriangleMesh mesh, std::span<const double> errors,
                         UpAxis up) {
  std::string line;
  if (!files.picture.empty()) line = draw_errors(files.picture, mesh, errors, up);
  if (!files.mesh.empty()) write_with_errors(files.mesh, std::move(mesh), errors);
  return line;
}

}  // namespace orbweave
