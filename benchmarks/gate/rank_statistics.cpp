#include "benchmarks/gate/rank_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <stdexcept>

namespace finegauge {
namespace {

void require_finite(std::span<const double> differences) {
  for (const double d : differences)
    if (!std::isfinite(d)) throw std::invalid_argument("a difference is not finite");
}

/// Chances of each doubled sum, 0 to that of all ranks: a rank after the other, each counted or not with odds 1/2.
std::vector<double> sum_chances(std::span<const int> doubled_ranks) {
  std::vector<double> chance(1, 1.0);
  for (const int rank : doubled_ranks) {
    const std::size_t before = chance.size();
    chance.resize(before + static_cast<std::size_t>(rank), 0.0);
    for (std::size_t sum = chance.size(); sum-- > 0;) {
      const double without = sum < before ? chance[sum] : 0.0;
      const double with = sum >= static_cast<std::size_t>(rank) ? chance[sum - static_cast<std::size_t>(rank)] : 0.0;
      chance[sum] = 0.5 * (without + with);
    }
  }
  return chance;
}

}  // namespace

SignedRanks signed_ranks(std::span<const double> differences) {
  require_finite(differences);
  std::vector<double> nonzero;
  for (const double d : differences)
    if (d != 0.0) nonzero.push_back(d);
  std::ranges::sort(nonzero, {}, [](double d) { return std::abs(d); });
  SignedRanks ranks;
  for (std::size_t first = 0, next = 0; first < nonzero.size(); first = next) {
    for (next = first; next < nonzero.size() && std::abs(nonzero[next]) == std::abs(nonzero[first]);) ++next;
    const int doubled = static_cast<int>(first + 1 + next);  // of ranks first + 1 to next, twice their mean
    for (std::size_t i = first; i < next; ++i) {
      ranks.doubled_ranks.push_back(doubled);
      if (nonzero[i] > 0.0) ranks.positive += 0.5 * doubled;
    }
  }
  return ranks;
}

double signed_rank_cumulative(std::span<const int> doubled_ranks, double sum) {
  if (sum < 0.0) return 0.0;
  const std::vector<double> chance = sum_chances(doubled_ranks);
  const auto end = std::min(chance.size(), static_cast<std::size_t>(std::floor(2.0 * sum)) + 1);
  return std::min(1.0, std::accumulate(chance.begin(), chance.begin() + static_cast<std::ptrdiff_t>(end), 0.0));
}

double p_value_above(std::span<const double> differences) {
  const SignedRanks ranks = signed_ranks(differences);
  const double all = 0.5 * std::accumulate(ranks.doubled_ranks.begin(), ranks.doubled_ranks.end(), 0.0);
  // By symmetry the chance of a sum so high is that of the rest being so low: small chances are sums of small ones.
  return signed_rank_cumulative(ranks.doubled_ranks, all - ranks.positive);
}

HodgesLehmann hodges_lehmann(std::span<const double> differences, double confidence) {
  require_finite(differences);
  if (differences.empty()) throw std::invalid_argument("no differences");
  if (!(confidence > 0.0 && confidence < 1.0)) throw std::invalid_argument("a confidence is within (0, 1)");
  const std::size_t n = differences.size();
  std::vector<double> means;
  means.reserve(n * (n + 1) / 2);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i; j < n; ++j) means.push_back(0.5 * (differences[i] + differences[j]));
  std::ranges::sort(means);
  // W⁺ of the differences less a shift counts the means above that shift. The interval from the k-th mean from below to
  // the k-th from above misses with odds P(W⁺ <= k - 1) on either side: the largest k that may miss so often, or 1.
  std::vector<int> doubled_ranks(n);
  for (std::size_t i = 0; i < n; ++i) doubled_ranks[i] = 2 * static_cast<int>(i + 1);
  const std::vector<double> chance = sum_chances(doubled_ranks);
  std::size_t k = 1;
  double miss = chance[0];
  while (2 * (k + 1) <= means.size() && miss + chance[2 * k] <= 0.5 * (1.0 - confidence)) miss += chance[2 * k++];
  return {median(means), means[k - 1], means[means.size() - k], 1.0 - 2.0 * miss};
}

double median(std::vector<double> values) {
  if (values.empty()) throw std::invalid_argument("no values");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace finegauge
