#include "io/direction_file.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "core/error.h"

namespace micro {
namespace {

/// Longer lines are no directions, whatever they are.
constexpr std::size_t kLongestLine = 1000;

/// The numbers of a line, or nothing if something else stands there.
std::optional<std::vector<double>> numbers(std::string_view line) {
  line = line.substr(0, line.find('#'));
  constexpr std::string_view kBetween = " \t\r,;";
  std::vector<double> result;
  for (;;) {
    const auto start = line.find_first_not_of(kBetween);
    if (start == std::string_view::npos) return result;
    line.remove_prefix(start);
    double value = 0;
    const auto [rest, error] = std::from_chars(line.data(), line.data() + line.size(), value);
    line.remove_prefix(static_cast<std::size_t>(rest - line.data()));
    const bool ends = line.empty() || kBetween.find(line.front()) != std::string_view::npos;
    if (error != std::errc() || !ends || !std::isfinite(value)) return std::nullopt;
    result.push_back(value);
  }
}

/// The direction that two or three numbers mean, or what is wrong with them.
struct Parsed {
  Vec3 h = Vec3::Zero();
  const char* fault = nullptr;
};

Parsed direction(const std::vector<double>& n) {
  if (n.size() == 2) {
    const double z2 = 1 - n[0] * n[0] - n[1] * n[1];
    if (!(z2 >= 0)) return {.fault = "hx² + hy² is more than 1"};
    return {.h = {n[0], n[1], std::sqrt(z2)}};
  }
  if (n.size() != 3) return {.fault = "expected two or three numbers, hx hy or hx hy hz"};
  const Vec3 h(n[0], n[1], n[2]);
  constexpr double kLengthTolerance = 0.01;
  if (!(std::abs(h.norm() - 1) <= kLengthTolerance)) return {.fault = "the direction's length is not 1"};
  if (h.z() < 0) return {.fault = "the direction points below the surface"};
  return {.h = h.normalized()};
}

}  // namespace

std::vector<Vec3> read_directions(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path)) throw FileError(path, "cannot be opened");
  std::vector<Vec3> result;
  std::string line;
  for (std::size_t count = 1; std::getline(file, line); ++count) {
    const auto refuse = [&](const char* fault) {
      throw FileError(path, "line " + std::to_string(count) + ": " + fault);
    };
    if (line.size() > kLongestLine) refuse("too long for a direction");
    const auto found = numbers(line);
    if (!found) refuse("something that is no number");
    if (found->empty()) continue;
    const Parsed parsed = direction(*found);
    if (parsed.fault) refuse(parsed.fault);
    result.push_back(parsed.h);
  }
  if (result.empty()) throw FileError(path, "holds no direction");
  return result;
}

}  // namespace micro
