/// \file
/// Single samples that no drive can have reached: a bit error of an encoder, a lost word on a bus. One of them in a
/// position is two large velocities and three larger accelerations, so they are looked for before anything is
/// differentiated.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace simgap {

/// What a channel of a log holds of them.
struct ChannelSpikes {
  std::string channel;
  std::vector<std::size_t> rows;  ///< of the log, from 0, rising; never empty
};

/// Rows whose value stands alone: its distance from the line between its neighbours is many times what that distance
/// is elsewhere, and its neighbours' own distances are the -1/2 of it that a single wrong sample causes.
/// \param time  [s] rising, shape (n).  \param values  shape (n).
std::vector<std::size_t> findSpikes(std::span<const double> time, std::span<const double> values);

/// The same, looked for session by session; each is replaced by the line between its neighbours.
/// \param session  shape (n).
std::vector<std::size_t> repairSpikes(std::span<const double> time, const std::vector<int>& session,
                                      std::span<double> values);

}  // namespace simgap
