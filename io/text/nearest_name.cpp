#include "io/text/nearest_name.h"

#include <algorithm>
#include <limits>

namespace orbweave {
namespace {

/// Names are short; a longer word is compared by its beginning, so that a hostile one costs little.
constexpr std::size_t kComparedLength = 64;

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  a = a.substr(0, kComparedLength);
  b = b.substr(0, kComparedLength);
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

bool may_mean(std::string_view word, std::string_view name) {
  constexpr std::size_t kBeginning = 3;
  if (word.size() >= kBeginning && name.starts_with(word)) return true;
  return edit_distance(word, name) <= std::max(word.size(), name.size()) * 2 / 5;
}

std::string nearest_name(std::string_view word, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t smallest = std::numeric_limits<std::size_t>::max();
  for (const std::string& name : known) {
    const std::size_t distance = edit_distance(word, name);
    if (distance >= smallest || !may_mean(word, name)) continue;
    smallest = distance;
    nearest = name;
  }
  return nearest;
}

std::string advice_on_name(std::string_view word, const std::vector<std::string>& known) {
  const std::string nearest = nearest_name(word, known);
  return nearest.empty() ? "" : "Did you mean '" + nearest + "'?";
}

}  // namespace orbweave
