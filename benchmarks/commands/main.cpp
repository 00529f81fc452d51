#ifdef __linux__
#include <malloc.h>
#endif

#include <cstdio>
#include <exception>
#include <string>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/program/build_info.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "core/scene/scene_error.hpp"

namespace {

using namespace finegauge;

/// CLI11 reports a misspelt command as a missing one; this names it.
void check_command_name(const CLI::App& program, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::string known;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return;
    if (!command->get_group().empty()) known += (known.empty() ? "" : ", ") + command->get_name();
  }
  throw UsageError(std::string("no command \"") + argv[1] + "\"; there are: " + known);
}

/// Each step of a study frees and asks for the same tens of megabytes again. Giving them back to the system in between
/// costs a page fault per 4 KiB, which is a third of the time of a small step.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int gigabyte = 1 << 30;
  mallopt(M_MMAP_THRESHOLD, gigabyte);
  mallopt(M_TRIM_THRESHOLD, 2 * (gigabyte - 1));
#endif
}

int run_program(int argc, char** argv) {
  CLI::App program("finegauge: verification and benchmarks of adaptive finite element methods for surgical simulation");
  program.set_version_flag("--version",
                           std::string("finegauge ") + build_info::version + " (" + build_info::commit + ")");
  program.footer(
      "Examples:\n"
      "  finegauge list\n"
      "  finegauge run reference_data/scenes/lshape.toml --set adapt.steps=4\n"
      "  finegauge run reference_data/scenes/phantom.toml --vtu 20\n"
      "  finegauge reproduce lshape --quick\n"
      "  finegauge help scene\n"
      "\n"
      "Exit codes: 0 done, all checks hold; 1 done, but a check or the convergence failed; 2 bad input or usage,\n"
      "nothing is written; 130 or 143 interrupted, what was finished is kept.");
  program.require_subcommand(1);
  int exit_code = exit_ok;
  add_list_command(program, exit_code);
  add_run_command(program, exit_code);
  add_reproduce_command(program, exit_code);
  add_verify_command(program, exit_code);
  add_atlas_command(program, exit_code);
  add_trade_command(program, exit_code);
  add_audit_command(program, exit_code);
  add_merge_command(program, exit_code);
  add_profile_command(program, exit_code);
  add_report_command(program, exit_code);
  add_gate_command(program, exit_code);
  add_help_command(program, exit_code);
  check_command_name(program, argc, argv);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return program.exit(error);
    std::fprintf(stderr, "finegauge: %s\nRun finegauge --help, or finegauge COMMAND --help.\n", error.what());
    return exit_bad_input;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  catch_interrupts();
  try {
    return run_program(argc, argv);
  } catch (const finegauge::SceneError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return exit_bad_input;
  } catch (const finegauge::UsageError& error) {
    std::fprintf(stderr, "finegauge: %s\n", error.what());
    return exit_bad_input;
  } catch (const std::exception& error) {
    // Not the user's input: a full disk, no memory.
    std::fprintf(stderr, "finegauge: %s\n", error.what());
    return exit_check_failed;
  }
}
