/// \file
/// Whether the sizes of a cause were measured: a fit gives a number in any case.
#pragma once

#include <span>
#include <string>

#include "log_hypotheses.h"

namespace simgap {

/// Why the cause's own parameters are no measurement; empty when they are. \param fit  of theta, to all rows
std::string undetermined(const ActuatorRegression& model, std::span<const double> theta, const LogFit& fit,
                         std::size_t effect);

/// How strongly a cause acts on some rows, about its mean, squared and summed: by itself, and with all else refitted
/// without it, the smaller of the two. 0 of a constant. \param refitted  the latter's change, \param rows  both shape
/// (n)
double actionOf(const Fitted& fitted, std::size_t effect, const Eigen::ArrayXd& refitted,
                const Eigen::Array<bool, Eigen::Dynamic, 1>& rows);

/// Why a cause that counted when it was tried counts no more, fitted with all others to all rows: a relaxation within
/// two of them, say. Empty when it does.
std::string outOfSight(const ActuatorRegression& model, std::span<const double> theta, std::size_t effect,
                       const ActuatorRows& rows);

/// The first column whose size nothing in the log comes near: its shape is fitted to the tail of a law, and the law's
/// head, where its size would show, lies outside of the data. Empty: none.
std::string beyondTheData(const ActuatorRegression& model, const Fitted& fitted, std::size_t effect,
                          const ActuatorRows& rows);

/// A load that the cause adds to one that is known, and that may be nothing: k_a makes up for as much of it as it
/// likes, so that the log may tell only its small rest. Empty: it is none, or is measured. \param fit  of all rows
std::string loadThatMayBeNone(const ActuatorRegression& model, const LogFit& fit, std::size_t effect,
                              const ActuatorRows& rows);

/// Why a cause stands in for a load that was measured: with it the load counts for far less. Noise of the sensor is
/// reason enough for a quieter copy. Empty: it does not, or none was measured. \param rest  without the cause
std::string loadItReplaces(const Fitted& rest, const Fitted& full, const ActuatorRows& rows);

/// Whether the strength of a motor that a load told ends at its bound with a cause of torque: what was known of it made
/// room. \param rest  without the cause
bool losesStrength(const Fitted& rest, const Fitted& full, std::size_t effect);

/// Terms that nearly cancel each other have no physical size (a sine over a small part of its period).
bool cancels(const ActuatorRegression& model, const Fitted& fitted, std::size_t effect);

}  // namespace simgap
