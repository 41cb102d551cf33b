// No file of the user's is lost: paths that collide are found before any work, and what the
// program did not write stays. Messages, exit statuses and what lies on disk afterwards.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <climits>
#include <map>
#include <string>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/program.h"
#include "tests/support/snapshot.h"

using Catch::Matchers::Contains;
using namespace orbweave::test;

namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

// Every run of the program flushes dozens of files.
[[maybe_unused]] const bool in_memory = scratch_in_memory();

void make_scan(const ScratchDirectory& in, const std::string& name = "scan.ply") {
  REQUIRE(run_in(in, {"generate", "bumpy-torus", "--points", "3000", "--noise", "0.1", "-o", name})
              .status == 0);
}

Arguments joined(Arguments first, const Arguments& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

ProgramResult reconstruct(const ScratchDirectory& in, const Arguments& more) {
  return run_in(in, joined({"reconstruct", "--progress", "none"}, more));
}

/// Refused as wrong usage before any work, with nothing changed.
void check_refused(const ScratchDirectory& in, const Arguments& arguments,
                   const Arguments& fragments) {
  const auto before = snapshot(in.path());
  const ProgramResult result = run_in(in, arguments);
  CAPTURE(arguments, result.err);
  CHECK(result.status == 2);
  CHECK(result.out.empty());
  for (const std::string& fragment : fragments) CHECK_THAT(result.err, Contains(fragment));
  CHECK_THAT(result.err, !Contains("begins"));
  CHECK(snapshot(in.path()) == before);
}

/// The mesh of scan.ply, made without any trouble.
std::string expected_mesh(const ScratchDirectory& in) {
  REQUIRE(reconstruct(in, {"scan.ply", "-o", "expected.ply"}).status == 0);
  const std::string mesh = file_text(in / "expected.ply");
  fs::remove(in / "expected.ply");
  return mesh;
}

}  // namespace

// ---------------------------------------------------------------- every pair of a command's paths

TEST_CASE("EveryPairOfPathsOfAJobFileIsFoundBeforeTheWork", "[slow]") {
  const ScratchDirectory in;
  make_scan(in);
  make_scan(in, "second.ply");
  write_text(in / "poses.conf", "bmesh scan.ply 0 0 0 0 0 0 1\nbmesh second.ply 0 0 0 0 0 0 1\n");
  fs::create_directory(in / "links");
  struct Role {
    std::string name, key, path;
    bool is_written;
  };
  const std::vector<Role> roles = {{"the mesh", "output.mesh", "mesh.ply", true},
                                   {"the report", "output.report", "report.json", true},
                                   {"the picture", "output.picture", "picture.png", true},
                                   {"the work directory", "run.work_dir", "work", true},
                                   {"the job file", "", "job.toml", false},
                                   {"the file of poses", "input.poses", "poses.conf", false},
                                   {"a scan of the job", "input.files", "scan.ply", false}};
  const bool tiles = GENERATE(false, true);
  write_text(in / "job.toml",
             "[input]\nfiles = [\"scan.ply\", \"second.ply\"]\nposes = \"poses.conf\"\n[output]\n"
             "mesh = \"mesh.ply\"\nreport = \"report.json\"\npicture = \"picture.png\"\n" +
                 std::string(tiles ? "tiles = true\n" : "") + "[run]\nwork_dir = \"work\"\n");
  int found = 0;
  for (const Role& moved : roles) {
    for (const Role& other : roles) {
      if (&moved == &other || !moved.is_written) continue;
      for (const bool linked : {false, true}) {
        // Meshes go by their extension.
        const std::string link = moved.key == "output.mesh" ? "links/link.ply" : "links/link";
        if (!linked && moved.key == "output.mesh" && !other.path.ends_with(".ply")) continue;
        fs::remove(in / link);
        if (linked) fs::create_symlink("../" + other.path, in / link);
        check_refused(in,
                      {"run", "job.toml", "--progress", "none", "--set",
                       moved.key + "=" + (linked ? link : "./links/../" + other.path)},
                      {moved.name, other.name});
        ++found;
      }
    }
  }
  CHECK(found == 4 * 6 * 2 - 5);
}

TEST_CASE("FilesBesideOutputsCountAsWell") {
  const ScratchDirectory in;
  make_scan(in);
  const Arguments base = {"reconstruct", "scan.ply", "-o", "m.ply"};
  check_refused(in, joined(base, {"--report", "r.json", "--picture", "r.html"}),
                {"the report's page", "the picture"});
  check_refused(in, joined(base, {"--report", "m.prj"}),
                {"the coordinate system beside the mesh", "the report"});
  check_refused(in, joined(base, {"--tiles", "--work-dir", "m.tiles"}),
                {"the work directory", "the directory of the tiles"});
  check_refused(in, joined(base, {"--tiles", "--report", "m.tiles/r.json"}),
                {"the report", "the directory of the tiles"});
  fs::create_directory(in / "w");
  fs::create_symlink("../scan.ply", in / "w" / "orbweave.log");
  check_refused(in, joined(base, {"--work-dir", "w"}), {"the log", "a scan of the job"});
}

