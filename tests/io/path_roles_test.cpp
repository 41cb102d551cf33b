// Every pair of a job's paths, in every way in which two paths can be one place or one in another:
// found before any work, with nothing changed on disk.
#include "io/system/path_roles.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <functional>
#include <optional>

#include "engine/pipeline/job_paths.h"
#include "io/error.h"
#include "tests/support/data.h"
#include "tests/support/program.h"
#include "tests/support/snapshot.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using test::ScratchDirectory;
using test::snapshot;
using test::write_text;

namespace {

namespace fs = std::filesystem;

[[maybe_unused]] const bool in_memory = test::scratch_in_memory();

/// A job with every role, each at a place of its own.
class Places {
 public:
  /// `all_there`: outputs and directories are there from an earlier run.
  explicit Places(bool all_there) {
    for (const char* folder : {"in", "out", "other", "links", "far"})
      fs::create_directory(scratch_ / folder);
    job_.input.files = {in("a.ply"), in("b.ply")};
    job_.input.poses = in("scans.conf");
    job_.input.trajectory = in("path.txt");
    job_.output.mesh = out("mesh.ply");
    job_.output.tiles = true;
    job_.output.tileset = out("mesh.tileset");
    job_.output.simplify = SimplifyTarget{};
    job_.output.simplified = out("small.ply");
    job_.output.polygons = out("polygons.ply");
    job_.output.medial_axis = out("medial_axis.ply");
    job_.output.report = out("report.json");
    job_.output.picture = out("picture.png");
    job_.run.work_dir = out("work");
    for (const char* name : {"a.ply", "b.ply", "scans.conf", "job.toml"})
      write_text(in(name), std::string("content of ") + name);
    if (!all_there) return;
    fs::create_directory(out("work"));
    fs::create_directory(out("mesh.tiles"));
    fs::create_directory(out("mesh.tileset"));
    for (const char* name :
         {"mesh.ply", "mesh.prj", "polygons.ply", "medial_axis.ply", "report.json", "report.html",
          "picture.png", "small.ply", "work/orbweave.log", "work/orbweave-steps.jsonl"})
      write_text(out(name), std::string("old content of ") + name);
  }

  fs::path root() const { return scratch_.path(); }
  const Job& job() const { return job_; }
  std::vector<PathRole> paths() const {
    std::vector<PathRole> all = job_paths(job_, job_.input.files, in("job.toml"));
    // The process's own directory is none of these, and tests must not change it.
    for (PathRole& role : all)
      if (role.role == "the current directory") role.path = root() / "other";
    return all;
  }

 private:
  std::string in(const std::string& name) const { return (scratch_ / "in" / name).string(); }
  std::string out(const std::string& name) const { return (scratch_ / "out" / name).string(); }

  ScratchDirectory scratch_;
  Job job_;
};

bool is_written(const PathRole& role) {
  return role.use != PathUse::kReadFile && role.use != PathUse::kReadDirectory;
}
bool is_cleared(const PathRole& role) {
  return role.use == PathUse::kWorkDirectory || role.use == PathUse::kWrittenDirectory;
}

/// Another path for the place that `path` is; empty where there is none.
struct Spelling {
  const char* name;
  std::function<std::optional<fs::path>(const fs::path& root, const fs::path& path)> respell;
};

std::optional<fs::path> link_to(const fs::path& root, const fs::path& path, const char* name) {
  const fs::path link = root / "links" / name;
  fs::create_symlink(path, link);
  return link;
}

const std::vector<Spelling>& spellings() {
  static const std::vector<Spelling> all = {
      {"as it is", [](const fs::path&, const fs::path& path) { return path; }},
      {"with dots",
       [](const fs::path&, const fs::path& path) {
         return path.parent_path() / "." / ".." / path.parent_path().filename() / path.filename();
       }},
      {"through a folder that is not there",
       [](const fs::path&, const fs::path& path) {
         return path.parent_path() / "nowhere" / ".." / path.filename();
       }},
      {"with a slash behind it",
       [](const fs::path&, const fs::path& path) { return fs::path(path.string() + "/"); }},
      {"relative", [](const fs::path&, const fs::path& path) { return fs::relative(path); }},
      {"a link",
       [](const fs::path& root, const fs::path& path) { return link_to(root, path, "one"); }},
      {"a relative link to a link",
       [](const fs::path& root, const fs::path& path) {
         link_to(root, fs::path("..") / fs::relative(path, root), "two");
         return link_to(root, "two", "three");
       }},
      {"a link to its folder",
       [](const fs::path& root, const fs::path& path) -> std::optional<fs::path> {
         return *link_to(root, path.parent_path(), "folder") / path.filename();
       }},
      {"a hard link", [](const fs::path& root, const fs::path& path) -> std::optional<fs::path> {
         if (!fs::is_regular_file(path)) return std::nullopt;
         fs::create_hard_link(path, root / "links" / "hard");
         return root / "links" / "hard";
       }}};
  return all;
}

/// The message of the refusal; empty: none. Nothing may change.
std::string refusal_of(const std::vector<PathRole>& paths, const fs::path& root,
                       ErrorKind expected = ErrorKind::kUsage) {
  const auto before = snapshot(root);
  std::string message;
  try {
    check_paths(paths);
  } catch (const Error& error) {
    CHECK(error.kind() == expected);
    message = error.what();
  }
  CHECK(snapshot(root) == before);
  return message;
}

void clear_links(const fs::path& root) {
  fs::remove_all(root / "links");
  fs::create_directory(root / "links");
}

/// Calls visit(paths, i, j, name of the spelling) with role i at `place_of(role j)`.
template <class Visit>
void for_every_pair(const Places& places, const std::function<fs::path(const PathRole&)>& place_of,
                    const Visit& visit) {
  const std::vector<PathRole> given = places.paths();
  REQUIRE(given.size() >= 13);
  for (std::size_t i = 0; i < given.size(); ++i) {
    for (std::size_t j = 0; j < given.size(); ++j) {
      if (i == j || given[i].in_work_directory) continue;
      for (const Spelling& spelling : spellings()) {
        clear_links(places.root());
        const auto path = spelling.respell(places.root(), place_of(given[j]));
        if (!path) continue;
        std::vector<PathRole> paths = given;
        paths[i].path = *path;
        INFO(given[i].role << " at " << given[j].role << ", " << spelling.name);
        visit(paths, i, j);
      }
    }
  }
}

}  // namespace

