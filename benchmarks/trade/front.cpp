#include "benchmarks/trade/front.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "benchmarks/program/frame_statistics.hpp"

namespace finegauge {

std::vector<std::size_t> pareto_front(std::span<const TradePoint> points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].cost) && std::isfinite(points[i].error)) order.push_back(i);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    return points[a].cost != points[b].cost ? points[a].cost < points[b].cost : points[a].error < points[b].error;
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order)
    if (front.empty() || points[i].error < points[front.back()].error) front.push_back(i);
  return front;
}

FrameTiming frame_timing(std::span<const std::vector<double>> passes) {
  std::vector<double> p50, p99;
  for (const std::vector<double>& pass : passes) {
    p50.push_back(percentile(pass, 50));
    p99.push_back(percentile(pass, 99));
  }
  if (p99.empty()) throw std::invalid_argument("frame_timing: no pass was timed");
  FrameTiming timing;
  timing.passes = static_cast<int>(passes.size());
  timing.p50 = percentile(p50, 50), timing.p99 = percentile(p99, 50);
  const auto [least, most] = std::ranges::minmax(p99);
  timing.worst_p50 = std::ranges::max(p50), timing.worst_p99 = most;
  timing.noise = timing.p99 > 0.0 ? 0.5 * (most - least) / timing.p99 : 0.0;
  return timing;
}

double promised_rate(const FrameTiming& timing) {
  return 1e3 / (std::max(promise_margin, 1.0 + timing.noise) * timing.worst_p99);
}

std::optional<std::size_t> cheapest(std::span<const TradeOffer> offers, const TradeQuestion& question) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < offers.size(); ++i)
    if (offers[i].error <= question.error && offers[i].rate >= question.rate &&
        (!best || offers[i].rate > offers[*best].rate))
      best = i;
  return best;
}

NearestOffers nearest(std::span<const TradeOffer> offers, const TradeQuestion& question) {
  NearestOffers found;
  for (std::size_t i = 0; i < offers.size(); ++i) {
    const TradeOffer& offer = offers[i];
    if (offer.rate >= question.rate && (!found.fast_enough || offer.error < offers[*found.fast_enough].error))
      found.fast_enough = i;
    if (offer.error <= question.error && (!found.right_enough || offer.rate > offers[*found.right_enough].rate))
      found.right_enough = i;
  }
  return found;
}

}  // namespace finegauge
