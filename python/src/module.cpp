// The module orbweave._orbweave: what the package orbweave (python/orbweave) calls.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "engine/reconstruct.h"
#include "engine/validation/mesh_facts.h"
#include "io/clouds/open_point_source.h"
#include "io/clouds/scan_source.h"
#include "io/error.h"
#include "io/job/job_defaults.h"
#include "io/job/output_origin.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/shift_file.h"
#include "io/points/coordinate_system_file.h"
#include "io/shown_text.h"
#include "io/text/quantity.h"
#include "python/src/arrays.h"
#include "python/src/errors.h"
#include "python/src/job_calls.h"
#include "python/src/objects.h"
#include "python/src/others_may_run.h"
#include "python/src/watched_call.h"

namespace py = pybind11;

namespace orbweave::python {
namespace {

ReconstructionOptions options_of(const Settings& settings, WatchedCall& call) {
  Job job;
  apply(job, settings);
  ReconstructionOptions options;
  options.ball_radii = job.reconstruct.ball_radii;
  options.levels = job.reconstruct.levels;
  options.normals = job.normals;
  options.fill = job.fill;
  options.keep_strays = job.input.keep_strays;
  options.threads = job.run.threads;
  options.progress = [&call](std::string_view stage, double done) {
    call.tell(std::string(stage), done);
  };
  options.stop = &call.stop();
  return options;
}

std::unique_ptr<MeshObject> object_of(Reconstruction result) {
  return std::make_unique<MeshObject>(MeshObject{std::move(result.mesh),
                                                 std::move(result.holes),
                                                 std::move(result.ball_radii),
                                                 std::move(result.dropped),
                                                 {}});
}

/// A place for each of so many points, from an array of as many, or of one for all of them.
struct Scanners {
  Rows given;
  std::vector<Vec3> repeated;  ///< the one place, where there is one

