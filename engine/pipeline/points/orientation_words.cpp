#include "engine/pipeline/points/orientation_words.h"

#include "io/job/setting.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

/// Share of the surface beyond which a doubt is worth a warning.
constexpr double kMuch = 0.05;

const char* text_of(PartDoubt doubt) {
  switch (doubt) {
    case PartDoubt::kNone:
      return "joined to the rest by votes that contradict each other";
    case PartDoubt::kSheet:
      return "an open sheet, seen from either side";
    case PartDoubt::kBowl:
      return "a valley, or the outer side of a bowl";
    case PartDoubt::kHalfOpen:
      return "neither closed nor level";
    case PartDoubt::kTube:
      return "a tube or a tunnel";
    case PartDoubt::kBox:
      return "a box, or an empty room";
    case PartDoubt::kFreeSpace:
      return "an object, or an interior";
    case PartDoubt::kNested:
      return "one component within another";
  }
  return "";
}

/// Patches whose votes for their side are not 3 to 1: "4 % of the patches".
std::string share_of_contested(const NormalFacts& normals) {
  return format_percent(static_cast<double>(normals.contested) /
                        static_cast<double>(normals.patches)) +
         " of the patches";
}

std::string uncertain_patches(const NormalFacts& normals) {
  if (normals.contested == 0) return "every patch certain";
  return share_of_contested(normals) + " uncertain: check for flipped areas";
}

std::string interiors(const NormalFacts& normals) {
  if (normals.interiors == 0) return "";
  return ", " + format_count(normals.interiors) +
         (normals.interiors == 1 ? " component" : " components") + " seen from inside";
}

std::string advice_on_interiors(const Job& job, Orientation rule) {
  if (rule != Orientation::kPropagate) return "";
  return " " + setting(job, "normals.orientation", "inward") +
         " is for rooms, seen from their inside.";
}

/// What would make the side of the normals certain.
std::string advice_on_orientation(const Job& job, Orientation rule) {
  std::string scanners = "Known places of the scanners (" + setting_name(job, "input.scanner") +
                         ", " + setting_name(job, "input.trajectory") + ") decide the side.";
  if (rule == Orientation::kGround) return scanners;
  return scanners + " " + setting(job, "normals.orientation", "ground") +
         " decides it for a scene that has a ground.";
}

void warn_of_contested(StageRunner& runner, const NormalFacts& normals) {
  if (normals.contested_places.empty() || normals.contested_area < kMuch) return;
  std::string places;
  for (const ContestedFacts& place : normals.contested_places)
    places += (places.empty() ? "" : ", ") + format_position(place.center) + " (" +
              format_count(place.patches) + ")";
  runner.say_of_points(
      {.shown = "the side of the normals is uncertain on " + share_of_contested(normals) +
                "; look first near " + format_position(normals.contested_places.front().center),
       .full = "the side of the normals is uncertain: the votes of " +
               format_count(normals.contested) + " of " + format_count(normals.patches) +
               " patches, " + format_percent(normals.contested_area) +
               " of the surface, contradict each other. The places with the most of them: " +
               places + ". " + advice_on_orientation(runner.job, normals.orientation),
       .is_warning = true});
}

/// Of little of the surface the report's notes tell.
void tell_of_doubtful(StageRunner& runner, const NormalFacts& normals) {
  constexpr double kNoted = 0.02;
  if (normals.doubtful.empty() || normals.doubtful_area < kNoted) return;
  std::string parts;
  for (const DoubtfulFacts& part : normals.doubtful)
    parts += (parts.empty() ? "" : "; ") + format_percent(part.area) + " near " +
             format_position(part.center) + ": " + part.reason;
  const std::string what = "the side of the normals is a guess on " +
                           format_percent(normals.doubtful_area) + " of the surface";
  const DoubtfulFacts& largest = normals.doubtful.front();
  runner.say_of_points({.shown = what + " (" + largest.reason + "); look first near " +
                                 format_position(largest.center),
                        .full = what + ". The largest parts of it: " + parts + ". " +
                                advice_on_orientation(runner.job, normals.orientation) +
                                advice_on_interiors(runner.job, normals.orientation),
                        .is_warning = normals.doubtful_area >= kMuch});
}

}  // namespace

void take_facts(const PatchOrientation& orientation, NormalFacts& normals) {
  normals.patches = orientation.patches.size();
  normals.components = orientation.components;
  normals.contested = orientation.contested;
  normals.satisfied = orientation.satisfied;
  normals.ground_patches = orientation.ground;
  normals.ground_patches_down = orientation.ground_down;
  normals.interiors = orientation.interiors;
  normals.contested_area = orientation.contested_area;
  normals.doubtful_area = orientation.doubtful_area;
  for (const ContestedPlace& place : orientation.places)
    normals.contested_places.push_back({place.center, place.patches});
  for (const DoubtfulPart& part : orientation.doubtful)
    normals.doubtful.push_back({part.center, part.area, text_of(part.doubt)});
}

std::string describe_orientation(const NormalFacts& normals) {
  switch (normals.orientation) {
    case Orientation::kScanner:
      return "oriented towards the scanner";
    case Orientation::kViewpoint:
      return "oriented towards the viewpoint";
    case Orientation::kUp:
      return "oriented by the up direction";
    case Orientation::kPropagate:
      return "oriented by propagation" + interiors(normals) + "; " + uncertain_patches(normals);
    case Orientation::kGround:
      return "oriented by propagation, the ground upward" + interiors(normals) + "; " +
             uncertain_patches(normals);
    case Orientation::kInward:
      return "oriented by propagation, inward; " + uncertain_patches(normals);
    default:
      return "not oriented";
  }
}

std::string describe_normals(const NormalFacts& normals) {
  const std::string origin = normals.source == NormalSource::kPoles
                                 ? "directions to the poles of the Voronoi cells"
                                 : "estimated from up to " + std::to_string(normals.neighbors) +
                                       " neighbours within " + format_number(normals.max_radius);
  std::string line = "normals: " + origin + ", " + describe_orientation(normals);
  if (normals.patches > 0)
    line += " (" + format_count(normals.contested) + " of " + format_count(normals.patches) +
            " patches)";
  return line;
}

void warn_of_orientation(StageRunner& runner, const NormalFacts& normals) {
  warn_of_contested(runner, normals);
  tell_of_doubtful(runner, normals);
}

}  // namespace orbweave
