#include "core/solve/step_solver.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "verification/support/catch.hpp"
#include "verification/support/needle_in_box.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

PointInterpolation interpolation(const NeedleInBox& box) {
  std::vector<PointWeights> weights;
  for (const ContactRows& point : box.points) weights.push_back({point.tissue.node, point.tissue.weight});
  PointInterpolation B;
  interpolate_points(weights, box.d->supports, B);
  return B;
}

/// All three rows of every point; C a full matrix of `share` of the size of J diag(A)⁻¹ Jᵀ: small is stiff.
PointTerm point_term(const NeedleInBox& box, double share) {
  std::mt19937 generator(3);
  PointTerm term;
  const int m = 3 * static_cast<int>(box.points.size());
  Eigen::MatrixXd L(m, m);
  for (double& value : L.reshaped()) value = random_number(generator);
  term.compliance = Eigen::MatrixXd::Identity(m, m) + 0.1 * L * L.transpose();
  const Eigen::Matrix3d block = box.A.block(box.d->pattern.diagonal[box.points[0].tissue.node[0]]);
  term.compliance *= share / block.trace();
  for (int p = 0; p < static_cast<int>(box.points.size()); ++p)
    for (int k = 0; k < 3; ++k) term.rows.push_back({p, box.points[p].frame.col(k)});
  return term;
}

Eigen::MatrixXd dense_rows(const PointTerm& term, const PointInterpolation& B, int n) {
  Eigen::MatrixXd J(term.rows.size(), n);
  for (int i = 0; i < J.rows(); ++i) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    add_spread(B, term.rows[i].point, term.rows[i].direction, row);
    J.row(i) = row;
  }
  return J;
}

Eigen::VectorXd dense_solution(const NeedleInBox& box, const PointTerm* term) {
  Eigen::MatrixXd A = Eigen::MatrixXd(to_sparse(box.A));
  if (term) {
    const Eigen::MatrixXd J = dense_rows(*term, interpolation(box), static_cast<int>(A.rows()));
    A += J.transpose() * term->compliance.ldlt().solve(J);
  }
  return A.ldlt().solve(box.b);
}

}  // namespace

TEST_CASE("points sample free directions, and spreading is the adjoint", "[step_solver]") {
  NeedleInBoxOptions options;
  options.refine = true;
  const NeedleInBox box = needle_in_box(options);
  const PointInterpolation B = interpolation(box);
  REQUIRE(B.held.size() > 0);
  std::mt19937 generator(1);
  Eigen::VectorXd x(box.b.size()), y = Eigen::VectorXd::Zero(box.b.size());
  for (double& value : x) value = random_number(generator);
  Eigen::VectorXd free = x;
  project(box.d->supports, free);
  for (int p = 0; p < B.point_count(); ++p) {
    const Eigen::Vector3d f = random_vector(generator), sample = sample_free(B, p, x);
    CHECK((sample - sample_all(B, p, free)).norm() <= 1e-15 * x.norm());
    y.setZero();
    add_spread(B, p, f, y);
    CHECK(std::abs(y.dot(x) - f.dot(sample)) <= 1e-14 * x.norm());
    Eigen::VectorXd projected = y;
    project(box.d->supports, projected);
    CHECK((projected - y).norm() <= 1e-15 * y.norm());
  }
  double held_share = 0.0;  // taking the held directions out did change something
  for (int p = 0; p < B.point_count(); ++p) held_share += (sample_all(B, p, x) - sample_free(B, p, x)).norm();
  CHECK(held_share > 1e-3);
}

TEST_CASE("a step's system is solved to the residual asked for, with and without rows", "[step_solver]") {
  const StepMethod method = GENERATE(StepMethod::plain, StepMethod::kept);
  const double share = GENERATE(0.0, 1e-4, 1.0, 1e4);  // 0: no term
  CAPTURE(static_cast<int>(method), share);
  const NeedleInBox box = needle_in_box({});
  const PointTerm term = point_term(box, share);
  const PointTerm* const rows = share > 0.0 ? &term : nullptr;
  StepSolver solver({method, {1e-11, 5000}});
  solver.set_matrix(box.A, false);
  solver.set_points(interpolation(box));
  Eigen::VectorXd x = Eigen::VectorXd::Zero(box.b.size());
  const SolveReport report = solver.solve(rows, box.b, box.b.norm(), x);
  CHECK(report.converged);
  CHECK(report.relative_residual <= 1e-11);
  const Eigen::VectorXd exact = dense_solution(box, rows);
  CHECK((x - exact).norm() <= 1e-8 * exact.norm());  // residual × condition of this step, some 1e2
  if (rows && share <= 1.0) CHECK((x - dense_solution(box, nullptr)).norm() > 1e-3 * exact.norm());
}

TEST_CASE("with the factor of the matrix itself the preconditioner is the inverse: one iteration", "[step_solver]") {
  const double share = GENERATE(1e-4, 1.0, 1e4);
  const NeedleInBox box = needle_in_box({});
  const PointTerm term = point_term(box, share);
  StepSolver solver;
  solver.set_matrix(box.A, false);
  solver.set_points(interpolation(box));
  Eigen::VectorXd x = Eigen::VectorXd::Zero(box.b.size());
  SolveReport report = solver.solve(&term, box.b, box.b.norm(), x);
  CHECK(report.converged);
  CHECK(report.iterations == 1);
  x.setZero();
  report = solver.solve(box.b, x);
  CHECK(report.iterations == 1);
  solver.set_matrix(box.A, true);  // the next frame, the same matrix: no new factor
  x.setZero();
  report = solver.solve(&term, box.b, box.b.norm(), x);
  CHECK(report.iterations == 1);
  CHECK(solver.factorizations() == 1);
  // Another outer iteration from the solution makes progress instead of stopping at the tolerance.
  report = solver.solve(&term, box.b, box.b.norm(), x);
  CHECK(report.iterations == 1);
}

