#include "benchmarks/commands/merge.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <optional>

#include "benchmarks/program/command.hpp"

namespace finegauge {
namespace {

std::string shard_text(const Shard& shard) { return std::to_string(shard.number) + "/" + std::to_string(shard.of); }

[[noreturn]] void refuse(const MergePart& part, const std::string& why) {
  throw UsageError("merge: " + part.directory.string() + ": " + why);
}

/// A document of ours in this file, or none.
std::optional<Json> document_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  Json json = Json::parse(in, nullptr, false);
  if (!json.is_object() || json.value("schema", Json()) != "finegauge/1") return std::nullopt;
  return json;
}

std::string brief(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

void require_same(const MergePart& first, const MergePart& other, const std::string& what, const Json& a,
                  const Json& b) {
  if (a == b) return;
  refuse(other, "found " + what + " " + brief(b) + ", allowed that of the other parts, " + brief(a) + " in " +
                    first.directory.string());
}

void require_one_sweep(const MergePart& first, const MergePart& other) {
  for (const char* key : {"kind", "name", "quick", "inputs"})
    require_same(first, other, key, first.document.at(key), other.document.at(key));
  for (const char* key : {"version", "commit", "compiler", "flags"})
    require_same(first, other, key, first.document.at("environment").at(key), other.document.at("environment").at(key));
  require_same(first, other, "number of jobs", first.document.at("summary").at("jobs"),
               other.document.at("summary").at("jobs"));
  require_same(first, other, "number of parts", first.shard.of, other.shard.of);
}

/// Rows of jobs that are done on this shard, of so many in all.
std::size_t expected_rows(const Shard& shard, std::size_t jobs) {
  std::size_t rows = 0;
  for (std::size_t job = 0; job < jobs; ++job) rows += shard.has(job);
  return rows;
}

/// By shard number, each once.
std::map<int, const MergePart*> parts_in_order(std::span<const MergePart> parts, const MergeableKind& kind) {
  std::map<int, const MergePart*> ordered;
  for (const MergePart& part : parts) {
    require_one_sweep(parts.front(), part);
    const auto [place, is_new] = ordered.emplace(part.shard.number, &part);
    if (is_new) continue;
    const Json &a = place->second->document.at("rows"), &b = part.document.at("rows");
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
      if (a[i] != b[i])
        refuse(part, "is part " + shard_text(part.shard) + " like " + place->second->directory.string() +
                         ", with another row " + kind.row_name(b[i]));
    if (a.size() != b.size())
      refuse(part, "is part " + shard_text(part.shard) + " like " + place->second->directory.string() +
                       ", with another number of rows");
  }
  return ordered;
}

/// Of parts that are there twice, one counts.
Environment joined_environment(const std::map<int, const MergePart*>& parts) {
  const Json& first = parts.begin()->second->document.at("environment");
  Environment whole;
  whole.version = first.at("version").get<std::string>();
  whole.commit = first.at("commit").get<std::string>();
  whole.compiler = first.at("compiler").get<std::string>();
  whole.flags = first.at("flags").get<std::string>();
  whole.started = first.at("started").get<std::string>();
  whole.cores = whole.threads = 0;
  std::vector<std::string> processors;
  for (const auto& [number, part] : parts) {
    const Json& own = part->document.at("environment");
    if (const auto cpu = own.at("cpu").get<std::string>(); std::ranges::find(processors, cpu) == processors.end())
      processors.push_back(cpu);
    whole.cores = std::max(whole.cores, own.at("cores").get<int>());
    whole.threads = std::max(whole.threads, own.at("threads").get<int>());
    whole.started = std::min(whole.started, own.at("started").get<std::string>());  // ISO 8601: by letters is by time
    whole.seconds += own.at("seconds").get<double>();
  }
  for (const std::string& cpu : processors) whole.cpu += (whole.cpu.empty() ? "" : "; ") + cpu;
  return whole;
}

}  // namespace

std::span<const MergeableKind> mergeable_kinds() {
  static const std::array kinds = {mergeable_atlas(), mergeable_trade()};
  return kinds;
}

MergePart read_part(const std::filesystem::path& directory) {
  MergePart part{directory, {}, {}};
  std::error_code missing;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(directory, missing))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  if (missing) refuse(part, "found no directory that can be read, allowed one with the result of a run with --shard");
  std::sort(files.begin(), files.end());
  int documents = 0;
  for (const std::filesystem::path& file : files)
    if (std::optional<Json> document = document_in(file)) {
      part.document = std::move(*document);
      ++documents;
    }
  if (documents != 1)
    refuse(part, "found " + std::to_string(documents) + " results, allowed one, of a run with --shard");
  try {
    const Json &rows = part.document.at("rows"), &summary = part.document.at("summary");
    if (!rows.is_array()) refuse(part, "found rows that are no list");
    if (!summary.contains("shard") || !summary.contains("jobs"))
      refuse(part, "found a whole result, allowed a part, of a run with --shard");
    part.shard = parse_shard(summary.at("shard").get<std::string>());
    const auto jobs = summary.at("jobs").get<std::size_t>();
    const std::size_t expected = expected_rows(part.shard, jobs);
    if (rows.size() != expected)
      refuse(part, "found " + std::to_string(rows.size()) + " rows, allowed the " + std::to_string(expected) +
                       " of part " + shard_text(part.shard) + "; a run that was stopped goes on with --resume");
  } catch (const Json::exception& defect) {
    refuse(part, std::string("found a result that cannot be read: ") + defect.what());
  }
  return part;
}

ResultDocument join_parts(std::span<const MergePart> parts, const MergeableKind& kind) {
  ResultDocument whole;
  const std::map<int, const MergePart*> ordered = parts_in_order(parts, kind);
  std::string lacking;
  const int of = parts.front().shard.of;
  for (int number = 1; number <= of; ++number)
    if (!ordered.contains(number))
      lacking += (lacking.empty() ? "" : ", ") + std::to_string(number) + "/" + std::to_string(of);
  if (!lacking.empty()) throw UsageError("merge: found no part " + lacking + ", allowed all " + std::to_string(of));

  const Json& first = parts.front().document;
  whole.kind = first.at("kind").get<std::string>();
  whole.name = first.at("name").get<std::string>();
  whole.quick = first.at("quick").get<bool>();
  whole.inputs = {first.at("inputs").at("scene").get<std::string>(), first.at("inputs").at("sha256").get<std::string>(),
                  first.at("inputs").at("overrides")};
  whole.environment = joined_environment(ordered);
  const auto jobs = first.at("summary").at("jobs").get<std::size_t>();
  const auto parts_of = static_cast<std::size_t>(of);
  std::map<std::string, std::size_t> names;
  for (std::size_t job = 0; job < jobs; ++job) {
    const MergePart& part = *ordered.at(static_cast<int>(job % parts_of) + 1);
    const Json& row = part.document.at("rows").at(job / parts_of);
    if (const auto [place, is_new] = names.emplace(kind.row_name(row), job); !is_new)
      refuse(part, "has the row " + place->first + ", which " +
                       ordered.at(static_cast<int>(place->second % parts_of) + 1)->directory.string() + " has too");
    whole.rows.push_back(row);
  }
  whole.summary["jobs"] = jobs;
  Json told = Json::array();
  for (const auto& [number, part] : ordered)
    told.push_back({{"shard", shard_text(part->shard)}, {"environment", part->document.at("environment")}});
  whole.summary["parts"] = told;
  return whole;
}

}  // namespace finegauge
