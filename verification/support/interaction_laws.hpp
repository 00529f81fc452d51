#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/needle/interaction.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/dense_kkt.hpp"
#include "verification/support/needle_in_box.hpp"

namespace finegauge {

inline Interaction solve(const NeedleInBox& box, const InteractionOptions& options = {},
                         const StepSolverOptions& solver_options = {}) {
  StepSolver solver(solver_options);
  solver.set_matrix(box.A, false);
  return solve_interaction(box.system(), options, solver);
}

/// Tolerances below what the tests compare to.
inline Interaction solve_tightly(const NeedleInBox& box, StepMethod method = StepMethod::kept) {
  InteractionOptions options;
  options.tolerance = 1e-10;
  return solve(box, options, {method, {1e-11, 4000}});
}

inline double relative_error(const Eigen::VectorXd& value, const Eigen::VectorXd& exact) {
  return (value - exact).norm() / exact.norm();
}

inline int count(const Interaction& found, bool (*is)(const ContactOutcome&)) {
  return static_cast<int>(std::count_if(found.points.begin(), found.points.end(), is));
}

/// The laws of contact_rows.hpp at every point, within `slack` of λ's scale and of the reference speed.
inline void check_laws(const NeedleInBox& box, const Interaction& found, double slack) {
  const double impulse = slack * multipliers(found).cwiseAbs().maxCoeff(), speed = slack * box.reference_speed;
  for (std::size_t p = 0; p < box.points.size(); ++p) {
    CAPTURE(p);
    const ContactRows& point = box.points[p];
    const auto& [lambda, r, axial_slip, lateral_slip] = found.points[p];
    const Eigen::Vector3d closing = r + point.gap / box.tau;
    const double across = lambda.tail<2>().norm();
    if (point.lateral == LateralLaw::none) CHECK(across == 0.0);
    if (point.axial == AxialLaw::bilateral) CHECK(std::abs(closing[0]) <= speed);
    if (point.lateral == LateralLaw::bilateral) CHECK(closing.tail<2>().norm() <= 2.0 * speed);
    if (point.axial == AxialLaw::unilateral) {
      CHECK(lambda[0] >= 0.0);
      CHECK(closing[0] <= speed);
      CHECK((lambda[0] == 0.0 || closing[0] >= -speed));
    }
    if (point.axial == AxialLaw::friction) {
      const double N = across + point.clamp * box.tau;
      CHECK(lambda[0] <= point.friction_in * N + impulse);
      CHECK(lambda[0] >= -point.friction_out * N - impulse);
      if (axial_slip == 0) CHECK(std::abs(r[0]) <= speed);
      // A slip: on the bound to the last bit, and it dissipates.
      if (axial_slip == 1) CHECK(lambda[0] == point.friction_in * N);
      if (axial_slip == -1) CHECK(lambda[0] == -(point.friction_out * N));
      CHECK(axial_slip * r[0] >= -speed);
    }
    if (point.lateral == LateralLaw::coulomb) {
      const double bound = point.surface_friction * std::max(lambda[0], 0.0);
      CHECK(across <= bound * (1.0 + 1e-14) + (lateral_slip ? 0.0 : impulse));
      if (lateral_slip) {
        CHECK_THAT(across, WithinRel(bound, 1e-14));
        // Along the velocity, of its sign: positive impulses push the needle back.
        CHECK(lambda.tail<2>().dot(r.tail<2>()) >= (1.0 - 1e-6) * across * r.tail<2>().norm());
      } else if (lambda[0] > 0.0) {
        CHECK(r.tail<2>().norm() <= 2.0 * speed);
      }
    }
  }
}

/// Both momentum balances with the multipliers returned.
inline void check_balance(const NeedleInBox& box, const Interaction& found, double tolerance) {
  const DenseInteraction dense = dense_interaction(box.system());
  Eigen::VectorXd dv(dense.b.size());
  dv << found.tissue, found.needle;
  const Eigen::VectorXd impulse = dense.J.transpose() * multipliers(found);
  const Eigen::VectorXd rest = dense.b - impulse - dense.A * dv;
  const int n = dense.tissue_dofs;
  CHECK(rest.head(n).norm() <= tolerance * std::max(dense.b.head(n).norm(), impulse.head(n).norm()));
  CHECK(rest.tail(rest.size() - n).norm() <= tolerance * (dense.A * dv).tail(rest.size() - n).norm());
  const Eigen::VectorXd velocity = dense.v + dense.J * dv;
  for (std::size_t p = 0; p < found.points.size(); ++p)
    CHECK((found.points[p].velocity - velocity.segment<3>(static_cast<Eigen::Index>(3 * p))).norm() <=
          1e-12 * box.reference_speed);
}

inline const std::array<std::pair<AxialLaw, LateralLaw>, 7> contact_laws = {
    {{AxialLaw::bilateral, LateralLaw::bilateral},
     {AxialLaw::none, LateralLaw::bilateral},
     {AxialLaw::bilateral, LateralLaw::none},
     {AxialLaw::unilateral, LateralLaw::bilateral},
     {AxialLaw::unilateral, LateralLaw::coulomb},
     {AxialLaw::friction, LateralLaw::bilateral},
     {AxialLaw::friction, LateralLaw::none}}};

}  // namespace finegauge
