// orbweave compare: whether two meshes are the same, and how far apart they are if not.
#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/cli/commands.h"
#include "engine/cli/error_files.h"
#include "engine/cli/file_kind.h"
#include "engine/cli/files_beside.h"
#include "engine/cli/json_text.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/validation/compare.h"
#include "engine/validation/usable_mesh.h"
#include "engine/validation/usable_scale.h"
#include "io/bounds.h"
#include "io/clouds/open_point_source.h"
#include "io/mesh_size.h"
#include "io/points/coordinate_system_file.h"
#include "io/system/file_descriptor.h"
#include "io/system/path_roles.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

struct CompareArguments {
  std::string a;
  std::string b;
  ErrorFiles errors;
  CompareOptions options;
  bool json = false;
};

Json surface_json(const SurfaceAgreement& surface) {
  if (!surface.measured()) return nullptr;
  return {{"a_to_b", distance_json(surface.a_to_b)}, {"b_to_a", distance_json(surface.b_to_a)},
          {"hausdorff", surface.hausdorff},          {"normal_angle", surface.normal_angle},
          {"opposite_normals", surface.opposite},    {"within", within_json(surface.within)}};
}

std::string comparison_json(const CompareArguments& files, const MeshComparison& found) {
  return json_text({{"identical", found.identical},
                    {"same_surface", found.same_surface},
                    {"a",
                     {{"file", files.a},
                      {"vertices", found.vertices_a},
                      {"triangles", found.triangles_a},
                      {"checksum", found.checksum_a}}},
                    {"b",
                     {{"file", files.b},
                      {"vertices", found.vertices_b},
                      {"triangles", found.triangles_b},
                      {"checksum", found.checksum_b}}},
                    {"a_to_b", distance_json(found.a_to_b)},
                    {"b_to_a", distance_json(found.b_to_a)},
                    {"by_area", surface_json(found.surface)}});
}

/// The surfaces by their areas; empty where one of them is a cloud.
std::string surface_text(const SurfaceAgreement& surface) {
  if (!surface.measured()) return "";
  std::string text =
      "\n" + facts_table({{"Hausdorff distance", format_number(surface.hausdorff)},
                          {"angle of normals", format_number(surface.normal_angle) + " degrees"},
                          {"opposite normals", show_percent(surface.opposite)}});
  return text + within_table(surface.within);
}

std::string verdict(const MeshComparison& found) {
  if (found.identical) return "same: the same vertices and triangles in the same order\n";
  if (found.same_surface) return "same surface: the same triangles, in another order\n";
  return "different\n";
}

/// The checksum is of triangles: that of every cloud is the same.
std::string checksum_text(const std::string& checksum, std::uint64_t triangles) {
  return triangles > 0 ? checksum : "-";
}

std::string comparison_text(const CompareArguments& files, const MeshComparison& found) {
  if (found.identical) return verdict(found);
  std::vector<std::pair<std::string, DistanceSummary>> rows = {{"A to B, vertices", found.a_to_b},
                                                               {"B to A, vertices", found.b_to_a}};
  if (found.surface.measured()) {
    rows.emplace_back("A to B, by area", found.surface.a_to_b);
    rows.emplace_back("B to A, by area", found.surface.b_to_a);
  }
  return verdict(found) + "\n" +
         table({{"", "A", "B"},
                {"file", files.a, files.b},
                {"vertices", format_count(found.vertices_a), format_count(found.vertices_b)},
                {"triangles", format_count(found.triangles_a), format_count(found.triangles_b)},
                {"checksum", checksum_text(found.checksum_a, found.triangles_a),
                 checksum_text(found.checksum_b, found.triangles_b)}}) +
         "\n" + distance_table(rows) + surface_text(found.surface);
}

void check_places(const CompareArguments& files) {
  check_error_files(files.errors);
  std::vector<PathRole> paths = roles_of(files.errors);
  paths.push_back({"the first mesh", files.a, PathUse::kReadFile});
  paths.push_back({"the second mesh", files.b, PathUse::kReadFile});
  check_paths(paths);
  require_once_each(std::array{files.a, files.b});
}

struct Side {
  TriangleMesh mesh;
  std::string coordinate_system;
};

/// A mesh; of a format of clouds the points, which are vertices without triangles.
Side read_side(const std::string& file) {
  if (file == "-" || !is_cloud_only_format(file))
    return {read_usable_mesh(file), coordinate_system_beside(file)};
  const auto source = open_point_source(file);
  TriangleMesh cloud;
  cloud.vertices = read_all(*source);
  require_mesh_in_core(file, cloud.vertices.size(), 0);
  require_usable_scale(file, "cloud", bounds_of_finite(cloud.vertices.positions));
  return {std::move(cloud), source->coordinate_system()};
}

void compare(const CompareArguments& files) {
  end_at_once_on_signals();
  check_places(files);
  warn_of_lost_origins(std::array{files.a, files.b});
  Side a = read_side(files.a);
  const Side b = read_side(files.b);
  warn_of_two_systems(files.a, a.coordinate_system, files.b, b.coordinate_system);
  const MeshComparison found = compare_meshes(a.mesh, b.mesh, files.options);
  std::string colours;
  if (!files.errors.empty()) {
    const std::vector<double> errors = vertex_distances(a.mesh, b.mesh);
    colours = write_errors(files.errors, std::move(a.mesh), errors, UpAxis::kAuto);
  }
  std::cout << (files.json ? comparison_json(files, found)
                           : comparison_text(files, found) + colours);
}

}  // namespace

void add_compare_command(CLI::App& program, const CommandContext& context) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = program.add_subcommand(
      "compare", "Compare two meshes: same or not, how far apart, how many triangles");
  command->add_option("A", arguments->a, "A mesh, or a cloud")->type_name("")->required();
  command->add_option("B", arguments->b, "Another mesh or cloud")->type_name("")->required();
  add_measure_options(*command, arguments->options,
                      "Share of each surface that is at most so far from the other, in the meshes' "
                      "units: precision, recall and F-score, where B is the truth");
  add_error_options(*command, arguments->errors, "A", "B");
  command->add_flag("--json", arguments->json, "Print JSON");
  command->footer(
      "Distances are from the vertices of one mesh, and from points spread over it by area,\n"
      "to the surface of the other. The first word printed is \"same\" or \"different\"; the\n"
      "exit status is 0 for both.\n\n"
      "Example:\n  orbweave compare mesh.ply truth.ply --within 0.01,0.02 --errors errors.ply\n");
  command->callback([arguments, context] { context.then([arguments] { compare(*arguments); }); });
}

}  // namespace orbweave
