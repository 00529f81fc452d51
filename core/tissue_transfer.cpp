#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/space/nested_nodes.hpp"
#include "core/space/transfer.hpp"
#include "core/tissue_step.hpp"

namespace finegauge {
namespace {

/// What the old nodes that are gone, or hang now, bring to the nodes that they hung on.
struct Gathered {
  Eigen::VectorXd mass;      // Σ_f P_fi m_f
  Eigen::Matrix3Xd impulse;  // Σ_f P_fi m_f (v_f - v_i)
  std::vector<int> nodes;    // that they touch, ascending
  bool only_coarsened = false;
};

void sort_and_unite(std::vector<int>& nodes) {
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

Gathered gather_momentum(const TissueMesh& from, const TissueState& state, const TissueMesh& to,
                         const Eigen::Matrix3Xd& v) {
  const std::vector<OldNode> old = find_old_nodes(from.d.mesh, to.d.mesh);
  Gathered gathered{Eigen::VectorXd::Zero(v.cols()), Eigen::Matrix3Xd::Zero(3, v.cols()), {}, false};
  for (int f = 0; f < from.d.hanging.reduced_count(); ++f) {
    const int node = from.d.hanging.node_of[f];
    if (old[node].node >= 0 && !to.d.hanging.hangs(old[node].node)) continue;  // it is what it was
    visit_row(to.d, old[node], [&](int i, double weight) {
      gathered.mass[i] += weight * from.mass[f];
      gathered.impulse.col(i) += weight * from.mass[f] * (state.v.col(node) - v.col(i));
      gathered.nodes.push_back(i);
    });
  }
  sort_and_unite(gathered.nodes);
  gathered.only_coarsened = std::ranges::count_if(old, [](const OldNode& at) { return at.node >= 0; }) ==
                            static_cast<std::ptrdiff_t>(to.d.mesh.node_count());
  return gathered;
}

/// Per reduced node i of the coarser of two meshes, whether m_i is not Σ_f P_fi m_f of the finer one, P the
/// interpolation between them, by more than round-off. It is where masses are row sums of nested functions
/// (lumped_mass.hpp), and not where a cell's mass is scaled or known better by its children. There velocities that
/// change as they should lose (m_i - Σ_f P_fi m_f) v_i.
std::vector<char> other_mass(const TissueMesh& coarse, const TissueMesh& fine, const std::vector<OldNode>& place) {
  constexpr double mass_round_off = 1e-12;  // sums of some thousand terms; shares of cut cells are as exact
  Eigen::VectorXd carried = Eigen::VectorXd::Zero(coarse.mass.size()), magnitude = coarse.mass;
  for (int f = 0; f < fine.d.hanging.reduced_count(); ++f)
    visit_row(coarse.d, place[fine.d.hanging.node_of[f]], [&](int i, double weight) {
      carried[i] += weight * fine.mass[f];
      magnitude[i] += std::abs(weight) * fine.mass[f];
    });
  std::vector<char> other(coarse.mass.size());
  for (int i = 0; i < coarse.mass.size(); ++i)
    other[i] = std::abs(coarse.mass[i] - carried[i]) > mass_round_off * magnitude[i];
  return other;
}

/// The nodes of the new mesh near which masses are not the old ones, for `share`: of a mesh that was coarsened only
/// these nodes, else those that depend on an old node of other mass. Added to `nodes`.
void add_nodes_of_other_mass(const TissueMesh& from, const TissueMesh& to, bool only_coarsened,
                             std::vector<int>& nodes) {
  if (only_coarsened) {
    const std::vector<char> other = other_mass(to, from, find_old_nodes(from.d.mesh, to.d.mesh));
    for (int i = 0; i < to.d.hanging.reduced_count(); ++i)
      if (other[i]) nodes.push_back(i);
  } else {
    const std::vector<OldNode> place = find_old_nodes(to.d.mesh, from.d.mesh);
    const std::vector<char> other = other_mass(from, to, place);
    for (int f = 0; f < to.d.hanging.reduced_count(); ++f)
      visit_row(from.d, place[to.d.hanging.node_of[f]], [&](int i, double) {
        if (other[i]) nodes.push_back(f);
      });
  }
  sort_and_unite(nodes);
}

/// Σ m (X - c) × v at rest positions, c the centre of mass: lumping may move c by moving mass between nodes, which
/// must not turn a body that moves uniformly.
Eigen::Vector3d rest_spin(const TissueMesh& mesh, const Eigen::Matrix3Xd& v) {
  const auto place = [&](int i) { return mesh.d.mesh.nodes.col(mesh.d.hanging.node_of[i]); };
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), sum = centre;
  for (int i = 0; i < mesh.mass.size(); ++i) centre += mesh.mass[i] * place(i);
  if (const double mass = mesh.mass.sum(); mass > 0.0) centre /= mass;
  for (int i = 0; i < mesh.mass.size(); ++i) sum += mesh.mass[i] * (place(i) - centre).cross(v.col(i));
  return sum;
}

/// Gives the nodes that have mass a rigid motion of linear momentum p and, unless that is left open, adds `spin` to
/// rest_spin: of all velocities that do so the ones of least kinetic energy. Nodes on a line cannot turn about it: what
/// is asked along it is left out.
void share(const TissueMesh& mesh, const std::vector<int>& nodes, const Eigen::Vector3d& p, const Eigen::Vector3d* spin,
           Eigen::Ref<Eigen::Matrix3Xd> v) {
  const auto place = [&](int i) { return mesh.d.mesh.nodes.col(mesh.d.hanging.node_of[i]); };
  double mass = 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const int i : nodes) {
    mass += mesh.mass[i];
    centre += mesh.mass[i] * place(i);
  }
  if (!(mass > 0.0)) return;
  centre /= mass;
  Eigen::Vector3d turning = Eigen::Vector3d::Zero();  // [rad/s]
  if (spin) {
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    for (const int i : nodes) {
      const Eigen::Vector3d arm = place(i) - centre;
      inertia += mesh.mass[i] * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
    Eigen::Matrix3Xd pushed = Eigen::Matrix3Xd::Zero(3, mesh.mass.size());
    for (const int i : nodes) pushed.col(i) = p / mass;
    const Eigen::Vector3d rest = *spin - rest_spin(mesh, pushed);
    for (int k = 0; k < 3; ++k)
      if (axes.eigenvalues()[k] > 1e-10 * axes.eigenvalues()[2])
        turning += axes.eigenvectors().col(k) * (axes.eigenvectors().col(k).dot(rest) / axes.eigenvalues()[k]);
  }
  for (const int i : nodes)
    if (mesh.mass[i] > 0.0) v.col(i) += p / mass + turning.cross(place(i) - centre);
}

}  // namespace

TissueState transfer_state(const TissueMesh& from, const TissueState& state, const TissueMesh& to,
                           TransferLedger* ledger, double time) {
  const HangingNodes& T = to.d.hanging;
  const Eigen::VectorXd u = gather(T, transfer(from.d.mesh, state.u, to.d.mesh));
  Eigen::VectorXd reduced = gather(T, transfer(from.d.mesh, state.v, to.d.mesh));
  const Eigen::Matrix3Xd kept = reduced.reshaped(3, T.reduced_count());
  Gathered gathered = gather_momentum(from, state, to, kept);
  Eigen::Map<Eigen::Matrix3Xd> v(reduced.data(), 3, T.reduced_count());
  // m_i is what came plus what the node had itself; where it is not (see the header), still no more than a mean.
  for (const int i : gathered.nodes)
    if (const double mass = std::max(to.mass[i], gathered.mass[i]); mass > 0.0)
      v.col(i) += gathered.impulse.col(i) / mass;
  const double fastest = std::sqrt(state.v.colwise().squaredNorm().maxCoeff());
  const double round_off = 1e-14 * from.mass.sum() * fastest;
  const Eigen::Vector3d left_over = linear_momentum(from, state) - v * to.mass;
  Eigen::Vector3d spin_left_over = Eigen::Vector3d::Zero();
  if (gathered.only_coarsened) {
    Eigen::Matrix3Xd before(3, from.d.hanging.reduced_count());
    for (int f = 0; f < from.d.hanging.reduced_count(); ++f) before.col(f) = state.v.col(from.d.hanging.node_of[f]);
    spin_left_over = rest_spin(from, before) - rest_spin(to, v);
  }
  const Eigen::Vector3d extent = from.d.mesh.nodes.rowwise().maxCoeff() - from.d.mesh.nodes.rowwise().minCoeff();
  const bool lost = left_over.norm() > round_off, turned = spin_left_over.norm() > round_off * extent.norm();
  if (lost || turned) add_nodes_of_other_mass(from, to, gathered.only_coarsened, gathered.nodes);
  const std::vector<int>& moved = gathered.nodes;
  share(to, moved, left_over, turned ? &spin_left_over : nullptr, v);
  Eigen::Vector3d support_impulse = Eigen::Vector3d::Zero(), support_turn = Eigen::Vector3d::Zero();
  for (std::size_t s = 0; s < to.d.supports.reduced.size() && !moved.empty(); ++s) {
    const int i = to.d.supports.reduced[s];
    const Eigen::Vector3d change = to.d.supports.held[s] * (v.col(i) - kept.col(i));
    v.col(i) -= change;
    support_impulse += to.mass[i] * change;
    const Eigen::Vector3d x = to.d.mesh.nodes.col(T.node_of[i]) + u.segment<3>(3 * i);
    support_turn += to.mass[i] * x.cross(change);
  }
  const TissueState result{expand(T, u), expand(T, reduced)};
  if (ledger) {
    const TissueEnergy before = tissue_energy(from, state, time), after = tissue_energy(to, result, time);
    ledger->elastic_change = after.elastic - before.elastic;
    ledger->kinetic_change = after.kinetic - before.kinetic;
    ledger->support_impulse = support_impulse;
    const Eigen::Vector3d dp = linear_momentum(to, result) - linear_momentum(from, state) + support_impulse;
    const double scale = from.mass.sum() * fastest;
    ledger->momentum_change = scale > 0.0 ? dp.norm() / scale : 0.0;
    ledger->angular_change = angular_momentum(to, result) - angular_momentum(from, state) + support_turn;
    ledger->moved = static_cast<int>(moved.size());
  }
  return result;
}

}  // namespace finegauge
