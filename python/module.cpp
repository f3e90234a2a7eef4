// The compiled half of the Python module (python/simgap.py): arms, poses, where arms come to rest, and fits, as numpy
// arrays. Everything is the library's; here stand only the names and shapes.
#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/fit/actuators/fitted_drive.h"
#include "simgap/fit/actuators/friction_comparison.h"
#include "simgap/fit/actuators/pam_fit.h"
#include "simgap/fit/actuators/spring_fit.h"
#include "simgap/measure/logs/log_table.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/simulate/replay.h"

namespace py = pybind11;

namespace simgap {
namespace {

using Array = py::array_t<double>;
using InputArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Columns = std::map<std::string, py::object>;

/// What `compute` gives, while other threads of Python go on.
auto unlocked(const auto& compute) {
  const py::gil_scoped_release released;
  return compute();
}

Array missing(std::vector<py::ssize_t> shape) {
  Array array(std::move(shape));
  std::fill_n(array.mutable_data(), array.size(), std::numeric_limits<double>::quiet_NaN());
  return array;
}

// --------------------------------------------------------------------------------------------------- arms and poses

std::vector<std::string> namesOf(const auto& parts) {
  std::vector<std::string> names;
  for (const auto& part : parts) names.push_back(part.name);
  return names;
}

/// Positions of one joint: shape (n, 4), quaternions w, x, y, z, of a spherical one, (n) [rad] of a revolute one. NaN
/// where there is none.
Array jointArray(JointType type, std::size_t joint, std::span<const std::vector<JointPosition>* const> positions) {
  const auto width = static_cast<py::ssize_t>(kindOf(type).columns.size());
  const auto rows = std::ssize(positions);
  Array array = missing(width == 1 ? std::vector{rows} : std::vector{rows, width});
  double* out = array.mutable_data();
  for (const std::vector<JointPosition>* position : positions) {
    if (!position->empty()) std::ranges::copy(kindOf(type).cells((*position)[joint]), out);
    out += width;
  }
  return array;
}

py::dict jointArrays(const ArmModel& model, std::span<const std::vector<JointPosition>* const> positions) {
  py::dict joints;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    joints[py::str(model.joints[j].name)] = jointArray(model.joints[j].type, j, positions);
  }
  return joints;
}

py::dict readPoses(const ArmModel& model, const std::string& file) {
  const PoseSet set = readPosesFor(model, CsvTable::load(file));
  const auto muscles = std::ssize(model.muscles);
  Array shafts = missing({std::ssize(set.poses), muscles});
  std::vector<std::string> names;
  std::vector<const std::vector<JointPosition>*> positions;
  double* out = shafts.mutable_data();
  for (const Pose& pose : set.poses) {
    names.push_back(pose.name);
    positions.push_back(&pose.joints);
    out = std::ranges::copy(pose.shafts, out).out;
  }
  py::dict result;
  result["names"] = names;
  result["shafts"] = shafts;
  result["joints"] = jointArrays(model, positions);
  return result;
}

std::vector<Pose> posesOf(const ArmModel& model, const InputArray& shafts) {
  if (shafts.ndim() != 2 || shafts.shape(1) != std::ssize(model.muscles)) {
    throw py::value_error(fmt::format("found shafts of another shape, expected (poses, {})", model.muscles.size()));
  }
  std::vector<Pose> poses;
  for (py::ssize_t i = 0; i < shafts.shape(0); ++i) {
    Pose& pose = poses.emplace_back();
    pose.name = std::to_string(i);
    pose.shafts.assign(shafts.data(i, 0), shafts.data(i, 0) + shafts.shape(1));
    if (!std::ranges::all_of(pose.shafts, [](double angle) { return std::isfinite(angle); })) {
      throw py::value_error(fmt::format("found a shaft of pose {} that is no finite number", i));
    }
  }
  return poses;
}

/// Bodies of poses that came to rest; NaN for the others.
void addFrames(const ArmModel& model, std::span<const PoseOutcome> outcomes, py::dict& result) {
  const auto poses = std::ssize(outcomes), bodies = std::ssize(model.bodies);
  Array origins = missing({poses, bodies, 3}), rotations = missing({poses, bodies, 4});
  for (py::ssize_t p = 0; p < poses; ++p) {
    const std::vector<JointPosition>& joints = outcomes[static_cast<std::size_t>(p)].joints;
    if (joints.empty()) continue;
    const std::vector<BodyInWorld> frames = bodiesInWorld(model, joints);
    for (py::ssize_t b = 0; b < bodies; ++b) {
      const BodyInWorld& frame = frames[static_cast<std::size_t>(b)];
      const Eigen::Quaterniond q(frame.rotation);
      Eigen::Map<Eigen::Vector3d>(origins.mutable_data(p, b, 0)) = frame.origin;
      Eigen::Map<Eigen::Vector4d>(rotations.mutable_data(p, b, 0)) = Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
    }
  }
  result["origins"] = origins;
  result["rotations"] = rotations;
}

py::dict rest(const ArmModel& model, const InputArray& shafts, const std::string& evaluator) {
  if (evaluator != "bullet" && evaluator != "equilibrium") {
    throw py::value_error("found the evaluator " + evaluator + ", expected bullet or equilibrium");
  }
  const std::vector<Pose> poses = posesOf(model, shafts);
  const std::vector<PoseOutcome> outcomes = unlocked([&] {
    return makeEvaluator(evaluator, {})->evaluate({&model, 1}, poses, AfterInvalid::kGoOn);
  });
  std::vector<std::string> status;
  std::vector<const std::vector<JointPosition>*> positions;
  for (const PoseOutcome& outcome : outcomes) {
    status.emplace_back(toString(outcome.status));
    positions.push_back(&outcome.joints);
  }
  py::dict result;
  result["status"] = status;
  result["joints"] = jointArrays(model, positions);
  addFrames(model, outcomes, result);
  return result;
}

// -------------------------------------------------------------------------------------------------------------- fits

/// The columns as a log: written and read as a file's, so that names, units and refusals are those of a file.
CsvTable logOf(const Columns& columns) {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> texts;
  std::vector<InputArray> numbers;
  std::size_t rows = 0;
  for (const auto& [name, values] : columns) {
    const py::array array = py::array::ensure(values);
    if (!array || array.ndim() != 1) throw py::value_error(name + ": found no array of one dimension, expected one");
    const bool is_number = array.dtype().kind() == 'f' || array.dtype().kind() == 'i' || array.dtype().kind() == 'u';
    if (!header.empty() && static_cast<std::size_t>(array.size()) != rows) {
      throw py::value_error(
          fmt::format("{}: found {} rows, expected the {} of {}", name, array.size(), rows, header[0]));
    }
    rows = static_cast<std::size_t>(array.size());
    header.push_back(name);
    numbers.push_back(is_number ? InputArray(array) : InputArray());
    texts.push_back(is_number ? std::vector<std::string>()
                              : py::cast<std::vector<std::string>>(array.attr("astype")("str")));
  }
  CsvWriter csv(header);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t c = 0; c < header.size(); ++c) {
      if (!texts[c].empty()) {
        csv.add(texts[c][row]);
      } else if (const double value = numbers[c].data()[row]; std::isfinite(value)) {
        csv.add(value);
      } else {
        csv.add("");
      }
    }
    csv.endRow();
  }
  return readLogTable(CsvTable::parse(csv.text(), "columns")).table;
}

