#pragma once

#include <functional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace finegauge {

/// What a piece of evidence speaks for: the factors of verification in ASME V&V 40 (2018), "Assessing Credibility of
/// Computational Modeling through Verification and Validation".
enum class CredibilityFactor {
  software_quality_assurance,
  code_verification,
  discretization_error,
  numerical_solver_error,
  use_error
};
std::string to_string(CredibilityFactor factor);  ///< in words, "numerical solver error"

/// A number that a study found, the bounds it has to keep, and why the bounds are these.
struct Claim {
  std::string name;  ///< words joined by underscores, unique in its study
  double value = 0.0, low = 0.0, high = 0.0;
  std::string reason;  ///< of the bounds: the theory's order, round-off times condition, the source's own digits

  bool holds() const { return value >= low && value <= high; }  ///< false for NaN
};

using TableValue = std::variant<double, std::string>;
struct EvidenceTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<TableValue>> rows;  ///< each as long as `columns`
};

/// What a study shows: tables to read, claims to gate.
struct Evidence {
  std::vector<EvidenceTable> tables;
  std::vector<Claim> claims;

  void claim(std::string name, double value, double low, double high, std::string reason);
  bool holds() const;  ///< there are claims and all of them hold
};

/// What a study may use and must heed.
struct EvidenceOptions {
  bool full = false;  ///< all that the study can do, however long; otherwise what the tests gate
  std::function<void(double fraction, const std::string& doing)> progress = [](double, const std::string&) {};
  std::function<bool()> interrupted = [] { return false; };  ///< true: return what is finished
};

/// A part of a study: what it does, in a few words, and what adds to the evidence; `full` as in the options.
struct EvidencePart {
  const char* doing;
  void (*show)(Evidence& evidence, bool full);
};
/// One part after the other, with progress, until all are shown or the user wants to stop.
Evidence show_parts(std::span<const EvidencePart> parts, const EvidenceOptions& options);

struct EvidenceStudy {
  std::string name;  ///< as `finegauge verify NAME` takes it
  CredibilityFactor factor;
  std::string about;  ///< one line
  Evidence (*run)(const EvidenceOptions&);
};

/// Aligned lines: title, header, rows; then the claims with their bounds, those that do not hold marked by "FAILS".
std::string to_text(const EvidenceTable& table);
std::string to_text(const std::vector<Claim>& claims);
std::string to_text(const Evidence& evidence);

}  // namespace finegauge
