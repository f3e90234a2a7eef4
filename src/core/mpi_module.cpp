/// The ranks' channel by Open MPI. Not linked with it: core/ranks.cpp loads libmpi before, with its symbols for all,
/// because Open MPI's own plugins look for them.
#define OMPI_SKIP_MPICXX
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <list>
#include <thread>

#include "rank_channel.h"

namespace simgap {
namespace {

constexpr std::size_t kLargestPiece = std::size_t{1} << 30U;  // MPI counts bytes in int

class MpiChannel : public RankChannel {
 public:
  MpiChannel() {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);  // a rank that died must not take rank 0 along
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
  }
  int rank() const override { return rank_; }
  int count() const override { return count_; }

  void send(int to, std::string bytes) override {
    Sending& sending = sending_.emplace_back(Sending{std::move(bytes), MPI_REQUEST_NULL});
    MPI_Isend(sending.bytes.data(), static_cast<int>(sending.bytes.size()), MPI_BYTE, to, 0, MPI_COMM_WORLD,
              &sending.request);
    removeSent();
  }

  std::optional<RankMessage> receive() override {
    removeSent();
    int there = 0;
    MPI_Message message = MPI_MESSAGE_NULL;
    MPI_Status status = {};
    if (MPI_Improbe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &there, &message, &status) != MPI_SUCCESS || there == 0) {
      return std::nullopt;
    }
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    RankMessage received{status.MPI_SOURCE, std::string(static_cast<std::size_t>(size), '\0')};
    MPI_Mrecv(received.bytes.data(), size, MPI_BYTE, &message, MPI_STATUS_IGNORE);
    return received;
  }

  std::optional<std::string> broadcast(std::string bytes, const std::function<bool()>& give_up) override {
    unsigned long size = bytes.size();
    if (!broadcastPiece(reinterpret_cast<char*>(&size), sizeof size, give_up)) return std::nullopt;
    bytes.resize(size);
    for (std::size_t begin = 0; begin < size; begin += kLargestPiece) {
      if (!broadcastPiece(bytes.data() + begin, std::min(kLargestPiece, size - begin), give_up)) return std::nullopt;
    }
    return bytes;
  }

  void end() override { MPI_Finalize(); }

 private:
  struct Sending {
    std::string bytes;
    MPI_Request request;
  };

  void removeSent() {
    sending_.remove_if([](Sending& sending) {
      int sent = 0;
      MPI_Test(&sending.request, &sent, MPI_STATUS_IGNORE);
      return sent != 0;
    });
  }

  /// MPI_Bcast would keep a core busy while it waits for a first rank that writes files. \returns false: given up
  static bool broadcastPiece(char* bytes, std::size_t size, const std::function<bool()>& give_up) {
    using std::chrono::microseconds;
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ibcast(bytes, static_cast<int>(size), MPI_BYTE, 0, MPI_COMM_WORLD, &request);
    int done = 0;
    for (microseconds pause{10}; MPI_Test(&request, &done, MPI_STATUS_IGNORE) == MPI_SUCCESS && done == 0;
         pause = std::min(2 * pause, microseconds{1000})) {
      if (give_up()) return false;
      std::this_thread::sleep_for(pause);
    }
    return true;
  }

  int rank_ = 0, count_ = 1;
  std::list<Sending> sending_;
};

}  // namespace
}  // namespace simgap

simgap::RankChannel* simgapMpiModule() {
  static simgap::MpiChannel channel;
  return &channel;
}