py::dict estimates(const Uncertainty& uncertainty, double mse) {
  std::vector<std::string> names, units;
  std::vector<double> values, deviations;
  for (const Estimate& estimate : uncertainty.estimates) {
    names.push_back(estimate.name);
    units.push_back(estimate.unit);
    values.push_back(estimate.value);
    deviations.push_back(estimate.sd);
  }
  py::dict result;
  result["names"] = names;
  result["units"] = units;
  result["values"] = py::array(py::cast(values));
  result["sd"] = py::array(py::cast(deviations));
  result["covariance"] = uncertainty.covariance;
  result["mse"] = mse;
  return result;
}

py::dict fitFrictionTo(const Columns& columns, const std::string& law, std::optional<double> ratio) {
  const std::vector<std::string> names{law};
  const std::vector<const FrictionLaw*> laws = lawsNamed(names);
  if (laws.size() != 1) throw py::value_error(law + ": found several laws, expected one");
  const CsvTable table = logOf(columns);
  FrictionFitOptions options;
  options.folds = 0;
  const FrictionFit fit = unlocked([&] {
    const FrictionData data = prepareFrictionData(readActuatorLog(table, {ratio.value_or(0.0)}), {}, {});
    return fitFriction(*laws[0], data, options);
  });
  return estimates(fit.uncertainty, fit.mse);
}

