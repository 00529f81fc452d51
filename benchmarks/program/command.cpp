#include "benchmarks/program/command.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>

#include "benchmarks/program/interrupt.hpp"
#include "core/parallel/for_parts.hpp"

namespace finegauge {
namespace {

std::string number(double value, int digits) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

/// "eta: 0.104397 is not in [0, 0.1]": six digits, unless these do not tell the value from the bound that it violates.
std::string describe_failure(const Json& failed) {
  const auto value_of = [&](const char* key) {
    return failed.at(key).is_number() ? failed.at(key).get<double>() : std::nan("");
  };
  const double value = value_of("value"), low = value_of("low"), high = value_of("high");
  const std::string low_text = number(low, 6), high_text = number(high, 6);
  std::string text = std::isfinite(value) ? number(value, 6) : "none";
  if (text == low_text || text == high_text) text = number(value, 17);
  return failed.at("name").get<std::string>() + ": " + text + " is not in [" + low_text + ", " + high_text + "]";
}

}  // namespace

void add_common_options(CLI::App& command, CommonOptions& options, const std::string& set_help) {
  command.add_option("-o,--out", options.out,
                     "Directory of the result files (default: results/NAME, or results/NAME_COMMAND where another "
                     "command's stand there)");
  command.add_option("--set", options.set, set_help)->allow_extra_args(false)->type_name("KEY=VALUE");
  command
      .add_option(
          "--threads", options.threads,
          "Threads that share the loops over cells, nodes and rows (default: 1); results have the same bits for "
          "any number. Factors, solves with them and changes of the mesh are made by one: the sums of BLAS "
          "depend on how many share them")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  command
      .add_option("--vtu", options.vtu_every,
                  "Write a VTU file for ParaView every N steps or frames and after the last one")
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
    if (equals == std::string::npos || equals == 0) throw UsageError("--set " + text + ": expected KEY=VALUE");
    overrides[text.substr(0, equals)] = text.substr(equals + 1);
  }
  return overrides;
}

void require_writable(const std::filesystem::path& directory) {
  const auto refuse = [&](const std::string& found) {
    throw UsageError("--out " + directory.string() + ": found " + found + ", allowed a directory that can be written");
  };
  std::error_code error;
  std::filesystem::path existing = std::filesystem::absolute(directory, error).lexically_normal();
  // A link that leads nowhere exists too: nothing can be created in its place.
  const auto missing = [&](const std::filesystem::path& path) {
    return std::filesystem::symlink_status(path, error).type() == std::filesystem::file_type::not_found;
  };
  // Below a file the status is "not a directory" and not "not found", so the file itself is met on the way up.
  while (existing.has_relative_path() && (missing(existing) || error == std::errc::not_a_directory))
    existing = existing.parent_path();
  if (!std::filesystem::is_directory(existing, error)) {
    if (error == std::errc::permission_denied) refuse(existing.string() + ", which cannot be reached");
    const std::string kind = std::filesystem::is_symlink(existing, error) ? "a link to no directory" : "a file";
    const bool itself = existing == std::filesystem::absolute(directory, error).lexically_normal();
    refuse(itself ? kind : kind + " in its path, " + existing.string());
  }
  // Permissions do not tell all (a superuser, a read-only file system): only trying does.
  std::string probe = (existing / ".finegauge.XXXXXX").string();
  if (!::mkdtemp(probe.data())) refuse(existing.string() + ", which cannot be written: " + std::strerror(errno));
  ::rmdir(probe.c_str());
}

std::filesystem::path result_directory(const CommonOptions& options, const std::string& name, const std::string& kind) {
  const std::filesystem::path usual = options.directory(name);
  if (!options.out.empty()) return usual;
  std::ifstream file(usual / (name + ".json"));
  std::string head(512, '\0');  // the kind stands in the first lines of a document
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  const bool of_another =
      head.find("\"kind\": \"") != std::string::npos && head.find("\"kind\": \"" + kind + "\"") == std::string::npos;
  return of_another ? std::filesystem::path(usual.string() + "_" + kind) : usual;
}

void use_threads(int count) {
  set_thread_count(count);
  // Found at run time: which BLAS and whether OpenMP is the installation's choice, not ours. Older CHOLMODs ask for
  // four threads whatever OpenMP's number is, so no parallel region may be active but those of for_parts.
  using Setter = void (*)(int);
  const auto set = [](const char* name, int value) {
    if (void* symbol = dlsym(RTLD_DEFAULT, name)) reinterpret_cast<Setter>(symbol)(value);
  };
  set("openblas_set_num_threads", 1);
  set("omp_set_num_threads", 1);
  set("omp_set_max_active_levels", 0);
}

int finish(ResultDocument& document, const CommonOptions& options, const std::filesystem::path& directory,
           const Progress& progress) {
  if (document.environment.seconds == 0.0) document.environment.seconds = progress.seconds();  // else of the parts
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
    if (!item.at("ok").get<bool>()) std::fprintf(stderr, "failed: %s\n", describe_failure(item).c_str());
  if (signal) {
    std::fprintf(stderr, "interrupted; what was finished is kept\n");
    return 128 + signal;
  }
  return all_checks_hold(document.checks) ? exit_ok : exit_check_failed;
}

}  // namespace finegauge
