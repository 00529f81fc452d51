#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "core/adapt/error_estimate.hpp"
#include "core/adapt/marking.hpp"
#include "core/elasticity/cell_response.hpp"
#include "core/space/lumped_mass.hpp"
#include "core/space/transfer.hpp"
#include "core/tissue_forces.hpp"
#include "core/tissue_step.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/cut_body.hpp"
#include "verification/support/deformed_body.hpp"
#include "verification/support/tissue_samples.hpp"

using namespace finegauge;

namespace {

TissueMesh partly_filled(const RefinementForest& forest, const TissueProblem& problem, std::vector<double> shares) {
  Mesh mesh = forest.leaf_mesh();
  mesh.fraction = std::move(shares);
  return build_tissue_mesh(forest, std::move(mesh), problem);
}

/// A box of 4 × 4 × 4 cells of which a few are refined, cut by an oblique plane that leaves cells of every share and
/// some wholly empty.
const HalfSpace oblique{{1.0, 0.7, -0.4}, 0.7};

RefinementForest refined_box() {
  BoxMeshOptions options;
  options.cells = {4, 4, 4};
  RefinementForest forest(box_mesh(options));
  for (const int cell : {0, 21, 26, 42, 43, 63}) forest.refine(cell, {{2, 2, 2}});
  return forest;
}

}  // namespace

TEST_CASE("each cell's stiffness counts with its share, at least a hundredth", "[partly filled]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  CAPTURE(int(shape), int(kinematics));
  std::mt19937 generator(31);
  const RefinementForest forest = random_body({.shape = shape}, generator);
  Discretization d = discretize(forest, soft_problem(kinematics).material, {});
  REQUIRE(d.hanging.hanging_count() > 0);
  const Eigen::Matrix3Xd u = bent_and_turned(d.mesh, d.hanging, 0.1, 1.0), w = random_field(d, 1.0, generator);
  const std::vector<double> shares = random_shares(d.mesh, generator);
  REQUIRE(std::count(shares.begin(), shares.end(), 0.0) > 3);

  // Cell by cell, each alone, its share taken by hand.
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * d.mesh.node_count(), 3 * d.mesh.node_count());
  Eigen::Matrix3Xd f = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  double energy = 0.0;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const double share = shares[cell] < 0.01 ? 0.01 : shares[cell];
    const CellVectors X = corner_values(d.mesh, cell, d.mesh.nodes), x = X + corner_values(d.mesh, cell, u);
    const CellGeometry geometry = cell_geometry(shape, X);
    const CellMatrix K_e = share * cell_stiffness(shape, geometry, d.shapes.material());
    const Eigen::Matrix3d R = cell_rotation(geometry, d.shapes.material(), x);
    const CellVectors f_e = cell_force(K_e, R, X, x), local = R.transpose() * x - X;
    energy += local.reshaped().dot(K_e * local.reshaped());
    for (int a = 0; a < corner_count(shape); ++a) {
      f.col(d.mesh.cells[cell][a]) += f_e.col(a);
      for (int b = 0; b < corner_count(shape); ++b)
        K.block<3, 3>(3 * d.mesh.cells[cell][a], 3 * d.mesh.cells[cell][b]) +=
            R * K_e.block<3, 3>(3 * a, 3 * b) * R.transpose();
    }
  }
  const Eigen::MatrixXd full = nodal_stiffness(d, u);
  d.mesh.fraction = shares;
  const Eigen::SparseMatrix<double> T = interpolation_matrix(d.hanging);
  // Cells that share an entry of RestShapes are alike to 2^-42.
  const double round_off = 1e-12;
  CHECK((Eigen::MatrixXd(nodal_stiffness(d, u)) - K).norm() <= round_off * K.norm());
  CHECK((full - K).norm() > 0.1 * K.norm());
  const Eigen::MatrixXd A = to_sparse(assemble_stiffness(d, u)), TKT = T.transpose() * K * T;
  CHECK((A - TKT).norm() <= round_off * A.norm());
  CHECK((internal_forces(d, u) - f).norm() <= round_off * K.norm() * u.norm());
  CHECK_THAT(strain_energy_product(d, u), WithinRel(energy, 1e-10));
  const TissueForces forces = tissue_forces(d, u, w);
  CHECK((forces.internal - T.transpose() * f.reshaped()).norm() <= round_off * K.norm() * u.norm());
  CHECK((forces.stiff - T.transpose() * (K * w.reshaped())).norm() <= round_off * K.norm() * w.norm());
}

