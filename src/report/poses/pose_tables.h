/// \file
/// Pieces that the reports of calibrate and validate share.
#pragma once

#include <cmath>
#include <numeric>

#include "simgap/report/poses/pose_report.h"

namespace simgap {

/// Units of the joints' errors: "deg" always, "mm" where a joint slides. Results hold numbers of each under a key that
/// ends so: `mje_deg`, `mje_mm`.
std::vector<std::string> errorUnits(const PoseLayout& layout);
/// {joint: error} of the joints with that unit.
Json mjeJson(const PoseLayout& layout, const std::vector<double>& mje, const std::string& unit);
/// The numbers of all joints, as deep as they stand: `name`_deg, and `name`_mm with joints called "rail [mm]".
Json ofAllJoints(const Json& result, const std::string& name);
/// "elbow", "rail [mm]": of a joint in a table of degrees.
std::string jointLabel(const JointChannel& joint);
/// "3.20° (elbow)", "0.41 mm (rail)" \param label  of the joint
std::string errorText(const Json& error, const std::string& label);

/// "p003: acquisition error of biceps, 12.3 deg" for every invalid pose.
std::vector<std::string> invalidPoses(const Assessment& assessment, const PoseSet& set, const PoseLayout& layout);

/// Muscles whose cords do not pull in this pose.
std::vector<std::string> slackMuscles(const PoseOutcome& outcome, const PoseLayout& layout);
/// The same in one cell.
std::string slackText(const PoseOutcome& outcome, const PoseLayout& layout);

/// {joint: {mean, ci90}} of the joints with that unit.
Json predictionJson(const PoseLayout& layout, const PredictedError& predicted, const std::string& unit);

/// Errors as 001 eq. 4 prints them: half of the true angle for spherical joints.
std::vector<double> paperAngles(const PoseLayout& layout, std::vector<double> angles);

/// Mean joint errors [deg] before and after, from the result.json of calibrate; a second row per set as 001 prints
/// them.
Table calibrationErrors(const Json& result);
/// The same of the one model that validate judged.
Table validationErrors(const Json& result);
/// The limits set on a validation, and whether they hold.
Table criteriaTable(const Json& result);
/// Errors on unseen poses that design expects, with every further pose recorded.
Table expectedErrors(const Json& result);
/// Errors that the posterior of a calibration predicts, beside those found.
Table predictionTable(const Json& result);
/// What the evaluator that searched finds, and how far the one that judged disagrees.
Table verificationTable(const Json& result);
/// That the search ended away from the most probable parameters, and what to do; empty where it did not.
std::string notConverged(const Json& result);
/// What contradicts the posterior of a calibration: errors beyond its interval, poses far from the fit.
std::vector<std::string> surprises(const Json& result);

}  // namespace simgap
