#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// Where a number stands in a result document: keys joined by dots, each with at most one pair of brackets behind it.
/// `rows[0]` is the first entry of a list, `rows[-1]` its last; `rows[study=estimator,claim=spr.crack]` the only one
/// whose keys have these values, written as text.
struct PathPart {
  std::string key;
  std::optional<long> index = {};
  std::vector<std::pair<std::string, std::string>> where = {};
};
/// None when it is no path.
std::optional<std::vector<PathPart>> parse_result_path(std::string_view path);

/// Whether a key of a result, or of a budget, holds a time or what follows from one: milliseconds, seconds, rates,
/// missed frames.
bool is_time(std::string_view key);

/// A number found, or why there is none.
struct FoundNumber {
  std::optional<double> value;
  std::string why;
};
/// true and false count as 1 and 0. `why` names the first part of the path that leads nowhere, and the reason that the
/// document gives for a null.
FoundNumber find_number(const Json& document, const std::string& path);

}  // namespace finegauge
