#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// A number that may be unknown: null then, with the reason beside it (KEY_reason).
template <class Number>
void put(Json& object, const std::string& key, bool known, Number value, const char* why_not) {
  if (known) {
    object[key] = value;
    return;
  }
  object[key] = nullptr;
  object[key + "_reason"] = why_not;
}

inline void put(Json& object, const std::string& key, const std::optional<double>& value, const char* why_not) {
  put(object, key, value.has_value(), value.value_or(0.0), why_not);
}

/// The one of larger magnitude; what is no number is larger than all, and stays it.
inline double larger(double a, double b) { return std::isnan(b) || std::abs(b) > std::abs(a) ? b : a; }

}  // namespace finegauge
