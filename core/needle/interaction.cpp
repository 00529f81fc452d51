#include "core/needle/interaction.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/needle/contact_law.hpp"

namespace finegauge {

namespace {

using NeedleRows = Eigen::Matrix<double, 3, 12>;

/// The needle seen from the points: velocity u of its points [m/s], 3 P, for impulses Λ on them in global axes:
/// u = u_0 - G Λ.
struct EliminatedNeedle {
  Eigen::VectorXd dv_0;  ///< A⁻¹ b
  Eigen::MatrixXd V;     ///< A⁻¹ Nᵀ, dofs × 3 P
  Eigen::VectorXd u_0;   ///< N A⁻¹ b
  Eigen::MatrixXd G;     ///< N A⁻¹ Nᵀ
};

/// N without the held dofs.
NeedleRows free_rows(const ContactRows& point, const HeldDofs& held) {
  NeedleRows N = point.needle;
  for (int k = 0; k < 12; ++k)
    if (held[point.element + k / 6] >> (k % 6) & 1u) N.col(k).setZero();
  return N;
}

EliminatedNeedle eliminate_needle(const InteractionSystem& system, const ChainFactor& factor) {
  const Eigen::Index dofs = system.needle_b.size(), P = static_cast<Eigen::Index>(system.points.size());
  EliminatedNeedle needle;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(dofs, 1);
  right.col(0) = system.needle_b;
  factor.solve(right);
  needle.dv_0 = right.col(0);
  needle.V = Eigen::MatrixXd::Zero(dofs, 3 * P);
  for (Eigen::Index p = 0; p < P; ++p)
    needle.V.block<12, 3>(6 * system.points[p].element, 3 * p) = free_rows(system.points[p], system.held).transpose();
  if (P > 0) factor.solve(needle.V);
  needle.u_0.resize(3 * P);
  needle.G.resize(3 * P, 3 * P);
  for (Eigen::Index p = 0; p < P; ++p) {
    const NeedleRows N = free_rows(system.points[p], system.held);
    const Eigen::Index at = 6 * system.points[p].element;
    needle.u_0.segment<3>(3 * p) = N * needle.dv_0.segment<12>(at);
    needle.G.middleRows<3>(3 * p).noalias() = N * needle.V.middleRows<12>(at);
  }
  return needle;
}

/// W of each row: κ over its compliance in the two diagonals, the scale of a multiplier's step. 0: nothing there can
/// move, the row is left out.
Eigen::Vector3d row_weights(const InteractionSystem& system, double kappa, const PointInterpolation& B, int p) {
  const ContactRows& point = system.points[p];
  const NeedleRows N = free_rows(point, system.held);
  Eigen::Vector3d weights;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d f = point.frame.col(i);
    double tissue = 0.0, needle = 0.0;
    for (int k = B.start[p]; k < B.start[p + 1]; ++k) {
      Eigen::Vector3d share = B.weight[k] * f;
      if (B.support[k] >= 0) share -= B.held[B.support[k]] * share;
      const auto block = system.A.block(system.A.pattern->diagonal[B.node[k]]);
      for (int c = 0; c < 3; ++c) tissue += share[c] * share[c] / block(c, c);
    }
    for (int k = 0; k < 12; ++k) {
      const double share = N.col(k).dot(f);
      needle += share * share / system.needle_A.diagonal[point.element + k / 6](k % 6, k % 6);
    }
    const double compliance = tissue + needle;
    weights[i] = compliance > 0.0 ? kappa / compliance : 0.0;
  }
  return weights;
}

/// The rows of an iteration: impulse along the row = base + weight (direction · (u - B dv) - target).
struct HoldingRows {
  PointTerm term;
  std::vector<double> weight, base, target;
  Eigen::VectorXd fixed;  ///< impulses of all else, global axes [N s], 3 P

