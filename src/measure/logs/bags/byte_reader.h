/// \file
/// A cursor over bytes nobody can be trusted for: every length is compared with what is left before it is used.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace simgap::bags {

/// What is wrong with some bytes; who knows the file and the place makes a DataError of it.
struct Malformed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes, std::endian order = std::endian::little)
      : bytes_(bytes), foreign_(order != std::endian::native) {}

  std::size_t at() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }

  /// \param what  stands in the sentence. \throws Malformed: fewer are left
  std::string_view take(std::uint64_t count, std::string_view what) {
    if (count > left()) throw Malformed(fmt::format("found {} bytes for {}, expected {}", left(), what, count));
    at_ += static_cast<std::size_t>(count);
    return bytes_.substr(at_ - static_cast<std::size_t>(count), static_cast<std::size_t>(count));
  }

  template <typename Number>
  Number number(std::string_view what) {
    static_assert(std::is_arithmetic_v<Number>);
    std::array<char, sizeof(Number)> raw;
    std::memcpy(raw.data(), take(raw.size(), what).data(), raw.size());
    if (foreign_) std::ranges::reverse(raw);
    return std::bit_cast<Number>(raw);
  }

  /// A text or block behind its length.
  template <typename Length>
  std::string_view prefixed(std::string_view what) {
    return take(number<Length>(what), what);
  }

  /// Moves on to a multiple of `size`, counted from the first byte.
  void align(std::size_t size, std::string_view what) { take((size - at_ % size) % size, what); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool foreign_;  ///< the bytes stand in the other order than this machine's
};

}  // namespace simgap::bags
