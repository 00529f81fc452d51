#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/hanging_nodes.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "core/space/loads.hpp"
#include "core/space/supports.hpp"
#include "verification/support/evidence.hpp"
#include "verification/support/property.hpp"

namespace finegauge {

/// A simulation that refines and coarsens for hours must not wear its mesh out. Random histories of refinements and
/// coarsenings, by every template, nested and mixed, on bodies of both cell shapes.

struct HistoryBody {
  std::string name;
  std::uint32_t seed = 0;  ///< of its histories
  BaseMesh base;
  std::vector<SupportCondition> supports;
  std::vector<SurfaceLoad> loads;  ///< beside a body force that varies in space
};
/// A box; the same of distorted cells whose neighbours see their faces in different frames; MacNeal & Harder's patch;
/// six distorted tetrahedra; a torus that fills the cells of a lattice in part.
std::vector<HistoryBody> history_bodies();
/// The `number`-th history of a body; every template of its shape.
ForestHistory drawn_history(const HistoryBody& body, std::uint32_t number);

/// All that a mesh brings into a simulation: for comparison bit by bit.
struct MeshImprint {
  Mesh mesh;
  HangingNodes T;
  std::vector<int> pattern, held;  ///< columns of the reduced matrix; reduced nodes that are held
  Eigen::VectorXd stiffness;       ///< of a corotational material, rotations at a smooth field of displacements [N/m]
  Eigen::Matrix3Xd loads;          ///< [N]
  Eigen::VectorXd mass;            ///< [kg]
};
MeshImprint imprint(const RefinementForest& forest, const HistoryBody& body);
/// The first of the above that is not the same to the last bit, in words; empty when all is. Handles in the forest are
/// compared only where asked.
std::string difference(const MeshImprint& a, const MeshImprint& b, bool handles = false);

/// Of two errors, and not a number when either is none, so that no error gets lost.
inline double larger_error(double a, double b) { return std::isnan(a) || b <= a ? a : b; }

/// The statements, as property.hpp wants them.
///
/// Taken back operation by operation, a history passes through the states that it came through, bit by bit, the middle
/// one and the first with everything that follows from the mesh; and coarsening all at the end of it, in any order,
/// leaves the base mesh, handles included.
std::string fault_in_return(const HistoryBody& body, const ForestHistory& history);
/// The refinements that a history leaves, done on a fresh forest parents first, or in random orders with detours that
/// are undone, give the same mesh, numbering and T.
std::string fault_in_order(const HistoryBody& body, const ForestHistory& history);
/// After every operation T is what hanging_nodes.hpp promises, within interpolation_round_off.
std::string fault_in_interpolation(const HistoryBody& body, const ForestHistory& history);

/// What T does on one mesh.
struct InterpolationErrors {
  double row_sum = 0.0;     ///< largest |Σ weights - 1|
  double linear = 0.0;      ///< largest error of the rest positions, taken as a field, over the body's size
  double conformity = 0.0;  ///< largest jump between leaves of a random field of size one; only where asked
  int chains = 0;  ///< entries of T that name a node that hangs, and rows of free nodes that are not the node itself
  int lost = 0;    ///< entries of gather(expand(x)) that are not x, bit by bit
  int hanging = 0, longest_chain = 0;
};
/// Two hundred units of round-off: rows have some dozens of terms, weights of hanging nodes through up to nine levels
/// of chains.
inline constexpr double interpolation_round_off = 200 * std::numeric_limits<double>::epsilon();
InterpolationErrors interpolation_errors(const RefinementForest& forest, const Mesh& mesh, bool conformity);

/// How much of the space of refinements the histories of a body visited, and what was found.
struct HistoryRow {
  std::string body;
  int histories = 0, operations = 0, coarsenings = 0;
  std::vector<RefinementTemplate> templates;  ///< that were tried, ascending
  int most_leaves = 0, deepest = 0;
  int broken_returns = 0, broken_orders = 0, broken_interpolations = 0;  ///< statements: 0 or 1
  InterpolationErrors worst;                 ///< over all states; conformity over the last of each history
  std::vector<std::string> counterexamples;  ///< as text that can be replayed
};
HistoryRow try_histories(const HistoryBody& body, std::span<const std::uint32_t> numbers);

/// Eigenvalues of the explicit Tᵀ K T without supports, at rest, of small meshes with hanging nodes.
struct NullSpaceRow {
  std::string body;
  int meshes = 0, most_dofs = 0, most_hanging = 0;
  int fewest_modes = 0, most_modes = 0;  ///< eigenvalues below 1e-11 of the largest
  double largest_zero = 0.0;             ///< sixth smallest eigenvalue over the largest
  double smallest_stiff = 1.0;           ///< seventh smallest over the largest
  double rigid_force = 0.0;              ///< largest ‖A r‖ / (‖A‖ ‖r‖) of a rigid motion r
  double assembly_error = 0.0;           ///< assemble_stiffness against Tᵀ K T, entry by entry, over the largest
};
NullSpaceRow null_space(const HistoryBody& body, std::span<const std::uint32_t> seeds);

/// A state carried to a finer mesh, refinement by refinement, and back the same way.
///
/// A node that does not hang is a corner of every leaf that holds it, and of a child there wherever such a leaf is
/// refined: its displacement is copied both ways, and hanging ones follow from the same numbers by the same T. So
/// displacements come back bit by bit. There is one exception, in about one of three hundred random histories: where
/// unlike templates meet, a refinement can make a node hang that did not. Its value is then interpolated and comes back
/// up to round-off, on some meshes with a unit of it more on every trip. Velocities do not come back: coarsening keeps
/// the momentum instead (tissue_step.hpp).
struct RoundTrip {
  ForestHistory start, there;  ///< from the base mesh; then refinements only
};
RoundTrip drawn_round_trip(const HistoryBody& body, std::span<const RefinementTemplate> templates, std::uint32_t seed);
/// The exception, as shrunk from random histories while T took pivots of small coefficients: on the box the node came
/// back once and for all, on the patch it drifted. Now both come back bit by bit.
RoundTrip box_with_a_node_that_comes_to_hang();
RoundTrip patch_with_a_node_that_comes_to_hang();

struct RoundTripRow {
  std::string body, what;
  int cases = 0, trips = 0, values = 0;  ///< each case makes all trips; displacements of all cases
  int came_to_hang = 0;                  ///< nodes that do not hang at the start, and do on the finest mesh
  int changed = 0;                       ///< displacements that are not the same number after all trips
  double largest_change = 0.0;           ///< over the largest displacement, after one trip
  double drift = 0.0;                    ///< the same after all trips
  double momentum = 0.0;                 ///< largest change of the linear momentum in a transfer, over mass × speed
  double kinetic_growth = -1.0;          ///< largest of a case's first trip, over the energy before
  double velocity_change = 0.0;          ///< root mean square after one trip, over that of the velocities
};
RoundTripRow make_round_trips(const HistoryBody& body, const std::string& what, const std::vector<RoundTrip>& cases,
                              int trips);

/// What a forest holds after cycles of refining and coarsening everything.
struct StorageRow {
  std::string body;
  int cycles = 0;
  double first_bytes = 0.0, last_bytes = 0.0;  ///< after the first and the last cycle of the same history
  int first_peak = 0, last_peak = 0;           ///< largest handle_count within these cycles
  int left = 0;                                ///< handles beyond the base cells' after the last
  double fragmentation = 0.0;  ///< of a refined place that wanders: peak of handles over that of cells in use
};
StorageRow storage(const HistoryBody& body, int cycles);

/// Statements that are false on purpose, and what is left of histories that show it.
struct ShrinkRow {
  std::string statement;
  int drawn = 0, shrunk = 0, runs = 0;
  int expected = 0;                       ///< operations that it takes; 0 where that depends on the history
  int spare = 0;                          ///< operations that could still be left out, one at a time
  bool replays = false, is_right = true;  ///< the text read back breaks it too; what is left is what was put in
  std::string history;
};
std::vector<ShrinkRow> shrink_broken_statements(const HistoryBody& body, std::span<const std::uint32_t> numbers);

Evidence reversibility_evidence(const EvidenceOptions& options);

}  // namespace finegauge