  void add(int point, const Eigen::Vector3d& direction, double w, double lambda, double c) {
    if (!(w > 0.0)) return;
    term.rows.push_back({point, direction});
    weight.push_back(w);
    base.push_back(lambda);
    target.push_back(c);
  }
};

/// v: relative velocities at the start, r: at the last iteration, both global, 3 P.
void collect_rows(const InteractionSystem& system, const std::vector<ContactState>& states, const Eigen::Matrix3Xd& W,
                  const Eigen::VectorXd& v, const Eigen::VectorXd& r, HoldingRows& rows) {
  rows.term.rows.clear();
  rows.weight.clear();
  rows.base.clear();
  rows.target.clear();
  rows.fixed.setZero(3 * static_cast<Eigen::Index>(states.size()));
  for (int p = 0; p < static_cast<int>(states.size()); ++p) {
    const ContactRows& point = system.points[p];
    const ContactState& state = states[p];
    const Eigen::Vector3d n = point.frame.col(0);
    const auto across = point.frame.rightCols<2>();
    if (state.axial_holds) {
      const double gap = point.axial == AxialLaw::friction ? 0.0 : point.gap[0];
      rows.add(p, n, W(0, p), state.lambda[0], -(n.dot(v.segment<3>(3 * p)) + gap / system.tau));
    } else {
      rows.fixed.segment<3>(3 * p) += state.lambda[0] * n;
    }
    if (state.lateral_holds) {
      for (int i = 1; i < 3; ++i) {
        const double gap = point.lateral == LateralLaw::coulomb ? 0.0 : point.gap[i];
        const Eigen::Vector3d t = point.frame.col(i);
        rows.add(p, t, W(i, p), state.lambda[i], -(t.dot(v.segment<3>(3 * p)) + gap / system.tau));
      }
    } else {
      rows.fixed.segment<3>(3 * p) += across * state.lambda.tail<2>();
      if (state.slip_direction.isZero(0.0)) continue;
      const Eigen::Vector2d p_t = state.lambda.tail<2>() + W(1, p) * (across.transpose() * r.segment<3>(3 * p));
      const Eigen::Vector3d turned = across * Eigen::Vector2d(-state.slip_direction[1], state.slip_direction[0]);
      if (p_t.squaredNorm() > 0.0)
        rows.add(p, turned, W(1, p) * (state.lambda.tail<2>().norm() / p_t.norm()), 0.0,
                 turned.dot(r.segment<3>(3 * p) - v.segment<3>(3 * p)));
    }
  }
}

Eigen::VectorXd global_impulses(const InteractionSystem& system, const std::vector<ContactState>& states) {
  Eigen::VectorXd impulses(3 * static_cast<Eigen::Index>(states.size()));
  for (std::size_t p = 0; p < states.size(); ++p)
    impulses.segment<3>(3 * static_cast<Eigen::Index>(p)) = system.points[p].frame * states[p].lambda;
  return impulses;
}

Eigen::VectorXd tissue_impulse(const PointInterpolation& B, const Eigen::VectorXd& impulses, Eigen::Index n) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
  for (int p = 0; p < B.point_count(); ++p) add_spread(B, p, impulses.segment<3>(3 * p), sum);
  return sum;
}

/// Largest change over the largest value, or over `scale` where all are smaller.
double relative_change(const std::vector<ContactState>& before, const std::vector<ContactState>& after, double scale) {
  double change = 0.0, largest = scale;
  for (std::size_t p = 0; p < after.size(); ++p) {
    change = std::max(change, (after[p].lambda - before[p].lambda).cwiseAbs().maxCoeff());
    largest =
        std::max(largest, std::max(before[p].lambda.cwiseAbs().maxCoeff(), after[p].lambda.cwiseAbs().maxCoeff()));
  }
  return largest > 0.0 ? change / largest : 0.0;
}

}  // namespace

