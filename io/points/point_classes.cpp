#include "io/points/point_classes.h"

namespace orbweave {
namespace {

constexpr std::array<const char*, 19> kClassNames = {
    "never classified",  "unclassified",    "ground",         "low vegetation",
    "medium vegetation", "high vegetation", "building",       "low point",
    "model key point",   "water",           "rail",           "road",
    "overlap",           "wire guard",      "wire conductor", "transmission tower",
    "wire connector",    "bridge deck",     "high noise"};

}  // namespace

std::string plain_name_of_class(int number) {
  const auto index = static_cast<std::size_t>(number);
  return index < kClassNames.size() ? kClassNames[index] : "";
}

std::string name_of_class(int number) {
  const std::string name = plain_name_of_class(number);
  return "class " + std::to_string(number) + (name.empty() ? "" : " (" + name + ")");
}

std::string text_of_dropped_class(int number) { return name_of_class(number) + " left out"; }

}  // namespace orbweave
