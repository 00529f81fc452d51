#include <cstdio>
#include <memory>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/report/page.hpp"
#include "benchmarks/report/report_input.hpp"

namespace finegauge {
namespace {

struct ReportCommand {
  std::vector<std::string> paths;
  std::string out = "report.html";
};

void report(const ReportCommand& asked) {
  const std::filesystem::path out = asked.out;
  std::error_code error;
  if (std::filesystem::is_directory(out, error) || !out.has_filename())
    throw UsageError("--out " + asked.out + ": found a directory, allowed the name of a file");
  require_writable(out.has_parent_path() ? out.parent_path() : ".");
  const std::vector<ReportDocument> documents = read_report_documents({asked.paths.begin(), asked.paths.end()});
  const std::string page = report_page(documents);
  write_file_atomically(out, page);
  std::size_t checks = 0, failing = 0;
  for (const ReportDocument& document : documents)
    checks += document.checks().size(), failing += document.failing_checks().size();
  std::printf("%s: %zu documents, %zu checks, %zu of them fail; %.1f MB\n", asked.out.c_str(), documents.size(), checks,
              failing, static_cast<double>(page.size()) / 1e6);
}

}  // namespace

void add_report_command(CLI::App& program, int& exit_code) {
  CLI::App* command =
      program.add_subcommand("report", "One self-contained page of results: tables, plots, mesh pictures, checks");
  const auto asked = std::make_shared<ReportCommand>();
  command->add_option("DIR", asked->paths, "Directories of results, or result documents")->required();
  command->add_option("-o,--out", asked->out, "The page (default: report.html)")->type_name("FILE");
  command->footer(
      "Reads DIR/*.json, or where DIR has none those of its directories, and the curves (CSV) and pictures (SVG) "
      "beside\n"
      "them. The page needs no network, reads in print, and is the same for the same results. What a document lacks "
      "is\n"
      "left out; a file that is no result document ends the command with exit code 2, and nothing is written. Failing\n"
      "checks are the page's first lines; the exit code is 0 all the same, since the page was made.\n"
      "\n"
      "Examples:\n"
      "  finegauge report results\n"
      "  finegauge report results/lshape results/phantom -o lshape_and_phantom.html");
  command->callback([&exit_code, asked] {
    report(*asked);
    exit_code = exit_ok;
  });
}

}  // namespace finegauge
