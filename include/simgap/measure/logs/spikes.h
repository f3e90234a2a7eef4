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

/// "CHANNEL stands alone in N rows": how a sentence about them begins.
std::string standsAlone(const ChannelSpikes& spikes);

/// How many may stand near to each other: no mass jumps there and back, but an effort may change for two rows.
inline constexpr std::size_t kMotionSpikes = 3, kEffortSpikes = 1;

/// A sample that cannot be right, and what was likely there.
struct Spike {
  std::size_t row;
  double likely;
};

/// Rows that stand off a smooth curve (a cubic) through the rows on both sides of them: by many times what rows are
/// usually off the line between their neighbours, here and in the whole channel, while all rows around lie on it.
/// \param time  [s] rising, shape (n).  \param values  shape (n).
/// \param most  wrong rows that may stand near to each other
std::vector<Spike> findSpikes(std::span<const double> time, std::span<const double> values, std::size_t most);

/// A channel that is looked through for them.
struct SearchedChannel {
  std::string name;
  std::vector<double>* values;  ///< shape (n), or empty: there is none
  std::size_t most;             ///< wrong rows that may stand near to each other
};

/// The same, looked for session by session, and replaced by what was likely there.
/// \param session  shape (n).  \returns the channels that held any
std::vector<ChannelSpikes> repairSpikes(std::span<const double> time, const std::vector<int>& session,
                                        std::span<const SearchedChannel> channels);

}  // namespace simgap
