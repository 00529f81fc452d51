#include "core/needle/needle.hpp"

#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/needle/centreline.hpp"

using namespace finegauge;

namespace {

/// A steel needle of 1 mm radius and 0.1 m length, bent to a quarter circle, twisted by a quarter turn and stretched a
/// little: nothing in it is zero.
struct BentNeedle {
  Needle needle;
  NeedleState state;
  HeldDofs held;

  explicit BentNeedle(const benchmark::State& loop) {
    constexpr double L = 0.1, bend = 1.5, twist = 1.5;
    const int n = static_cast<int>(loop.range(0));
    needle = straight_needle({}, {0.0, 0.0, 0.0}, {L, 0.0, 0.0}, n);
    state = needle_at_rest(needle);
    for (int i = 0; i <= n; ++i) {
      const double s = static_cast<double>(i) / n, angle = bend * s;
      Eigen::VectorXd turn = Eigen::VectorXd::Zero(needle.dof_count());
      turn[6 * i + 3] = twist * s;
      displace(turn, state);
      turn[6 * i + 3] = 0.0;
      turn[6 * i + 5] = angle;
      displace(turn, state);
      state.positions.col(i) << 1.001 * L / bend * std::sin(angle), L / bend * (1.0 - std::cos(angle)), 0.0;
    }
    held.assign(needle.node_count(), 0u);
    held[0] = hold_all;
  }
  /// A frame's matrix but for τ²: material stiffness and mass at a step of 1 ms.
  ChainMatrix system() const {
    constexpr double tau = 1e-3;
    ChainMatrix A;
    A.set_zero(needle.node_count());
    add_material_stiffness(needle, state, 1.0, A);
    const Eigen::VectorXd mass = needle_mass(needle) / (tau * tau);
    for (int i = 0; i < needle.node_count(); ++i) A.diagonal[i].diagonal() += mass.segment<6>(6 * i);
    hold(held, A);
    return A;
  }
};

void count_sizes(benchmark::State& loop, const BentNeedle& bent) {
  loop.counters["elements"] = bent.needle.element_count();
  loop.counters["dofs"] = bent.needle.dof_count();
}

constexpr auto needle_sizes = [](auto* registered) {
  registered->ArgName("elements")->Unit(benchmark::kMicrosecond)->MeasureProcessCPUTime();
  for (const int elements : {10, 40, 160}) registered->Arg(elements);
};

/// Forces of nothing but the configuration are in balance.
void beam_internal_forces(benchmark::State& loop) {
  const BentNeedle bent(loop);
  Eigen::VectorXd forces;
  for (auto _ : loop) {
    forces = needle_forces(bent.needle, bent.state);
    benchmark::DoNotOptimize(forces.data());
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < forces.size(); i += 6) sum += forces.segment<3>(i);
  if (!(forces.norm() > 0.0 && sum.norm() < 1e-12 * forces.norm())) loop.SkipWithError("the forces are not in balance");
  count_sizes(loop, bent);
}
BENCHMARK(beam_internal_forces)->Apply(needle_sizes);

/// Whether A times a rigid rotation about the base vanishes beside A times its spins alone.
bool knows_rigid_motions(const ChainMatrix& A, const NeedleState& state) {
  const Eigen::Vector3d omega(0.3, -0.5, 0.8);
  Eigen::VectorXd rigid = Eigen::VectorXd::Zero(6 * state.positions.cols()), force, torn;
  for (Eigen::Index i = 0; i < state.positions.cols(); ++i) rigid.segment<3>(6 * i + 3) = omega;
  multiply(A, rigid, torn);
  for (Eigen::Index i = 0; i < state.positions.cols(); ++i)
    rigid.segment<3>(6 * i) = omega.cross(Eigen::Vector3d(state.positions.col(i)));
  multiply(A, rigid, force);
  return torn.norm() > 0.0 && force.norm() < 1e-9 * torn.norm();
}

void beam_material_stiffness(benchmark::State& loop) {
  const BentNeedle bent(loop);
  ChainMatrix A;
  for (auto _ : loop) {
    A.set_zero(bent.needle.node_count());
    add_material_stiffness(bent.needle, bent.state, 1.0, A);
    benchmark::DoNotOptimize(A.diagonal.data());
  }
  if (!knows_rigid_motions(A, bent.state)) loop.SkipWithError("a rigid motion meets resistance");
  count_sizes(loop, bent);
}
BENCHMARK(beam_material_stiffness)->Apply(needle_sizes);

/// The geometric part turns the forces with a rigid motion; its answer is checked by the forces' own change.
void beam_tangent_stiffness(benchmark::State& loop) {
  const BentNeedle bent(loop);
  ChainMatrix A;
  for (auto _ : loop) {
    A.set_zero(bent.needle.node_count());
    add_tangent_stiffness(bent.needle, bent.state, 1.0, A);
    benchmark::DoNotOptimize(A.diagonal.data());
  }
  const Eigen::Index dof = 6 * (bent.needle.node_count() / 2) + 1;  // a translation: its row has no skew part
  const double h = 1e-9;
  NeedleState ahead = bent.state, behind = bent.state;
  displace(h * Eigen::VectorXd::Unit(bent.needle.dof_count(), dof), ahead);
  displace(-h * Eigen::VectorXd::Unit(bent.needle.dof_count(), dof), behind);
  const Eigen::VectorXd change = (needle_forces(bent.needle, ahead) - needle_forces(bent.needle, behind)) / (2.0 * h);
  Eigen::VectorXd column;
  multiply(A, Eigen::VectorXd::Unit(bent.needle.dof_count(), dof), column);
  if (!((column - change).norm() < 1e-3 * change.norm()))
    loop.SkipWithError("the tangent is not the forces' derivative");
  count_sizes(loop, bent);
}
BENCHMARK(beam_tangent_stiffness)->Apply(needle_sizes);

/// Block factorization and one right side.
void chain_factor_solve(benchmark::State& loop) {
  const BentNeedle bent(loop);
  const ChainMatrix A = bent.system();
  Eigen::VectorXd b = needle_forces(bent.needle, bent.state);
  hold(bent.held, b);
  ChainFactor factor;
  Eigen::VectorXd x, product;
  bool factored = true;
  for (auto _ : loop) {
    factor.factor(A);
    factored = factored && factor.factored();
    if (!factored) break;
    x = b;
    factor.solve(x);
    benchmark::DoNotOptimize(x.data());
  }
  // Backward error: the condition grows with the fourth power of the elements' number, and x with it.
  double size = 0.0;
  for (const auto& D : A.diagonal) size = std::max(size, D.norm());
  if (factored) multiply(A, x, product);
  if (!factored || !((product - b).norm() < 1e-13 * size * x.norm())) loop.SkipWithError("the solve is not exact");
  loop.counters["negative_pivots"] = factor.negative_pivots();
  count_sizes(loop, bent);
}
BENCHMARK(chain_factor_solve)->Apply(needle_sizes);

/// The closest point of the axis: what each constraint point of a frame asks for.
void centreline_closest_point(benchmark::State& loop) {
  const BentNeedle bent(loop);
  const CentrelinePoint asked{bent.needle.element_count() / 3, 0.4};
  const Eigen::Vector3d x = centreline_position(bent.needle, bent.state, asked);
  ClosestPoint closest;
  for (auto _ : loop) {
    closest = closest_point(bent.needle, bent.state, x);
    benchmark::DoNotOptimize(closest);
  }
  if (closest.point.element != asked.element || !(std::abs(closest.point.share - asked.share) < 1e-9))
    loop.SkipWithError("it is another point");
  count_sizes(loop, bent);
}
BENCHMARK(centreline_closest_point)->Apply(needle_sizes);

}  // namespace
