#pragma once

#include <span>
#include <vector>

namespace finegauge {

/// Signed ranks of paired differences (Wilcoxon 1945) and the shift that belongs to them (Hodges and Lehmann 1963).
/// Distributions are exact, by counting, with midranks where differences tie: given the ranks, under no shift each
/// difference is above or below zero with equal odds. Nothing is assumed of the noise but that it favours neither side.

/// The statistic: sum of the ranks of |d| over the differences above zero. Differences that are exactly zero tell
/// neither way and are left out, as Wilcoxon did.
struct SignedRanks {
  double positive = 0.0;           ///< the sum over d > 0
  std::vector<int> doubled_ranks;  ///< 2 × midrank of every difference that is not zero, ascending
};
/// Throws std::invalid_argument on a difference that is not finite.
SignedRanks signed_ranks(std::span<const double> differences);

/// P(W⁺ <= sum) with each rank's sign tossed; doubled_ranks as above, 1 to 1000 of them, or none (then 1 for sum >= 0).
double signed_rank_cumulative(std::span<const int> doubled_ranks, double sum);
/// One-sided: how likely ranks as high as these are if there is no shift, P(W⁺ >= observed). 1 without a difference.
double p_value_above(std::span<const double> differences);

/// Median of all (d_i + d_j) / 2, i <= j, and the interval of those that signed ranks do not reject.
struct HodgesLehmann {
  double shift, low, high;
  double confidence;  ///< of [low, high], exact: at least what was asked where so many differences allow it
};
/// confidence: asked, in (0, 1). Throws std::invalid_argument without a difference or with one that is not finite.
HodgesLehmann hodges_lehmann(std::span<const double> differences, double confidence);

/// Mean of the two middle ones where their number is even. Throws std::invalid_argument on nothing.
double median(std::vector<double> values);

}  // namespace finegauge
