#include "benchmarks/paper/tjunctions_crossover.hpp"

#include <cmath>

namespace finegauge {

std::vector<EqualError> equal_errors(const LshapeSequences& study, LshapeScheme scheme) {
  std::vector<EqualError> meshes;
  const std::vector<LshapeStep>& uniform = study.sequences.at(LshapeScheme::uniform);
  const LshapeError error = [&](const LshapeStep& step) { return study.true_error(step); };
  double all_ms = 0.0;
  for (const LshapeStep& step : study.sequences.at(scheme)) {
    all_ms += step.total_ms();
    EqualError mesh{scheme, step, study.true_error(step), 0.0, 0.0, all_ms};
    if (mesh.true_error >= error(uniform.front()) * (1.0 - 1e-9)) {
      // Both sequences start on one mesh, of which a conforming method needs neither estimate nor marks.
      mesh.conforming_dofs = step.dofs, mesh.conforming_ms = step.total_ms() - step.estimate_ms - step.mark_ms;
    } else {
      const LshapeCrossing crossing = find_crossing(study, LshapeScheme::uniform, error, mesh.true_error);
      mesh.conforming_dofs = crossing.dofs, mesh.conforming_ms = crossing.step_ms;
    }
    meshes.push_back(mesh);
  }
  return meshes;
}

std::optional<Crossover> find_crossover(const std::vector<EqualError>& meshes, double (EqualError::*gain)() const) {
  std::optional<Crossover> crossover;
  for (std::size_t k = 1; k < meshes.size(); ++k) {
    const double a = (meshes[k - 1].*gain)(), b = (meshes[k].*gain)();
    if (!(std::isfinite(a) && std::isfinite(b))) break;
    if (a >= 1.0 && b < 1.0) crossover.reset();
    if (!(a < 1.0 && b >= 1.0)) continue;
    const double w = std::log(1.0 / a) / std::log(b / a);
    const auto between = [&](double x, double y) { return std::exp((1.0 - w) * std::log(x) + w * std::log(y)); };
    crossover = {between(meshes[k - 1].true_error, meshes[k].true_error),
                 between(meshes[k - 1].step.dofs, meshes[k].step.dofs)};
  }
  return crossover;
}

Json to_json(const EqualError& m) {
  Json row = {{"kind", "equal_error"},
              {"scheme", to_string(m.scheme)},
              {"dofs", m.step.dofs},
              {"cells", m.step.cells},
              {"hanging_nodes", m.step.hanging_nodes},
              {"true_error", m.true_error},
              {"total_ms", m.step.total_ms()},
              {"all_steps_ms", m.all_steps_ms},
              {"conforming_dofs", m.conforming_dofs},
              {"conforming_ms", m.conforming_ms},
              {"gain", m.gain()},
              {"gain_with_the_way", m.gain_with_the_way()}};
  if (!std::isfinite(m.conforming_ms))
    for (const char* key : {"conforming_dofs", "conforming_ms", "gain", "gain_with_the_way"})
      row[std::string(key) + "_reason"] = "the uniform meshes of the run do not reach that error";
  return row;
}

}  // namespace finegauge