TEST_CASE("PicturesAndReportsAreNotWrittenUnderNamesOfOtherFormats") {
  const ScratchDirectory in;
  make_scan(in);
  REQUIRE(
      run_in(in, {"generate", "sphere", "--points", "500", "-o", "ball.ply", "--truth", "mesh.ply"})
          .status == 0);
  const Arguments picture = {"a picture is a PNG file", "found .jpg", "ends in .png"};
  const Arguments report = {"a report is a JSON file", "found .html", ".json"};
  const Arguments stream = {"a report is not written to standard output", "report", "found -"};
  for (const Arguments& job : {Arguments{"reconstruct", "scan.ply", "-o", "m.ply"},
                               Arguments{"plan", "scan.ply", "-o", "m.ply"},
                               Arguments{"fill", "mesh.ply", "-o", "m.ply"}}) {
    check_refused(in, joined(job, {"--picture", "i.jpg"}), picture);
    check_refused(in, joined(job, {"--picture", "-"}), {"a picture is a PNG file"});
    check_refused(in, joined(job, {"--report", "r.html"}), report);
    check_refused(in, joined(job, {"--report", "-"}), stream);
  }
  check_refused(in, {"inspect", "mesh.ply", "--picture", "i.jpg"}, picture);
  check_refused(in, {"compare", "mesh.ply", "mesh.ply", "--errors-picture", "i.jpg"}, picture);
  const Arguments tileset = {"tileset", "mesh.ply", "-o"};
  check_refused(in, joined(tileset, {"t", "--report", "r.html"}), report);
  check_refused(in, joined(tileset, {"t", "--report", "-"}), stream);
  check_refused(in, joined(tileset, {"-"}),
                {"the folder of the tiles is not written to standard output"});
  check_refused(in, {"view", "mesh.ply", "--folder", "-"}, {"the folder is not written to"});
  check_refused(in, {"reconstruct", "scan.ply", "-o", "m.ply", "--tileset", "-"},
                {"the directory of the tileset is not written to"});
  CHECK(reconstruct(in, {"scan.ply", "-o", "m.ply", "--picture", "i.PNG"}).status == 0);
}

TEST_CASE("PathsOfAllOtherCommandsAreCheckedBeforeTheWork", "[costly]") {
  const ScratchDirectory in;
  make_scan(in);
  REQUIRE(reconstruct(in, {"scan.ply", "-o", "mesh.ply"}).status == 0);
  fs::create_hard_link(in / "mesh.ply", in / "hard.ply");
  fs::create_symlink("mesh.ply", in / "soft.ply");
  for (const char* mesh : {"./mesh.ply", "hard.ply", "soft.ply", "no/../mesh.ply"}) {
    check_refused(in, {"fill", "mesh.ply", "-o", mesh}, {"would replace the mesh that is read"});
    check_refused(in, {"fill", "mesh.ply", "-o", "o.ply", "--report", mesh},
                  {"would replace the mesh that is read"});
    check_refused(in, {"fill", "mesh.ply", "-o", "o.ply", "--picture", mesh},
                  {"would replace the mesh that is read"});
    check_refused(in, {"convert", "mesh.ply", mesh}, {"would replace the file that is read"});
    check_refused(in, {"inspect", "mesh.ply", "--picture", mesh},
                  {"would replace the file that is read"});
    check_refused(in, {"inspect", "scan.ply", "--against", "mesh.ply", "--picture", mesh},
                  {"would replace the scan to compare with"});
  }
  check_refused(in, {"fill", "mesh.ply", "-o", "o.ply", "--report", "o.ply"},
                {"the mesh", "the report"});
  check_refused(in, {"fill", "mesh.ply", "-o", "o.ply", "--picture", "./o.ply"},
                {"the mesh", "the picture"});
  check_refused(in, {"fill", "mesh.ply", "-o", "o.ply", "--report", "p", "--picture", "p"},
                {"the report", "the picture"});
  const Arguments torus = {"generate", "torus", "--points", "1000"};
  check_refused(in, joined(torus, {"-o", "g.ply", "--truth", "g.ply"}),
                {"the true surface", "the cloud"});
  const Arguments scans = joined(torus, {"--scans", "3", "--separate", "-o", "g.ply", "--truth"});
  check_refused(in, joined(scans, {"g_2.ply"}), {"the true surface", "scan 2"});
  fs::create_symlink("g.conf", in / "truth.ply");
  check_refused(in, joined(scans, {"truth.ply"}), {"the true surface", "the file of poses"});
  fs::create_directory(in / "d.ply");
  check_refused(in, {"convert", "mesh.ply", "d.ply"}, {"a directory of that name"});
  check_refused(in, joined(torus, {"-o", "g.ply", "--truth", "d.ply"}),
                {"the true surface cannot be written there"});
  check_refused(in, {"plan", "scan.ply", "-o", "m.ply", "--report", "m.ply"},
                {"the mesh", "the report"});
}

