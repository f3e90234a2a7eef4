/// \file
/// The ranks of a run, and the words they exchange.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <string_view>
#include <utility>

#include "rank_channel.h"
#include "simgap/core/bytes.h"
#include "simgap/core/error.h"

namespace simgap {

/// What the first rank calls all others to, by a broadcast.
enum class RankCall : char { kTasks, kShare, kEnd };
/// The first word of a message from one rank to another.
enum class RankWord : char { kResults, kFailure, kFarewell, kTasks, kStop };

struct RankTeam {
  RankChannel* channel = nullptr;
  int rank = 0, count = 1;
  std::atomic<bool> ended{false};                  ///< the others have been told to go, or this one has been
  std::atomic<bool> unheard{false};                ///< a call was given up: one of the others is dead, or hangs
  std::atomic<bool> at_work{false};                ///< in tasks: what they call stays on its rank
  std::size_t lists = 0, messages = 0, bytes = 0;  ///< so far: lists of tasks, and what went through this rank

  void send(int to, Bytes message);
  std::optional<RankMessage> receive();
  /// \throws InterruptedError: on the first rank, when after an interrupt the others do not take it
  Bytes broadcast(Bytes bytes = {});
  /// Tells the other ranks to go, wherever they are in their tasks.
  void stopOthers();
  /// Every other rank waits for a call: it gets the last one.
  void callToEnd();
};
RankTeam& team();

/// A message or call that begins so.
template <class Word>
Bytes beginWith(Word word) {
  Bytes bytes;
  pack(bytes, word);
  return bytes;
}

/// The way of a rank that has failed, or finds that the others do something else: the first one is told why, and ends.
[[noreturn]] void failOnRank(std::string_view sentence, ExitCode code);
/// The way of a rank that is told to go.
[[noreturn]] void goAsOther();

/// Pauses of a thread that waits for messages: short at first, then some hundred a second cost nothing.
class Patience {
  using microseconds = std::chrono::microseconds;

 public:
  microseconds next() { return std::exchange(pause_, std::min(2 * pause_, microseconds{500})); }
  void renew() { pause_ = microseconds{20}; }

 private:
  microseconds pause_{20};
};

}  // namespace simgap
