#include "verification/studies/augmented_lagrangian.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <iomanip>
#include <sstream>

#include "verification/support/dense_kkt.hpp"

namespace finegauge {

namespace {

Interaction solve(const NeedleInBox& box, const InteractionOptions& options) {
  StepSolver solver({StepMethod::kept, {1e-12, 2000}});
  solver.set_matrix(box.A, false);
  return solve_interaction(box.system(), options, solver);
}

/// λ after a number of iterations from the start in `box`.
Eigen::VectorXd iterated(const NeedleInBox& box, double kappa, int iterations) {
  InteractionOptions options;
  options.weight = kappa;
  options.iterations = iterations;
  options.tolerance = 0.0;  // never done
  return multipliers(solve(box, options));
}

}  // namespace

WeightTable weight_table(const NeedleInBox& box, const std::vector<double>& kappas) {
  WeightTable table;
  for (const double kappa : kappas) {
    InteractionOptions options;
    options.weight = kappa;
    const Interaction found = solve(box, options);
    const Eigen::VectorXd exact = solve_dense_kkt(box.system(), found).lambda;
    table.rows.push_back({kappa, found.converged, found.iterations, found.linear_iterations,
                          (multipliers(found) - exact).norm() / exact.norm(), found.violation});
  }
  return table;
}

std::string WeightTable::text() const {
  std::ostringstream text;
  text << "kappa  iterations  linear  force error  violation\n" << std::scientific << std::setprecision(1);
  for (const WeightRow& row : rows)
    text << row.kappa << "  " << row.iterations << (row.converged ? "  " : " (not converged)  ")
         << row.linear_iterations << "  " << row.force_error << "  " << row.violation << '\n';
  return text.str();
}

std::vector<ErrorFactorRow> error_factors(NeedleInBox box, const std::vector<double>& kappas) {
  const DenseInteraction dense = dense_interaction(box.system());
  const Eigen::MatrixXd G = delassus(dense).G;
  const Eigen::VectorXd exact = solve_dense_kkt(dense, std::vector<bool>(static_cast<std::size_t>(G.rows()), true),
                                                target_of_rows(box.system(), dense), Eigen::VectorXd::Zero(G.rows()))
                                    .lambda;
  // The documented weights at κ = 1.
  const Eigen::VectorXd diagonal = dense.A.diagonal();
  const Eigen::VectorXd root =
      (dense.J * diagonal.cwiseInverse().asDiagonal() * dense.J.transpose()).diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(root.asDiagonal() * G * root.asDiagonal());
  const double sigma = modes.eigenvalues()[0];
  const int n = dense.tissue_dofs;
  const auto set_start = [&](const Eigen::VectorXd& lambda) {
    for (std::size_t p = 0; p < box.points.size(); ++p)
      box.points[p].lambda = lambda.segment<3>(static_cast<Eigen::Index>(3 * p));
  };
  const auto error = [&](const Eigen::VectorXd& lambda) { return (lambda - exact).cwiseQuotient(root).norm(); };

  std::vector<ErrorFactorRow> rows;
  for (const double kappa : kappas) {
    ErrorFactorRow row;
    row.kappa = kappa;
    row.bound = 1.0 / (1.0 + kappa * sigma);
    set_start(Eigen::VectorXd::Zero(exact.size()));
    double last = error(Eigen::VectorXd::Zero(exact.size()));
    for (int k = 1; k <= 4; ++k) {
      const double now = error(iterated(box, kappa, k));
      if (now > 1e-8 * exact.cwiseQuotient(root).norm()) row.generic = std::max(row.generic, now / last);
      last = now;
    }
    const Eigen::VectorXd start =
        exact + exact.cwiseQuotient(root).norm() * root.cwiseProduct(modes.eigenvectors().col(0));
    set_start(start);
    row.slowest = error(iterated(box, kappa, 1)) / error(start);
    const Eigen::MatrixXd J_t = dense.J.leftCols(n);
    const Eigen::MatrixXd augmented =
        dense.A.topLeftCorner(n, n) + kappa * J_t.transpose() * root.cwiseAbs2().asDiagonal() * J_t;
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(augmented, Eigen::EigenvaluesOnly).eigenvalues();
    row.condition = values[n - 1] / values[0];
    rows.push_back(row);
  }
  return rows;
}

}  // namespace finegauge