// ------------------------------------------------------------------------- case 1 of the issue

TEST_CASE("OutputsInTheWorkDirectoryAreRefusedAndItStays") {
  const ScratchDirectory in;
  make_scan(in);
  const bool there = GENERATE(false, true);
  if (there) fs::create_directory(in / "w");
  for (const Arguments& outputs :
       {Arguments{"-o", "w/mesh.ply"}, Arguments{"-o", "m.ply", "--report", "w/r.json"},
        Arguments{"-o", "m.ply", "--picture", "w/a/p.png"}})
    check_refused(
        in, joined({"reconstruct", "scan.ply", "--work-dir", "w"}, outputs),
        {"lies in the work directory, which is removed in the end", "Choose another place"});
  check_refused(in, {"reconstruct", "scan.ply", "-o", "m.ply", "--work-dir", "."},
                {"lies in the work directory"});
  CHECK(fs::exists(in / "w") == there);
}

// ------------------------------------------------------------------------- case 2 of the issue

TEST_CASE("AFolderOfTheUsersIsNoWorkDirectoryWhateverItsFilesAreCalled", "[costly]") {
  const ScratchDirectory in;
  make_scan(in);
  const std::string name = GENERATE(
      "movie.mp4.part", "member.csv", "member.1", "lock", "ended.json", "team",
      "orbweave-store.json", "orbweave-record.0", "orbweave.log", "orbweave-steps.jsonl", "points");
  fs::create_directory(in / "w");
  if (name == "points")
    fs::create_directory(in / "w" / name);
  else
    write_text(in / "w" / name, "the user's own\n");
  for (const Arguments& more : {Arguments{}, Arguments{"--fresh"}})
    check_refused(in,
                  joined({"reconstruct", "scan.ply", "-o", "mesh.ply", "--work-dir", "w"}, more),
                  {"w", name, name == "orbweave-store.json" ? "damaged" : "holds something else",
                   "--work-dir"});
}

TEST_CASE("AFolderOfTheUsersWithAnEmptyLockIsNoWorkDirectory") {
  const ScratchDirectory in;
  make_scan(in);
  fs::create_directory(in / "w");
  for (const char* name : {"movie.mp4.part", "member.csv", "lock", "ended.json"})
    write_text(in / "w" / name, "");
  check_refused(in, {"reconstruct", "scan.ply", "-o", "mesh.ply", "--work-dir", "w", "--fresh"},
                {"holds something else"});
}

// ------------------------------------------------------------------------- case 3 of the issue

TEST_CASE("TilesReplaceNothingThatIsNotOnTheRecordOfTheirIndex", "[slow]") {
  const ScratchDirectory in;
  make_scan(in);
  fs::create_directory(in / "t.tiles");
  fs::copy_file(in / "scan.ply", in / "t.tiles" / "000000.ply");
  check_refused(in, {"reconstruct", "t.tiles/000000.ply", "-o", "t.ply", "--tiles"},
                {"a scan of the job lies in the directory of the tiles"});
  const Arguments tiles = {"reconstruct", "scan.ply", "-o", "t.ply", "--tiles"};
  check_refused(in, tiles, {"t.tiles", "000000.ply", "Move it away"});
  fs::remove(in / "t.tiles" / "000000.ply");
  REQUIRE(run_in(in, tiles).status == 0);
  REQUIRE(run_in(in, tiles).status == 0);  // its own are replaced
  const fs::path stranger = in / "t.tiles" / GENERATE(".notes.part", "000099.ply", "notes.txt");
  write_text(stranger, "notes");
  check_refused(in, tiles, {stranger.filename().string(), "does not list"});
  fs::remove(stranger);
  SECTION("a tile that the user changed") {
    const std::string whole = file_text(in / "t.tiles" / "000000.ply");
    write_text(in / "t.tiles" / "000000.ply", whole.substr(0, whole.size() - 1) + "x");
    check_refused(in, tiles, {"000000.ply", "is not as its tiles.json has it"});
  }
  SECTION("a copy of the tiles is the tiles") {
    fs::rename(in / "t.tiles", in / "moved");
    fs::copy(in / "moved", in / "t.tiles", fs::copy_options::recursive);
    CHECK(run_in(in, tiles).status == 0);
  }
  SECTION("a link in the place of a tile") {
    fs::rename(in / "t.tiles" / "000000.ply", in / "tile.ply");
    fs::create_symlink("../tile.ply", in / "t.tiles" / "000000.ply");
    check_refused(in, tiles, {"000000.ply"});
  }
  SECTION("a link to the directory is written through") {
    fs::rename(in / "t.tiles", in / "far");
    fs::create_symlink("far", in / "t.tiles");
    const std::string before = file_text(in / "far" / "tiles.json");
    CHECK(run_in(in, tiles).status == 0);
    CHECK(fs::is_symlink(in / "t.tiles"));
    CHECK(file_text(in / "far" / "tiles.json") == before);
  }
}

