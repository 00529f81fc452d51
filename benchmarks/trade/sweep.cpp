#include "benchmarks/trade/sweep.hpp"

#include <gsl/gsl_qrng.h>
#include <gsl/gsl_rng.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "benchmarks/trade/front.hpp"

namespace finegauge {
namespace {

constexpr double share_of_filling = 0.6;
constexpr std::size_t round_size = 6;
constexpr int tries_for_a_point = 200;  // of settings that were all tried before

}  // namespace

QuasiRandom::QuasiRandom(int dimensions, std::uint64_t seed)
    : dimensions_(dimensions),
      sequence_(gsl_qrng_alloc(gsl_qrng_sobol, static_cast<unsigned>(dimensions)),
                [](void* sequence) { gsl_qrng_free(static_cast<gsl_qrng*>(sequence)); }) {
  if (!sequence_) throw std::runtime_error("no quasi-random sequence of " + std::to_string(dimensions) + " dimensions");
  const std::unique_ptr<gsl_rng, void (*)(gsl_rng*)> random(gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free);
  gsl_rng_set(random.get(), static_cast<unsigned long>(seed));
  for (int d = 0; d < dimensions; ++d) shift_.push_back(gsl_rng_uniform(random.get()));
}

std::vector<double> QuasiRandom::point(int index) {
  if (index < next_) throw std::invalid_argument("QuasiRandom: points are asked in ascending order");
  std::vector<double> at(static_cast<std::size_t>(dimensions_));
  for (; next_ <= index; ++next_) gsl_qrng_get(static_cast<gsl_qrng*>(sequence_.get()), at.data());
  for (std::size_t d = 0; d < at.size(); ++d) {
    at[d] += shift_[d];
    at[d] -= std::floor(at[d]);
  }
  return at;
}

// Two numbers for each axis: filling uses the first, a step from the front both (whether the axis moves, and where to).
TradePlan::TradePlan(std::vector<TradeAxis> axes, int points, std::uint64_t seed, bool fill_only)
    : axes_(std::move(axes)),
      points_(points),
      fill_only_(fill_only),
      random_(2 * static_cast<int>(axes_.size()) + 1, seed) {}

bool TradePlan::take(const TradeSetting& setting, std::vector<TradeSetting>& round) {
  if (!planned_.insert(setting).second) return false;
  round.push_back(setting);
  return true;
}

void TradePlan::fill(std::vector<TradeSetting>& round) {
  take(own_setting(axes_), round);
  const auto wanted = static_cast<std::size_t>(std::lround((fill_only_ ? 1.0 : share_of_filling) * points_));
  for (int misses = 0; planned_.size() < wanted && misses < tries_for_a_point;) {
    const std::vector<double> at = random_.point(index_++);
    TradeSetting setting;
    for (std::size_t a = 0; a < axes_.size(); ++a)
      setting.push_back(static_cast<int>(at[a] * static_cast<double>(axes_[a].choices.size())));
    misses = take(setting, round) ? 0 : misses + 1;
  }
}

void TradePlan::refine(const std::vector<TradeJob>& finished, std::vector<TradeSetting>& round) {
  std::set<std::string> names;
  for (const TradeJob& job : finished)
    for (const auto& [name, error] : job.run.errors) names.insert(name);
  std::vector<std::size_t> around;  // jobs on a front, each once
  for (const std::string& name : names) {
    std::vector<TradePoint> points;
    for (const TradeJob& job : finished) {
      const auto error = job.run.errors.find(name);
      points.push_back({job.run.work, error == job.run.errors.end() ? std::nan("") : error->second});
    }
    for (const std::size_t i : pareto_front(points))
      if (std::ranges::find(around, i) == around.end()) around.push_back(i);
  }
  if (around.empty()) return;
  const std::size_t left = static_cast<std::size_t>(points_) - planned_.size();
  for (int misses = 0; round.size() < std::min(round_size, left) && misses < tries_for_a_point;) {
    const std::vector<double> at = random_.point(index_++);
    const auto pick = static_cast<std::size_t>(at.back() * static_cast<double>(around.size()));
    TradeSetting setting = finished[around[pick]].setting;
    const double move = 1.5 / static_cast<double>(axes_.size());  // one or two axes at a time
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      if (at[a] >= move) continue;
      const int last = static_cast<int>(axes_[a].choices.size()) - 1;
      const int step = at[axes_.size() + a] < 0.5 ? -1 : 1;
      setting[a] = std::clamp(setting[a] + step, 0, last);
    }
    misses = take(setting, round) ? 0 : misses + 1;
  }
}

std::vector<TradeSetting> TradePlan::next_round(const std::vector<TradeJob>& finished) {
  std::vector<TradeSetting> round;
  if (planned_.empty())
    fill(round);
  else if (!fill_only_ && planned_.size() < static_cast<std::size_t>(points_))
    refine(finished, round);
  return round;
}

}  // namespace finegauge
