#include "rank_team.h"

#include <thread>

#include "simgap/core/interrupt.h"
#include "simgap/core/ranks.h"

namespace simgap {

RankTeam& team() {
  static RankTeam instance;
  return instance;
}

void RankTeam::send(int to, Bytes message) {
  ++messages;
  bytes += message.size();
  channel->send(to, std::move(message));
}

std::optional<RankMessage> RankTeam::receive() {
  std::optional<RankMessage> message = channel->receive();
  if (message) ++messages;
  if (message) bytes += message->bytes.size();
  return message;
}

Bytes RankTeam::broadcast(Bytes given) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kGrace{200};  // mpirun kills a second after it has told ranks to end
  std::optional<Clock::time_point> asked;
  const auto give_up = [&] {
    if (rank > 0 || !interruptRequested()) return false;
    if (!asked) asked = Clock::now();
    return Clock::now() - *asked > kGrace;
  };
  std::optional<Bytes> all = channel->broadcast(std::move(given), give_up);
  if (!all) {
    ended = unheard = true;
    throw InterruptedError("interrupted, and a rank does not listen");
  }
  ++messages;
  bytes += all->size();
  return std::move(*all);
}

void RankTeam::stopOthers() {
  for (int other = 1; other < count; ++other) send(other, beginWith(RankWord::kStop));
  ended = true;
}

void RankTeam::callToEnd() {
  try {
    broadcast(beginWith(RankCall::kEnd));
  } catch (const InterruptedError&) {  // one is dead: mpirun ends what is left
  }
  ended = true;
}

void failOnRank(std::string_view sentence, ExitCode code) {
  Bytes bytes = beginWith(RankWord::kFailure);
  pack(bytes, code);
  pack(bytes, sentence);
  team().send(0, std::move(bytes));
  for (Patience patience;; std::this_thread::sleep_for(patience.next())) {
    const auto message = team().receive();
    if (message && message->bytes.front() == static_cast<char>(RankWord::kStop)) goAsOther();
  }
}

void goAsOther() {
  team().ended = true;
  throw RanksEnded();
}

}  // namespace simgap