// ------------------------------------------------------------------------- case 4 of the issue

TEST_CASE("OutputsThatAreOneFileAreRefused") {
  const ScratchDirectory in;
  make_scan(in);
  const Arguments base = {"reconstruct", "scan.ply", "-o", "m.ply"};
  check_refused(in, joined(base, {"--report", "m.ply"}), {"the mesh", "the report", "m.ply"});
  check_refused(in, joined(base, {"--picture", "m.ply"}), {"the mesh", "the picture", "m.ply"});
  check_refused(in, joined(base, {"--report", "x", "--picture", "x"}),
                {"the report", "the picture"});
  write_text(in / "job.toml", "[input]\nfiles = [\"scan.ply\"]\n[output]\nmesh = \"m.ply\"\n");
  check_refused(in, {"run", "job.toml", "--report", "job.toml"}, {"the report", "the job file"});
  write_text(in / "p.conf", "bmesh scan.ply 0 0 0 0 0 0 1\n");
  check_refused(in, joined(base, {"--poses", "p.conf", "--report", "p.conf"}),
                {"the report", "the file of poses"});
  check_refused(in, {"generate", "torus", "--points", "100", "-o", "g.ply", "--truth", "g.ply"},
                {"the true surface would replace the cloud"});
}

// ------------------------------------------------------------------------- case 5 of the issue

TEST_CASE("AWorkDirectoryKeepsWhatTheUserPutThere", "[costly]") {
  const ScratchDirectory in;
  make_scan(in);
  const std::string expected = expected_mesh(in);
  const Arguments base = {"scan.ply", "-o", "mesh.ply"};
  REQUIRE(reconstruct(in, joined(base, {"--keep-work-dir"})).status == 0);
  const fs::path work = in / "mesh.work";
  write_text(work / "notes.txt", "mine");
  write_text(work / "movie.mp4.part", "mine, too");
  write_text(work / "mesh" / ".movie.part", "and mine");
  fs::create_directory(work / "photos");
  fs::copy_file(in / "scan.ply", work / "points" / "000077.h5");
  fs::create_hard_link(in / "scan.ply", work / "mesh" / "scan.ply");
  fs::create_symlink("../scan.ply", work / "link.ply");
  const bool fresh = GENERATE(false, true);
  const ProgramResult result =
      reconstruct(in, fresh ? joined(base, {"--fresh"}) : base);  // without progress
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK(file_text(in / "mesh.ply") == expected);
  CHECK_THAT(result.err, Contains("mesh.work stays: it holds") && Contains("notes.txt") &&
                             Contains("which this program did not write"));
  CHECK(file_text(work / "notes.txt") == "mine");
  CHECK(file_text(work / "movie.mp4.part") == "mine, too");
  CHECK(file_text(work / "mesh" / ".movie.part") == "and mine");
  CHECK(fs::is_directory(work / "photos"));
  CHECK(file_text(work / "points" / "000077.h5") == file_text(in / "scan.ply"));
  CHECK(fs::equivalent(work / "mesh" / "scan.ply", in / "scan.ply"));
  CHECK(fs::is_symlink(work / "link.ply"));
  std::size_t left = 0;
  for ([[maybe_unused]] const auto& entry : fs::recursive_directory_iterator(work)) ++left;
  CHECK(left == 9);  // those, and the folders points and mesh
}