TEST_CASE("a mesh whose shares are all one has the bits of a mesh without shares", "[partly filled]") {
  std::mt19937 generator(32);
  const RefinementForest forest = random_body({}, generator);
  TissueProblem problem = soft_problem(Kinematics::corotational);
  problem.gravity = {0.0, -9.81, 0.0};
  problem.body = [](const Eigen::Vector3d& X) { return Eigen::Vector3d(X.y(), 1.0, X.x()); };
  const TissueMesh plain = build_tissue_mesh(forest, problem);
  const TissueMesh filled = partly_filled(forest, problem, std::vector<double>(plain.d.mesh.cells.size(), 1.0));
  CHECK(same_bits(plain.mass, filled.mass));
  CHECK(same_bits(plain.loads, filled.loads));
  TissueState state{random_field(plain.d, 0.01, generator), random_field(plain.d, 0.1, generator)}, same = state;
  TissueSystem system;
  FactorCache factors;
  (void)step_tissue(plain, problem, 0.0, 0.01, {}, direct_linear_solve(factors), system, state);
  (void)step_tissue(filled, problem, 0.0, 0.01, {}, direct_linear_solve(factors), system, same);
  CHECK(same_bits(state.u, same.u));
  const ErrorEstimate a = estimate_error_spr(plain.d, state.u), b = estimate_error_spr(filled.d, state.u);
  CHECK(same_bits(a.eta, b.eta));
  CHECK(a.relative == b.relative);
}

TEST_CASE("mass and body forces are those of the material, and empty nodes have none", "[partly filled][mass]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  CAPTURE(int(shape));
  std::mt19937 generator(33);
  const RefinementForest forest = random_body({.shape = shape, .refinements = 10}, generator);
  TissueProblem problem = soft_problem();
  problem.body = [](const Eigen::Vector3d&) { return Eigen::Vector3d(1.0, -2.0, 3.0); };
  Mesh mesh = forest.leaf_mesh();
  std::vector<double> shares = random_shares(mesh, generator);
  // So that some nodes see no material: around a corner of the body.
  const NodeCells around = cells_around_nodes(mesh);
  for (int node = 0; node < mesh.node_count(); node += 17)
    for (int k = around.start[node]; k < around.start[node + 1]; ++k) shares[around.cells[k]] = 0.0;
  const TissueMesh cut = partly_filled(forest, problem, shares);
  const double volume = material_volume(cut.d);
  REQUIRE(volume > 0.05);
  REQUIRE(volume < 0.8);
  CHECK_THAT(cut.mass.sum(), WithinRel(problem.density * volume, 1e-13));
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < cut.mass.size(); ++i) total += cut.loads.segment<3>(3 * i);
  CHECK((total - volume * Eigen::Vector3d(1.0, -2.0, 3.0)).norm() <= 1e-12 * total.norm());
  const std::vector<std::uint8_t> empty = nodes_without_material(cut.d.mesh);
  int massless = 0;
  for (Eigen::Index i = 0; i < cut.mass.size(); ++i) {
    CHECK(cut.mass[i] >= 0.0);
    massless += cut.mass[i] == 0.0;
    // A node whose own cells are empty may still carry what hangs on it.
    if (cut.mass[i] == 0.0) CHECK(empty[cut.d.hanging.node_of[i]]);
    if (cut.d.hanging.hanging_count() == 0) CHECK((cut.mass[i] == 0.0) == bool(empty[cut.d.hanging.node_of[i]]));
  }
  CHECK(massless > 0);
}

TEST_CASE("a body with empty cells falls as backward Euler says, all nodes alike", "[partly filled][tissue_step]") {
  const auto kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  const RefinementForest forest = refined_box();
  TissueProblem problem = soft_problem(kinematics);
  problem.gravity = {0.3, -9.81, 1.0};
  const TissueMesh mesh = partly_filled(forest, problem, shares_in(oblique, forest.leaf_mesh()));
  REQUIRE((mesh.mass.array() == 0.0).count() > 5);
  REQUIRE(mesh.d.hanging.hanging_count() > 0);
  TissueState state = state_at_rest(mesh);
  TissueSystem system;
  FactorCache factors;
  const double tau = 0.01;
  for (int step = 0; step < 50; ++step)
    REQUIRE(step_tissue(mesh, problem, step * tau, tau, {}, direct_linear_solve(factors), system, state).converged);
  const Eigen::Vector3d v = 50 * tau * problem.gravity, u = 0.5 * 51 * 50 * tau * tau * problem.gravity;
  // Round-off of the positions acts through the stiffness, where there is little mass more than elsewhere.
  CHECK((state.v.colwise() - v).cwiseAbs().maxCoeff() <= 1e-10 * v.norm());
  CHECK((state.u.colwise() - u).cwiseAbs().maxCoeff() <= 1e-10 * u.norm());
}

