#include "core/solve/anderson_mixing.hpp"

#include <Eigen/QR>

namespace finegauge {

Eigen::VectorXd AndersonMixing::next(const Eigen::VectorXd& x, const Eigen::VectorXd& g) {
  // A step that did not change g says nothing, and Eigen's pivoting takes exception to zero columns.
  if (depth_ > 0 && last_x_.size() == x.size() && g != last_g_) {
    x_changes_.push_back(x - last_x_);
    g_changes_.push_back(g - last_g_);
    if (static_cast<int>(x_changes_.size()) > depth_) {
      x_changes_.pop_front();
      g_changes_.pop_front();
    }
  }
  last_x_ = x;
  last_g_ = g;
  Eigen::VectorXd mixed = x + g;
  if (g_changes_.empty()) return mixed;
  const auto columns = static_cast<Eigen::Index>(g_changes_.size());
  Eigen::MatrixXd G(g.size(), columns);
  for (Eigen::Index k = 0; k < columns; ++k) G.col(k) = g_changes_[static_cast<std::size_t>(k)];
  // Pivoting leaves out differences that depend on the others, as they do once the iteration stalls at round-off.
  const Eigen::VectorXd share = G.colPivHouseholderQr().solve(g);
  for (Eigen::Index k = 0; k < columns; ++k)
    mixed -= share[k] * (x_changes_[static_cast<std::size_t>(k)] + g_changes_[static_cast<std::size_t>(k)]);
  return mixed;
}

}  // namespace finegauge
