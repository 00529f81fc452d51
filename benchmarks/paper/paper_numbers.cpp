#include "benchmarks/paper/paper_numbers.hpp"

#include <fstream>
#include <stdexcept>

namespace finegauge {

PaperNumbers::PaperNumbers(const std::filesystem::path& file) : file_(file.string()) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file_ + ": cannot be opened");
  try {
    entries_ = Json::parse(stream);
  } catch (const Json::exception& error) {
    throw std::runtime_error(file_ + ": " + error.what());
  }
  if (!entries_.is_object()) throw std::runtime_error(file_ + ": is not an object of entries");
  for (const auto& [key, entry] : entries_.items()) {
    if (key == "source") continue;
    if (!entry.is_object() || !entry.contains("value") || !entry.contains("place") || !entry["place"].is_string())
      throw std::runtime_error(file_ + ": " + key + " has no value or no place");
  }
}

const Json& PaperNumbers::entry(const std::string& key) const {
  const auto found = entries_.find(key);
  if (found == entries_.end() || key == "source") throw std::runtime_error(file_ + ": has no " + key);
  return *found;
}

template <class T>
T PaperNumbers::get(const std::string& key, const char* kind) const {
  try {
    return entry(key).at("value").get<T>();
  } catch (const Json::exception&) {
    throw std::runtime_error(file_ + ": the value of " + key + " is not " + kind);
  }
}

double PaperNumbers::value(const std::string& key) const { return get<double>(key, "a number"); }
std::vector<double> PaperNumbers::values(const std::string& key) const {
  return get<std::vector<double>>(key, "a list of numbers");
}
std::string PaperNumbers::words(const std::string& key) const { return get<std::string>(key, "a text"); }

std::string PaperNumbers::operator()(const std::string& key) const {
  const Json& value = entry(key).at("value");
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string PaperNumbers::place(const std::string& key) const { return entry(key).at("place").get<std::string>(); }

PaperNumbers paper_numbers(const std::string& study) {
  return PaperNumbers(std::filesystem::path(FINEGAUGE_SOURCE_DIR) / "reference_data" / "paper" / (study + ".json"));
}

}  // namespace finegauge
