#pragma once

#include <vector>

#include "core/stopwatch.hpp"

namespace finegauge {

/// Processor time of the calling thread. On a machine that others use too it is what the work takes, where the wall
/// clock also shows the turns of others. About ten times as expensive to read as the wall clock.
StageClock processor_clock();

/// Times of a work that is repeated in turns with others, and their median [ms]; zero without one.
double median_ms(std::vector<double> times);

}  // namespace finegauge
