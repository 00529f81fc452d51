#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// What the paper says, by key: numbers and words, each with its place (section, figure or table). Every access throws
/// std::runtime_error, naming the file and the key, where there is no such entry or it is of another kind.
class PaperNumbers {
 public:
  /// Throws std::runtime_error, naming the file, when it cannot be read or an entry has no value or no place.
  explicit PaperNumbers(const std::filesystem::path& file);

  double value(const std::string& key) const;
  std::vector<double> values(const std::string& key) const;
  std::string words(const std::string& key) const;
  /// As a table shows it: a number with the file's digits, or the words.
  std::string operator()(const std::string& key) const;
  std::string place(const std::string& key) const;

 private:
  template <class T>
  T get(const std::string& key, const char* kind) const;
  const Json& entry(const std::string& key) const;

  std::string file_;
  Json entries_;
};

/// reference_data/paper/STUDY.json of the source tree.
PaperNumbers paper_numbers(const std::string& study);

}  // namespace finegauge
