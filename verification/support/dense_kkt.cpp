#include "verification/support/dense_kkt.hpp"

#include <Eigen/LU>
#include <cmath>

namespace finegauge {

DenseInteraction dense_interaction(const InteractionSystem& system) {
  const Eigen::Index n = system.b.size(), m = system.needle_b.size(),
                     P = static_cast<Eigen::Index>(system.points.size());
  DenseInteraction dense;
  dense.tissue_dofs = static_cast<int>(n);
  dense.A = Eigen::MatrixXd::Zero(n + m, n + m);
  dense.A.topLeftCorner(n, n) = Eigen::MatrixXd(to_sparse(system.A));
  for (int i = 0; i < static_cast<int>(system.needle_A.diagonal.size()); ++i) {
    dense.A.block<6, 6>(n + 6 * i, n + 6 * i) = system.needle_A.diagonal[i];
    if (6 * (i + 1) == m) break;
    dense.A.block<6, 6>(n + 6 * i, n + 6 * i + 6) = system.needle_A.upper[i];
    dense.A.block<6, 6>(n + 6 * i + 6, n + 6 * i) = system.needle_A.upper[i].transpose();
  }
  dense.b.resize(n + m);
  dense.b << system.b, system.needle_b;
  Eigen::VectorXd velocity(n + m);
  velocity << system.tissue_velocity, system.needle_velocity;
  dense.J = Eigen::MatrixXd::Zero(3 * P, n + m);
  for (Eigen::Index p = 0; p < P; ++p) {
    const ContactRows& point = system.points[static_cast<std::size_t>(p)];
    const Eigen::Matrix3d Q = point.frame.transpose();
    for (std::size_t k = 0; k < point.tissue.node.size(); ++k)
      dense.J.block<3, 3>(3 * p, 3 * point.tissue.node[k]) = -point.tissue.weight[k] * Q;
    dense.J.block<3, 12>(3 * p, n + 6 * point.element) = Q * point.needle;
  }
  dense.v = dense.J * velocity;  // held directions move too
  for (std::size_t s = 0; s < system.supports.reduced.size(); ++s) {
    const int at = 3 * system.supports.reduced[s];
    const Eigen::Matrix3d Z = Eigen::Matrix3d::Identity() - system.supports.held[s];
    dense.J.middleCols<3>(at) = (dense.J.middleCols<3>(at) * Z).eval();
  }
  for (std::size_t i = 0; i < system.held.size(); ++i)
    for (int k = 0; k < 6; ++k)
      if (system.held[i] >> k & 1u) dense.J.col(n + 6 * static_cast<Eigen::Index>(i) + k).setZero();
  return dense;
}

DenseSolution solve_dense_kkt(const DenseInteraction& dense, const std::vector<bool>& holds, const Eigen::VectorXd& rhs,
                              const Eigen::VectorXd& fixed) {
  std::vector<int> rows;
  for (int i = 0; i < static_cast<int>(holds.size()); ++i)
    if (holds[i]) rows.push_back(i);
  const Eigen::Index n = dense.A.rows(), m = static_cast<Eigen::Index>(rows.size());
  Eigen::VectorXd free_impulse = fixed;
  for (const int i : rows) free_impulse[i] = 0.0;

  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + m, n + m);
  Eigen::VectorXd right(n + m);
  K.topLeftCorner(n, n) = dense.A;
  right.head(n) = dense.b - dense.J.transpose() * free_impulse;
  for (Eigen::Index k = 0; k < m; ++k) {
    K.row(n + k).head(n) = dense.J.row(rows[k]);
    K.col(n + k).head(n) = dense.J.row(rows[k]).transpose();
    right[n + k] = rhs[rows[k]];
  }
  // Tissue and needle differ by many orders: equal diagonals, then equal rows of J.
  Eigen::VectorXd scale(n + m);
  scale.head(n) = dense.A.diagonal().cwiseSqrt().cwiseInverse();
  for (Eigen::Index k = 0; k < m; ++k)
    scale[n + k] = 1.0 / K.row(n + k).head(n).transpose().cwiseProduct(scale.head(n)).norm();
  const Eigen::MatrixXd equilibrated = scale.asDiagonal() * K * scale.asDiagonal();
  const Eigen::VectorXd scaled_right = scale.cwiseProduct(right);
  Eigen::FullPivLU<Eigen::MatrixXd> lu(equilibrated);
  lu.setThreshold(0.0);
  Eigen::VectorXd y = lu.solve(scaled_right);
  using Extended = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
  Extended sum = y.cast<long double>();
  DenseSolution solution;
  for (int step = 0; step < 3; ++step) {
    const Extended residual = scaled_right.cast<long double>() - equilibrated.cast<long double>() * sum;
    solution.residual = static_cast<double>(residual.norm()) / scaled_right.norm();
    if (step < 2) sum += lu.solve(residual.cast<double>()).cast<long double>();
  }
  y = sum.cast<double>().cwiseProduct(scale);
  solution.dv = y.head(n);
  solution.lambda = free_impulse;
  for (Eigen::Index k = 0; k < m; ++k) solution.lambda[rows[k]] = y[n + k];
  solution.velocity = dense.v + dense.J * solution.dv;
  return solution;
}

Delassus delassus(const DenseInteraction& dense) {
  const Eigen::VectorXd scale = dense.A.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(scale.asDiagonal() * dense.A * scale.asDiagonal());
  const Eigen::MatrixXd scaled_rows = dense.J * scale.asDiagonal();
  const Eigen::MatrixXd columns = lu.solve(scaled_rows.transpose());
  return {scaled_rows * columns, dense.v + scaled_rows * lu.solve(scale.cwiseProduct(dense.b))};
}

Eigen::VectorXd target_of_rows(const InteractionSystem& system, const DenseInteraction& dense) {
  Eigen::VectorXd target = -dense.v;
  for (std::size_t p = 0; p < system.points.size(); ++p) {
    const ContactRows& point = system.points[p];
    const auto at = static_cast<Eigen::Index>(3 * p);
    if (point.axial != AxialLaw::friction) target[at] -= point.gap[0] / system.tau;
    if (point.lateral != LateralLaw::coulomb) target.segment<2>(at + 1) -= point.gap.tail<2>() / system.tau;
  }
  return target;
}

DenseSolution solve_dense_kkt(const InteractionSystem& system, const Interaction& found) {
  const DenseInteraction dense = dense_interaction(system);
  std::vector<bool> holds(3 * system.points.size(), false);
  for (std::size_t p = 0; p < system.points.size(); ++p) {
    const ContactRows& point = system.points[p];
    const ContactOutcome& outcome = found.points[p];
    holds[3 * p] = point.axial == AxialLaw::bilateral ||
                   (point.axial == AxialLaw::unilateral && outcome.lambda[0] > 0.0) ||
                   (point.axial == AxialLaw::friction && outcome.axial_slip == 0);
    holds[3 * p + 1] = holds[3 * p + 2] =
        point.lateral == LateralLaw::bilateral ||
        (point.lateral == LateralLaw::coulomb && !outcome.lateral_slip && outcome.lambda[0] > 0.0);
  }
  return solve_dense_kkt(dense, holds, target_of_rows(system, dense), multipliers(found));
}

Eigen::VectorXd multipliers(const Interaction& found) {
  Eigen::VectorXd lambda(3 * static_cast<Eigen::Index>(found.points.size()));
  for (std::size_t p = 0; p < found.points.size(); ++p)
    lambda.segment<3>(static_cast<Eigen::Index>(3 * p)) = found.points[p].lambda;
  return lambda;
}

}  // namespace finegauge
