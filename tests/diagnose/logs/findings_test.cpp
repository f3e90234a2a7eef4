// What is taken for a cause and is none: a part of a larger one without a name, a drift for a change.
#include "diagnose/logs/findings.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnose/logs/prepared_logs.h"

namespace simgap::test {
namespace {

/// The reason for which the last of some causes is no finding; empty where it is one.
/// \param causes  all that are taken to be there, one after another \param rivals  that cannot be told from the first
std::string doubtOfLast(const PreparedLog& log, const std::vector<std::string>& causes,
                        const std::vector<std::string>& rivals) {
  const LogDiagnosisOptions options;
  const LogSplit split = splitLog(log, options);
  const LogSearch search(friction::find("classic"), log.data, split.training, options);
  Selection selection;
  selection.baseline = search.fit({}, nullptr);
  search.validate(selection.baseline);
  selection.steps = {selection.baseline};
  std::vector<Hypothesis> named;
  for (const std::string& cause : causes) {
    named.push_back({&actuator_effects::find(cause), {}, {}});
    selection.steps.push_back(search.tryAll(selection.steps.back(), {named.back()})[0].fitted);
    selection.p_adjusted.push_back(1e-6);
  }
  selection.chosen = selection.steps.back();
  selection.ambiguous_with.resize(causes.size());
  selection.ambiguous_with[0] = rivals;
  selection.instead.resize(causes.size());
  HeldOutParts parts(search, split.heldout, 0);
  const Findings found = keepFindings(search, log, parts, 0, named, options, selection);
  const auto last = std::ranges::find(found.candidates, causes.back(), &Candidate::effect);
  return last == found.candidates.end() ? "" : last->reason;
}

/// A bias, a small cause, beside much bending.
std::string doubtOfBias(const std::vector<std::string>& rivals) {
  reality::DriveSecret secret;
  secret.current_bias = 0.2;
  secret.capstan = 0.3;
  return doubtOfLast(preparedLog(smallRig(20000), secret), {"bend-friction", "current-bias"}, rivals);
}

TEST(SlowFindings, ASmallCauseBesideALargeOneWithANameIsNamed) { EXPECT_EQ(doubtOfBias({}), ""); }

TEST(SlowFindings, ASmallCauseBesideALargeGroupWithoutANameIsACandidate) {
  const std::string doubt = doubtOfBias({"load-nonlinearity", "regime-change", "position-ripple"});
  EXPECT_NE(doubt.find("left without a name"), std::string::npos) << doubt;
}

TEST(SlowFindings, AnAmplifierThatDriftsIsNoChangeOfRegime) {
  PreparedLog log = preparedLog(smallRig(20000));
  ActuatorRows& rows = log.data.rows;
  rows.effort += 0.3 * rows.elapsed / rows.elapsed[rows.rows() - 1];  // [A]
  EXPECT_EQ(doubtOfLast(log, {"regime-change"}, {}),
            "friction that wanders over the log explains as much as a change at one moment");
}

TEST(SlowFindings, ACableReTensionedAtOneMomentIsOne) {
  const reality::DriveRig rig = smallRig(20000);
  reality::DriveSecret secret;
  secret.change_share = 0.5;
  secret.change_time = 0.6 * static_cast<double>(rig.rows) / rig.rate;
  EXPECT_EQ(doubtOfLast(preparedLog(rig, secret), {"regime-change"}, {}), "");
}

}  // namespace
}  // namespace simgap::test
