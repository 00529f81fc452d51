#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/program/progress.hpp"
#include "benchmarks/program/result_document.hpp"
#include "benchmarks/trade/trade_result.hpp"

namespace finegauge {

// What finegauge trade leaves of a sweep, and finegauge merge of the parts of one.

/// The summary's quantity, reference and axes.
void summarize_sweep(const TradeSweep& sweep, const std::string& quantity, ResultDocument& document);

/// Answers and plots; `print`: the table, the answers and the checks on standard output.
void conclude_sweep(const TradeSweep& sweep, const std::string& quantity, const std::vector<TradeAnswer>& answers,
                    ResultDocument& document, const std::filesystem::path& directory, bool print,
                    const Progress& progress);

}  // namespace finegauge
