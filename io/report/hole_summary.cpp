#include "io/report/hole_summary.h"

#include <algorithm>
#include <map>
#include <string_view>

#include "io/report/reasons.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// True for a character inside a number such as 3,000 or 1.5e-07.
bool continues_number(std::string_view text, std::size_t i) {
  const char next = i + 1 < text.size() ? text[i + 1] : ' ';
  if (text[i] == 'e') return is_digit(next) || next == '-' || next == '+';
  const bool may_stand_inside =
      text[i] == '.' || text[i] == ',' || text[i] == '-' || text[i] == '+';
  return is_digit(text[i]) || (may_stand_inside && is_digit(next));
}

/// The text with its numbers as "#", so that texts that differ in numbers alone are one kind; the
/// number of a hole as "another hole".
std::string without_numbers(std::string_view text) {
  std::string kept;
  bool in_number = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool was_in_number = in_number;
    in_number = is_digit(text[i]) || (in_number && continues_number(text, i));
    if (!in_number) kept += text[i];
    if (in_number && !was_in_number) kept += '#';
  }
  constexpr std::string_view kNumbered = "hole #";
  for (auto at = kept.find(kNumbered); at != std::string::npos; at = kept.find(kNumbered, at))
    kept.replace(at, kNumbered.size(), "another hole");
  return kept;
}

std::string kind_of(const HoleFacts& hole) {
  std::string decided = text_of(hole.open);
  if (!decided.empty()) return decided;
  return hole.reason.empty() ? "not filled" : without_numbers(hole.reason);
}

Counted by_frequency(const std::map<std::string, std::uint64_t>& counts) {
  Counted sorted(counts.begin(), counts.end());
  std::ranges::stable_sort(sorted,
                           [](const auto& a, const auto& b) { return a.second > b.second; });
  return sorted;
}

}  // namespace

HoleSummary hole_summary(std::span<const HoleFacts> holes) {
  HoleSummary summary;
  std::map<std::string, std::uint64_t> methods, reasons;
  double largest = 0.0;
  for (const HoleFacts& hole : holes) {
    ++summary.loops;
    ++(hole.filled ? summary.filled : summary.open);
    ++(hole.filled ? methods[hole.method] : reasons[kind_of(hole)]);
    summary.partly += hole.open_edges > 0 ? 1 : 0;
    summary.open_edges += hole.open_edges;
    if (hole.filled && hole.joined_to == 0 && hole.confidence < kDoubtful) {
      ++summary.doubtful;
      summary.doubtful_area += hole.area;
      if (hole.area > largest) summary.most_doubtful = hole.center;
      largest = std::max(largest, hole.area);
    }
    summary.points_added += hole.points_added;
    summary.triangles_added += hole.triangles_added;
  }
  summary.methods = by_frequency(methods);
  summary.reasons = by_frequency(reasons);
  return summary;
}

std::uint64_t sum_of(const Counted& counts) {
  std::uint64_t sum = 0;
  for (const auto& [what, count] : counts) sum += count;
  return sum;
}

std::string counted_list(const Counted& counts, std::size_t most) {
  std::string text;
  std::uint64_t others = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (i >= most) {
      others += counts[i].second;
      continue;
    }
    text += (text.empty() ? "" : ", ") + format_count(counts[i].second) + " " + counts[i].first;
  }
  if (others > 0)
    text +=
        (text.empty() ? "" : ", ") + format_count(others) + (others == 1 ? " other" : " others");
  return text;
}

std::vector<const HoleFacts*> widest_holes(std::span<const HoleFacts> holes, std::size_t most) {
  std::vector<const HoleFacts*> widest;
  widest.reserve(holes.size());
  for (const HoleFacts& hole : holes) widest.push_back(&hole);
  const std::size_t kept = std::min(most, widest.size());
  std::partial_sort(widest.begin(), widest.begin() + static_cast<std::ptrdiff_t>(kept),
                    widest.end(), [](const HoleFacts* a, const HoleFacts* b) {
                      return a->diameter != b->diameter ? a->diameter > b->diameter : a->id < b->id;
                    });
  widest.resize(kept);
  return widest;
}

}  // namespace orbweave
