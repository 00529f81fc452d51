#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/program/plots.hpp"
#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// What a study may use and must heed.
struct StudyContext {
  bool quick = false;  ///< a smaller version that ends in under a minute
  bool full = false;   ///< all that the study can do, however long
  bool quiet = false;
  int vtu_every = 0;  ///< a VTU every so many steps; 0: none
  std::filesystem::path out;
  std::map<std::string, std::string> overrides;  ///< of --set; a study throws UsageError for keys that it does not know
  /// Tells how far the study is, from 0 to 1, in a few words.
  std::function<void(double fraction, const std::string& doing)> progress = [](double, const std::string&) {};
  /// True once the user wants to stop: return what is finished. Asked between steps.
  std::function<bool()> interrupted = [] { return false; };
};

/// A file of the result that the study has made in memory: a picture.
struct StudyFile {
  std::string name;  ///< in the output directory
  std::string content;
};

/// What a study found.
struct StudyResult {
  Json rows = Json::array();
  Json summary = Json::object();
  Json checks = Json::array();     ///< made by `check`
  std::vector<std::string> table;  ///< lines for the terminal, with the columns paper, here, why they differ
  std::vector<Plot> plots;
  std::vector<StudyFile> files;
  std::string scene;   ///< path or name of what was computed; empty where a study brings its own problem
  std::string sha256;  ///< of the scene file; empty without one
};

struct Study {
  std::string name;
  std::string about;  ///< one line
  StudyResult (*run)(const StudyContext&);
};

/// A row of the terminal's table.
struct ComparisonRow {
  std::string quantity, paper, here, why;
  std::string place = {};  ///< in the paper, of its number or words; empty: not told
};
/// Adds to the table aligned lines with a header "quantity | paper | here | why they differ", wrapped; below them, once
/// each, the paper's entries whose place is given, with it. The rows go to the document: summary.comparison, a list of
/// objects with quantity, paper, here, why and, where it is told, place. What the table says already becomes
/// summary.comparison_note.
void add_comparison(const std::vector<ComparisonRow>& rows, StudyResult& result);

}  // namespace finegauge
