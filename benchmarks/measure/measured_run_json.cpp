#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "benchmarks/measure/measured_run.hpp"

// Runs and references as JSON: through a pipe, into a journal, into a cache.

namespace finegauge {
namespace {

/// Dense numbers as bytes: CBOR would spend nine on each double and a call on reading it.
Json::binary_t bytes_of(const double* values, Eigen::Index count) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(values);
  return Json::binary_t(std::vector<std::uint8_t>(bytes, bytes + count * static_cast<Eigen::Index>(sizeof(double))));
}

template <class Matrix>
void read_columns(const Json& json, Eigen::Index rows, Matrix& matrix) {
  const Json::binary_t& bytes = json.get_binary();
  if (bytes.size() % (static_cast<std::size_t>(rows) * sizeof(double)) != 0)
    throw std::runtime_error("a reference run: found " + std::to_string(bytes.size()) +
                             " bytes of numbers, allowed whole columns of " + std::to_string(rows));
  const Eigen::Index count = static_cast<Eigen::Index>(bytes.size() / sizeof(double));
  if constexpr (Matrix::ColsAtCompileTime == 1)
    matrix.resize(count);
  else
    matrix.resize(rows, count / rows);
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<std::uint8_t*>(matrix.data()));
}

}  // namespace

std::vector<std::uint8_t> to_bytes(const ReferenceRun& reference) {
  Json instants = Json::array();
  for (const auto& [time, strains] : reference.instants)
    instants.push_back({{"time", time},
                        {"places", bytes_of(strains.places.data(), strains.places.size())},
                        {"volumes", bytes_of(strains.volumes.data(), strains.volumes.size())},
                        {"gradients", bytes_of(strains.gradients.data(), strains.gradients.size())}});
  return Json::to_cbor({{"curves", to_json(reference.curves)},
                        {"instants", instants},
                        {"corotational", reference.kinematics == Kinematics::corotational}});
}

ReferenceRun reference_run(const std::vector<std::uint8_t>& bytes) {
  const Json json = Json::from_cbor(bytes);
  ReferenceRun reference;
  reference.curves = run_curves(json.at("curves"));
  reference.kinematics = json.at("corotational").get<bool>() ? Kinematics::corotational : Kinematics::linear;
  for (const Json& instant : json.at("instants")) {
    StrainInstant& made = reference.instants.emplace_back();
    instant.at("time").get_to(made.time);
    read_columns(instant.at("places"), 3, made.strains.places);
    read_columns(instant.at("volumes"), 1, made.strains.volumes);
    read_columns(instant.at("gradients"), 9, made.strains.gradients);
    const Eigen::Index places = made.strains.places.cols();
    if (made.strains.volumes.size() != places || made.strains.gradients.cols() != places)
      throw std::runtime_error("a reference run: found " + std::to_string(places) + " places, " +
                               std::to_string(made.strains.volumes.size()) + " volumes and " +
                               std::to_string(made.strains.gradients.cols()) + " strains, allowed as many of each");
  }
  return reference;
}

Json to_json(const MeasuredRun& run) {
  Json json = {{"complete", run.complete},
               {"why_incomplete", run.why_incomplete},
               {"curves", to_json(run.curves)},
               {"frame_ms", run.frame_ms},
               {"frames", run.frames},
               {"unconverged", run.unconverged},
               {"refined", run.refined},
               {"coarsened", run.coarsened},
               {"dofs_start", run.dofs_start},
               {"dofs_max", run.dofs_max},
               {"dofs_end", run.dofs_end},
               {"dofs_mean", run.dofs_mean},
               {"iterations", run.iterations},
               {"work", run.work},
               {"eta_max", run.eta_max ? Json(*run.eta_max) : Json()},
               {"peak_memory_mb", run.peak_memory_mb},
               {"reference_size", run.reference_size},
               {"left_out", run.left_out},
               {"errors", Json::object()}};
  // JSON has no NaN: nothing to compare is null.
  for (const auto& [name, error] : run.errors) json["errors"][name] = std::isfinite(error) ? Json(error) : Json();
  return json;
}

MeasuredRun measured_run(const Json& json) {
  MeasuredRun run;
  json.at("complete").get_to(run.complete);
  json.at("why_incomplete").get_to(run.why_incomplete);
  run.curves = run_curves(json.at("curves"));
  json.at("frame_ms").get_to(run.frame_ms);
  json.at("frames").get_to(run.frames);
  json.at("unconverged").get_to(run.unconverged);
  json.at("refined").get_to(run.refined);
  json.at("coarsened").get_to(run.coarsened);
  json.at("dofs_start").get_to(run.dofs_start);
  json.at("dofs_max").get_to(run.dofs_max);
  json.at("dofs_end").get_to(run.dofs_end);
  json.at("dofs_mean").get_to(run.dofs_mean);
  json.at("iterations").get_to(run.iterations);
  json.at("work").get_to(run.work);
  if (!json.at("eta_max").is_null()) run.eta_max = json.at("eta_max").get<double>();
  json.at("peak_memory_mb").get_to(run.peak_memory_mb);
  json.at("reference_size").get_to(run.reference_size);
  json.at("left_out").get_to(run.left_out);
  for (const auto& [name, error] : json.at("errors").items())
    run.errors[name] = error.is_null() ? std::nan("") : error.get<double>();
  return run;
}

}  // namespace finegauge
