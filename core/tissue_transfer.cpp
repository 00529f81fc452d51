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
};

Gathered gather_momentum(const TissueMesh& from, const TissueState& state, const TissueMesh& to,
                         const Eigen::Matrix3Xd& v) {
  const std::vector<OldNode> old = find_old_nodes(from.d.mesh, to.d.mesh);
  Gathered gathered{Eigen::VectorXd::Zero(v.cols()), Eigen::Matrix3Xd::Zero(3, v.cols()), {}};
  for (int f = 0; f < from.d.hanging.reduced_count(); ++f) {
    const int node = from.d.hanging.node_of[f];
    if (old[node].node >= 0 && !to.d.hanging.hangs(old[node].node)) continue;  // it is what it was
    visit_row(to.d, old[node], [&](int i, double weight) {
      gathered.mass[i] += weight * from.mass[f];
      gathered.impulse.col(i) += weight * from.mass[f] * (state.v.col(node) - v.col(i));
      gathered.nodes.push_back(i);
    });
  }
  std::sort(gathered.nodes.begin(), gathered.nodes.end());
  gathered.nodes.erase(std::unique(gathered.nodes.begin(), gathered.nodes.end()), gathered.nodes.end());
  return gathered;
}

}  // namespace

TissueState transfer_state(const TissueMesh& from, const TissueState& state, const TissueMesh& to,
                           TransferLedger* ledger, double time) {
  const HangingNodes& T = to.d.hanging;
  const Eigen::VectorXd u = gather(T, transfer(from.d.mesh, state.u, to.d.mesh));
  Eigen::VectorXd reduced = gather(T, transfer(from.d.mesh, state.v, to.d.mesh));
  const Eigen::Matrix3Xd kept = reduced.reshaped(3, T.reduced_count());
  const Gathered gathered = gather_momentum(from, state, to, kept);
  Eigen::Vector3d support_impulse = Eigen::Vector3d::Zero();
  if (!gathered.nodes.empty()) {
    Eigen::Map<Eigen::Matrix3Xd> v(reduced.data(), 3, T.reduced_count());
    // m_i is what came plus what the node had itself; where it is not (see the header), still no more than a mean.
    double moved_mass = 0.0;
    for (const int i : gathered.nodes) {
      moved_mass += to.mass[i];
      if (const double mass = std::max(to.mass[i], gathered.mass[i]); mass > 0.0)
        v.col(i) += gathered.impulse.col(i) / mass;
    }
    const Eigen::Vector3d left_over = linear_momentum(from, state) - v * to.mass;
    for (const int i : gathered.nodes)
      if (to.mass[i] > 0.0) v.col(i) += left_over / moved_mass;
    for (std::size_t s = 0; s < to.d.supports.reduced.size(); ++s) {
      const int i = to.d.supports.reduced[s];
      const Eigen::Vector3d change = to.d.supports.held[s] * (v.col(i) - kept.col(i));
      v.col(i) -= change;
      support_impulse += to.mass[i] * change;
    }
  }
  const TissueState result{expand(T, u), expand(T, reduced)};
  if (ledger) {
    const TissueEnergy before = tissue_energy(from, state, time), after = tissue_energy(to, result, time);
    ledger->elastic_change = after.elastic - before.elastic;
    ledger->kinetic_change = after.kinetic - before.kinetic;
    ledger->support_impulse = support_impulse;
    const Eigen::Vector3d dp = linear_momentum(to, result) - linear_momentum(from, state) + support_impulse;
    const double scale = from.mass.sum() * std::sqrt(state.v.colwise().squaredNorm().maxCoeff());
    ledger->momentum_change = scale > 0.0 ? dp.norm() / scale : 0.0;
    ledger->moved = static_cast<int>(gathered.nodes.size());
  }
  return result;
}

}  // namespace finegauge
