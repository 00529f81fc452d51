#pragma once

#include <string>
#include <vector>

#include "benchmarks/report/report_input.hpp"

namespace finegauge {

/// One HTML page of all documents, with everything in it: it fetches nothing and is read without its script, too. The
/// same documents with the same files beside them give the same bytes.
std::string report_page(const std::vector<ReportDocument>& documents);

}  // namespace finegauge
