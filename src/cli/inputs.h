/// \file
/// The files that several commands read, as the library takes them. A session notes each for run.json.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "simgap/capture/camera_files.h"
#include "simgap/cli/session.h"
#include "simgap/fit/actuators/actuator_model.h"
#include "simgap/fit/motions/motion_calibration.h"
#include "simgap/fit/poses/calibration.h"
#include "simgap/measure/logs/bench.h"
#include "simgap/measure/logs/log_table.h"
#include "simgap/model/actuator/fitted_model.h"
#include "simgap/model/arm/arm.h"
#include "simgap/simulate/motion_player.h"

namespace simgap {

/// What the file of a model says. \throws ConfigError: no YAML, or a robot of another format, which has to be converted
YamlNode readModelFile(Session& session, const std::string& role, const std::string& file);
ArmModel readArmFile(Session& session, const std::string& role, const std::string& file);
/// Calibration settings: those the user named, or the paper's that are built in. \throws ConfigError: also for
/// parameters that `model` does not have.
CalibrationConfig readConfig(Session& session, const std::string& file, const ArmModel* model = nullptr);
/// The same for motions.
MotionCalibrationConfig readMotionConfig(Session& session, const std::string& file, const ArmModel& model);
/// Recorded poses for that model; warns of rows that were left out. \throws ConfigError, DataError as readPosesFor.
PoseSet readPoses(Session& session, const std::string& role, const std::string& file, const ArmModel& model,
                  const CsvOptions& csv);
/// Those of several files, one behind the other. \throws DataError: a name that two files give a pose.
PoseSet readPoses(Session& session, const std::string& role, const std::vector<std::string>& files,
                  const ArmModel& model, const CsvOptions& csv);

/// Recorded motions for that model, with the tables that the set names. \throws ConfigError, DataError as
/// readMotionsFor. \param restart  [s], 0: never
MotionSet readMotions(Session& session, const std::string& role, const std::string& file, const ArmModel& model,
                      bool skip_bad_rows, double restart);

/// A log without the rows that nothing can be taken from; rows that the user lets pass are counted in a warning.
/// \param sessions  only these. \throws DataError as readLogTable and, for a recording, readBag; ConfigError: --topic
/// without a recording, or the other way round.
LogTable readLog(Session& session, const std::string& role, const std::string& file, const LogFileOptions& options,
                 const std::vector<std::string>& sessions = {});
/// Two cameras, and the same as OpenCV's YAML: the file itself where it is that.
struct CamerasInput {
  StereoCameras cameras;
  std::string yaml;
};
/// \param files  as readCameras; without any the one that the rig names. \throws ConfigError as readCameras
CamerasInput readCameraFiles(Session& session, const std::vector<std::filesystem::path>& files,
                             const std::filesystem::path& of_rig);
/// --cameras, with which it is called.
void addCamerasOption(CLI::App& app, std::vector<std::filesystem::path>& files);

/// The rig of a file, or a torque sensor without one; `ratio` replaces its own.
Bench readRig(Session& session, const std::string& file, const std::optional<double>& ratio);
/// The fitted model of a file. \param kinds  as readFittedModel
FittedModel readModel(Session& session, const std::string& role, const std::string& file,
                      const std::vector<std::string>& kinds = {});

/// A file, not the name of a law.
bool namesFile(const std::string& model);
/// \param model  a file, or a name: of a friction law, motor, gearbox, pam or spring. \param fitted  set to what a file
/// holds.
ActuatorModel readSubject(Session& session, const std::string& model, FittedModel& fitted);

}  // namespace simgap
