#include "verification/support/evidence.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace finegauge {

namespace {

std::string six_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string cell_text(const TableValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return six_digits(*number);
  return std::get<std::string>(value);
}

}  // namespace

Evidence show_parts(std::span<const EvidencePart> parts, const EvidenceOptions& options) {
  Evidence evidence;
  const double count = static_cast<double>(parts.size());
  for (std::size_t k = 0; k < parts.size() && !options.interrupted(); ++k) {
    options.progress(static_cast<double>(k) / count, parts[k].doing);
    parts[k].show(evidence, options.full);
  }
  return evidence;
}

std::string to_string(CredibilityFactor factor) {
  switch (factor) {
    case CredibilityFactor::software_quality_assurance:
      return "software quality assurance";
    case CredibilityFactor::code_verification:
      return "code verification";
    case CredibilityFactor::discretization_error:
      return "discretization error";
    case CredibilityFactor::numerical_solver_error:
      return "numerical solver error";
    case CredibilityFactor::use_error:
      return "use error";
  }
  throw std::invalid_argument("no such credibility factor");
}

void Evidence::claim(std::string name, double value, double low, double high, std::string reason) {
  claims.push_back({std::move(name), value, low, high, std::move(reason)});
}

bool Evidence::holds() const {
  return !claims.empty() && std::ranges::all_of(claims, [](const Claim& claim) { return claim.holds(); });
}

std::string to_text(const EvidenceTable& table) {
  std::vector<std::vector<std::string>> lines{table.columns};
  for (const std::vector<TableValue>& row : table.rows) {
    if (row.size() != table.columns.size()) throw std::invalid_argument(table.title + ": a row of another length");
    std::vector<std::string>& line = lines.emplace_back();
    for (const TableValue& value : row) line.push_back(cell_text(value));
  }
  std::vector<std::size_t> widths(table.columns.size(), 0);
  for (const auto& line : lines)
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  std::string text = table.title + '\n';
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::string padding(widths[i] - line[i].size(), ' ');
      text += "  " + (i == 0 ? line[i] + padding : padding + line[i]);  // names left, numbers right
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  return text;
}

std::string to_text(const std::vector<Claim>& claims) {
  std::size_t width = 0;
  for (const Claim& claim : claims) width = std::max(width, claim.name.size());
  std::string text;
  for (const Claim& claim : claims)
    text += std::string(claim.holds() ? "  holds  " : "  FAILS  ") + claim.name +
            std::string(width - claim.name.size(), ' ') + "  " + six_digits(claim.value) + "  in [" +
            six_digits(claim.low) + ", " + six_digits(claim.high) + "]  " + claim.reason + '\n';
  return text;
}

std::string to_text(const Evidence& evidence) {
  std::string text;
  for (const EvidenceTable& table : evidence.tables) text += to_text(table) + '\n';
  return text + to_text(evidence.claims);
}

}  // namespace finegauge