Interaction solve_interaction(const InteractionSystem& system, const InteractionOptions& options, StepSolver& solver) {
  const int P = static_cast<int>(system.points.size());
  const Eigen::Index n = system.b.size();
  Interaction result;
  result.tissue = Eigen::VectorXd::Zero(n);
  result.needle = Eigen::VectorXd::Zero(system.needle_b.size());
  result.points.resize(system.points.size());

  const ChainFactor factor(system.needle_A);
  if (!factor.factored()) return result;
  const EliminatedNeedle needle = eliminate_needle(system, factor);
  if (!(needle.dv_0.allFinite() && needle.V.allFinite())) return result;

  std::vector<PointWeights> weights;
  for (const ContactRows& point : system.points) weights.push_back({point.tissue.node, point.tissue.weight});
  PointInterpolation B;
  interpolate_points(weights, system.supports, B);
  solver.set_points(B);

  Eigen::VectorXd v(3 * P), r(3 * P);
  Eigen::Matrix3Xd W(3, P);
  std::vector<ContactState> states;
  for (int p = 0; p < P; ++p) {
    const ContactRows& point = system.points[p];
    assert(!(point.axial == AxialLaw::friction && point.lateral == LateralLaw::coulomb));
    v.segment<3>(3 * p) =
        point.needle * system.needle_velocity.segment<12>(6 * point.element) - sample_all(B, p, system.tissue_velocity);
    W.col(p) = row_weights(system, options.weight, B, p);
    states.push_back(
        start_contact(point, system.tau, point.frame.col(0).dot(v.segment<3>(3 * p)) + point.gap[0] / system.tau));
  }
  r = v;
  // The impulse that changes a point's speed by the reference speed. Impulses far below it are round-off of a contact
  // that carries nothing, and are not asked to settle among themselves.
  double impulse_scale = 0.0;
  if (P > 0) impulse_scale = W.maxCoeff() / options.weight * system.reference_speed;

  Eigen::VectorXd x = result.tissue, impulses = global_impulses(system, states);
  const double load = system.b.norm();
  HoldingRows rows;
  Eigen::MatrixXd& C = rows.term.compliance;
  while (result.iterations < options.iterations && !result.converged) {
    collect_rows(system, states, W, v, r, rows);
    const int m = static_cast<int>(rows.term.rows.size());
    const Eigen::VectorXd u_fixed = needle.u_0 - needle.G * rows.fixed;
    Eigen::VectorXd s(m);
    C.resize(m, m);
    for (int i = 0; i < m; ++i) {
      const auto [p, f] = rows.term.rows[i];
      s[i] = rows.base[i] / rows.weight[i] + f.dot(u_fixed.segment<3>(3 * p)) - rows.target[i];
      for (int j = 0; j < m; ++j) {
        const auto [q, g] = rows.term.rows[j];
        C(i, j) = f.dot(needle.G.block<3, 3>(3 * p, 3 * q) * g) + (i == j ? 1.0 / rows.weight[i] : 0.0);
      }
    }
    const Eigen::LDLT<Eigen::MatrixXd> compliance(C);
    const auto spread = [&](const Eigen::VectorXd& lambda) {
      Eigen::VectorXd all = rows.fixed;
      for (int i = 0; i < m; ++i)
        all.segment<3>(3 * rows.term.rows[i].point) += lambda[i] * rows.term.rows[i].direction;
      return all;
    };
    const Eigen::VectorXd b = system.b + tissue_impulse(B, spread(m > 0 ? compliance.solve(s).eval() : s), n);
    // What b is made of is the load and the points' impulses; b itself is larger by up to κ.
    double reference = std::max(load, tissue_impulse(B, impulses, n).norm());
    if (impulses.squaredNorm() == 0.0) reference = std::max(reference, b.norm());  // none known yet
    reference = std::max(reference, impulse_scale);
    const SolveReport solved = solver.solve(P > 0 ? &rows.term : nullptr, b, reference, x);
    ++result.iterations;
    result.linear_iterations += solved.iterations;
    if (!solved.converged && !(solved.relative_residual <= 1e-3)) break;  // the matrix is not positive definite

    // From here on r, the needle's part by back-substitution.
    for (int i = 0; i < m; ++i) s[i] -= rows.term.rows[i].direction.dot(sample_free(B, rows.term.rows[i].point, x));
    const Eigen::VectorXd used = spread(m > 0 ? compliance.solve(s).eval() : s);
    r = v + needle.u_0 - needle.G * used;
    for (int p = 0; p < P; ++p) r.segment<3>(3 * p) -= sample_free(B, p, x);

    const std::vector<ContactState> before = states;
    double step = 1.0;
    if (result.iterations > options.patience)
      for (int p = 0; p < P; ++p) {
        const Eigen::Vector3d trial = system.points[p].frame.transpose() * used.segment<3>(3 * p);
        step = std::min(step, feasible_step(system.points[p], system.tau, trial, states[p]));
      }
    bool same_set = true, may_change = step == 1.0;
    result.violation = 0.0;
    for (int p = 0; p < P; ++p) {
      const ContactRows& point = system.points[p];
      const ContactTrial trial{point.frame.transpose() * used.segment<3>(3 * p),
                               point.frame.transpose() * r.segment<3>(3 * p), W(1, p),
                               options.tolerance * system.reference_speed, step};
      const SetChange change = update_contact(point, system.tau, trial, may_change, states[p]);
      if (change != SetChange::none) same_set = false;
      if (change == SetChange::made && point.lateral == LateralLaw::coulomb && result.iterations > options.patience)
        may_change = false;
      result.violation = std::max(
          result.violation, contact_violation(point, system.tau, trial.velocity, states[p]) / system.reference_speed);
    }
    result.multiplier_change = relative_change(before, states, impulse_scale);
    result.converged = solved.converged && same_set && result.violation <= options.tolerance &&
                       result.multiplier_change <= options.tolerance;
    impulses = global_impulses(system, states);
    if (P == 0) break;
  }

  if (!result.converged)
    for (int p = 0; p < P; ++p) clip_to_cone(system.points[p], system.tau, states[p]);
  impulses = global_impulses(system, states);
  result.tissue = x;
  result.needle = needle.dv_0;
  if (P > 0) result.needle -= needle.V * impulses;
  r = v + needle.u_0 - needle.G * impulses;
  for (int p = 0; p < P; ++p) {
    const Eigen::Vector3d velocity = r.segment<3>(3 * p) - sample_free(B, p, x);
    result.points[p] = {states[p].lambda, system.points[p].frame.transpose() * velocity, states[p].axial_slip,
                        states[p].lateral_slip};
  }
  Eigen::VectorXd Ax;
  multiply(system.A, x, Ax);
  const Eigen::VectorXd impulse = tissue_impulse(B, impulses, n);
  const double scale = std::max({load, impulse.norm(), Ax.norm(), impulse_scale});
  if (scale > 0.0) result.residual = (system.b + impulse - Ax).norm() / scale;
  if (std::isnan(result.residual) || std::isnan(scale)) result.residual = INFINITY;
  return result;
}

}  // namespace finegauge
