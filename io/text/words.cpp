#include "io/text/words.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "io/text/text_number.h"

namespace orbweave {

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

double finite_number(std::string_view word) {
  double number = 0.0;
  if (parse_number(word.data(), word.data() + word.size(), number) != word.data() + word.size() ||
      !std::isfinite(number))
    throw std::invalid_argument("\"" + std::string(word) + "\" is no number");
  return number;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace orbweave
