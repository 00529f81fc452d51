#include "verification/studies/static_block.hpp"

#include <Eigen/SparseCholesky>
#include <cmath>

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// The textbook's way: Bᵀ D B by 2×2×2 Gauss points of a brick with edges h, three unknowns per node in a dense 24×24
/// matrix; nodes i + nx (j + ny k). Shares no line with the core.
Eigen::Matrix<double, 24, 24> brick_stiffness(const Eigen::Vector3d& h, double E, double nu) {
  Eigen::Matrix<double, 6, 6> D = Eigen::Matrix<double, 6, 6>::Zero();
  D.topLeftCorner<3, 3>().setConstant(nu);
  D.diagonal() << 1 - nu, 1 - nu, 1 - nu, 0.5 - nu, 0.5 - nu, 0.5 - nu;
  D *= E / ((1 + nu) * (1 - 2 * nu));
  Eigen::Matrix<double, 24, 24> K = Eigen::Matrix<double, 24, 24>::Zero();
  const double g = 1.0 / std::sqrt(3.0);
  for (const double r : {-g, g})
    for (const double s : {-g, g})
      for (const double t : {-g, g}) {
        Eigen::Matrix<double, 6, 24> B = Eigen::Matrix<double, 6, 24>::Zero();
        for (int a = 0; a < 8; ++a) {
          const double ra = a & 1 ? 1 : -1, sa = a & 2 ? 1 : -1, ta = a & 4 ? 1 : -1;
          const double x = ra * (1 + s * sa) * (1 + t * ta) / 8 * 2 / h.x();
          const double y = sa * (1 + r * ra) * (1 + t * ta) / 8 * 2 / h.y();
          const double z = ta * (1 + r * ra) * (1 + s * sa) / 8 * 2 / h.z();
          B.block<6, 3>(0, 3 * a) << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, 0, z, y, z, 0, x;
        }
        K += B.transpose() * D * B * h.prod() / 8;
      }
  return K;
}

/// Linear displacement of the clamped block by lattice node.
Eigen::Matrix3Xd textbook_block(const std::array<int, 3>& n) {
  const Eigen::Vector3d h(0.04 / (n[0] - 1), 0.02 / (n[1] - 1), 0.02 / (n[2] - 1));
  const Eigen::Matrix<double, 24, 24> K_cell = brick_stiffness(h, 1e7, 0.4);
  const int count = n[0] * n[1] * n[2];
  const auto unknown = [&](int node, int axis) { return node % n[0] == 0 ? -1 : 3 * (node - node / n[0] - 1) + axis; };
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k + 1 < n[2]; ++k)
    for (int j = 0; j + 1 < n[1]; ++j)
      for (int i = 0; i + 1 < n[0]; ++i) {
        const auto node = [&](int a) { return i + (a & 1) + n[0] * (j + ((a >> 1) & 1) + n[1] * (k + (a >> 2))); };
        for (int p = 0; p < 24; ++p)
          for (int q = 0; q < 24; ++q) {
            const int row = unknown(node(p / 3), p % 3), column = unknown(node(q / 3), q % 3);
            if (row >= 0 && column >= 0) entries.emplace_back(row, column, K_cell(p, q));
          }
      }
  const int unknowns = 3 * (count - n[1] * n[2]);
  Eigen::SparseMatrix<double> K(unknowns, unknowns);
  K.setFromTriplets(entries.begin(), entries.end());
  Eigen::VectorXd f = Eigen::VectorXd::Zero(unknowns);
  for (int node = n[0] - 1; node < count; node += n[0]) f[unknown(node, 1)] = -40.0 / (n[1] * n[2]);
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(K);
  REQUIRE(solver.info() == Eigen::Success);
  const Eigen::VectorXd x = solver.solve(f);
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, count);
  for (int node = 0; node < count; ++node)
    if (node % n[0] != 0) u.col(node) = x.segment<3>(unknown(node, 0));
  return u;
}

}  // namespace

TEST_CASE("the clamped block of 4 x 2 x 2 cm bends as an independent assembly says, and a little less when it may turn",
          "[block]") {
  const auto nodes = GENERATE(std::array{10, 5, 5}, std::array{20, 10, 10});
  const BlockRow linear = solve_block(nodes, Kinematics::linear),
                 turning = solve_block(nodes, Kinematics::corotational);
  INFO(block_table({linear, turning}));
  REQUIRE(linear.converged);
  REQUIRE(turning.converged);
  REQUIRE(linear.rest.cols() == nodes[0] * nodes[1] * nodes[2]);

  const Eigen::Matrix3Xd expected = textbook_block(nodes);
  double largest = 0.0;
  for (Eigen::Index node = 0; node < linear.rest.cols(); ++node) {
    std::array<int, 3> at;
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = static_cast<int>(std::lround(linear.rest(axis, node) / (axis == 0 ? 0.04 : 0.02) * (nodes[axis] - 1)));
    const auto other = expected.col(at[0] + nodes[0] * (at[1] + nodes[1] * at[2]));
    largest = std::max(largest, (linear.u.col(node) - other).norm());
  }
  CHECK(largest <= 1e-10 * linear.corner.norm());  // two solutions, condition some 1e5

  // Figures of this discretization, to seven digits: another load share, point order or integration moves the third.
  const bool coarse = nodes[0] == 10;
  CHECK_THAT(linear.mean_length, WithinRel(coarse ? 2.902944831e-3 : 3.008453476e-3, 1e-7));
  CHECK_THAT(linear.corner.y(), WithinRel(coarse ? -6.911710731e-3 : -7.308579830e-3, 1e-7));
  CHECK_THAT(turning.mean_length, WithinRel(coarse ? 2.863672264e-3 : 2.964937865e-3, 1e-7));
  CHECK_THAT(turning.corner.x(), WithinRel(coarse ? 1.572696891e-3 : 1.619215334e-3, 1e-7));
  CHECK_THAT(turning.corner.y(), WithinRel(coarse ? -7.033628741e-3 : -7.436182639e-3, 1e-7));
  // Timoshenko's beam with the shear coefficient of a square, (10 + 10 nu)/(12 + 11 nu): F L³/3EI + F L/(k G A); the
  // clamp holds the section's warping and contraction too, and coarse cells lock in bending: 5 to 15 % stiffer.
  const double EI = 1e7 * std::pow(0.02, 4) / 12.0, kGA = 14.0 / 16.4 * 1e7 / 2.8 * 4e-4;
  const double beam = 40.0 * std::pow(0.04, 3) / (3.0 * EI) + 40.0 * 0.04 / kGA;
  CAPTURE(beam);
  CHECK(-linear.face_mean.y() < beam);
  CHECK(-linear.face_mean.y() > 0.85 * beam);
  // A body that may turn draws its far face back; linear kinematics cannot.
  CHECK_THAT(linear.face_mean.x(), WithinAbs(0.0, 1e-12));
  CHECK(turning.face_mean.x() < -5e-4);
}
