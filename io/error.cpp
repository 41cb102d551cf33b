#include "io/error.h"

#include "io/shown_text.h"

namespace orbweave {
namespace {

std::string compose(const std::string& problem, const ErrorParts& parts) {
  std::string text;
  if (!parts.file.empty()) text += parts.file + ": ";
  if (!parts.place.empty()) text += parts.place + ": ";
  text += problem;
  if (!parts.found.empty()) text += "; found " + parts.found;
  if (!parts.expected.empty())
    text += (parts.found.empty() ? "; expected " : ", expected ") + parts.expected;
  // What was told may be an error's whole text, which may end in an advice of its own.
  if (!parts.advice.empty()) text += (text.ends_with('.') ? " " : ". ") + parts.advice;
  return shown(text);
}

}  // namespace

Error::Error(ErrorKind kind, const std::string& problem, ErrorParts parts)
    : std::runtime_error(compose(problem, parts)),
      kind_(kind),
      problem_(problem),
      parts_(std::move(parts)) {}

void throw_usage(const std::string& problem, ErrorParts parts) {
  throw Error(ErrorKind::kUsage, problem, std::move(parts));
}
void throw_bad_input(const std::string& problem, ErrorParts parts) {
  throw Error(ErrorKind::kBadInput, problem, std::move(parts));
}
void throw_resource(const std::string& problem, ErrorParts parts) {
  throw Error(ErrorKind::kResource, problem, std::move(parts));
}

}  // namespace orbweave
