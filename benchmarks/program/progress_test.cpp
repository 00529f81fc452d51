#include "benchmarks/program/progress.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <vector>

#include "verification/support/catch.hpp"
#include "verification/support/temporary_file.hpp"

using namespace finegauge;

TEST_CASE("the progress that is shown never falls", "[progress]") {
  const TemporaryFile file("progress", "");
  const int terminal = dup(STDERR_FILENO), out = open(file.path().c_str(), O_WRONLY | O_TRUNC);
  REQUIRE(out >= 0);
  dup2(out, STDERR_FILENO);
  {
    Progress progress(false);
    int step = 0;
    for (const double fraction : {0.1, 0.5, 0.3, -1.0, 0.6, 1.5, 0.2}) {
      progress.update(fraction, "step " + std::to_string(++step));
      progress.update(fraction, "step " + std::to_string(step));  // nothing new to tell
    }
  }
  std::fflush(stderr);
  dup2(terminal, STDERR_FILENO);
  close(terminal), close(out);
  std::vector<int> shown;
  std::ifstream in(file.path());
  for (std::string line; std::getline(in, line);) shown.push_back(std::stoi(line));
  CHECK(shown == std::vector<int>{10, 50, 50, 50, 60, 100, 100});
}
