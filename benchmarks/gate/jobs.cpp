#include "benchmarks/gate/jobs.hpp"

#include <fstream>
#include <iterator>

#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

std::string content(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::string first_line(const std::string& text) { return quoted_excerpt(text.substr(0, text.find('\n')), 300); }

std::string failure_of(const ProcessEnd& end, double seconds_allowed, const std::string& complaint) {
  const std::string line = first_line(complaint);
  return describe(end, seconds_allowed) + (line.empty() ? "" : ": " + line);
}

bool reached_its_end(const ProcessEnd& end) {
  return !end.timed_out && !end.interrupted && (end.exit_code == 0 || end.exit_code == 1);
}

}  // namespace

std::filesystem::path JobRunner::this_program() { return std::filesystem::read_symlink("/proc/self/exe"); }

JobRunner::Files JobRunner::files_for_next() {
  const std::filesystem::path folder = temporary_.path() / std::to_string(++jobs_);
  return {folder, folder.string() + ".out", folder.string() + ".err"};
}

std::vector<std::string> JobRunner::command_line(const std::filesystem::path& program, const JobWords& words,
                                                 const Files& files) const {
  std::vector<std::string> line = {program.string()};
  line.insert(line.end(), words.begin(), words.end());
  line.insert(line.end(), {"--out", files.folder.string(), "--json", "--quiet"});
  return line;
}

JobResult JobRunner::run(const std::filesystem::path& program, const JobWords& words) {
  const Files files = files_for_next();
  const ProcessEnd end = run_process(command_line(program, words, files), files.out, files.err, seconds_allowed_);
  JobResult result;
  result.exit_code = end.exit_code;
  result.seconds = end.seconds;
  if (reached_its_end(end)) {
    Json document = Json::parse(content(files.out), nullptr, /*allow_exceptions=*/false);
    if (document.is_object() && document.value("schema", "") == "finegauge/1")
      result.document = std::move(document);
    else
      result.failure =
          "no result document on its standard output; " + failure_of(end, seconds_allowed_, content(files.err));
  } else {
    result.failure = failure_of(end, seconds_allowed_, content(files.err));
  }
  std::filesystem::remove_all(files.folder);
  return result;
}

CountedInstructions JobRunner::count_instructions(const std::filesystem::path& program, const JobWords& words,
                                                  const std::string& within) {
  const Files files = files_for_next();
  const std::string log = files.folder.string() + ".callgrind";
  if (run_process({"valgrind", "--version"}, files.out, files.err, seconds_allowed_).exit_code != 0)
    return {{}, true, "valgrind is not installed"};
  std::vector<std::string> line = {"valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null",
                                   "--log-file=" + log};
  if (!within.empty()) line.push_back("--toggle-collect=" + within);
  const std::vector<std::string> job = command_line(program, words, files);
  line.insert(line.end(), job.begin(), job.end());
  const ProcessEnd end = run_process(line, files.out, files.err, seconds_allowed_);
  const std::string told = content(log);
  std::filesystem::remove_all(files.folder);
  if (told.find("unhandled instruction") != std::string::npos ||
      told.find("Unrecognised instruction") != std::string::npos)
    return {{},
            true,
            "valgrind does not know the instructions of " + program.string() +
                "; it does those of a build with -DFINEGAUGE_NATIVE=OFF"};
  if (!reached_its_end(end)) return {{}, false, failure_of(end, seconds_allowed_, content(files.err))};
  const std::string key = "Collected :";
  const std::size_t at = told.find(key);
  const double count = at == std::string::npos ? 0.0 : std::strtod(told.c_str() + at + key.size(), nullptr);
  if (!(count > 0.0))
    return {{}, false, "callgrind counted no instructions" + (within.empty() ? "" : " within " + within)};
  return {count, false, {}};
}

}  // namespace finegauge