TEST_CASE("AWorkDirectoryKeepsWhatOnlyLooksLikeTheProgramsWork", "[costly]") {
  const ScratchDirectory in;
  make_scan(in);
  const std::string expected = expected_mesh(in);
  for (const char* work : {"other", "w"})
    REQUIRE(reconstruct(in, {"scan.ply", "-o", "mesh.ply", "--work-dir", work, "--keep-work-dir"})
                .status == 0);
  fs::remove(in / "mesh.ply");
  const fs::path work = in / "w";
  const fs::path other = in / "other";
  std::map<std::string, std::string> users;
  const auto put = [&](const std::string& name, const std::string& text) {
    users[name] = text;
    write_text(work / name, text);
  };
  // Results and documents of another job, and of this one, elsewhere and under other names.
  put("my_backup.h5", file_text(other / "mesh/000000.h5"));
  put("points/000077.h5", file_text(other / "points/000000.h5"));
  put("mesh/000078.h5", file_text(work / "mesh/000000.h5"));
  put("mesh/backup.h5", file_text(work / "mesh/000000.h5"));
  put("points/000000.h5.part", file_text(work / "points/000000.h5"));
  put("my_facts.json", file_text(other / "points/partition.json"));
  put("my_facts.json.xxh3", file_text(other / "points/partition.json.xxh3"));
  // What begins like records and locks.
  put("orbweave-record.notes", "run 3 took five minutes\n");
  put("orbweave-record.17", "run 3 took five minutes\n");
  put("orbweave-record.18", file_text(other / "orbweave-record.0"));
  put("orbweave-record.empty", "");
  put("member.csv", "");
  put("member.3", "");
  put("member.4", file_text(other / "lock"));
  put("team", "the blue one (orbweave)\n");
  const ProgramResult result = reconstruct(in, {"scan.ply", "-o", "mesh.ply", "--work-dir", "w"});
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK(file_text(in / "mesh.ply") == expected);
  CHECK_THAT(result.err, Contains("w stays: it holds") && Contains("did not write"));
  std::map<std::string, std::string> left;
  for (const auto& entry : fs::recursive_directory_iterator(work))
    if (entry.is_regular_file())
      left[fs::relative(entry.path(), work).string()] = file_text(entry.path());
  for (const auto& [name, text] : users) {
    INFO(name);
    REQUIRE(left.contains(name));
    CHECK(left[name] == text);
  }
  CHECK(left.size() == users.size());
}

TEST_CASE("AnOutputIsNoTemporaryWhateverItsName", "[costly]") {
  const ScratchDirectory in;
  make_scan(in);
  const Arguments kept = {"--work-dir", "w", "--keep-work-dir"};
  const std::string name = GENERATE("r.part", ".r.json.0123456789abcdef.part");
  REQUIRE(reconstruct(in, joined({"scan.ply", "-o", "b.ply", "--report", name}, kept)).status == 0);
  const std::string report = file_text(in / name);
  REQUIRE(reconstruct(in, {"scan.ply", "-o", "c.ply", "--work-dir", "w"}).status == 0);
  CHECK(file_text(in / name) == report);
}

TEST_CASE("NamesAsLongAsTheFileSystemHasThemAreWritten", "[costly]") {
  const ScratchDirectory in;
  make_scan(in);
  const std::string stem(NAME_MAX - 5, 'm');  // the work directory is of that name with .work
  REQUIRE(reconstruct(in, {"scan.ply", "-o", stem + ".ply", "--report", stem + ".json"}).status ==
          0);
  CHECK(std::filesystem::exists(in / (stem + ".ply")));
  CHECK(std::filesystem::exists(in / (stem + ".json")));
  CHECK(run_in(in, {"convert", "scan.ply", stem + "m.ply"}).status == 0);
  const ProgramResult longer = reconstruct(in, {"scan.ply", "-o", stem + "m.ply"});
  CHECK(longer.status == 4);
  CHECK_THAT(longer.err, Contains("cannot use the work directory; found File name too long"));
}

TEST_CASE("AnEmptyDirectoryOfTheUsersIsUsedAndLeftWhateverItsPermissions", "[costly]") {
  const ScratchDirectory in;
  make_scan(in);
  fs::create_directory(in / "shared");
  REQUIRE(::chmod((in / "shared").c_str(), GENERATE(0755u, 01777u, 01700u)) == 0);
  const auto before = fs::status(in / "shared").permissions();
  const ProgramResult result =
      reconstruct(in, {"scan.ply", "-o", "mesh.ply", "--work-dir", "shared"});
  CHECK(result.status == 0);
  CHECK(names_in(in) == Arguments{"mesh.ply", "scan.ply", "shared"});
  CHECK(fs::is_empty(in / "shared"));
  CHECK(fs::status(in / "shared").permissions() == before);
}

TEST_CASE("AScanInTheWorkDirectoryIsRefused") {
  const ScratchDirectory in;
  make_scan(in);
  REQUIRE(reconstruct(in, {"scan.ply", "-o", "mesh.ply", "--keep-work-dir"}).status == 0);
  fs::rename(in / "scan.ply", in / "mesh.work" / "scan.ply");
  for (const char* fresh : {"", "--fresh"}) {
    Arguments arguments = {"reconstruct", "mesh.work/scan.ply", "-o", "mesh.ply"};
    if (*fresh != '\0') arguments.emplace_back(fresh);
    check_refused(in, arguments, {"a scan of the job lies in the work directory"});
  }
}

