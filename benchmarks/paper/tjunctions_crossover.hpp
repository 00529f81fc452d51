#pragma once

#include <map>
#include <optional>
#include <vector>

#include "benchmarks/paper/lshape_sequences.hpp"
#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// A mesh with hanging nodes beside the uniform, conforming one of the same true error on the L-shape, found between
/// two uniform meshes in logarithms. Not a number where the uniform meshes do not reach that far.
struct EqualError {
  LshapeScheme scheme;
  LshapeStep step;
  double true_error = 0.0;
  double conforming_dofs = 0.0, conforming_ms = 0.0;
  double all_steps_ms = 0.0;  ///< every mesh on the way to this one

  double gain() const { return conforming_ms / step.total_ms(); }  ///< of the last step
  double gain_with_the_way() const { return conforming_ms / all_steps_ms; }
};
/// Precondition: the uniform sequence has a mesh, and both start on it.
std::vector<EqualError> equal_errors(const LshapeSequences& study, LshapeScheme scheme);

/// Where a gain passes one for good: true error and dofs of the mesh with hanging nodes, in logarithms between two
/// meshes. None where it never does, or is above one from the first mesh on.
struct Crossover {
  double true_error = 0.0, dofs = 0.0;
};
std::optional<Crossover> find_crossover(const std::vector<EqualError>& meshes, double (EqualError::*gain)() const);

Json to_json(const EqualError& mesh);

}  // namespace finegauge
