#include "benchmarks/paper/lshape_options.hpp"

#include <map>
#include <stdexcept>

#include "benchmarks/program/command.hpp"

namespace finegauge {
namespace {

double number(const std::string& key, const std::string& text) {
  try {
    std::size_t end = 0;
    const double value = std::stod(text, &end);
    if (end == text.size() && value > 0.0 && value <= 1.0) return value;
  } catch (const std::exception&) {
  }
  throw UsageError("--set " + key + ": found \"" + text + "\", allowed is a number in (0, 1]");
}

}  // namespace

LshapeStudyOptions read_lshape_options(const StudyContext& context) {
  static const std::map<std::string, NotchCorner> notches = {{"lower_left", NotchCorner::lower_left},
                                                             {"lower_right", NotchCorner::lower_right},
                                                             {"upper_left", NotchCorner::upper_left},
                                                             {"upper_right", NotchCorner::upper_right}};
  LshapeStudyOptions read;
  LshapeRunOptions& options = read.run;
  options.solver.method = LinearMethod::multigrid;
  options.directional.theta = 0.3;
  for (const auto& [key, value] : context.overrides) {
    if (key == "theta") {
      options.theta = number(key, value);
    } else if (key == "directional_theta") {
      options.directional.theta = number(key, value);
    } else if (key == "notch" || key == "clamped" || key == "roller" || key == "loaded") {
      read.default_problem = false;
      if (key == "notch" && !notches.contains(value))
        throw UsageError("--set notch: found \"" + value +
                         "\", allowed are lower_left, lower_right, upper_left, upper_right");
      if (key == "notch") options.problem.notch = notches.at(value);
      if (key == "clamped") options.problem.clamped = value;
      if (key == "roller") options.problem.roller = value;
      if (key == "loaded") options.problem.loaded = value;
    } else {
      throw UsageError("--set " + key +
                       ": unknown; lshape knows notch, clamped, roller, loaded, theta, directional_theta");
    }
  }
  try {
    LshapeProblem probe = lshape_problem(options.problem);
  } catch (const std::invalid_argument& fault) {
    throw UsageError(fault.what());
  }
  return read;
}

}  // namespace finegauge
