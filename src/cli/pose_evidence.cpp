#include "pose_evidence.h"

#include <fmt/format.h>

#include <algorithm>

#include "cli/inputs.h"
#include "simgap/core/error.h"
#include "simgap/report/diagnosis/candidate_files.h"

namespace simgap {

PoseEvidence readPoseEvidence(const std::filesystem::path& run, Session& session) {
  const std::filesystem::path folder = run / kCandidateFolder;
  const std::string list_file = (folder / kCandidateList).string();
  const CandidateList list =
      CandidateList::read(YamlNode::parse(session.read("candidates", list_file).content, list_file));
  PoseEvidence evidence;
  evidence.given = readArmFile(session, "given model", (folder / kGivenModel).string());
  evidence.excess = list.excess;
  const std::filesystem::path config = run / "config.resolved.yaml";
  const CalibrationConfig settings = readConfig(session, config.string(), &evidence.given);
  evidence.parameters = settings.parameters;
  evidence.noise = settings.noise;
  std::vector<std::string> files;
  for (const std::string& file : list.poses) files.push_back((folder / file).string());
  const PoseSet poses = readPoses(session, "poses before", files, evidence.given, {});
  for (const std::string& name : list.used) {
    const auto pose = std::ranges::find(poses.poses, name, &Pose::name);
    if (pose == poses.poses.end()) {
      throw DataError(fmt::format("{}: found no pose {}, which {} says was used", poses.file, name, list_file));
    }
    evidence.poses.push_back(*pose);
  }
  for (const CandidateList::Entry& entry : list.entries) {
    evidence.candidates.push_back(entry.candidate);
    evidence.candidates.back().model = readArmFile(session, "candidate", (folder / entry.file).string());
  }
  evidence.threads = session.options().threads;
  return evidence;
}

}  // namespace simgap
