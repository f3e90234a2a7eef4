/// \file
/// The folder `candidates` of a diagnosis: the models that it left standing or refused, and what their posterior came
/// from, `simgap/candidates/1` (docs/formats.md).
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/core/yaml.h"
#include "simgap/diagnose/logs/refitted_model.h"
#include "simgap/diagnose/poses/pose_diagnosis.h"
#include "simgap/intervene/logs/log_intervention.h"
#include "simgap/intervene/motions/motion_intervention.h"

namespace simgap {

inline constexpr const char* kCandidateFolder = "candidates";
inline constexpr const char* kCandidateList = "candidates.yaml";
inline constexpr const char* kGivenModel = "given.yaml";
inline constexpr const char* kGivenPoses = "poses.csv";  ///< the first file
inline constexpr const char* kGivenLog = "log.csv";
inline constexpr const char* kGivenBench = "bench.yaml";
inline constexpr const char* kLogCandidates = "simgap/log-candidates/1";
inline constexpr const char* kMotionCandidates = "simgap/motion-candidates/1";

/// \throws ConfigError: a run without candidates of any kind.
void requireCandidates(const std::filesystem::path& run);

/// Whether a run has left candidates of a kind. \param format  kLogCandidates or kMotionCandidates
bool holdsCandidates(const std::filesystem::path& run, std::string_view format);

/// \param poses_csv  the files as the user gave them
void writeCandidates(const PoseDiagnosis& result, const ArmModel& given, std::span<const std::string> poses_csv,
                     const RunDirectory& directory);

/// The list without its models.
struct CandidateList {
  struct Entry {
    std::string file;
    CandidateModel candidate;  ///< its model is still to be read
  };
  std::vector<Entry> entries;
  std::vector<std::string> poses;  ///< files of this folder
  std::vector<std::string> used;   ///< poses without a fault
  double excess = 0.0;

  /// \throws ConfigError: fewer than two candidates, and all that YamlNode refuses.
  static CandidateList read(const YamlNode& root);
};

/// Of a log: the models, and the log itself as a reference for what is foreseen; nothing where it could not be fitted.
/// \param bench_yaml  as the user gave it, empty without one. \param ratio  of --ratio
void writeLogCandidates(const LogDiagnosis& result, const FittedModel& given, const ActuatorModel& subject,
                        const PreparedLog& log, const LogSource& source, const std::string& log_csv,
                        const std::string& bench_yaml, std::optional<double> ratio, const RunDirectory& directory);

/// The list without its models.
struct LogCandidateList {
  struct Entry {
    std::string file;
    LogCandidate candidate;
  };
  std::vector<Entry> entries;
  double correlation_s = 0.0;
  std::optional<double> ratio;
  bool has_bench = false;

  /// \throws ConfigError: fewer than two candidates, and all that YamlNode refuses.
  static LogCandidateList read(const YamlNode& root);
};

/// Of motions: the models, how well each knows its parameters, and the commands of a few motions to foresee others
/// with; nothing where there was no fit, or nothing to compare it with.
void writeMotionCandidates(const MotionDiagnosis& result, const ArmModel& given, const RunDirectory& directory);

/// The list without its models, covariances and commands.
struct MotionCandidateList {
  struct Entry {
    std::string file;
    MotionCandidate candidate;
  };
  struct Profile {
    std::string name, file;
    bool linear = false;
  };
  std::vector<Entry> entries;
  std::vector<Profile> profile;
  MotionReference reference;
  MotionNoise noise;

  /// \throws ConfigError: fewer than two candidates, and all that YamlNode refuses.
  static MotionCandidateList read(const YamlNode& root, const ArmModel& given);
};
/// Of a candidate's number.
std::string covarianceFileName(std::size_t number);
std::string covarianceCsv(const Eigen::MatrixXd& covariance);
/// \throws DataError: it is not square, or not symmetric
Eigen::MatrixXd readCovariance(const CsvTable& table);

}  // namespace simgap
