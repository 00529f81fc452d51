#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace finegauge {

/// Cost and error of a run; NaN where it has none (a run that did not end well), which is never on a front.
struct TradePoint {
  double cost = 0.0, error = 0.0;
};

/// The points that no other one beats in both, by ascending cost; of equal ones the first. A point beats another when
/// it is no worse in one and better in the other.
std::vector<std::size_t> pareto_front(std::span<const TradePoint> points);

/// Frame times of one setting over several passes [ms].
struct FrameTiming {
  double p50 = 0.0, p99 = 0.0;              ///< medians over the passes of each pass's percentile
  double worst_p50 = 0.0, worst_p99 = 0.0;  ///< of any pass
  int passes = 0;

  /// Half of what the passes differ by, over their median: the noise of p99; 0 of one pass, which says nothing of it.
  double noise = 0.0;
};
/// Throws std::invalid_argument without passes or frames.
FrameTiming frame_timing(std::span<const std::vector<double>> passes);

/// A rate that a frame of this setting keeps in ninety-nine of a hundred frames, in the worst pass seen and, for those
/// not seen, with a tenth in hand or, where passes differed by more, with their noise [frames/s].
double promised_rate(const FrameTiming& timing);
inline constexpr double promise_margin = 1.1;

struct TradeQuestion {
  double error = 0.0;  ///< at most, relative
  double rate = 0.0;   ///< at least [frames/s]
};
struct TradeOffer {
  double error = 0.0, rate = 0.0;  ///< rate: promised
};
/// The offer of the highest rate among those that meet the question; none where none does.
std::optional<std::size_t> cheapest(std::span<const TradeOffer> offers, const TradeQuestion& question);
/// Of those that are fast enough the one with the least error, and of those that are right enough the fastest: what a
/// user may ask for instead.
struct NearestOffers {
  std::optional<std::size_t> fast_enough, right_enough;
};
NearestOffers nearest(std::span<const TradeOffer> offers, const TradeQuestion& question);

}  // namespace finegauge