  std::span<const Vec3> rows() const { return repeated.empty() ? given.rows : repeated; }
};

Scanners scanners_of(const py::object& values, std::size_t points) {
  Scanners scanners;
  if (values.is_none()) return scanners;
  scanners.given = rows_of(values, "scanners");
  const std::size_t places = scanners.given.rows.size();
  // None of them would tell the library that nothing is known.
  if (places == 0 && points > 0)
    throw_usage("there are no places of scanners",
                {.place = "scanners",
                 .found = "shape (0, 3)",
                 .expected = "one for each point, one for all, or None"});
  if (places == 1 && points > 1) scanners.repeated.assign(points, scanners.given.rows[0]);
  return scanners;
}

/// Points of the caller's arrays are read where they lie.
std::unique_ptr<MeshObject> reconstruct_arrays(const py::object& points, const py::object& normals,
                                               const py::object& scanners, const Settings& settings,
                                               const py::object& progress) {
  const Rows positions = rows_of(points, "points");
  Rows given;
  if (!normals.is_none()) {
    given = rows_of(normals, "normals");
    // None of them would tell the library to estimate all.
    if (given.rows.empty() && !positions.rows.empty())
      throw_usage(
          "there are no normals",
          {.place = "normals", .found = "shape (0, 3)", .expected = "as many as points, or None"});
  }
  const Scanners places = scanners_of(scanners, positions.rows.size());
  WatchedCall call(progress);
  ReconstructionOptions options = options_of(settings, call);
  options.scanners = places.rows();
  Reconstruction result;
  if (given.are_floats) {  // spans hold doubles alone
    PointCloud cloud = cloud_of(positions, given);
    call.run([&] { result = reconstruct(std::move(cloud), options); });
  } else {
    call.run([&] { result = reconstruct(positions.rows, given.rows, options); });
  }
  return object_of(std::move(result));
}

std::unique_ptr<MeshObject> reconstruct_cloud(const CloudObject& cloud, const py::object& scanners,
                                              const Settings& settings,
                                              const py::object& progress) {
  const Scanners places = scanners_of(scanners, cloud.cloud.size());
  WatchedCall call(progress);
  ReconstructionOptions options = options_of(settings, call);
  options.scanners = places.rows();
  Reconstruction result;
  call.run([&] { result = reconstruct(cloud.cloud, options); });
  std::unique_ptr<MeshObject> object = object_of(std::move(result));
  object->coordinate_system = cloud.coordinate_system;
  return object;
}

/// Warns of what a file holds and the object that was read has no place for.
void warn_of_left_out(const std::string& path, const std::vector<std::string>& left_out) {
  std::string text;
  for (const std::string& what : left_out) text += (text.empty() ? "" : "; ") + shown(what);
  if (!text.empty()) warn_of(shown(path) + ": not carried over: " + text);
}

/// Warns of places of scanners, which turn the normals that a cloud lacks the right way.
void warn_of_scanners(const std::string& path, const std::vector<ScannerPlace>& places) {
  if (places.empty()) return;
  const std::string what =
      places.size() > 1 ? "the places of " + format_count(places.size()) +
                              " scanners; orbweave.run() turns normals towards them"
                        : "the place of the scanner; reconstruct(cloud, scanners=[[" +
                              origin_text(places.front().vector) + "]]) turns normals towards it";
  warn_of(shown(path) + ": not carried over: " + what);
}

std::unique_ptr<CloudObject> read_points(const std::string& path) {
  auto object = std::make_unique<CloudObject>();
  std::vector<std::string> left_out;
  std::vector<ScannerPlace> places;
  WatchedCall call(py::none{});
  call.run([&] {
    const auto source = open_scan_source(
        open_point_source(path, {.text = {}, .stop = &call.stop()}), {.stop = &call.stop()}, path);
    object->cloud = read_all(*source);
    object->coordinate_system = source->coordinate_system();
    left_out = not_read(source->facts());
    if (!object->cloud.schema.has_normals) places = scanner_places(*source);
  });
  warn_of_left_out(path, left_out);
  warn_of_scanners(path, places);
  return object;
}

std::unique_ptr<MeshObject> read_mesh_file(const std::string& path) {
  auto object = std::make_unique<MeshObject>();
  std::vector<std::string> left_out;
  WatchedCall call(py::none{});
  call.run([&] {
    object->mesh = read_mesh(path, &left_out, &call.stop());
    object->coordinate_system = coordinate_system_beside(path);
  });
  warn_of_left_out(path, left_out);
  return object;
}

/// Three finite numbers of anything that Python iterates over.
Vec3 origin_of(const py::object& given) {
  std::vector<double> numbers;
  try {
    for (const py::handle number : given) numbers.push_back(number.cast<double>());
  } catch (const py::cast_error&) {
    numbers.clear();
  } catch (const py::error_already_set& raised) {
    pass_on_unless_about_value(raised);
    numbers.clear();
  }
  if (numbers.size() == 3 && is_finite(Vec3{numbers[0], numbers[1], numbers[2]}))
    return {numbers[0], numbers[1], numbers[2]};
  throw_usage("origin has an unsuitable value", {.place = "origin",
                                                 .found = py::repr(given).cast<std::string>(),
                                                 .expected = "three finite numbers x, y, z"});
}

MeshWriterOptions writer_options(bool binary, bool float_positions, const py::object& origin) {
  MeshWriterOptions options;
  options.binary = binary;
  options.float_positions = float_positions;
  options.origin = origin_of(origin);
  return options;
}

/// Whether floats hold each coordinate as it is.
bool are_floats(const PointCloud& points) {
  return std::ranges::all_of(points.positions, [](Vec3 p) {
    return p == Vec3{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  });
}

/// Refuses an origin so far away that the numbers of the file would move the points. `spacing`: of
/// the points, 0 where it is not known.
void check_origin(const std::string& path, const MeshWriterOptions& options,
                  const PointCloud& points, const std::function<double()>& spacing) {
  if (points.empty()) return;
  const bool floats = has_float_coordinates(path, options);
  if (options.origin == Vec3{} && (!floats || are_floats(points))) return;
  Job job;
  job.output.mesh = path;
  job.output.origin_rule = OriginRule::kGiven;
  job.output.origin = options.origin;
  OutputOrigin chosen = output_origin(job.output, floats, points.bounds(), spacing());
  // Points at one place have no extent: their coordinates take its part.
  if (chosen.extent == 0.0) chosen.extent = norm(points.positions.front());
  try {
    check_output_origin(job, chosen);
  } catch (const Error& error) {
    ErrorParts parts = error.parts();
    parts.place = "origin";
    parts.advice = "An origin among the points keeps their coordinates.";
    throw Error(error.kind(), error.problem(), std::move(parts));
  }
}

/// The origin and the coordinate system of a file that was written, beside it. `what`: "the mesh".
void write_beside(const std::string& path, const std::string& what, const std::string& system,
                  Vec3 origin) {
  std::vector<std::string> doubts;
  {
    const OthersMayRun others_may_run;
    write_shift(path, origin);
    doubts = doubts_of_written_system(path, what, system, write_coordinate_system(path, system));
  }
  for (const std::string& doubt : doubts) warn_of(doubt);
}

void write_mesh_file(const std::string& path, const MeshObject& object, bool binary,
                     bool float_positions, const py::object& origin) {
  const MeshWriterOptions options = writer_options(binary, float_positions, origin);
  {
    const OthersMayRun others_may_run;
    check_origin(path, options, object.mesh.vertices, [&] { return vertex_spacing(object.mesh); });
    write_mesh(path, object.mesh, options);
  }
  write_beside(path, "the mesh", object.coordinate_system, options.origin);
}

void write_cloud_file(const std::string& path, const CloudObject& object, bool binary,
                      bool float_positions, const py::object& origin) {
  const MeshWriterOptions options = writer_options(binary, float_positions, origin);
  {
    const OthersMayRun others_may_run;
    check_origin(path, options, object.cloud, [] { return 0.0; });
    write_cloud(path, object.cloud, options);
  }
  write_beside(path, "the cloud", object.coordinate_system, options.origin);
}

void add_calls(py::module_& module) {
  module.def("reconstruct_arrays", &reconstruct_arrays, py::arg("points"), py::arg("normals"),
             py::arg("scanners"), py::arg("settings"), py::arg("progress"));
  module.def("reconstruct_cloud", &reconstruct_cloud, py::arg("cloud"), py::arg("scanners"),
             py::arg("settings"), py::arg("progress"));
  module.def("read_points", &read_points, py::arg("path"));
  module.def("read_mesh", &read_mesh_file, py::arg("path"));
  module.def("write_mesh", &write_mesh_file, py::arg("path"), py::arg("mesh"), py::arg("binary"),
             py::arg("float_positions"), py::arg("origin"));
  module.def("write_points", &write_cloud_file, py::arg("path"), py::arg("cloud"),
             py::arg("binary"), py::arg("float_positions"), py::arg("origin"));
  module.def("job_defaults", &commented_job_file);
}

}  // namespace
}  // namespace orbweave::python

PYBIND11_MODULE(_orbweave, module) {
  module.doc() = "The compiled part of orbweave; programs import orbweave.";
  orbweave::python::translate_errors();
  orbweave::python::wait_for_work_at_exit();
  orbweave::python::add_objects(module);
  orbweave::python::add_calls(module);
  orbweave::python::add_job_calls(module);
  module.attr("__version__") = ORBWEAVE_VERSION;
}
