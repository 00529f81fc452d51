#include <algorithm>
#include <cstdio>
#include <memory>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/commands/merge.hpp"
#include "benchmarks/program/command.hpp"

namespace finegauge {
namespace {

const MergeableKind& kind_of(const MergePart& part) {
  const auto kind = part.document.value("kind", Json());
  std::string known;
  for (const MergeableKind& one : mergeable_kinds()) {
    if (kind == one.kind) return one;
    known += (known.empty() ? "" : ", ") + std::string(one.kind);
  }
  throw UsageError("merge: " + part.directory.string() + ": found a result of kind " + kind.dump() +
                   ", allowed: " + known);
}

/// Limits and bounds are those of the program that merges.
void require_own_build(const ResultDocument& whole) {
  const Environment own = describe_environment(1);
  if (whole.environment.version != own.version || whole.environment.commit != own.commit)
    throw UsageError("merge: found parts of version " + whole.environment.version + " (" + whole.environment.commit +
                     "), allowed those of the program that merges, " + own.version + " (" + own.commit + ")");
}

int merge(const std::vector<std::string>& directories, const CommonOptions& options) {
  std::vector<MergePart> parts;
  for (const std::string& directory : directories) {
    std::error_code none;
    if (std::filesystem::equivalent(directory, options.out, none))
      throw UsageError("--out " + options.out + ": found one of the parts, allowed another directory");
    parts.push_back(read_part(directory));
  }
  const MergeableKind& kind = kind_of(parts.front());
  Progress progress(options.quiet);
  try {
    ResultDocument whole = join_parts(parts, kind);
    require_own_build(whole);
    require_writable(options.out);
    kind.conclude(parts, whole, options.out, !options.json);
    if (!options.json) std::fflush(stdout);
    return finish(whole, options, options.out, progress);
  } catch (const Json::exception& defect) {
    throw UsageError(std::string("merge: found a part that lacks what its kind of result has: ") + defect.what());
  }
}

}  // namespace

void add_merge_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand("merge", "Joins the parts of a sweep (--shard) into one result");
  const auto directories = std::make_shared<std::vector<std::string>>();
  const auto options = std::make_shared<CommonOptions>();
  command->add_option("DIR", *directories, "Directories of the parts, in any order")->required();
  command->add_option("-o,--out", options->out, "Directory of the whole result")->required();
  command->add_flag("--json", options->json, "Print the result document on standard output, and nothing else there");
  command->add_flag("--quiet", options->quiet, "No progress on standard error");
  command->footer(
      "Writes what one undivided run would have written: the same rows in the same order, summary and checks of all "
      "of\n"
      "them, the picture, the scenes of failing points. summary.parts tells on which machine and when each part ran.\n"
      "Refused are parts that are missing, unfinished (--resume goes on with them), of other commits of the program,\n"
      "or that have a row in common with other numbers in it.\n"
      "\n"
      "Example:\n"
      "  finegauge atlas --shard 1/2 -o part_1\n"
      "  finegauge atlas --shard 2/2 -o part_2\n"
      "  finegauge merge part_1 part_2 -o results/atlas");
  command->callback([&exit_code, directories, options] { exit_code = merge(*directories, *options); });
}

}  // namespace finegauge
