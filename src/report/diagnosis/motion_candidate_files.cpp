#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "candidate_entries.h"
#include "simgap/core/error.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/diagnosis/candidate_files.h"

namespace simgap {
namespace {

constexpr double kSymmetric = 1e-6;  // of the two variances' geometric mean

}  // namespace

std::string covarianceFileName(std::size_t number) { return fmt::format("covariance_{:02}.csv", number); }

std::string covarianceCsv(const Eigen::MatrixXd& covariance) {
  std::vector<std::string> header;
  for (Eigen::Index i = 0; i < covariance.cols(); ++i) header.push_back(fmt::format("z{}", i));
  CsvWriter csv(header);
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    for (const double value : covariance.row(i)) csv.add(value);
    csv.endRow();
  }
  return csv.text();
}

Eigen::MatrixXd readCovariance(const CsvTable& table) {
  const auto n = static_cast<Eigen::Index>(table.rows());
  if (table.columns().size() != table.rows()) {
    throw DataError(fmt::format("{}: found {} rows of {} columns, expected a covariance: as many of both", table.name(),
                                table.rows(), table.columns().size()));
  }
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::vector<double> column = table.quantity(fmt::format("z{}", i), "");
    covariance.col(i) = Eigen::VectorXd::Map(column.data(), n);
  }
  const Eigen::ArrayXd variances = covariance.diagonal();
  const Eigen::ArrayXXd scale = (variances.matrix() * variances.matrix().transpose()).array().cwiseMax(0.0).sqrt();
  if (!(variances >= 0.0).all() ||
      !((covariance - covariance.transpose()).array().abs() <= kSymmetric * (scale + 1e-12)).all()) {
    throw DataError(
        fmt::format("{}: found numbers that are no covariance: not symmetric, or a variance below 0", table.name()));
  }
  return covariance;
}

void writeMotionCandidates(const MotionDiagnosis& result, const ArmModel& given, const RunDirectory& directory) {
  if (result.candidates.size() < 2) return;
  const auto write = [&](const std::string& name, const std::string& content) {
    directory.write(fmt::format("{}/{}", kCandidateFolder, name), content);
  };
  const MotionReference& reference = result.reference;
  std::string list =
      fmt::format("format: {}\nvariance: {}\nlog_mean: {}\nlog_sd: {}\nmotions: {}\nway: {}\n", kMotionCandidates,
                  reference.variance, reference.mean, reference.sd, reference.motions, reference.way);
  list += fmt::format("noise: {{joints: [{}], shafts_rad: {}, currents_A: {}}}\nprofile:\n",
                      fmt::join(result.noise.joints, ", "), result.noise.shafts, result.noise.currents);
  for (std::size_t m = 0; m < result.profile.size(); ++m) {
    const RecordedMotion& motion = result.profile[m];
    const std::string file = fmt::format("commands_{}.csv", m + 1);
    write(file, commandsCsv(motion.commands, result.layout));
    list +=
        fmt::format("  - {{name: {}, file: {}, linear: {}}}\n", yamlText(motion.name), file, motion.commands.linear);
  }
  list += "candidates:\n";
  for (std::size_t c = 0; c < result.candidates.size(); ++c) {
    const MotionCandidate& candidate = result.candidates[c];
    const std::string file = candidateFileName(c, candidate.causes);
    write(file, writeArm(candidate.model));
    write(covarianceFileName(c), covarianceCsv(candidate.covariance));
    list += fmt::format("  - {{file: {}, causes: {}, role: {}, log_odds: {}, capture_delay_s: {}}}\n", file,
                        yamlText(candidate.causes), candidate.role, candidate.log_odds, candidate.capture_delay);
  }
  write(kGivenModel, writeArm(given));
  write(kCandidateList, list);
}

MotionCandidateList MotionCandidateList::read(const YamlNode& root, const ArmModel& given) {
  static_cast<void>(root.at("format").oneOf({kMotionCandidates}));
  MotionCandidateList list;
  list.reference.variance = root.at("variance").number(Range{1.0, 1e12, false, "a number in [1, 1e12]"});
  list.reference.mean = root.at("log_mean").number();
  list.reference.sd = root.at("log_sd").number(kNonNegative);
  list.reference.motions = static_cast<int>(root.at("motions").integer(1, 1000000));
  list.reference.way = root.at("way").number(Range{1.0, 1e12, false, "a number in [1, 1e12]"});
  const YamlNode noise = root.at("noise"), joints = noise.at("joints");
  for (const YamlNode& joint : joints.items()) list.noise.joints.push_back(joint.number(kPositive));
  if (list.noise.joints.size() != given.joints.size()) {
    joints.fail(fmt::format("found {} joints, expected {}", list.noise.joints.size(), given.joints.size()));
  }
  list.noise.shafts = noise.at("shafts_rad").number(kPositive);
  list.noise.currents = noise.at("currents_A").number(kPositive);
  for (const YamlNode& motion : root.at("profile").items()) {
    list.profile.push_back({motion.at("name").text(), fileNameOf(motion.at("file")), motion.at("linear").boolean()});
  }
  list.entries =
      readCandidateEntries<Entry>(root.at("candidates"), [](const YamlNode& node, MotionCandidate& candidate) {
        candidate.log_odds = node.at("log_odds").number();
        candidate.capture_delay = node.at("capture_delay_s").number(Range{-1.0, 1.0, false, "a time in [-1, 1] s"});
      });
  root.expectAllRead();
  return list;
}

}  // namespace simgap