py::dict fitMotorTo(const Columns& columns) {
  const CsvTable table = logOf(columns);
  const DriveFit fit = unlocked([&] { return fitDrive(readMotorLog(table), {}); });
  py::dict result = estimates(fit.uncertainty, std::numeric_limits<double>::quiet_NaN());
  result.attr("pop")("mse");  // of several channels, each with its own
  py::dict rms;
  for (const DriveChannel& channel : fit.channels) rms[py::str(channel.name)] = channel.rms;
  result["rms"] = rms;
  return result;
}

py::dict fitSpringTo(const Columns& columns, bool cord) {
  const CsvTable table = logOf(columns);
  SpringFitOptions options;
  options.cord = cord;
  const SpringFit fit = unlocked([&] { return fitSpring(prepareLog(table, {}, ActuatorKind::kSpring), options); });
  return estimates(fit.uncertainty, fit.mse);
}

py::dict fitPamTo(const Columns& columns, bool spring) {
  const CsvTable table = logOf(columns);
  PamFitOptions options;
  options.spring = spring;
  const PamFit fit = unlocked([&] { return fitPam(readPamLog(table), options); });
  return estimates(fit.uncertainty, fit.mse);
}

}  // namespace
}  // namespace simgap

PYBIND11_MODULE(_simgap, module) {
  using namespace simgap;
  module.doc() = "Arms, poses and fits of simgap as numpy arrays; use it through the module simgap.";

  static py::exception<Error> error(module, "LibraryError", PyExc_RuntimeError);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& e) {
      const py::object raised = static_cast<py::object&>(error)(e.what());  // its own call sets the error
      raised.attr("code") = static_cast<int>(e.code());
      PyErr_SetObject(error.ptr(), raised.ptr());
    }
  });

  py::class_<ArmModel>(module, "Arm", "An arm as its file describes it.")
      .def(py::init([](const std::string& file) { return readArm(YamlNode::load(file)); }), py::arg("file"))
      .def_property_readonly("name", [](const ArmModel& model) { return model.name; })
      .def_property_readonly("bodies", [](const ArmModel& model) { return namesOf(model.bodies); })
      .def_property_readonly("joints", [](const ArmModel& model) { return namesOf(model.joints); })
      .def_property_readonly("muscles", [](const ArmModel& model) { return namesOf(model.muscles); })
      .def("read_poses", &readPoses, py::arg("file"),
           "A pose set (CSV): names; shafts [rad], shape (poses, muscles); joints: name -> quaternions w, x, y, z, "
           "shape "
           "(poses, 4), or angles [rad], shape (poses).")
      .def(
          "rest", &rest, py::arg("shafts"), py::arg("evaluator") = "equilibrium",
          "Where the arm comes to rest for shafts [rad], shape (poses, muscles), by the minimum of its energy, or by "
          "simulation (evaluator 'bullet'). status: 'steady', or why not; joints as read_poses; origins [m], shape "
          "(poses, bodies, 3), and rotations w, x, y, z, shape (poses, bodies, 4), in the world. NaN where it does not "
          "come to rest.");

  module.def(
      "fit_friction", &fitFrictionTo, py::arg("columns"), py::arg("law") = "classic", py::arg("ratio") = py::none(),
      "A friction law fitted to a log, name -> array, as docs/formats.md names the columns: names, units, values, "
      "sd, covariance, mse.");
  module.def("fit_motor", &fitMotorTo, py::arg("columns"),
             "A DC motor fitted to a log: as fit_friction, with the rms of each channel instead of mse.");
  module.def("fit_spring", &fitSpringTo, py::arg("columns"), py::arg("cord") = false,
             "A spring, or a cord that only pulls, fitted to a log: as fit_friction.");
  module.def("fit_pam", &fitPamTo, py::arg("columns"), py::arg("spring") = true,
             "A pneumatic muscle, with its tendon's spring or without, fitted to a log: as fit_friction.");
}
