#include "benchmarks/program/command.hpp"

#include <dlfcn.h>

#include <cstdio>

#include "benchmarks/program/interrupt.hpp"

namespace finegauge {

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_option("-o,--out", options.out, "Directory of the result files (default: results/NAME)");
  command
      .add_option("--set", options.set,
                  "KEY=VALUE: replaces a key of the scene, such as material.poisson_ratio=0.4; repeatable")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command.add_option("--threads", options.threads, "Threads that linear algebra libraries may use (default: 1)")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  command.add_option("--vtu", options.vtu_every, "Write a VTU file for ParaView every N steps and after the last one")
      ->check(CLI::Range(1, 1000000000))
      ->type_name("N");
  CLI::Option* full = command.add_flag("--full", options.full, "All that the command can do, however long it takes");
  command.add_flag("--quick", options.quick, "A smaller version that ends in under a minute; the result says so")
      ->excludes(full);
  command.add_flag("--json", options.json, "Print the result document on standard output, and nothing else there");
  command.add_flag("--quiet", options.quiet, "No progress on standard error");
}

std::map<std::string, std::string> parse_overrides(const std::vector<std::string>& set) {
  std::map<std::string, std::string> overrides;
  for (const std::string& text : set) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw UsageError("--set " + text + ": expected KEY=VALUE, such as --set material.poisson_ratio=0.4");
    overrides[text.substr(0, equals)] = text.substr(equals + 1);
  }
  return overrides;
}

void limit_threads(int threads) {
  // Found at run time: which BLAS and whether OpenMP is the installation's choice, not ours.
  using Setter = void (*)(int);
  for (const char* name : {"openblas_set_num_threads", "omp_set_num_threads"})
    if (void* symbol = dlsym(RTLD_DEFAULT, name)) reinterpret_cast<Setter>(symbol)(threads);
}

int finish(ResultDocument& document, const CommonOptions& options, const std::filesystem::path& directory,
           const Progress& progress) {
  document.environment.seconds = progress.seconds();
  const int signal = interrupt_signal();
  if (signal) document.summary["interrupted"] = true;
  write_result(document, directory);
  if (options.json) {
    const std::string text = to_json(document).dump(2, ' ', false, Json::error_handler_t::replace);
    std::printf("%s\n", text.c_str());
    std::fflush(stdout);
  }
  progress.note("results: " + (directory / (document.name + ".json")).string() + " and files beside it");
  for (const Json& item : document.checks)
    if (!item.at("ok").get<bool>()) {
      const Json value = item.at("value").is_number() ? item.at("value") : Json("none");
      std::fprintf(stderr, "failed: %s: %s is not in [%s, %s]\n", item.at("name").get<std::string>().c_str(),
                   value.dump().c_str(), item.at("low").dump().c_str(), item.at("high").dump().c_str());
    }
  if (signal) {
    std::fprintf(stderr, "interrupted; what was finished is kept\n");
    return 128 + signal;
  }
  return all_checks_hold(document.checks) ? exit_ok : exit_check_failed;
}

}  // namespace finegauge
