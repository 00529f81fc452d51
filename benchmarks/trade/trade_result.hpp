#pragma once

#include <optional>
#include <string>
#include <vector>

#include "benchmarks/program/plots.hpp"
#include "benchmarks/program/result_document.hpp"
#include "benchmarks/trade/front.hpp"
#include "benchmarks/trade/trade_sweep.hpp"

namespace finegauge {

/// What the sweep answers to one question.
struct TradeAnswer {
  TradeQuestion question;
  std::optional<std::size_t> job;  ///< index; none: nothing that was tried meets it
  TradeOffer offer;                ///< of the job
  NearestOffers nearest;           ///< jobs, where there is no answer
};

/// Errors that runs were measured by, the first one the energy norm's.
std::vector<std::string> measured_quantities(const TradeSweep& sweep);

/// How far the reference may itself be off, by its distance from a coarser one; none where that is not known (no such
/// quantity, or the two are the same).
std::optional<double> reference_error(const TradeSweep& sweep, const std::string& quantity);

/// Jobs that did not end well have a rate of zero and an infinite error, and so have those that `counts` leaves out.
std::vector<TradeOffer> offers(const TradeSweep& sweep, const std::string& quantity);
TradeAnswer answer(const TradeSweep& sweep, const std::string& quantity, const TradeQuestion& question);

/// Three questions that the front itself answers, at a quarter, half and three quarters of its way in errors
/// (logarithmic): for who asked none. Fewer where the front is short, and none below the reference's own error.
std::vector<TradeQuestion> questions_of_front(const TradeSweep& sweep, const std::string& quantity);

/// The document's rows, a row per job; `on_front` is about `quantity`, `fronts` lists all quantities.
Json trade_rows(const TradeSweep& sweep, const std::string& quantity);
Json to_json(const TradeSweep& sweep, const TradeAnswer& answer, const std::string& quantity, const std::string& scene,
             const std::vector<std::string>& set);
/// Error over p99, all settings as a cloud and the front as a line, a plot per quantity.
std::vector<Plot> trade_plots(const TradeSweep& sweep, const std::string& name);
/// Lines for the terminal.
std::vector<std::string> trade_table(const TradeSweep& sweep, const std::string& quantity);

}  // namespace finegauge
