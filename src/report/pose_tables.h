/// \file
/// Pieces that the reports of calibrate and validate share.
#pragma once

#include <cmath>
#include <numeric>

#include "simgap/report/pose_report.h"

namespace simgap {

/// JSON has no NaN: an unknown number is null.
inline Json numberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// {joint: degrees}, or half of it for spherical joints: 001 eq. 4 as printed.
Json mjeJson(const PoseLayout& layout, const std::vector<double>& mje, bool paper_half_angle = false);

/// "p003: acquisition error of biceps, 12.3 deg" for every invalid pose.
std::vector<std::string> invalidPoses(const Assessment& assessment, const PoseSet& set, const PoseLayout& layout);

/// Errors of one joint over the poses [deg]; NaN where invalid.
std::vector<double> errorsOfJoint(const Assessment& assessment, std::size_t joint);

std::vector<std::string> poseNames(const PoseSet& set);

}  // namespace simgap
