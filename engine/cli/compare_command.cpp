// orbweave compare: whether two meshes are the same, and how far apart they are if not.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/cli/commands.h"
#include "engine/cli/json_text.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/validation/compare.h"
#include "io/meshes/mesh_reader.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

struct CompareArguments {
  std::string a;
  std::string b;
  bool json = false;
};

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
                    {"b_to_a", distance_json(found.b_to_a)}});
}

std::string verdict(const MeshComparison& found) {
  if (found.identical) return "same: the same vertices and triangles in the same order\n";
  if (found.same_surface) return "same surface: the same triangles, in another order\n";
  return "different\n";
}

std::string comparison_text(const CompareArguments& files, const MeshComparison& found) {
  if (found.identical) return verdict(found);
  return verdict(found) + "\n" +
         table({{"", "A", "B"},
                {"file", files.a, files.b},
                {"vertices", format_count(found.vertices_a), format_count(found.vertices_b)},
                {"triangles", format_count(found.triangles_a), format_count(found.triangles_b)},
                {"checksum", found.checksum_a, found.checksum_b}}) +
         "\n" + distance_table({{"A to B", found.a_to_b}, {"B to A", found.b_to_a}});
}

void compare(const CompareArguments& files) {
  end_at_once_on_signals();
  const MeshComparison found = compare_meshes(read_mesh(files.a), read_mesh(files.b));
  std::cout << (files.json ? comparison_json(files, found) : comparison_text(files, found));
}

}  // namespace

void add_compare_command(CLI::App& program, const CommandContext& context) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = program.add_subcommand(
      "compare", "Compare two meshes: same or not, how far apart, how many triangles");
  command->add_option("A", arguments->a, "A mesh")->type_name("")->required();
  command->add_option("B", arguments->b, "Another mesh")->type_name("")->required();
  command->add_flag("--json", arguments->json, "Print JSON");
  command->footer(
      "Distances are from the vertices of one mesh to the surface of the other. The first word\n"
      "printed is \"same\" or \"different\"; the exit status is 0 for both.\n\n"
      "Example:\n  orbweave compare mesh.ply truth.ply\n");
  command->callback([arguments, context] { context.then([arguments] { compare(*arguments); }); });
}

}  // namespace orbweave