TEST_CASE("WhatIsInAResultsPlaceAndNotTheProgramsStaysAndIsNamed", "[slow]") {
  const ScratchDirectory in;
  make_scan(in);
  const Arguments base = {"scan.ply", "-o", "mesh.ply", "--keep-work-dir"};
  REQUIRE(reconstruct(in, base).status == 0);
  const std::string expected = file_text(in / "mesh.ply");
  fs::remove(in / "mesh.ply");
  const std::string place =
      GENERATE("mesh.work/mesh/000000.h5", "mesh.work/points/000000.h5",
               "mesh.work/points/partition.json", "mesh.work/mesh/key.json", "mesh.work/mesh");
  const bool directory = GENERATE(false, true);
  fs::rename(in / place, in / "away");
  if (directory && place != "mesh.work/mesh") {
    fs::create_directory(in / place);
    write_text(in / place / "mine", "mine");
  } else {
    write_text(in / place, "mine");
  }
  const ProgramResult refused = reconstruct(in, base);
  INFO(place << ": " << refused.err);
  CHECK_THAT(refused.err, Contains(place));
  if (refused.status == 4) {
    CHECK(fs::is_directory(in / place));
    CHECK_THAT(refused.err, Contains("a directory lies where a file of the job belongs") &&
                                Contains("Move it elsewhere or remove it"));
  } else {
    CHECK(refused.status == 2);
    CHECK_THAT(refused.err,
               Contains("not on its record") && Contains("Move it away and repeat the command"));
  }
  CHECK(file_text(fs::is_directory(in / place) ? in / place / "mine" : in / place) == "mine");
  // The advice works.
  fs::rename(in / place, in / "mine");
  const ProgramResult resumed = reconstruct(in, base);
  INFO(resumed.err);
  CHECK(resumed.status == 0);
  CHECK(file_text(in / "mesh.ply") == expected);
}

TEST_CASE("AWorkDirectoryThatTheUserMadeIsLeftEmptyAndOneThatTheProgramMadeGoes") {
  const ScratchDirectory in;
  make_scan(in);
  fs::create_directory(in / "mine");
  CHECK(reconstruct(in, {"scan.ply", "-o", "m.ply", "--work-dir", "mine"}).status == 0);
  CHECK(fs::is_empty(in / "mine"));
  CHECK(reconstruct(in, {"scan.ply", "-o", "m.ply", "--work-dir", "a/b/c"}).status == 0);
  CHECK_FALSE(fs::exists(in / "a"));
  fs::create_directory(in / "a");
  CHECK(reconstruct(in, {"scan.ply", "-o", "m.ply", "--work-dir", "a/b/c/"}).status == 0);
  CHECK(fs::is_empty(in / "a"));
}

TEST_CASE("WhereTheCurrentFolderIsGoneTheMessageSaysSo") {
  const ScratchDirectory in;
  make_scan(in);
  const ProgramResult result =
      run_limited(in, "mkdir gone && cd gone && rmdir ../gone",
                  {"reconstruct", (in / "scan.ply").string(), "-o", "m.ply"});
  CHECK(result.status == 4);
  CHECK(result.err.find("found that the current folder was removed") != std::string::npos);
  CHECK(result.err.find("Change to a folder that is there") != std::string::npos);
}

TEST_CASE("ACopyOfAWorkDirectoryIsResumedAndRemoved") {
  const ScratchDirectory in;
  make_scan(in);
  REQUIRE(reconstruct(in, {"scan.ply", "-o", "mesh.ply", "--keep-work-dir"}).status == 0);
  const std::string expected = file_text(in / "mesh.ply");
  fs::remove(in / "mesh.ply");
  fs::copy(in / "mesh.work", in / "copy", fs::copy_options::recursive);
  write_text(in / "copy" / "mesh" / "notes.txt", "mine");
  const ProgramResult result =
      run_in(in, {"reconstruct", "scan.ply", "-o", "mesh.ply", "--work-dir", "copy"});
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK_THAT(result.err, Contains("resuming") && Contains("it holds mesh/notes.txt, which"));
  CHECK(file_text(in / "mesh.ply") == expected);
  std::size_t left = 0;
  for ([[maybe_unused]] const auto& entry : fs::recursive_directory_iterator(in / "copy")) ++left;
  CHECK(left == 2);
}

// ------------------------------------------------------------------------- case 6 of the issue

