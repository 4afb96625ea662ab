#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace micro::tools {

/// A length typed by a person, in µm: `550nm`, `1um`, `1µm`, `0.2mm`, `1m`; a bare number is micrometres.
/// Throws CLI::ValidationError with a sentence otherwise.
double parse_length(const std::string& text);

/// An angle typed by a person, in radians: `1.5deg`, `0.1rad`; a bare number is degrees.
double parse_angle(const std::string& text);

/// Adds an option that takes a length with a unit and stores micrometres.
CLI::Option* add_length(CLI::App& app, const std::string& name, double& micrometres, const std::string& help);

/// Adds an option that takes an angle with a unit and stores radians.
CLI::Option* add_angle(CLI::App& app, const std::string& name, double& radians, const std::string& help);

/// Checks of plain numbers, with a sentence of their own: finite and more than 0; finite and at least 0; a
/// seed, which is a whole number from 0 to 2⁶⁴ − 1.
CLI::Validator positive_number();
CLI::Validator number_from_zero();
CLI::Validator seed_number();

}  // namespace micro::tools