TEST_CASE("the energy ledger closes with slivers and nodes without mass", "[partly filled][tissue_step][energy]") {
  const RefinementForest forest = refined_box();
  TissueProblem problem = soft_problem();
  problem.gravity = {0.0, -9.81, 0.0};
  problem.stiffness_damping = 1e-3;
  problem.supports = {{"x_min", std::nullopt, {}}};
  const TissueMesh mesh = partly_filled(forest, problem, shares_in(oblique, forest.leaf_mesh()));
  TissueState state = state_at_rest(mesh);
  TissueSystem system;
  FactorCache factors;
  const double tau = 0.01;
  for (int step = 0; step < 50; ++step) {
    const TissueState before = state;
    REQUIRE(step_tissue(mesh, problem, 0.0, tau, {}, direct_linear_solve(factors), system, state).equilibrium_error <
            1e-10);
    const TissueWork work = tissue_work(mesh, problem, before, state, {}, tau);
    const double change = tissue_energy(mesh, state).sum() - tissue_energy(mesh, before).sum();
    const double size = std::abs(work.loads) + work.damping + work.numerical + tissue_energy(mesh, state).sum();
    REQUIRE(std::abs(change - work.sum()) <= 1e-12 * size);
  }
  CHECK(tissue_energy(mesh, state).elastic > 1e-3);
}

TEST_CASE("a change of mesh passes over nodes without mass", "[partly filled][transfer]") {
  std::mt19937 generator(34);
  RefinementForest forest = refined_box();
  const TissueProblem problem = soft_problem();
  const auto build = [&] { return partly_filled(forest, problem, shares_in(oblique, forest.leaf_mesh())); };
  const TissueMesh coarse = build();
  std::vector<int> refined;
  for (const int leaf : leaves(forest))
    if (generator() % 2 == 0) {
      forest.refine(leaf, {{2, 2, 2}});
      refined.push_back(leaf);
    }
  const TissueMesh fine = build();
  REQUIRE((fine.mass.array() == 0.0).count() > 20);
  // Exact shares: the mass does not depend on the mesh.
  CHECK_THAT(fine.mass.sum(), WithinRel(coarse.mass.sum(), 1e-12));
  const TissueState state{random_field(coarse.d, 0.02, generator), random_field(coarse.d, 1.0, generator)};
  TransferLedger there, back;
  const TissueState on_fine = transfer_state(coarse, state, fine, &there);
  // In cells that are cut the children know better where the mass is: what the old velocities lose is shared among the
  // nodes there, and the other nodes keep the field.
  CHECK(there.momentum_change <= 1e-14);
  const Eigen::Matrix3Xd field = transfer(coarse.d.mesh, state.v, fine.d.mesh);
  const Eigen::ArrayXd change = (on_fine.v - field).colwise().norm();
  CHECK((linear_momentum(fine, {state.u, field}) - linear_momentum(coarse, state)).norm() > 1e-6 * coarse.mass.sum());
  CHECK(there.moved > 20);
  CHECK(there.moved < fine.d.hanging.reduced_count());
  CHECK((change == 0.0).count() > 20);
  CHECK(change.maxCoeff() > 1e-6);
  CHECK(change.maxCoeff() < 0.05);
  for (const int parent : refined) forest.coarsen(parent);
  const TissueMesh again = build();
  const TissueState on_coarse = transfer_state(fine, on_fine, again, &back);
  CHECK(on_coarse.u.allFinite());
  CHECK(on_coarse.v.allFinite());
  CHECK(same_bits(on_coarse.u, state.u));
  CHECK(back.moved > 20);
  CHECK(back.momentum_change <= 1e-13);
  CHECK(on_coarse.v.cwiseAbs().maxCoeff() < 2.0 * on_fine.v.cwiseAbs().maxCoeff());
  // Where a body without any mass left over coarsens, there is nothing to share among.
  TissueState uniform = on_fine;
  uniform.v.colwise() = Eigen::Vector3d(1.0, -2.0, 0.5);
  const TissueState kept = transfer_state(fine, uniform, again, &back);
  CHECK((kept.v.colwise() - Eigen::Vector3d(1.0, -2.0, 0.5)).cwiseAbs().maxCoeff() <= 1e-13);
}