TEST_CASE("TheWrongKindOfFileIsFoundBeforeTheWork") {
  const ScratchDirectory in;
  make_scan(in);
  const Arguments base = {"reconstruct", "scan.ply"};
  check_refused(in, joined(base, {"-o", "f.ply", "--work-dir", "f.ply"}),
                {"the work directory", "the mesh", "f.ply"});
  fs::create_directory(in / "d.ply");
  check_refused(in, joined(base, {"-o", "m.ply", "--report", "d.ply"}),
                {"d.ply: the report cannot be written there; found a directory"});
  check_refused(in, joined(base, {"-o", "m.ply", "--picture", "d.ply"}),
                {"d.ply: the picture cannot be written there; found a directory"});
  check_refused(in, joined(base, {"-o", "d.ply"}),
                {"d.ply: the mesh cannot be written there; found a directory"});
  write_text(in / "file", "mine");
  check_refused(in, joined(base, {"-o", "m.ply", "--work-dir", "file"}),
                {"file: the work directory cannot be written there; found no directory"});
  fs::create_symlink("b.ply", in / "a.ply");
  fs::create_symlink("a.ply", in / "b.ply");
  check_refused(in, joined(base, {"-o", "a.ply"}), {"a.ply: the link leads to itself"});
}

TEST_CASE("OutputsThatAreLinksAreWrittenThrough", "[costly]") {
  const ScratchDirectory in;
  make_scan(in);
  const std::string expected = expected_mesh(in);
  const bool dangling = GENERATE(false, true);
  fs::create_directory(in / "far");
  const std::map<std::string, std::string> links = {
      {"mesh.ply", "far/mesh.ply"}, {"report.json", "far/r.json"}, {"picture.png", "far/p.png"}};
  for (const auto& [link, target] : links) {
    fs::create_symlink(target, in / link);
    if (!dangling) write_text(in / target, "old");
  }
  const ProgramResult result = reconstruct(
      in, {"scan.ply", "-o", "mesh.ply", "--report", "report.json", "--picture", "picture.png"});
  INFO(result.err);
  CHECK(result.status == 0);
  for (const auto& [link, target] : links) {
    CHECK(fs::read_symlink(in / link) == target);
    CHECK_FALSE(fs::is_symlink(in / target));
    CHECK(file_text(in / target).size() > 100);
  }
  CHECK(file_text(in / "far" / "mesh.ply") == expected);
  CHECK_FALSE(fs::exists(in / "mesh.work"));
  fs::create_symlink("far/c.ply", in / "c.ply");
  CHECK(run_in(in, {"convert", "mesh.ply", "c.ply"}).status == 0);
  CHECK(fs::is_symlink(in / "c.ply"));
  CHECK(fs::is_regular_file(fs::symlink_status(in / "far" / "c.ply")));
}

TEST_CASE("AWorkDirectoryThatIsALinkIsUsedAndLeft", "[costly]") {
  const ScratchDirectory in;
  make_scan(in);
  const std::string expected = expected_mesh(in);
  const bool dangling = GENERATE(false, true);
  if (!dangling) fs::create_directory(in / "far");
  fs::create_symlink("far", in / "w");
  const Arguments base = {"scan.ply", "-o", "mesh.ply", "--work-dir", "w"};
  REQUIRE(reconstruct(in, joined(base, {"--keep-work-dir"})).status == 0);
  CHECK(fs::exists(in / "far" / "orbweave-store.json"));
  const ProgramResult result = reconstruct(in, base);
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK(file_text(in / "mesh.ply") == expected);
  CHECK(fs::read_symlink(in / "w") == "far");
  if (dangling)
    CHECK_FALSE(fs::exists(in / "far"));
  else
    CHECK(fs::is_empty(in / "far"));
}

// ------------------------------------------------------- item 14: a damaged orbweave-store.json

TEST_CASE("ADamagedFileOfTheStoreIsWrittenAnewAndTheJobGoesOn", "[slow]") {
  const ScratchDirectory in;
  make_scan(in);
  const Arguments base = {"scan.ply", "-o", "mesh.ply"};
  REQUIRE(reconstruct(in, joined(base, {"--keep-work-dir"})).status == 0);
  const std::string expected = file_text(in / "mesh.ply");
  fs::remove(in / "mesh.ply");
  const fs::path store = in / "mesh.work" / "orbweave-store.json";
  const std::string whole = file_text(store);
  const std::string text =
      GENERATE_COPY(std::string(), whole.substr(0, whole.size() / 2), std::string(200, '\0'),
                    "X" + whole.substr(1), std::string("gone"));
  const bool record_lost = GENERATE(false, true);
  if (text == "gone")
    fs::remove(store);
  else
    write_text(store, text);
  if (record_lost) write_text(in / "mesh.work" / "orbweave-record.0", "");
  const ProgramResult result = run_in(in, joined({"reconstruct"}, base));
  INFO(text << ": " << result.err);
  CHECK(result.status == 0);
  CHECK(file_text(in / "mesh.ply") == expected);
  CHECK_THAT(result.err, Contains("orbweave-store.json: ") && Contains("written anew"));
  // Without the record, a log is like any other file.
  if (!record_lost) CHECK_FALSE(fs::exists(in / "mesh.work"));
}

