#include "unpack.h"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <new>

#include "byte_reader.h"

namespace simgap::bags {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20U;
constexpr int kLargestWindow = 27;  // log2 of bytes; zstd's own default

/// Calls `step` until all is unpacked. It takes from the front of `packed`, writes at most `room` bytes to `to`, and
/// says how many it wrote and whether a frame is complete.
struct Step {
  std::size_t taken, written;
  bool complete;
};
template <typename Unpack>
std::string unpackAll(std::string_view packed, std::uint64_t size, const Unpack& step) {
  std::string unpacked;
  std::size_t filled = 0;
  bool complete = packed.empty();
  while (!packed.empty() || !complete) {
    if (unpacked.size() - filled < kPiece / 2) unpacked.resize(std::max(2 * filled, filled + kPiece));
    const Step done = step(packed, unpacked.data() + filled, unpacked.size() - filled);
    packed.remove_prefix(done.taken);
    filled += done.written;
    complete = done.complete;
    if (filled > size) throw Malformed(fmt::format("found more than the {} bytes that the chunk says", size));
    if (done.taken == 0 && done.written == 0 && !complete) throw Malformed("found a packed chunk that is cut short");
    if (complete && done.taken == 0) break;  // an empty frame would never end
  }
  if (filled != size || !packed.empty()) {
    throw Malformed(fmt::format("found {} bytes in a chunk, expected the {} that it says", filled, size));
  }
  unpacked.resize(filled);
  return unpacked;
}

}  // namespace

std::string unpackLz4(std::string_view packed, std::uint64_t size) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION))) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(raw,
                                                                                     &LZ4F_freeDecompressionContext);
  return unpackAll(packed, size, [&](std::string_view from, char* to, std::size_t room) {
    std::size_t taken = from.size(), written = room;
    const std::size_t state = LZ4F_decompress(context.get(), to, &written, from.data(), &taken, nullptr);
    if (LZ4F_isError(state)) throw Malformed(fmt::format("found a damaged lz4 chunk ({})", LZ4F_getErrorName(state)));
    return Step{taken, written, state == 0};
  });
}

std::string unpackZstd(std::string_view packed, std::uint64_t size) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kLargestWindow);
  return unpackAll(packed, size, [&](std::string_view from, char* to, std::size_t room) {
    ZSTD_inBuffer in{from.data(), from.size(), 0};
    ZSTD_outBuffer out{to, room, 0};
    const std::size_t state = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(state)) throw Malformed(fmt::format("found a damaged zstd chunk ({})", ZSTD_getErrorName(state)));
    return Step{in.pos, out.pos, state == 0};
  });
}

}  // namespace simgap::bags
