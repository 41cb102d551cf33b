// Names that are told apart.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace orbweave {

/// Hands out names, no two alike: a name that is taken becomes NAME_2, NAME_3, ...
class DistinctNames {
 public:
  /// What a reader takes a name for; names that it takes for the same are alike.
  using Meaning = std::function<std::string(const std::string&)>;

  /// `taken`: names that are not to be given away. `meaning`: the name itself where it is empty.
  explicit DistinctNames(std::set<std::string> taken, Meaning meaning = {})
      : taken_(std::move(taken)), meaning_(std::move(meaning)) {}

  /// Whether the name was free; it is taken from then on.
  bool take(const std::string& name) {
    return taken_.insert(meaning_ ? meaning_(name) : name).second;
  }
  /// The wanted name, or the next one that is free.
  std::string give(const std::string& wanted) {
    std::string name = wanted;
    while (!take(name))
      name = wanted + "_" + std::to_string(++copies_.try_emplace(wanted, 1).first->second);
    return name;
  }

 private:
  std::set<std::string> taken_;
  Meaning meaning_;
  std::map<std::string, int> copies_;  ///< so that thousands of one name do not count from 2 on
};

}  // namespace orbweave
