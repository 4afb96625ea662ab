#include "tools/units.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <string_view>

namespace micro::tools {
namespace {

struct Unit {
  std::string_view name;
  double factor;
};

constexpr std::array kLengths = {Unit{"nm", 1e-3}, Unit{"um", 1.},  Unit{"µm", 1.}, Unit{"μm", 1.},
                                 Unit{"mm", 1e3},  Unit{"cm", 1e4}, Unit{"m", 1e6}, Unit{"", 1.}};
constexpr double kDegree = std::numbers::pi / 180;
constexpr std::array kAngles = {Unit{"deg", kDegree}, Unit{"°", kDegree}, Unit{"mrad", 1e-3}, Unit{"rad", 1.},
                                Unit{"", kDegree}};

double parse(const std::string& text, std::span<const Unit> units, const char* kind, const char* example) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc() && std::isfinite(value))
    for (const Unit& unit : units)
      if (std::string_view(rest, static_cast<std::size_t>(end - rest)) == unit.name)
        return value * unit.factor;
  throw CLI::ValidationError("'" + text + "' is no " + kind + "; write it like " + example);
}

CLI::Option* add(CLI::App& app, const std::string& name, double& target, const std::string& help,
                 const char* type, double (*parse_text)(const std::string&)) {
  return app
      .add_option_function<std::string>(
          name, [&target, parse_text](const std::string& text) { target = parse_text(text); }, help)
      ->type_name(type);
}

/// The whole text as a number, NaN if it is none.
double number_of(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && rest == end ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

CLI::Validator positive_number() {
  return CLI::Validator(
      [](const std::string& text) {
        const double value = number_of(text);
        return std::isfinite(value) && value > 0 ? std::string() : "'" + text + "' is no positive number";
      },
      "> 0");
}

CLI::Validator number_from_zero() {
  return CLI::Validator(
      [](const std::string& text) {
        const double value = number_of(text);
        return std::isfinite(value) && value >= 0 ? std::string() : "'" + text + "' is no number from 0 up";
      },
      ">= 0");
}

CLI::Validator seed_number() {
  return CLI::Validator(
      [](const std::string& text) {
        std::uint64_t value = 0;
        const char* end = text.data() + text.size();
        const auto [rest, error] = std::from_chars(text.data(), end, value);
        return error == std::errc() && rest == end
                   ? std::string()
                   : "'" + text + "' is no seed; it is a whole number from 0 to 18446744073709551615";
      },
      "");
}

double parse_length(const std::string& text) {
  return parse(text, kLengths, "length", "550nm, 1um or 0.5 (µm)");
}

double parse_angle(const std::string& text) {
  return parse(text, kAngles, "angle", "1.5deg, 0.1rad or 9 (degrees)");
}

CLI::Option* add_length(CLI::App& app, const std::string& name, double& micrometres,
                        const std::string& help) {
  return add(app, name, micrometres, help, "LENGTH", parse_length);
}

CLI::Option* add_angle(CLI::App& app, const std::string& name, double& radians, const std::string& help) {
  return add(app, name, radians, help, "ANGLE", parse_angle);
}

}  // namespace micro::tools