TEST_CASE("PathsThatHaveNothingInCommonAreFine") {
  const bool all_there = GENERATE(false, true);
  const Places places(all_there);
  CHECK(refusal_of(places.paths(), places.root()).empty());
}

TEST_CASE("TwoRolesOfOnePlaceAreFoundInAnySpelling", "[slow]") {
  const bool all_there = GENERATE(false, true);
  const Places places(all_there);
  std::size_t found = 0;
  for_every_pair(
      places, [](const PathRole& role) { return role.path; },
      [&](const std::vector<PathRole>& paths, std::size_t i, std::size_t j) {
        const bool collide = is_written(paths[i]) || is_written(paths[j]);
        const std::string message = refusal_of(paths, places.root());
        CHECK(message.empty() != collide);
        if (!collide) return;
        // What lies in the work directory is told of that.
        const std::string other = paths[j].in_work_directory ? "the work directory" : paths[j].role;
        CHECK_THAT(message,
                   Contains(paths[i].role) && (Contains(paths[j].role) || Contains(other)));
        ++found;
      });
  CHECK(found > 800);
}

TEST_CASE("APathInADirectoryThatIsClearedIsFoundInAnySpelling") {
  const bool all_there = GENERATE(false, true);
  const fs::path below = GENERATE(fs::path("x"), fs::path("a/b/x"));
  const Places places(all_there);
  std::size_t found = 0;
  for_every_pair(
      places, [&](const PathRole& role) { return role.path / below; },
      [&](const std::vector<PathRole>& paths, std::size_t i, std::size_t j) {
        if (!is_cleared(paths[j])) return;
        const std::string message = refusal_of(paths, places.root());
        CHECK_THAT(message,
                   Contains(paths[i].role) && Contains(paths[j].role) && Contains("lies in"));
        ++found;
      });
  CHECK(found > 100);
}

TEST_CASE("APathBelowAFileThatIsWrittenIsFound") {
  const bool all_there = GENERATE(false, true);
  const Places places(all_there);
  for_every_pair(
      places, [](const PathRole& role) { return role.path / "x"; },
      [&](const std::vector<PathRole>& paths, std::size_t i, std::size_t j) {
        if (paths[j].use != PathUse::kWrittenFile || paths[j].in_work_directory) return;
        const std::string message = refusal_of(paths, places.root());
        CHECK_THAT(message, Contains(paths[i].role) && Contains(paths[j].role));
      });
}

TEST_CASE("ALinkInTheWorkDirectoryIsAPathInIt") {
  const Places places(true);
  std::vector<PathRole> paths = places.paths();
  const fs::path link = fs::path(places.job().run.work_dir) / "scan.ply";
  fs::create_symlink(places.job().input.files[0], link);
  for (PathRole& role : paths)
    if (role.role == "a scan of the job") role.path = link;
  CHECK_THAT(refusal_of(paths, places.root()), Contains("lies in the work directory"));
}

TEST_CASE("TheWorkDirectoryIsNoFolderOfAnyOtherPath") {
  const Places places(true);
  for (const char* folder : {"in", "out", "other", "."}) {
    std::vector<PathRole> paths = places.paths();
    for (PathRole& role : paths)
      if (role.use == PathUse::kWorkDirectory) role.path = places.root() / folder;
    INFO(folder);
    CHECK_FALSE(refusal_of(paths, places.root()).empty());
  }
}

