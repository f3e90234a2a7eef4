#include "simgap/report/actuators/cable_drive_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "simgap/core/csv.h"
#include "simgap/core/rotation.h"

namespace simgap {
namespace {

Json huntingJson(const DriveHunting& hunting) {
  if (hunting.seconds == 0.0) return nullptr;
  return {{"looked_at_s", hunting.seconds},
          {"hunts", hunting.found()},
          {"amplitude_deg", hunting.amplitude / kDegree},
          {"frequency_Hz", hunting.frequency}};
}

Json comparedJson(const ComparedDrive& compared, bool torque) {
  const DriveTracking& t = compared.run.tracking;
  Json json{{"name", compared.name}, {"share", compared.share}};
  if (torque) {
    json.update({{"rms_Nm", t.rms}, {"largest_Nm", t.largest}});
  } else {
    json.update({{"rms_deg", t.rms / kDegree},
                 {"largest_deg", t.largest / kDegree},
                 {"trajectory_rms_deg", t.trajectory / kDegree},
                 {"motor_rms_deg", t.motor / kDegree},
                 {"cable_rms_deg", t.cable / kDegree},
                 {"rest", huntingJson(t.hunting)}});
  }
  json.update({{"current_rms_A", t.current_rms},
               {"current_largest_A", t.current_largest},
               {"at_limit_percent", 100.0 * t.at_limit},
               {"sticking_percent", 100.0 * t.sticking}});
  return json;
}

bool followsTorque(const Json& result) { return result.at("commanded") == "torque"; }
const char* unitOf(const Json& result) { return followsTorque(result) ? "Nm" : "deg"; }

std::string restCell(const Json& rest) {
  constexpr double kStill = 0.01;  // [deg]
  if (rest.is_null()) return "-";
  const std::string amplitude = numberText(rest.at("amplitude_deg"), "±{:.2g} deg");
  if (rest.at("hunts").get<bool>())
    return "hunts " + amplitude + ", " + numberText(rest.at("frequency_Hz"), "{:.2g} Hz");
  return numberOf(rest.at("amplitude_deg")) < kStill ? "still" : "moves " + amplitude;
}

}  // namespace

Json toJson(const CableDrive& drive, const CableDriveCommands& commands, const CableDriveStudy& study) {
  Json runs = Json::array();
  for (const ComparedDrive& compared : study.runs) runs.push_back(comparedJson(compared, commands.torque));
  return {{"format", "simgap/simulate-drive/1"},
          {"drive", drive.name},
          {"commanded", commands.torque ? "torque" : "position"},
          {"start_s", study.start},
          {"end_s", study.end},
          {"step_s", study.step},
          {"controller_rate_Hz", drive.rate},
          {"set_point_rate_Hz", drive.set_point_rate},
          {"direction", drive.control.by_reference ? "reference" : "measured"},
          {"half_step_percent", 100.0 * study.half_step},
          {"compensations", runs},
          {"notes", study.notes}};
}

std::string cableDriveAnswer(const Json& result) {
  const std::string key = fmt::format("rms_{}", unitOf(result));
  const Json& runs = result.at("compensations");
  const Json& none = runs.front();
  std::string answer =
      fmt::format("{:.4g} s of {}. Without compensation it misses its {} by {} {} (RMS)",
                  numberOf(result.at("end_s")) - numberOf(result.at("start_s")), result.at("drive").get<std::string>(),
                  followsTorque(result) ? "torque" : "reference", numberText(none.at(key), "{:.3g}"), unitOf(result));
  const auto best = std::ranges::min_element(runs, {}, [&](const Json& run) { return numberOf(run.at(key)); });
  answer += best == runs.begin() ? std::string(runs.size() > 1 ? "; no compensation does better." : ".")
                                 : fmt::format(", with {} by {} {}.", best->at("name").get<std::string>(),
                                               numberText(best->at(key), "{:.3g}"), unitOf(result));
  for (const Json& run : runs) {
    if (followsTorque(result) || run.at("rest").is_null() || !run.at("rest").at("hunts").get<bool>()) continue;
    answer += fmt::format(" With {} it does not come to rest: it {}.", run.at("name").get<std::string>(),
                          restCell(run.at("rest")));
  }
  return answer;
}

Table driveTrackingTable(const Json& result) {
  const std::string unit = unitOf(result);
  Table table{"How it follows",
              {"compensation", fmt::format("RMS [{}]", unit), "largest", "current RMS [A]", "largest", "at limit",
               "motor sticks", "at the end"},
              {}};
  if (followsTorque(result)) table.header.pop_back();
  for (const Json& run : result.at("compensations")) {
    std::vector<std::string> row = {run.at("name").get<std::string>(),
                                    numberText(run.at("rms_" + unit), "{:.3f}"),
                                    numberText(run.at("largest_" + unit), "{:.3f}"),
                                    numberText(run.at("current_rms_A"), "{:.2f}"),
                                    numberText(run.at("current_largest_A"), "{:.2f}"),
                                    numberText(run.at("at_limit_percent"), "{:.1f} %"),
                                    numberText(run.at("sticking_percent"), "{:.1f} %")};
    if (!followsTorque(result)) row.push_back(restCell(run.at("rest")));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table driveErrorTable(const Json& result) {
  Table table{"Where the error comes from (RMS [deg])",
              {"compensation", "joint - reference", "motor - reference", "joint - motor (cable)", "reference - told"},
              {}};
  for (const Json& run : result.at("compensations")) {
    std::vector<std::string> row = {run.at("name").get<std::string>()};
    for (const char* key : {"rms_deg", "motor_rms_deg", "cable_rms_deg", "trajectory_rms_deg"}) {
      row.push_back(numberText(run.at(key), "{:.3f}"));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string cableDriveText(const Json& result) {
  std::vector<Table> tables = {driveTrackingTable(result)};
  if (!followsTorque(result)) tables.push_back(driveErrorTable(result));
  return answerText(cableDriveAnswer(result), tables);
}

void writeCableDrive(const CableDriveStudy& study, bool torque, const RunDirectory& directory) {
  const std::string unit = torque ? "_Nm" : "_rad";
  std::vector<std::string> header = {"time_s", "told" + unit};
  if (!torque) header.push_back("reference_rad");
  for (const ComparedDrive& compared : study.runs) {
    header.push_back(compared.name + "_joint_rad");
    header.push_back(compared.name + "_motor_rad");
    header.push_back(compared.name + "_torque_Nm");
    header.push_back(compared.name + "_current_A");
  }
  CsvWriter csv(header);
  const DriveTrack& first = study.runs.front().run.track;
  for (std::size_t i = 0; i < first.time.size(); ++i) {
    csv.add(first.time[i]).add(first.told[i]);
    if (!torque) csv.add(first.reference[i]);
    for (const ComparedDrive& compared : study.runs) {
      const DriveTrack& t = compared.run.track;
      csv.add(t.joint[i]).add(t.motor[i]).add(t.torque[i]).add(t.current[i]);
    }
    csv.endRow();
  }
  directory.write("tracking.csv", csv.text());
}

}  // namespace simgap