TEST_CASE("SomethingElseInThePlaceOfTheStoresOwnFilesIsRefusedAndTheAdviceWorks", "[slow]") {
  const ScratchDirectory in;
  make_scan(in);
  const Arguments base = {"reconstruct", "scan.ply", "-o", "mesh.ply"};
  REQUIRE(run_in(in, joined(base, {"--keep-work-dir"})).status == 0);
  const std::string expected = file_text(in / "mesh.ply");
  fs::remove(in / "mesh.ply");
  const std::string name = GENERATE("orbweave-store.json", "lock", "orbweave-record.0");
  const std::string kind = GENERATE("a directory", "a file", "a link");
  INFO(kind << " as " << name);
  const fs::path place = in / "mesh.work" / name;
  fs::rename(place, in / "old");  // its inode is not given away again
  if (kind == "a directory") fs::create_directory(place);
  if (kind == "a file") write_text(place, "the user's own\n");
  if (kind == "a link") fs::create_symlink("elsewhere", place);
  for (const Arguments& more : {Arguments{}, Arguments{"--fresh"}})
    check_refused(in, joined(base, more),
                  {name, "found " + kind, "Move it away and repeat the command, which resumes"});
  fs::remove(in / "old");
  fs::rename(place, in / "away");
  const ProgramResult result = run_in(in, base);
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK(file_text(in / "mesh.ply") == expected);
  // Without the record, a log is like any other file.
  if (name == "orbweave-record.0")
    CHECK_THAT(result.err, Contains("it holds ") && Contains("orbweave.log, which"));
  else
    CHECK_FALSE(fs::exists(in / "mesh.work"));
}

TEST_CASE("NamesOfUnsupportedFormatsAreRefusedBeforeAnyWork") {
  const ScratchDirectory in;
  make_scan(in);
  write_text(in / "scan.toml", "[input]\nfiles = [\"scan.toml\"]\n[output]\nmesh = \"m.ply\"\n");
  write_text(in / "null.toml", "[input]\nfiles = [\"/dev/null\"]\n[output]\nmesh = \"m.ply\"\n");
  write_text(in / "dash.toml", "[input]\nfiles = [\"-\"]\n[output]\nmesh = \"m.ply\"\n");
  check_refused(in, {"run", "scan.toml"}, {"scan.toml: cannot read .toml clouds; supported: .ply"});
  check_refused(in, {"run", "null.toml"},
                {"/dev/null: cannot read clouds whose name has no extension"});
  check_refused(in, {"run", "dash.toml"},
                {"dash.toml: input.files: a job reads its scans several times"});
  check_refused(in, {"reconstruct", "-", "-o", "m.ply"},
                {"a job reads its scans several times", "orbweave convert - scan.ply"});
  for (const char* name : {".ply", ".ply.gz", "./.obj"})
    check_refused(in, {"reconstruct", "scan.ply", "-o", name},
                  {std::string(name) + ": cannot write "});
}

TEST_CASE("ADamagedLockIsStillTheProgramsLock", "[costly]") {
  const ScratchDirectory in;
  make_scan(in);
  const Arguments base = {"reconstruct", "scan.ply", "-o", "mesh.ply"};
  REQUIRE(run_in(in, joined(base, {"--keep-work-dir"})).status == 0);
  write_text(in / "mesh.work" / "lock", GENERATE("", "47", "4711 (orbweavf)\n"));
  const ProgramResult result = run_in(in, base);
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK_FALSE(fs::exists(in / "mesh.work"));
}

TEST_CASE("AWorkDirectoryOfAnotherVersionIsRefusedWithAdviceThatWorks") {
  const ScratchDirectory in;
  make_scan(in);
  fs::create_directory(in / "w");
  write_text(in / "w" / "orbweave-store.json",
             "{\"format\": \"orbweave chunk store\", \"layout_version\": 3}\n");
  const Arguments base = {"reconstruct", "scan.ply", "-o", "mesh.ply", "--work-dir", "w"};
  check_refused(in, base, {"found layout version 3", "Remove w"});
  check_refused(in, joined(base, {"--fresh"}), {"found layout version 3", "Remove w"});
  fs::remove_all(in / "w");
  CHECK(run_in(in, base).status == 0);
}
