/// \file
/// What a report shows of a diagnosis on motions.
#pragma once

#include "motion_fit.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

/// "elbow, 3.1 deg in the second from 4.2 s on": the joint or shaft and the second that a motion is missed most at, in
/// its noise.
std::string worstMoment(const RecordedMotion& motion, const PlayedMotion& played, const PoseLayout& layout,
                        const MotionNoise& noise);

/// Root mean square errors of every joint over time, a row per quarter of a second.
std::vector<EvidenceBin> errorsOverTime(const MotionSet& set, const std::vector<PlayedMotion>& before,
                                        const std::vector<PlayedMotion>& after, const PoseLayout& layout);

/// The causes' parameters with 95 % intervals, from the extensions. When a command changed is known to a row of the set
/// only, and so is how late it acts. \param step  of the rollouts [s]: no other time is known better
void fillParameters(Diagnosis& diagnosis, const MotionSet& set, double step);

/// Why a delay of commands may be none; empty where it is one. \param delay  [s]  \param row  usualRow
std::string doubtOfDelay(const Estimate& delay, double row);

/// By how much the ordinary parameters moved when the causes came in.
std::vector<Absorption> shiftsBetween(const MotionCauseFit& plain, const MotionCauseFit& with);

}  // namespace simgap
