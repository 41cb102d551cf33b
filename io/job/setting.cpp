#include "io/job/setting.h"

#include <algorithm>

#include "io/job/job_file.h"
#include "io/job/job_keys.h"

namespace orbweave {
namespace {

const JobKey* find_key(std::string_view name) {
  const auto keys = job_keys();
  const auto known =
      std::ranges::find_if(keys, [&](const JobKey& key) { return key.name() == name; });
  return known == keys.end() ? nullptr : &*known;
}

bool names_option(const Job& job, const JobKey* key) {
  return job.run.is_from_command_line && key != nullptr && *key->option != '\0';
}

}  // namespace

std::string setting_name(const Job& job, std::string_view name) {
  const JobKey* key = find_key(name);
  return names_option(job, key) ? std::string("--") + key->option : std::string(name);
}

std::string setting(const Job& job, std::string_view name, std::string_view value) {
  const JobKey* key = find_key(name);
  const std::string option = setting_name(job, name);
  if (!names_option(job, key)) {
    Job example;
    set_job_key(example, name, value);
    return option + " = " +
           (key == nullptr ? std::string(value) : value_text(key->get(example), key->type));
  }
  if (*key->option_value == '\0') return option + " " + std::string(value);
  return key->option_value == value ? option : "no " + option;
}

}  // namespace orbweave
