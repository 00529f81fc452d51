#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace finegauge {

// The energy of the exact solution of the paper's L-shape (lshape_problem.hpp, its defaults), ∫ ε:σ, twice the stored
// energy, dimensionless. There is no closed form: it is extrapolated from graded conforming meshes, on which the
// singularities do not spoil the order. The problem is symmetric about z = 1: half the thickness is computed, with
// u_z = 0 on the plane of symmetry, and its energy doubled.

/// Exponents of the displacement, r^exponent, at the two kinds of singular edges, by the plane-strain equations of
/// Williams 1952 for wedges.
double reentrant_edge_exponent();                          ///< free faces at 270 degrees, the strongest mode
double clamped_edge_exponent(double poisson_ratio = 0.3);  ///< a clamped face at right angles to a free one

/// Meshes of one family and the order of their elements. An edge of length 2 has n cells whose ends lie at distances
/// 2 (i / n)^grading from the singular end; n is even, as edges with two singular ends are graded in halves.
/// Order 1 uses the core's hexahedra, higher orders box_elements.hpp.
struct ReferenceSequence {
  int order;
  double grading;          ///< >= 1
  std::vector<int> cells;  ///< n, ascending, three or more
};

struct LshapeReferenceRun {
  int cells_per_edge = 0;   ///< n
  int cells = 0, dofs = 0;  ///< of the half that is computed; held dofs included
  double energy = 0.0;      ///< of the whole; a lower bound of the exact one
  double relative_residual = 0.0;
  bool converged = false;
};
/// One mesh of a family. Throws std::invalid_argument on n that is odd or not positive, and on a grading below 1.
LshapeReferenceRun lshape_reference_run(int order, double grading, int cells_per_edge);

struct ExtrapolatedSequence {
  int order;
  double grading;
  std::vector<LshapeReferenceRun> runs;
  std::vector<double> exponents;   ///< of 1/n in the error, as many as were fitted
  double observed_exponent = 0.0;  ///< from the last three meshes alone
  double extrapolated = 0.0;       ///< with the finest mesh
  double without_finest = 0.0;     ///< the same of the meshes but the finest (of four meshes: with one exponent less)
};

/// E(n) = E - sum_k a_k n^-s_k exactly through the finest meshes, at most four of them: one more than the exponents s,
/// which are 2 grading × an edge's exponent for the two kinds of edges, and 2 order; the lowest come first.
ExtrapolatedSequence extrapolate(const ReferenceSequence& sequence, std::vector<LshapeReferenceRun> runs);

struct LshapeReferenceOptions {
  std::vector<ReferenceSequence> sequences = {
      {3, 3.0, {4, 6, 8, 10}}, {3, 4.0, {4, 6, 8, 10}}, {1, 2.5, {8, 12, 16, 24}}};
  std::function<void(double fraction, const std::string& doing)> progress = [](double, const std::string&) {};
};

struct LshapeReferenceEnergy {
  /// Mean of the sequences of the highest order.
  double value = 0.0;
  /// The largest of: the distance of any sequence's extrapolation from the value; what leaving out the finest mesh
  /// changes in the sequences that make the value. An estimate, not a bound; the bound is below.
  double uncertainty = 0.0;
  double lower_bound = 0.0;  ///< the largest computed energy
  bool converged = false;    ///< every solve did
  std::vector<ExtrapolatedSequence> sequences;
};
/// The defaults take about half a minute and 2.2 GB. Throws std::invalid_argument on a sequence with fewer than three
/// meshes.
LshapeReferenceEnergy lshape_reference_energy(const LshapeReferenceOptions& options = {});

/// What reference_data/exact/lshape.json stores. Throws std::runtime_error, naming the file, when it cannot be read.
struct StoredReference {
  double value = 0.0, uncertainty = 0.0;
};
StoredReference read_lshape_reference(const std::filesystem::path& file);

}  // namespace finegauge