TEST_CASE("coarsening where no material is at all keeps the old velocities", "[partly filled][transfer]") {
  std::mt19937 generator(35);
  BoxMeshOptions options;
  options.cells = {4, 1, 1};
  RefinementForest forest(box_mesh(options));
  const TissueProblem problem = soft_problem();
  const auto filled_first = [&] {
    const Mesh mesh = forest.leaf_mesh();
    std::vector<double> shares;
    for (const LeafFrame& frame : mesh.frames) shares.push_back(frame.base_cell == 0 ? 1.0 : 0.0);
    return partly_filled(forest, problem, shares);
  };
  forest.refine(3, {{2, 2, 2}});
  const TissueMesh fine = filled_first();
  forest.coarsen(3);
  const TissueMesh coarse = filled_first();
  const TissueState state{random_field(fine.d, 0.02, generator), random_field(fine.d, 1.0, generator)};
  TransferLedger ledger;
  const TissueState after = transfer_state(fine, state, coarse, &ledger);
  CHECK(ledger.moved > 0);
  CHECK(after.v.allFinite());
  for (int c = 0; c < 8; ++c)  // the leaves of base cell 3 begin at leaf 3; its corners are its outer children's
    CHECK(after.v.col(coarse.d.mesh.cells[3][c]) == state.v.col(fine.d.mesh.cells[3 + c][c]));
}

TEST_CASE("a cell without material has no error and is never marked", "[partly filled][error]") {
  std::mt19937 generator(36);
  const RefinementForest forest = refined_box();
  const TissueMesh mesh = partly_filled(forest, soft_problem(), shares_in(oblique, forest.leaf_mesh()));
  const Eigen::Matrix3Xd u = random_field(mesh.d, 0.02, generator);
  const ErrorEstimate estimate = estimate_error_spr(mesh.d, u);
  Discretization full = mesh.d;
  full.mesh.fraction.clear();
  const CellStresses stresses = cell_stresses(mesh.d, u);
  double total = 0.0, energy = 0.0;
  int empty = 0, cut = 0;
  CellGeometry scratch;
  for (int cell = 0; cell < mesh.d.mesh.cell_count(); ++cell) {
    const double share = mesh.d.mesh.fraction[cell];
    empty += share == 0.0;
    cut += share > 0.0 && share < 0.5;
    if (share == 0.0) CHECK(estimate.eta[cell] == 0.0);
    total += estimate.eta[cell] * estimate.eta[cell];
    const CellGeometry& geometry = mesh.d.shapes.geometry(mesh.d.mesh, cell, scratch);
    for (int q = 0; q < 8; ++q) {
      const Voigt sigma = stresses.quadrature.col(8 * cell + q);
      energy += share * geometry.weights[q] * complementary_product(mesh.d.shapes.material(), sigma, sigma);
    }
  }
  REQUIRE(empty > 5);
  REQUIRE(cut > 5);
  CHECK_THAT(estimate.total, WithinRel(std::sqrt(total), 1e-12));
  CHECK_THAT(estimate.energy_norm, WithinRel(std::sqrt(energy), 1e-12));
  const std::span<const double> eta(estimate.eta.data(), static_cast<std::size_t>(estimate.eta.size()));
  for (const auto& marked :
       {mark_maximum(eta, 1e-9), mark_bulk(eta, 1.0), mark_fraction(eta, 1.0), mark_above(eta, 0.0)}) {
    CHECK(static_cast<int>(marked.size()) == mesh.d.mesh.cell_count() - empty);
    for (const int cell : marked) CHECK(mesh.d.mesh.fraction[cell] > 0.0);
  }
  // η_e² goes with the share: the same stresses in cells of half the share.
  Discretization half = mesh.d;
  for (double& share : half.mesh.fraction) share = share >= least_sampled_share ? 1.0 : share;
  const ErrorEstimate more = estimate_error_spr(half, u);
  for (int cell = 0; cell < mesh.d.mesh.cell_count(); ++cell) {
    const double share = mesh.d.mesh.fraction[cell];
    if (share >= least_sampled_share)
      CHECK_THAT(estimate.eta[cell], WithinRel(std::sqrt(share) * more.eta[cell], 1e-12));
  }
}

