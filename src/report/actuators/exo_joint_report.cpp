#include "simgap/report/actuators/exo_joint_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/core/rotation.h"

namespace simgap {
namespace {

Json rangeJson(const std::vector<double>& values, double unit) {
  const auto [lowest, highest] = std::ranges::minmax(values);
  return {{"lowest", lowest / unit}, {"highest", highest / unit}};
}

Json controllerJson(const ExoJointRun& run) {
  const TorqueTracking& t = run.tracking;
  return {{"name", run.name},
          {"tendons", run.play.tendons},
          {"motor", run.play.motor},
          {"rms_Nm", t.rms},
          {"largest_error_Nm", t.largest},
          {"motor_rms_Nm", t.motor_rms},
          {"motor_largest_Nm", t.motor_largest},
          {"at_limit_percent", run.play.motor ? Json(100.0 * t.at_limit) : Json(nullptr)}};
}

/// Every so many ticks are shown.
std::size_t tickStride(const ExoJoint& joint, double rate) {
  return static_cast<std::size_t>(std::max(1.0, std::round(joint.rate / rate)));
}

std::string exoMotionCsv(const ExoJointTrack& track, std::size_t stride) {
  const bool torque = !track.desired.empty();
  std::vector<std::string> header = {
      "time_s",           "angle_rad",          "velocity_rad_s",   "pressure_flexor_Pa", "pressure_extensor_Pa",
      "tension_flexor_N", "tension_extensor_N", "muscle_torque_Nm", "motor_torque_Nm"};
  if (torque) header.insert(header.end(), {"torque_Nm", "missing_torque_Nm"});
  CsvWriter csv(header);
  for (std::size_t i = 0; i < track.time.size(); i += stride) {
    csv.add(track.time[i]).add(track.angle[i]).add(track.velocity[i]);
    csv.add(track.flexor_pressure[i]).add(track.extensor_pressure[i]);
    csv.add(track.flexor_force[i]).add(track.extensor_force[i]);
    csv.add(track.muscles[i]).add(track.motor[i]);
    if (torque) csv.add(track.desired[i]).add(track.missing[i]);
    csv.endRow();
  }
  return csv.text();
}

std::string trackingCsv(const ExoJointStudy& study, std::size_t stride) {
  std::vector<std::string> header = {"time_s", "desired_Nm"};
  for (const ExoJointRun& run : study.runs) header.push_back(run.name + "_Nm");
  CsvWriter csv(header);
  const ExoJointTrack& first = study.main().track;
  for (std::size_t i = 0; i < first.time.size(); i += stride) {
    csv.add(first.time[i]).add(first.desired[i]);
    for (const ExoJointRun& run : study.runs) csv.add(run.track.muscles[i] + run.track.motor[i]);
    csv.endRow();
  }
  return csv.text();
}

const Json* controllerNamed(const Json& result, const std::string& name) {
  for (const Json& controller : result.at("controllers")) {
    if (controller.at("name") == name) return &controller;
  }
  return nullptr;
}

}  // namespace

Json toJson(const ExoJoint& joint, const ExoJointCommands& commands, const ExoJointStudy& study) {
  Json controllers = Json::array();
  if (commands.torque) {
    for (const ExoJointRun& run : study.runs) controllers.push_back(controllerJson(run));
  }
  return {{"format", "simgap/simulate-joint/1"},
          {"joint", joint.name},
          {"commanded", commands.switched ? "switch"
                        : commands.torque ? "torque"
                                          : "pressures"},
          {"obeyed_percent", study.obeyed ? Json(100.0 * *study.obeyed) : Json(nullptr)},
          {"start_s", study.start},
          {"end_s", study.end},
          {"step_s", study.main().play.step},
          {"controller_rate_Hz", joint.rate},
          {"real_time_factor", study.realTimeFactor()},
          {"half_step_deg", study.half_step / kDegree},
          {"angle_deg", rangeJson(study.main().track.angle, kDegree)},
          {"stiffness_Nm_rad", rangeJson(study.main().track.stiffness, 1.0)},
          {"motor_limit_Nm", joint.motorLimit()},
          {"controllers", controllers},
          {"notes", study.notes}};
}

std::string exoJointAnswer(const Json& result) {
  const double duration = numberOf(result.at("end_s")) - numberOf(result.at("start_s"));
  const std::string played =
      fmt::format("{:.4g} s of {}, {:.0f} times as fast as real time on one core", duration,
                  result.at("joint").get<std::string>(), numberOf(result.at("real_time_factor")));
  if (result.at("commanded") == "switch") {
    return fmt::format("{}. The joint goes from {} to {} deg, and is on the side it is told to in {} % of the time",
                       played, degreesCell(result.at("angle_deg").at("lowest")),
                       degreesCell(result.at("angle_deg").at("highest")),
                       numberText(result.at("obeyed_percent"), "{:.1f}"));
  }
  const Json* tendon = controllerNamed(result, "tendon_alone");
  const Json* rigid = controllerNamed(result, "rigid_alone");
  if (tendon == nullptr || rigid == nullptr) return played;
  std::string answer = fmt::format(
      "{}. The muscles alone miss the desired torque by {} Nm (RMS) where the controller knows their tendons, by {} Nm "
      "where it does not",
      played, numberText(tendon->at("rms_Nm"), "{:.2f}"), numberText(rigid->at("rms_Nm"), "{:.2f}"));
  if (const Json* motor = controllerNamed(result, "tendon_motor")) {
    answer += fmt::format("; with the motor {} Nm is left", numberText(motor->at("rms_Nm"), "{:.2f}"));
  }
  return answer;
}

Table exoControllerTable(const Json& result) {
  Table table{"What controllers miss: with the tendons (as the file says) and as if they were rigid",
              {"controller", "RMS [Nm]", "largest", "motor RMS", "largest", "at its limit"},
              {}};
  for (const Json& c : result.at("controllers")) {
    const bool motor = c.at("motor").get<bool>();
    const auto ofMotor = [&](const char* key, const char* format) {
      return motor ? numberText(c.at(key), format) : std::string("-");
    };
    table.rows.push_back(
        {fmt::format("{}, {}", c.at("tendons").get<bool>() ? "tendons" : "rigid", motor ? "motor" : "muscles alone"),
         numberText(c.at("rms_Nm"), "{:.2f}"), numberText(c.at("largest_error_Nm"), "{:.2f}"),
         ofMotor("motor_rms_Nm", "{:.2f}"), ofMotor("motor_largest_Nm", "{:.2f}"),
         ofMotor("at_limit_percent", "{:.1f} %")});
  }
  return table;
}

std::string exoJointText(const Json& result) {
  std::vector<Table> tables = {
      {"",
       {"joint", "lowest", "highest"},
       {{"angle [deg]", numberText(result.at("angle_deg").at("lowest"), "{:.2f}"),
         numberText(result.at("angle_deg").at("highest"), "{:.2f}")},
        {"stiffness of the muscles [Nm/rad]", numberText(result.at("stiffness_Nm_rad").at("lowest"), "{:.1f}"),
         numberText(result.at("stiffness_Nm_rad").at("highest"), "{:.1f}")}}}};
  if (!result.at("controllers").empty()) tables.push_back(exoControllerTable(result));
  return answerText(exoJointAnswer(result), tables);
}

void writeExoJoint(const ExoJoint& joint, const ExoJointStudy& study, double rate, const RunDirectory& directory) {
  const std::size_t stride = tickStride(joint, rate);
  directory.write("motion.csv", exoMotionCsv(study.main().track, stride));
  if (!study.main().track.desired.empty()) directory.write("tracking.csv", trackingCsv(study, stride));
}

}  // namespace simgap
