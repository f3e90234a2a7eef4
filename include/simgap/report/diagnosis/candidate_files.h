/// \file
/// The folder `candidates` of a diagnosis: the models that it left standing or refused, and what their posterior came
/// from, `simgap/candidates/1` (docs/formats.md).
#pragma once

#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/core/yaml.h"
#include "simgap/diagnose/poses/pose_diagnosis.h"

namespace simgap {

inline constexpr const char* kCandidateFolder = "candidates";
inline constexpr const char* kCandidateList = "candidates.yaml";
inline constexpr const char* kGivenModel = "given.yaml";
inline constexpr const char* kGivenPoses = "poses.csv";

/// \param poses_csv  as the user gave it
void writeCandidates(const PoseDiagnosis& result, const ArmModel& given, const std::string& poses_csv,
                     const RunDirectory& directory);

/// The list without its models.
struct CandidateList {
  struct Entry {
    std::string file;
    CandidateModel candidate;  ///< its model is still to be read
  };
  std::vector<Entry> entries;
  std::vector<std::string> used;  ///< poses without a fault
  double excess = 0.0;

  /// \throws ConfigError: fewer than two candidates, and all that YamlNode refuses.
  static CandidateList read(const YamlNode& root);
};

}  // namespace simgap