TEST_CASE("TheOtherKindOfFileInAnOutputsPlaceIsFoundAndNamed") {
  const Places places(false);
  const std::vector<PathRole> given = places.paths();
  fs::create_directory(places.root() / "far" / "folder");
  write_text(places.root() / "far" / "file", "a file");
  fs::create_symlink("folder", places.root() / "far" / "to-folder");
  fs::create_symlink("file", places.root() / "far" / "to-file");
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (!is_written(given[i]) || given[i].in_work_directory) continue;
    for (const char* front : {"", "to-"}) {
      const std::string wrong = is_cleared(given[i]) ? "file" : "folder";
      std::vector<PathRole> paths = given;
      paths[i].path = places.root() / "far" / (front + wrong);
      INFO(given[i].role << " at " << paths[i].path.string());
      CHECK_THAT(refusal_of(paths, places.root()),
                 Contains(given[i].role) && Contains(paths[i].path.string()) &&
                     Contains("Move it away or choose another name"));
    }
  }
}

TEST_CASE("LinksInACircleAreFoundAndLinksToNothingAreFine") {
  const Places places(false);
  const std::vector<PathRole> given = places.paths();
  const fs::path links = places.root() / "links";
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (!is_written(given[i]) || given[i].in_work_directory) continue;
    clear_links(places.root());
    fs::create_symlink("b", links / "a");
    fs::create_symlink("a", links / "b");
    fs::create_symlink("../far/not-there", links / "c");
    INFO(given[i].role);
    std::vector<PathRole> paths = given;
    paths[i].path = links / "a";
    CHECK_THAT(refusal_of(paths, places.root()), Contains("leads to itself"));
    paths[i].path = links / "c";
    CHECK(refusal_of(paths, places.root()).empty());
  }
}

TEST_CASE("AFolderThatIsNotThereIsFoundForEveryOutput") {
  const Places places(false);
  const std::vector<PathRole> given = places.paths();
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (!is_written(given[i]) || given[i].in_work_directory) continue;
    std::vector<PathRole> paths = given;
    paths[i].path = places.root() / "nowhere" / "x";
    INFO(given[i].role);
    const std::string message = refusal_of(paths, places.root(), ErrorKind::kResource);
    // Folders of a work directory are made; whether a coordinate system is written is not known.
    const bool may_be_absent = given[i].use == PathUse::kWorkDirectory || !given[i].is_certain;
    CHECK(message.empty() == may_be_absent);
  }
}

TEST_CASE("NamesThatOnlyLookAlikeAreNoCollision") {
  const Places places(true);
  const std::vector<PathRole> given = places.paths();
  const auto with = [&](const std::string& role, const fs::path& path) {
    std::vector<PathRole> paths = given;
    for (PathRole& one : paths)
      if (one.role == role) one.path = path;
    return paths;
  };
  const fs::path out = places.root() / "out";
  CHECK(refusal_of(with("the picture", out / "work.png"), places.root()).empty());
  CHECK(refusal_of(with("the picture", out / "mesh.tiles.png"), places.root()).empty());
  CHECK(refusal_of(with("the report", out / "mesh.ply.json"), places.root()).empty());
  CHECK(refusal_of(with("the work directory", out / "works"), places.root()).empty());
  CHECK(refusal_of(with("the picture", out / "work" / ".." / "p.png"), places.root()).empty());
  fs::create_symlink("../far/picture.png", places.root() / "links" / "picture.png");
  CHECK(refusal_of(with("the picture", places.root() / "links" / "picture.png"), places.root())
            .empty());
  // A second name of a scan is a second scan, or the same one twice.
  fs::create_hard_link(places.job().input.files[0], places.root() / "links" / "scan.ply");
  std::vector<PathRole> paths = given;
  paths.push_back({"a scan of the job", places.root() / "links" / "scan.ply", PathUse::kReadFile});
  CHECK(refusal_of(paths, places.root()).empty());
}

TEST_CASE("DevicesPipesAndStreamsMayHaveSeveralRoles") {
  const ScratchDirectory scratch;
  REQUIRE(mkfifo((scratch / "pipe").c_str(), 0600) == 0);
  for (const fs::path& path :
       {fs::path("/dev/null"), fs::path("-"), fs::path(), scratch / "pipe"}) {
    const std::vector<PathRole> paths = {{"the mesh", path, PathUse::kWrittenFile},
                                         {"the report", path, PathUse::kWrittenFile},
                                         {"a scan", path, PathUse::kReadFile}};
    INFO(path.string());
    CHECK(refusal_of(paths, scratch.path()).empty());
  }
  Job job;
  job.output.mesh = "-";
  job.output.report = "/dev/null";
  for (const PathRole& role : job_paths(job, {}))
    CHECK((role.role != "the report's page" || role.path.empty()));
}
