/// \file
/// Values as bytes and back, between processes of the same program: no format for files. A type of its own gets
/// pack(Bytes&, value) and unpack(BytesReader&, value) beside it.
#pragma once

#include <Eigen/Core>
#include <cassert>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace simgap {

using Bytes = std::string;

/// What is left to unpack of some bytes.
struct BytesReader {
  std::string_view left;
  std::string_view take(std::size_t size) {
    assert(size <= left.size());
    const std::string_view taken = left.substr(0, size);
    left.remove_prefix(taken.size());
    return taken;
  }
};

/// Numbers and enumerations, as they stand in memory.
template <class T>
requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) void pack(Bytes& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
template <class T>
requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) void unpack(BytesReader& from, T& value) {
  std::memcpy(&value, from.take(sizeof value).data(), sizeof value);
}

inline void pack(Bytes& bytes, std::string_view text) {
  pack(bytes, text.size());
  bytes.append(text);
}
inline void unpack(BytesReader& from, std::string& text) {
  std::size_t size = 0;
  unpack(from, size);
  text = from.take(size);
}

inline void pack(Bytes& bytes, const Eigen::VectorXd& values) {
  pack(bytes, values.size());
  for (const double value : values) pack(bytes, value);
}
inline void unpack(BytesReader& from, Eigen::VectorXd& values) {
  Eigen::Index size = 0;
  unpack(from, size);
  values.resize(size);
  for (double& value : values) unpack(from, value);
}

template <class T>
void pack(Bytes& bytes, const std::vector<T>& values) {
  pack(bytes, values.size());
  for (const T& value : values) pack(bytes, value);
}
template <class T>
void unpack(BytesReader& from, std::vector<T>& values) {
  std::size_t size = 0;
  unpack(from, size);
  values.resize(size);
  for (T& value : values) unpack(from, value);
}

}  // namespace simgap
