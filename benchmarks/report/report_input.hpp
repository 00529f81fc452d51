#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// A result document of a user, read. What the schema promises for every kind has been checked (the types of the outer
/// keys, the names and verdicts of the checks); rows and summary differ by kind and age, and are read by the functions
/// below.
struct ReportDocument {
  std::filesystem::path file;
  std::string shown_file;  ///< as the user would name it
  std::string id;          ///< of its anchors in the page: letters, digits and hyphens, unique in the report
  std::string kind, name;
  bool quick = false;
  Json content;

  const Json& rows() const { return content.at("rows"); }
  const Json& summary() const { return content.at("summary"); }
  const Json& checks() const { return content.at("checks"); }
  std::vector<const Json*> failing_checks() const;
};

/// Reads a file. Throws UsageError that names file and place where it is not JSON or not of the schema.
/// Nothing for a trace of the trace-event format, which stands beside results and is none.
std::optional<ReportDocument> read_report_document(const std::filesystem::path& file);

/// All documents of files and directories: DIR/*.json, or those of its sub-directories where DIR itself has none. In
/// the order of kind, start and name, whatever the order of the arguments; one that is reached twice counts once.
/// Throws UsageError where a path does not exist, holds no document, or one is not valid.
std::vector<ReportDocument> read_report_documents(const std::vector<std::filesystem::path>& paths);

/// The command that made a document, as one would type it again.
std::string command_of(const ReportDocument& document);

// Tolerant access: a key that a document lacks is no error, since kinds and versions differ.

/// By a path with dots, "frame_ms.p50"; nothing where a part is missing or null.
const Json* find_value(const Json& object, const std::string& path);
double number_at(const Json& object, const std::string& path);     ///< NaN where there is no number
std::string text_at(const Json& object, const std::string& path);  ///< empty where there is no text

}  // namespace finegauge
