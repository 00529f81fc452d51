#pragma once

#include <CLI/CLI.hpp>
#include <span>

#include "benchmarks/program/study.hpp"

namespace finegauge {

/// Each adds one command; the parsed command's number is left in `exit_code`.
void add_list_command(CLI::App& program, int& exit_code);
void add_run_command(CLI::App& program, int& exit_code);
void add_reproduce_command(CLI::App& program, int& exit_code);
void add_verify_command(CLI::App& program, int& exit_code);
void add_atlas_command(CLI::App& program, int& exit_code);
void add_trade_command(CLI::App& program, int& exit_code);
void add_audit_command(CLI::App& program, int& exit_code);
void add_merge_command(CLI::App& program, int& exit_code);
void add_profile_command(CLI::App& program, int& exit_code);
void add_report_command(CLI::App& program, int& exit_code);
void add_gate_command(CLI::App& program, int& exit_code);
void add_help_command(CLI::App& program, int& exit_code);

/// The studies of `finegauge reproduce` that exist, in the order of the paper.
std::span<const Study> paper_studies();

}  // namespace finegauge
