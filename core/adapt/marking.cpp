#include "core/adapt/marking.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace finegauge {

namespace {

/// The largest eta; zero for no cells. An estimate that is no number would make every comparison below false and
/// silently mark nothing, so it is refused here.
double checked_maximum(std::span<const double> eta) {
  double maximum = 0.0;
  for (std::size_t cell = 0; cell < eta.size(); ++cell) {
    if (!(eta[cell] >= 0.0 && std::isfinite(eta[cell])))
      throw std::invalid_argument("eta of cell " + std::to_string(cell) + " is " + std::to_string(eta[cell]) +
                                  ", must be finite and >= 0");
    maximum = std::max(maximum, eta[cell]);
  }
  return maximum;
}

void require_range(const char* name, double value, bool inside, const char* range) {
  if (!inside) throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) + ", must be " + range);
}

struct Candidate {
  double eta;
  int cell;
};

bool larger(const Candidate& a, const Candidate& b) { return a.eta > b.eta || (a.eta == b.eta && a.cell < b.cell); }

std::vector<Candidate> nonzero_candidates(std::span<const double> eta) {
  std::vector<Candidate> candidates;
  candidates.reserve(eta.size());
  for (std::size_t cell = 0; cell < eta.size(); ++cell)
    if (eta[cell] > 0.0) candidates.push_back({eta[cell], static_cast<int>(cell)});
  return candidates;
}

std::vector<int> ascending_cells(std::span<const Candidate> candidates) {
  std::vector<int> cells;
  cells.reserve(candidates.size());
  for (const Candidate& candidate : candidates) cells.push_back(candidate.cell);
  std::sort(cells.begin(), cells.end());
  return cells;
}

}  // namespace

std::vector<int> mark_maximum(std::span<const double> eta, double theta) {
  require_range("theta", theta, theta > 0.0 && theta <= 1.0, "in (0, 1]");
  const double threshold = theta * checked_maximum(eta);
  std::vector<int> marked;
  for (std::size_t cell = 0; cell < eta.size(); ++cell)
    if (eta[cell] > 0.0 && eta[cell] >= threshold) marked.push_back(static_cast<int>(cell));
  return marked;
}

std::vector<int> mark_bulk(std::span<const double> eta, double theta) {
  require_range("theta", theta, theta > 0.0 && theta <= 1.0, "in (0, 1]");
  const double maximum = checked_maximum(eta);
  std::vector<Candidate> candidates = nonzero_candidates(eta);
  if (candidates.empty()) return {};
  std::sort(candidates.begin(), candidates.end(), larger);

  // Divided by the maximum, squares neither overflow nor vanish as a whole. Both sums run from the smallest up, so that
  // small cells count, and what may be left out is exactly nothing for theta = 1.
  const auto share = [maximum](const Candidate& c) { return (c.eta / maximum) * (c.eta / maximum); };
  double total = 0.0;
  for (auto c = candidates.rbegin(); c != candidates.rend(); ++c) total += share(*c);
  const double may_be_left = (1.0 - theta * theta) * total;
  std::size_t kept = candidates.size();
  for (double left = 0.0; kept > 1; --kept) {
    left += share(candidates[kept - 1]);
    if (left > may_be_left) break;
  }
  return ascending_cells(std::span(candidates).first(kept));
}

std::vector<int> mark_fraction(std::span<const double> eta, double share) {
  require_range("share", share, share >= 0.0 && share <= 1.0, "in [0, 1]");
  checked_maximum(eta);
  std::vector<Candidate> candidates = nonzero_candidates(eta);
  // At least the share, so that a positive one always makes progress; the slack keeps 0.3 of 10 cells at three.
  const double wanted = share * static_cast<double>(eta.size());
  const auto count = std::min(candidates.size(), static_cast<std::size_t>(std::ceil(wanted * (1.0 - 1e-12))));
  std::nth_element(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count), candidates.end(),
                   larger);
  return ascending_cells(std::span(candidates).first(count));
}

std::vector<int> mark_above(std::span<const double> eta, double threshold) {
  require_range("threshold", threshold, threshold >= 0.0, ">= 0");
  checked_maximum(eta);
  std::vector<int> marked;
  for (std::size_t cell = 0; cell < eta.size(); ++cell)
    if (eta[cell] > threshold) marked.push_back(static_cast<int>(cell));
  return marked;
}

}  // namespace finegauge