TEST_CASE("a kept factor serves matrices that turn by degrees and is renewed when they turn far", "[step_solver]") {
  NeedleInBoxOptions options;
  const NeedleInBox start = needle_in_box(options);
  options.bend = 0.01745;  // one degree
  const NeedleInBox near = needle_in_box(options);
  options.bend = 1.5;
  const NeedleInBox far = needle_in_box(options);
  const PointTerm term = point_term(start, 1e-3);
  StepSolver solver;
  solver.set_points(interpolation(start));
  Eigen::VectorXd x = Eigen::VectorXd::Zero(start.b.size());
  solver.set_matrix(start.A, false);
  REQUIRE(solver.solve(&term, start.b, start.b.norm(), x).converged);

  solver.set_matrix(near.A, true);
  SolveReport report = solver.solve(&term, near.b, near.b.norm(), x);  // from the last solution, as in a frame
  CAPTURE(report.iterations);
  CHECK(report.converged);
  CHECK(report.iterations >= 2);  // the matrix is another
  CHECK(report.iterations <= 6);
  CHECK(solver.factorizations() == 1);
  Eigen::VectorXd exact = dense_solution(near, &term);
  CHECK((x - exact).norm() <= 1e-7 * exact.norm());

  solver.set_matrix(far.A, true);
  report = solver.solve(&term, far.b, far.b.norm(), x);
  CHECK(report.converged);
  CHECK(solver.factorizations() == 2);
  CHECK(report.iterations == solver.options().renew_iterations + 1);
  exact = dense_solution(far, &term);
  CHECK((x - exact).norm() <= 1e-7 * exact.norm());
  x.setZero();
  report = solver.solve(&term, far.b, far.b.norm(), x);
  CHECK(report.iterations == 1);
}

TEST_CASE("columns are computed for new points alone, and all anew with the factor", "[step_solver]") {
  NeedleInBox box = needle_in_box({});
  const PointTerm term = point_term(box, 1e-3);
  const int P = static_cast<int>(box.points.size());
  StepSolver solver;
  solver.set_matrix(box.A, false);
  const auto solved = [&] {
    solver.set_points(interpolation(box));
    Eigen::VectorXd x = Eigen::VectorXd::Zero(box.b.size());
    const SolveReport report = solver.solve(&term, box.b, box.b.norm(), x);
    const Eigen::VectorXd exact = dense_solution(box, &term);
    CHECK((x - exact).norm() <= 1e-7 * exact.norm());
    return report.iterations;
  };
  CHECK(solved() == 1);
  CHECK(solver.point_columns() == P);
  CHECK(solved() == 1);
  CHECK(solver.point_columns() == P);
  std::rotate(box.points.begin(), box.points.begin() + 1, box.points.end());  // other places, the same points
  CHECK(solved() == 1);
  CHECK(solver.point_columns() == P);
  box.points[2].tissue.weight[0] = std::nextafter(box.points[2].tissue.weight[0], 1.0);  // the last bit
  CHECK(solved() == 1);
  CHECK(solver.point_columns() == P + 1);
  solver.set_matrix(box.A, false);
  CHECK(solved() == 1);
  CHECK(solver.point_columns() == 2 * P + 1);
  CHECK(solver.factorizations() == 2);
}

TEST_CASE("no load has no solution but zero", "[step_solver]") {
  const NeedleInBox box = needle_in_box({});
  StepSolver solver;
  solver.set_matrix(box.A, false);
  Eigen::VectorXd x = Eigen::VectorXd::Ones(box.b.size());
  const SolveReport report = solver.solve(Eigen::VectorXd::Zero(box.b.size()), x);
  CHECK(report.converged);
  CHECK(x.isZero(0.0));
}

TEST_CASE("matrices that are not positive definite are reported, and the next good one is solved", "[step_solver]") {
  const StepMethod method = GENERATE(StepMethod::plain, StepMethod::kept);
  const bool with_rows = GENERATE(false, true);
  const NeedleInBox box = needle_in_box({});
  const PointTerm term = point_term(box, 1.0);
  NeedleInBox bad = needle_in_box({});
  int node = bad.d->pattern.size() - 1;  // one that no support holds
  while (std::binary_search(bad.d->supports.reduced.begin(), bad.d->supports.reduced.end(), node)) --node;
  const int some = bad.d->pattern.diagonal[node];
  bad.A.block(some) -= 1e3 * bad.A.block(some).trace() * Eigen::Matrix3d::Identity();
  StepSolver solver({method, {1e-9, 2000}});
  solver.set_points(interpolation(box));
  for (const bool same_mesh : {false, true}) {
    solver.set_matrix(bad.A, same_mesh);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(bad.b.size());
    SolveReport report = solver.solve(with_rows ? &term : nullptr, bad.b, bad.b.norm(), x);
    CHECK_FALSE(report.converged);
    CHECK(report.relative_residual > 1e-9);
    CHECK(x.allFinite());
    solver.set_matrix(box.A, true);
    x.setZero();
    report = solver.solve(with_rows ? &term : nullptr, box.b, box.b.norm(), x);
    CHECK(report.converged);
  }
}

TEST_CASE("the limit of iterations is reported as not converged by a step's solve", "[step_solver]") {
  const NeedleInBox box = needle_in_box({});
  StepSolver solver({StepMethod::plain, {1e-9, 3}});
  solver.set_matrix(box.A, false);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(box.b.size());
  const SolveReport report = solver.solve(box.b, x);
  CHECK_FALSE(report.converged);
  CHECK(report.iterations == 3);
  CHECK(report.relative_residual > 1e-9);
}
