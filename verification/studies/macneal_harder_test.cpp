#include "verification/studies/macneal_harder.hpp"

#include <cmath>

#include "verification/support/check_claims.hpp"

using namespace finegauge;

TEST_CASE("MacNeal and Harder's patch is exact and their beams score what is known of a plain trilinear cell",
          "[macneal_harder]") {
  const Evidence evidence = macneal_harder_evidence({});
  check_claims(evidence, 21);
}

TEST_CASE("the patch has eight nodes to find, and the meshes are skewed by 45 degrees", "[macneal_harder]") {
  CHECK(solve_macneal_harder_patch(Dilatation::standard).free_nodes == 8);
  for (const StraightMesh mesh : {StraightMesh::regular, StraightMesh::trapezoidal, StraightMesh::parallelogram}) {
    const Beam beam = straight_beam(mesh);
    CAPTURE(beam.name);
    const Eigen::Matrix3Xd nodes = mapped_box(beam.cells, beam.position).nodes;
    REQUIRE(nodes.cols() == 28);
    const double first = mesh == StraightMesh::regular ? 1.0 : 1.1;
    const double second = mesh == StraightMesh::regular ? 2.0 : mesh == StraightMesh::trapezoidal ? 1.9 : 2.1;
    CHECK_NOTHROW(node_at(nodes, {first, 0.1, 0.05}));
    CHECK_NOTHROW(node_at(nodes, {2.0 - first, -0.1, 0.05}));
    CHECK_NOTHROW(node_at(nodes, {second, 0.1, -0.05}));
    CHECK_THROWS(node_at(nodes, {first + 0.01, 0.1, 0.05}));
  }
}

TEST_CASE("a bending cell of trilinear shape takes the share of its curvature that shear leaves it",
          "[macneal_harder]") {
  // Six cells of length 1 in a beam of depth 0.2: each feels the moment at its middle, which costs 1 / 144 of the tip's
  // displacement. The brick is stiffer than the plane cell: it cannot widen freely either.
  const Beam beam = straight_beam(StraightMesh::regular);
  const std::vector<double> found = tip_displacements(beam, {1, 1, 1}, Dilatation::standard);
  for (const int k : {1, 2}) {
    const double plane = bending_share(k == 1 ? 5.0 : 10.0, 0.3) * (1.0 - 1.0 / 144.0);
    CAPTURE(k, found[k] / beam.loads[k].theory, plane);
    CHECK(found[k] / beam.loads[k].theory < 1.01 * plane);
    CHECK(found[k] / beam.loads[k].theory > 0.95 * plane);
  }
}

TEST_CASE("Saint-Venant's torsion constants have the handbooks' digits", "[macneal_harder]") {
  CHECK_THAT(torsion_constant(1.0, 1.0), WithinAbs(0.140577, 5e-7));
  CHECK_THAT(torsion_constant(2.0, 1.0) / 2.0, WithinAbs(0.228682, 5e-7));
  CHECK_THAT(torsion_constant(1.0, 2.0), WithinRel(torsion_constant(2.0, 1.0), 1e-15));
  CHECK_THAT(straight_beam(StraightMesh::regular).loads[3].theory, WithinAbs(0.034109, 5e-7));
  // Slender rings: π R³ / 4 EI. Thickness a thousandth of the radius; next term of its square.
  const Beam curved = curved_beam();
  const double EI = 1e7 * 0.1 * std::pow(0.2, 3) / 12.0;
  CHECK_THAT(curved.loads[0].theory, WithinRel(0.25 * 3.14159265358979 * std::pow(4.22, 3) / EI, 1e-3));
}