TEST_CASE("recovery in a cut body is exact for linear stress and deaf to cells mostly outside",
          "[partly filled][error]") {
  std::mt19937 generator(37);
  BoxMeshOptions options;
  options.cells = {6, 6, 6};
  const RefinementForest forest(box_mesh(options));
  Discretization d = discretize(forest, Material{}, {});
  d.mesh.fraction = shares_in({{1.0, 0.7, -0.4}, 0.75}, d.mesh);
  // Constant stress: no error anywhere.
  const Eigen::Matrix3d gradient = 0.01 * random_matrix(generator);
  const Eigen::Matrix3Xd u = gradient * d.mesh.nodes;
  const ErrorEstimate estimate = estimate_error_spr(d, u);
  CHECK(estimate.energy_norm > 0.1);
  CHECK(estimate.relative <= 1e-13);
  // Linear stress, and anything at all where less than half of the cell is material.
  const Eigen::Matrix<double, 6, 3> slope =
      Eigen::Matrix<double, 6, 3>::NullaryExpr([&] { return random_number(generator); });
  CellStresses stresses = cell_stresses(d, u);
  int outside = 0;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    stresses.centre.col(cell) =
        slope * (0.5 * (d.mesh.nodes.col(d.mesh.cells[cell][0]) + d.mesh.nodes.col(d.mesh.cells[cell][7])));
    if (d.mesh.fraction[cell] >= least_sampled_share) continue;
    ++outside;
    for (double& value : stresses.centre.col(cell)) value = 100.0 * random_number(generator);
  }
  REQUIRE(outside > 20);
  const auto recovered = recover_stress_spr(d, stresses);
  // At every node of a cell that is sampled, and nearly at all others that see material: a few stand where the plane
  // leaves a thin wedge, out of reach of all patches.
  const NodeCells around = cells_around_nodes(d.mesh);
  int of_the_body = 0, out_of_reach = 0;
  double error = 0.0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    double fullest = 0.0;
    for (int k = around.start[node]; k < around.start[node + 1]; ++k)
      fullest = std::max(fullest, d.mesh.fraction[around.cells[k]]);
    if (fullest == 0.0) continue;
    ++of_the_body;
    const double here = (recovered.col(node) - slope * d.mesh.nodes.col(node)).cwiseAbs().maxCoeff();
    if (fullest >= least_sampled_share)
      error = std::max(error, here);
    else
      out_of_reach += here > 1e-12;
  }
  REQUIRE(of_the_body > 200);
  CHECK(error <= 1e-12);
  CHECK(out_of_reach <= 0.01 * of_the_body);
  // Without shares the same samples are heard: the rule is what makes them deaf.
  Discretization plain = d;
  plain.mesh.fraction.clear();
  CHECK((recover_stress_spr(plain, stresses) - slope * d.mesh.nodes).cwiseAbs().maxCoeff() > 10.0);
}

TEST_CASE("in a thin body, without patches, cells mostly outside have no say as long as others are there",
          "[partly filled][error]") {
  BoxMeshOptions options;
  options.cells = {4, 4, 1};
  const RefinementForest forest(box_mesh(options));
  Discretization d = discretize(forest, Material{}, {});
  std::mt19937 generator(38);
  CellStresses stresses = cell_stresses(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
  const Voigt constant = (Voigt() << 1.0, -2.0, 3.0, 4.0, -5.0, 6.0).finished();
  d.mesh.fraction.assign(d.mesh.cells.size(), 1.0);
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    stresses.centre.col(cell) = constant;
    if (cell % 4 < 2) continue;  // by columns along x: full, full, less than half, less than half
    d.mesh.fraction[cell] = 0.4;
    for (double& value : stresses.centre.col(cell)) value = 100.0 * random_number(generator);
  }
  const auto recovered = recover_stress_spr(d, stresses);
  int deaf = 0, others = 0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    const double off = (recovered.col(node) - constant).norm();
    if (d.mesh.nodes(0, node) <= 0.5) {  // of a sampled cell
      CHECK(off <= 1e-14 * constant.norm());
      ++deaf;
    } else {
      others += off > 1.0;
    }
  }
  CHECK(deaf == 30);
  CHECK(others == 20);  // nothing but the cells that they have
}
