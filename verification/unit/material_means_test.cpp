// Where the material of a cell lies, and what the stiffness of a cell that a surface cuts makes of it.

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>

#include "core/adapt/error_estimate.hpp"
#include "core/elasticity/cell_response.hpp"
#include "core/mesh/body_location.hpp"
#include "core/mesh/immersed_body.hpp"
#include "core/mesh/material_share.hpp"
#include "core/space/assembly.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/closed_surfaces.hpp"
#include "verification/support/cut_body.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/strain_matrix.hpp"

using namespace finegauge;

namespace {

MaterialMeans means_of_only_cell(const TriangleSurface& surface) {
  const RefinementForest forest(immersed_mesh(surface, {Eigen::Vector3d::Ones(), Eigen::Vector3d::Zero()}));
  REQUIRE(forest.leaf_count() == 1);
  return forest.leaf_mesh().means[0];
}

double largest_difference(const MaterialMeans& a, const MaterialMeans& b) {
  double largest = 0.0;
  for (int k = 0; k < 6; ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

/// A box along the axes of three edge lengths.
CellVectors oblong_cell() {
  CellVectors corners;
  for (int c = 0; c < 8; ++c) corners.col(c) = Eigen::Vector3d((c & 1) * 1.0, ((c >> 1) & 1) * 0.7, (c >> 2) * 1.2);
  return corners;
}

/// In cells of 0.08, some of them refined.
RefinementForest forest_around(const TriangleSurface& surface, bool refined) {
  RefinementForest forest(immersed_mesh(surface, {Eigen::Vector3d::Constant(0.08), {}}));
  if (refined) {
    std::mt19937 generator(5);
    const RefinementTemplate templates[] = {{{2, 2, 2}}, {{3, 3, 3}}, {{2, 1, 3}}};
    for (const int leaf : leaves(forest))
      if (generator() % 4 == 0) forest.refine(leaf, templates[generator() % 3]);
  }
  return forest;
}

/// ∮ N σ n dA over the surface, reduced: each triangle in `pieces`² parts by their centres. Error like 1/pieces².
Eigen::VectorXd surface_load(const RefinementForest& forest, const Discretization& d, const TriangleSurface& surface,
                             const Eigen::Matrix3d& stress, int pieces) {
  Eigen::Matrix3Xd nodal = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  for (const auto& [i, j, k] : surface.triangles) {
    const Eigen::Vector3d a = surface.vertices.col(i), b = (surface.vertices.col(j) - a) / pieces,
                          c = (surface.vertices.col(k) - a) / pieces;
    const Eigen::Vector3d traction = stress * (0.5 * b.cross(c));
    for (int p = 0; p < pieces; ++p)
      for (int q = 0; p + q < pieces; ++q)
        for (const double third : {1.0 / 3.0, 2.0 / 3.0}) {
          if (third > 0.5 && p + q + 1 >= pieces) continue;
          const Eigen::Vector3d x = a + (p + third) * b + (q + third) * c;
          const auto place = locate_at_rest(forest.base(), x);
          REQUIRE(place);
          const LeafPoint at = find_leaf(forest, d.mesh, *place);
          const auto N = shape_functions(d.mesh.shape, at.xi);
          for (int corner = 0; corner < 8; ++corner) nodal.col(d.mesh.cells[at.cell][corner]) += N[corner] * traction;
        }
  }
  return reduce_forces(d.hanging, nodal);
}

/// What the least stiffness of cells with hardly any material makes of a displacement, reduced [N].
Eigen::VectorXd forces_of_least_stiffness(const Discretization& d, const Eigen::Matrix3Xd& u) {
  Eigen::Matrix3Xd nodal = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  CellGeometry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const double more = least_stiffness_share - material_share(d.mesh, cell);
    if (!(more > 0.0)) continue;
    const CellMatrix full = cell_stiffness(d.mesh.shape, d.shapes.geometry(d.mesh, cell, scratch), d.shapes.material());
    const Eigen::Matrix<double, 24, 1> forces = more * full * corner_values(d.mesh, cell, u).reshaped();
    for (int c = 0; c < 8; ++c) nodal.col(d.mesh.cells[cell][c]) += forces.segment<3>(3 * c);
  }
  return reduce_forces(d.hanging, nodal);
}

}  // namespace

TEST_CASE("means over material are those of shapes that one can integrate by hand", "[immersed][means]") {
  // The corner of the cell below x + y + z = 1: ∫ ξ = 1/24, ∫ ξη = 1/120, over 1/6.
  const auto corner = closed_tetrahedron(
      {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()});
  CHECK(largest_difference(means_of_only_cell(corner), {0.25, 0.25, 0.25, 0.05, 0.05, 0.05}) <= 1e-15);
  // Under a face in the plane of the cell's lid, and over one in that of its floor: such a face counts once.
  const auto hanging = closed_tetrahedron({Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(),
                                           Eigen::Vector3d(1.0, 0.0, 1.0), Eigen::Vector3d(0.0, 1.0, 1.0)});
  CHECK(largest_difference(means_of_only_cell(hanging), {0.25, 0.25, 0.75, 0.2, 0.2, 0.05}) <= 1e-15);
  for (const double lid : {1.0, 3.0})
    for (const bool upright : {false, true}) {
      const Eigen::Vector3d place(0.0, 0.0, lid - 1.0);
      // With a small box far above or below, so that the cell is looked at from both sides.
      TriangleSurface both = affine_image(Eigen::Matrix3d::Identity(), place, upright ? corner : hanging);
      const TriangleSurface box = closed_box({0.2, 0.2, 0.2}, {0.5, 0.5, lid > 2.0 ? 0.2 : 3.7});
      const auto vertices = static_cast<int>(both.vertices.cols());
      Eigen::Matrix3Xd joined(3, vertices + box.vertices.cols());
      joined << both.vertices, box.vertices;
      both.vertices = joined;
      for (const auto& t : box.triangles) both.triangles.push_back({t[0] + vertices, t[1] + vertices, t[2] + vertices});
      const RefinementForest forest(immersed_mesh(both, {Eigen::Vector3d::Ones(), Eigen::Vector3d::Zero()}));
      REQUIRE(forest.leaf_count() == 2);
      const Mesh mesh = forest.leaf_mesh();
      const int cell = mesh.fraction[0] > 0.1 ? 0 : 1;
      const double z = upright ? 0.25 : 0.75, across = upright ? 0.05 : 0.2;
      CAPTURE(lid, upright);
      CHECK(largest_difference(mesh.means[cell], {0.25, 0.25, z, across, across, 0.05}) <= 1e-14);
    }
  // A box in the cell, at its bottom and at its top: integrals from below and from above.
  for (const double lowest : {0.0, 0.5}) {
    const Eigen::Vector3d low(0.1, 0.2, lowest), high(0.7, 0.5, lowest + 0.4), m = 0.5 * (low + high);
    CHECK(largest_difference(means_of_only_cell(closed_box(high - low, m)),
                             {m[0], m[1], m[2], m[1] * m[2], m[2] * m[0], m[0] * m[1]}) <= 1e-14);
  }
}

TEST_CASE("the means of a cell's children are together those of the cell", "[immersed][means]") {
  const TriangleSurface surface = affine_image(oblique_turn(), Eigen::Vector3d(0.3, -0.2, 0.1),
                                               closed_ellipsoid(6, Eigen::Vector3d(0.5, 0.35, 0.25)));
  const auto refinement = GENERATE(RefinementTemplate{{2, 2, 2}}, RefinementTemplate{{3, 1, 4}});
  RefinementForest forest(immersed_mesh(surface, {Eigen::Vector3d(0.21, 0.17, 0.25), {}}));
  int cut = 0;
  double worst = 0.0;
  for (const int cell : leaves(forest)) {
    const RefinementForest::Cell whole = forest.cell(cell);
    if (whole.share == 0.0 || whole.share == 1.0) {
      CHECK(whole.means == means_of_full_cell);
      continue;
    }
    ++cut;
    forest.refine(cell, refinement);
    const auto& n = refinement.divisions;
    MaterialMeans sum{};
    double share = 0.0;
    for (int child = 0; child < refinement.child_count(); ++child) {
      const auto& part = forest.cell(forest.cell(cell).first_child + child);
      const std::array<int, 3> at = {child % n[0], child / n[0] % n[1], child / (n[0] * n[1])};
      const double weight = part.share / refinement.child_count();
      share += weight;
      for (int axis = 0; axis < 3; ++axis) {
        const int l = (axis + 1) % 3, m = (axis + 2) % 3;
        sum[axis] += weight * (at[axis] + part.means[axis]) / n[axis];
        sum[3 + axis] += weight *
                         (at[l] * at[m] + at[l] * part.means[m] + at[m] * part.means[l] + part.means[3 + axis]) /
                         (n[l] * n[m]);
      }
    }
    for (double& mean : sum) mean /= share;
    worst = std::max(worst, whole.share * largest_difference(sum, whole.means));
  }
  REQUIRE(cut > 20);
  CHECK(worst <= 1e-13);
  CHECK(validate(forest).empty());
}

TEST_CASE("a cell filled in part resists every motion but rigid ones, wherever its material lies",
          "[immersed][means]") {
  const auto dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  Material material;
  material.poisson_ratio = 0.49;
  material.dilatation = dilatation;
  std::mt19937 generator(3);
  const CellVectors corners = oblong_cell();
  const CellGeometry geometry = cell_geometry(CellShape::hexahedron, corners);
  const CellMatrix full = cell_stiffness(CellShape::hexahedron, geometry, material);
  const Eigen::VectorXd full_values =
      Eigen::SelfAdjointEigenSolver<CellMatrix>(full, Eigen::EigenvaluesOnly).eigenvalues();
  for (int k = 0; k < 50; ++k) {
    const double share = std::pow(10.0, -4.0 * (k % 5) / 4.0);
    MaterialMeans means;  // anything at all between 0 and 1
    for (double& mean : means) mean = 0.5 + 0.5 * random_number(generator);
    const CellMatrix K = partial_stiffness(geometry, full, material_gradients(corners, means), share, material);
    CHECK((K - K.transpose()).cwiseAbs().maxCoeff() == 0.0);
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<CellMatrix>(K, Eigen::EigenvaluesOnly).eigenvalues();
    CHECK(std::abs(values[0]) <= 1e-13 * values[23]);
    CHECK(std::abs(values[5]) <= 1e-13 * values[23]);
    CHECK(values[6] >= 0.05 * std::max(share, least_stiffness_share) * full_values[6]);
    // The same without the part of the least stiffness.
    const CellMatrix bare = K - std::max(0.0, least_stiffness_share - share) * full;
    CHECK(Eigen::SelfAdjointEigenSolver<CellMatrix>(bare, Eigen::EigenvaluesOnly).eigenvalues()[0] >=
          -1e-14 * full_values[23]);
  }
  const CellMatrix empty = partial_stiffness(geometry, full, geometry.mean_gradients, 0.0, material);
  CHECK((empty - least_stiffness_share * full).cwiseAbs().maxCoeff() == 0.0);
  // Full and even: the full matrix.
  const CellMatrix same =
      partial_stiffness(geometry, full, material_gradients(corners, means_of_full_cell), 1.0, material);
  CHECK((same - full).cwiseAbs().maxCoeff() <= 1e-14 * full.cwiseAbs().maxCoeff());
}

TEST_CASE("the stiffness of a cell filled in part is its formula with strain matrices", "[immersed][means]") {
  const auto dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  Material material;
  material.youngs_modulus = 3.0;
  material.poisson_ratio = 0.4;
  material.dilatation = dilatation;
  std::mt19937 generator(7);
  const CellVectors corners = oblong_cell();
  const CellGeometry geometry = cell_geometry(CellShape::hexahedron, corners);
  const CellMatrix full = cell_stiffness(CellShape::hexahedron, geometry, material);
  const Eigen::Matrix<double, 6, 6> D = elasticity_matrix(material);
  const StrainMatrix whole = strain_matrix(geometry.mean_gradients);
  const double V = geometry.volume;
  for (const double share : {1e-4, 0.005, 0.3, 0.99}) {
    MaterialMeans means;
    for (double& mean : means) mean = 0.5 + 0.5 * random_number(generator);
    const Gradients average = material_gradients(corners, means);
    const StrainMatrix B = strain_matrix(average);
    const CellMatrix expected = share * V * B.transpose() * D * B + share * (full - V * whole.transpose() * D * whole) +
                                std::max(0.0, least_stiffness_share - share) * full;
    const CellMatrix K = partial_stiffness(geometry, full, average, share, material);
    CHECK((K - expected).cwiseAbs().maxCoeff() <= 1e-13 * full.cwiseAbs().maxCoeff() * (share + least_stiffness_share));
  }
  // Averaged over material at a point they are the gradients at the point.
  const Eigen::Vector3d at(0.2, 0.7, 0.4);
  const Gradients there =
      material_gradients(corners, {at[0], at[1], at[2], at[1] * at[2], at[2] * at[0], at[0] * at[1]});
  const Eigen::Vector3d edges = corners.col(7) - corners.col(0);
  const Gradients expected = edges.cwiseInverse().asDiagonal() * shape_gradients(CellShape::hexahedron, at);
  CHECK((there - expected).cwiseAbs().maxCoeff() <= 1e-15);
}

TEST_CASE("a turned box under uniform stress on its own surface has that stress", "[immersed][means][patch]") {
  const bool refined = GENERATE(false, true);
  const TriangleSurface surface = closed_box({0.22, 0.17, 0.28}, Eigen::Vector3d(0.01, 0.02, -0.03), oblique_turn(), 2);
  const RefinementForest forest = forest_around(surface, refined);
  Material material;
  material.youngs_modulus = 1e4;
  material.poisson_ratio = 0.3;
  Discretization d = discretize(forest, material, {});
  CHECK((d.hanging.hanging_count() > 0) == refined);

  Eigen::Matrix3d stress;
  stress << 3.0, 1.0, -0.5, 1.0, -2.0, 0.7, -0.5, 0.7, 1.5;
  const double E = material.youngs_modulus, nu = material.poisson_ratio;
  const Eigen::Matrix3d strain = ((1.0 + nu) * stress - nu * stress.trace() * Eigen::Matrix3d::Identity()) / E;
  const Eigen::Matrix3Xd exact = strain * d.mesh.nodes;
  const double energy = enclosed_volume(surface) * stress.cwiseProduct(strain).sum();
  const Eigen::VectorXd load = surface_load(forest, d, surface, stress, 60);
  const Eigen::VectorXd unloaded = forces_of_least_stiffness(d, exact);

  struct Figures {
    double imbalance, error, eta;
  };
  const auto figures = [&] {
    const BlockMatrix<double> A = assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
    Eigen::MatrixXd K = to_sparse(A).toDense();
    // The rigid motions are held where they are: they are no strain.
    Eigen::MatrixXd rigid(K.rows(), 6);
    Eigen::VectorXd u_exact(K.rows());
    for (int node = 0, free = 0; node < d.mesh.node_count(); ++node) {
      if (d.hanging.reduced_of[node] < 0) continue;
      const Eigen::Vector3d X = d.mesh.nodes.col(node);
      rigid.block<3, 3>(3 * free, 0).setIdentity();
      for (int axis = 0; axis < 3; ++axis) rigid.block<3, 1>(3 * free, 3 + axis) = Eigen::Vector3d::Unit(axis).cross(X);
      u_exact.segment<3>(3 * free++) = exact.col(node);
    }
    const Eigen::MatrixXd orthonormal =
        Eigen::HouseholderQR<Eigen::MatrixXd>(rigid).householderQ() * Eigen::MatrixXd::Identity(K.rows(), 6);
    const Eigen::VectorXd internal = K * u_exact;
    K += K.diagonal().mean() * orthonormal * orthonormal.transpose();
    const Eigen::VectorXd balanced = load - orthonormal * (orthonormal.transpose() * load);
    const Eigen::VectorXd u = K.ldlt().solve(balanced);
    Eigen::VectorXd error = u - u_exact;
    error -= orthonormal * (orthonormal.transpose() * error);
    return Figures{(internal - unloaded - load).norm() / load.norm(), std::sqrt(error.dot(K * error) / energy),
                   estimate_error_spr(d, expand(d.hanging, u)).relative};
  };
  const Figures here = figures();
  d.mesh.means.clear();  // as if it lay evenly
  const Figures evenly = figures();
  CAPTURE(refined, here.imbalance, here.error, here.eta, evenly.imbalance, evenly.error, evenly.eta);
  CHECK(here.imbalance <= 1e-4);  // of the load's quadrature: 2e-5
  CHECK(evenly.imbalance >= 0.2);
  // What is left is a hundredth of the stiffness where there is next to no material.
  CHECK(here.error <= 0.06);
  CHECK(here.eta <= 0.04);
  CHECK(evenly.error >= 0.2);
  CHECK(evenly.eta >= 0.2);
}
